"""What all tests share."""

from collections.abc import Callable

import jax
import pytest


@pytest.fixture
def getkey() -> Callable[[], jax.Array]:
    """A function that gives a new key at every call; the same ones in every session."""
    keys = iter(jax.random.split(jax.random.key(20180513), 64))
    return lambda: next(keys)
