"""What arrives where an object is sent to another process, as executors and workers do."""

import multiprocessing
from typing import Any


def sent(value: Any) -> Any:
    """The value as the other end of a channel between processes receives it."""
    channel = multiprocessing.get_context("spawn").Queue()
    channel.put(value)
    return channel.get(timeout=60)
