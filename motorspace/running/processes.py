"""Jobs in processes of this machine: one for each job, with a core and a thread of its own."""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace.running.executors import Outcome
from motorspace.running.jobs import Job
from motorspace.running.work import ONE_THREAD, Execute, Failure, work, write_failure

TRIES = 3
"""Times that a job is begun when its process is killed, for want of memory perhaps."""

STOP_SECONDS = 15.0
"""Time that processes have to write their checkpoints when the command is stopped."""


@dataclass(frozen=True)
class Processes:
    """Processes of one thread each, which on a CPU beat one of many threads."""

    count: int = 2
    """Jobs at once."""
    modules: tuple[str, ...] = ()
    """Modules that register classes of the user's own."""

    def __post_init__(self) -> None:
        if self.count < 1:
            raise UserError(f"the number of processes must be at least 1, got {self.count}")

    def run(
        self, execute: Execute, jobs: Sequence[Job], folder: Path
    ) -> Generator[Outcome, None, None]:
        """Every job with its outcome. A job whose process is killed is begun again."""
        waiting = deque((job, 1) for job in jobs)
        cores, running = _Cores(), dict[Any, _Worker]()
        try:
            while waiting or running:
                while waiting and len(running) < self.count:
                    job, tries = waiting.popleft()
                    worker = _Worker(job, tries, cores.take())
                    running[worker.pipe] = worker
                    worker.begin((execute, job, folder, self.modules))
                for pipe in wait([*running]):
                    worker = running.pop(pipe)
                    found = worker.end()
                    cores.give_back(worker.core)
                    if found is not None:
                        yield worker.job, found
                    elif worker.tries < TRIES:
                        waiting.appendleft((worker.job, worker.tries + 1))
                    else:
                        yield worker.job, _killed(worker, folder)
        finally:
            _stop([worker.process for worker in running.values()])


class _Cores:
    """Cores for workers, as long as there are some.

    One of the libraries behind the compiled products starts a thread for every core that it may
    use, whatever the flags say; those of several workers would wait for one another.
    """

    def __init__(self) -> None:
        present = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else ()
        self.free = deque(sorted(present))

    def take(self) -> int | None:
        return self.free.popleft() if self.free else None

    def give_back(self, core: int | None) -> None:
        if core is not None:
            self.free.append(core)


@dataclass
class _Worker:
    """A process that does one job."""

    job: Job
    tries: int
    core: int | None
    process: BaseProcess = field(init=False)
    pipe: Connection = field(init=False)
    far_end: Connection = field(init=False)

    def __post_init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, self.far_end = context.Pipe()
        self.process = context.Process(target=_main, args=(self.far_end, self.core))

    def begin(self, task: tuple[Any, ...]) -> None:
        # Ctrl-C goes to all processes of a terminal; workers wait for `_stop` instead.
        if hasattr(signal, "pthread_sigmask"):
            before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            self.process.start()
        finally:
            if hasattr(signal, "pthread_sigmask"):
                signal.pthread_sigmask(signal.SIG_SETMASK, before)
        self.far_end.close()
        self.pipe.send(task)

    def end(self) -> Any:
        """What the worker has found; None if it was killed."""
        try:
            return self.pipe.recv()
        except (EOFError, OSError):
            return None
        finally:
            self.process.join()
            self.pipe.close()


def _main(pipe: Connection, core: int | None) -> None:
    """A worker: choose core and threads before anything is imported, then do the job."""
    signal.signal(signal.SIGTERM, _leave)
    _end_with_parent()
    if core is not None:
        os.sched_setaffinity(0, {core})
    os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} {ONE_THREAD}".strip()
    pipe.send(work(*pipe.recv()))


def _leave(*_: Any) -> None:
    """End a worker so that what it holds is written and let go."""
    raise SystemExit(128 + signal.SIGTERM)


def _end_with_parent() -> None:
    """Let a worker end when the command that started it is killed: its checkpoint stays."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def end() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=end, daemon=True).start()


def _stop(processes: Sequence[BaseProcess]) -> None:
    begun = [process for process in processes if process.pid is not None]
    for process in begun:
        process.terminate()
    for process in begun:
        process.join(STOP_SECONDS)
        if process.exitcode is None:
            process.kill()
            process.join()


def _killed(worker: _Worker, folder: Path) -> Failure:
    failure = Failure(
        f"its process was killed {TRIES} times (exit code {worker.process.exitcode}): perhaps the "
        "memory is too small for so many processes"
    )
    write_failure(folder / worker.job.study / worker.job.folder, failure)
    return failure
