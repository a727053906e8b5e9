"""What a worker does: one job in its folder, once, whoever asks for it and however often."""

import importlib
import os
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from motorspace._errors import UserError
from motorspace._files import locked, write_atomically
from motorspace.running.jobs import Job
from motorspace.running.store import Number, Result, from_line, result_of

Execute = Callable[[Job, Path], Mapping[str, Number]]
"""Trains a job's run in a folder, from its checkpoint if one is there, and measures it.

A function of a module's top level: worker processes import it by name. Its module should import
JAX inside the function, so that a worker can choose its core and its threads before.
"""

OUTCOME = ".job"
"""Folder within a run's folder: its lock, and its outcome until the results hold it."""

ONE_THREAD = "--xla_cpu_multi_thread_eigen=false"
"""A flag of XLA: many processes of one thread beat one process of many."""

WAIT_SECONDS = 60.0
"""How long to wait for the folder of a run: the worker that holds it may be about to end."""


@dataclass(frozen=True)
class Failure:
    """Why a job has no result."""

    what: str
    """A sentence."""
    details: str = ""
    """The traceback of an error that is not the user's."""


def work(execute: Execute, job: Job, folder: Path, modules: Sequence[str] = ()) -> Result | Failure:
    """Train and measure a job in its folder, or read the outcome that is already there.

    Args:
        execute: What trains and measures.
        job: The job.
        folder: The folder of all studies; the run's own is STUDY/CELL within it.
        modules: Modules to import first, which register classes of the user's own.

    Returns:
        Its result, or why there is none: an error of one job does not end the others.
    """
    place = folder / job.study / job.folder

    def do() -> Result:
        import_modules(modules)
        with held(place):
            return outcome(execute, job, place)

    return attempt(place, do)


def attempt(place: Path, do: Callable[[], Result]) -> Result | Failure:
    """What `do` returns, or its error as a value, which stays in the run's folder as well."""
    try:
        return do()
    except UserError as error:
        failure = Failure(str(error))
    except Exception as error:
        what = f"{type(error).__name__}: {error}".splitlines()[0]
        failure = Failure(what, traceback.format_exc())
    write_failure(place, failure)
    return failure


def outcome(execute: Execute, job: Job, place: Path) -> Result:
    """The result of a job whose folder this process holds; written there before it is returned."""
    path = place / OUTCOME / "result.json"
    if path.exists():
        found = from_line(path.read_text(), where=path)
        if found.key == job.key:
            return found
    result = result_of(job, execute(job, place))
    write_atomically(path, result.as_line().encode())
    (place / OUTCOME / "failure.txt").unlink(missing_ok=True)
    return result


def forget_outcome(job: Job, folder: Path) -> None:
    """Remove the outcome from a run's folder, once the results hold it."""
    (folder / job.study / job.folder / OUTCOME / "result.json").unlink(missing_ok=True)


@contextmanager
def held(place: Path) -> Iterator[None]:
    """Hold a run's folder. Raises `UserError` when another process does not let go of it."""
    end = time.monotonic() + WAIT_SECONDS
    with ExitStack() as stack:
        while True:
            try:
                stack.enter_context(locked(place / OUTCOME))
                break
            except UserError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.1)
        yield


def write_failure(place: Path, failure: Failure) -> None:
    """Leave a failure in a run's folder, if that can be written."""
    try:
        (place / OUTCOME).mkdir(parents=True, exist_ok=True)
        content = f"{failure.what}\n{failure.details}"
        write_atomically(place / OUTCOME / "failure.txt", content.encode())
    except (OSError, UserError):
        pass


def import_modules(names: Sequence[str]) -> None:
    """Import the modules that the user has named on the command line.

    They are found where Python finds modules, and in the present folder.
    Raises `UserError` for one that is not there.
    """
    here = os.getcwd()
    if names and here not in sys.path:
        sys.path.append(here)
    for name in names:
        try:
            importlib.import_module(name)
        except ModuleNotFoundError as error:
            raise UserError(
                f"there is no module {error.name!r}",
                where=f"--import {name}",
                remedy="run the command in the module's folder, or install it, on every machine",
            ) from None
