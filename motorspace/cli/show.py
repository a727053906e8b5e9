"""Results and progress, for a person or for a program."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from motorspace._files import json_text


def show(results: Mapping[str, Any], *, as_json: bool) -> None:
    """Print results, for a program or for a person."""
    if as_json:
        print(json_text(dict(results)))
        return
    width = max(32, *(len(name) for name, _ in _flat(results)))
    for name, value in _flat(results):
        for part in value if _sentences(value) else [value]:
            print(
                f"{name:<{width}} {part:.6g}"
                if isinstance(part, float)
                else f"{name:<{width}} {part}"
            )
            name = ""


def _sentences(value: Any) -> bool:
    """Whether a value is several sentences, which get a line each."""
    return isinstance(value, list | tuple) and all(isinstance(part, str) for part in value)


def _flat(results: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in results.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


@contextmanager
def progress(what: str, epochs: int) -> Iterator[Callable[[dict[str, float | int]], None]]:
    """A bar with rate and time left on a terminal, a line now and then elsewhere."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[rate]:.1f} epochs/s, loss {task.fields[loss]:.4f}"),
    )
    with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        task = bar.add_task(what, total=epochs, rate=0.0, loss=float("nan"))

        def callback(record: dict[str, float | int]) -> None:
            epoch, loss = int(record["epoch"]), record["prediction_loss"]
            bar.update(task, completed=epoch, rate=bar.tasks[0].speed or 0.0, loss=loss)
            if not console.is_terminal and epoch % max(1, epochs // 10) == 0:
                console.print(f"{what}: epoch {epoch} of {epochs}, loss {loss:.5f}")

        yield callback
