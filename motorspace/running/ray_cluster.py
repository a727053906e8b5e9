"""Jobs on a Ray cluster: the extra `sweep`.

Every machine needs this version of motorspace, and the working folder under the same path:
checkpoints lie there, so that a job whose machine is lost goes on elsewhere.
"""

import os
import socket
import time
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace.running.executors import Outcome
from motorspace.running.jobs import Job
from motorspace.running.store import Result
from motorspace.running.work import ONE_THREAD, Execute, Failure, work

RETRIES = 10
"""Times that Ray begins a job again when its worker or its machine is lost."""

CONNECTS = 3
"""Times that a connection is tried: on a busy machine the first one may run out of time."""

STOP_SECONDS = 15.0
"""Time that workers have to write their checkpoints when the command is stopped."""


@dataclass(frozen=True)
class RayExecutor:
    """Tasks of a Ray cluster, one for each job."""

    address: str
    """HOST:PORT of the cluster's head; auto: the cluster of this machine or RAY_ADDRESS."""
    cpus: float = 1.0
    """Cores that a job takes."""
    gpus: float = 0.0
    """Accelerators that a job takes: 0.25 lets four jobs share one."""
    modules: tuple[str, ...] = ()
    """Modules that register classes of the user's own; every machine must have them."""

    def run(
        self, execute: Execute, jobs: Sequence[Job], folder: Path
    ) -> Generator[Outcome, None, None]:
        """Every job with its outcome. A job whose worker is lost is begun again."""
        with _connected(self.address) as ray:
            self._check_resources(ray)
            task = ray.remote(
                # A worker of its own for each job: what a job leaves in memory ends with it.
                max_calls=1,
                max_retries=RETRIES,
                num_cpus=self.cpus,
                num_gpus=self.gpus,
            )(_on_ray)
            here = (str(Path.cwd()), self._environment(), self.modules)
            running = {task.remote(*here, execute, job, str(folder)): job for job in jobs}
            try:
                while running:
                    (done, *_), _ = ray.wait([*running], num_returns=1)
                    yield running.pop(done), _found(ray, done)
            finally:
                _stop(ray, [*running])

    def _environment(self) -> dict[str, str]:
        """The settings of JAX in this process, and one thread for each job."""
        found = {name: value for name, value in os.environ.items() if name.startswith("JAX_")}
        found["XLA_FLAGS"] = os.environ.get("XLA_FLAGS", ONE_THREAD)
        if 0 < self.gpus < 1:
            # By default the first job would take most of the memory that they share.
            found["XLA_PYTHON_CLIENT_PREALLOCATE"] = "false"
        return found

    def _check_resources(self, ray: Any) -> None:
        """Raise `UserError` if the cluster could never run a job: Ray itself would wait."""
        present = ray.cluster_resources()
        for name, wanted in (("CPU", self.cpus), ("GPU", self.gpus)):
            if wanted > present.get(name, 0):
                raise UserError(
                    f"the cluster has {present.get(name, 0):g} {name}s, and a job takes {wanted:g}",
                    where=self.address,
                    remedy="ask for less, or add machines to the cluster",
                )


def _on_ray(
    here: str,
    environment: Mapping[str, str],
    modules: Sequence[str],
    execute: Execute,
    job: Job,
    folder: str,
) -> Result | Failure:
    """A worker: do the job in the folder of the command, with its settings of JAX."""
    for name, value in environment.items():
        os.environ.setdefault(name, value)
    if not (Path(here).is_dir() and Path(folder).is_dir()):
        return Failure(
            f"{folder} is not on the machine {os.uname().nodename}: all machines must share the "
            "folder of the command and that of the runs"
        )
    os.chdir(here)
    return work(execute, job, Path(folder), modules)


@contextmanager
def _connected(address: str) -> Iterator[Any]:
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    try:
        import ray
    except ModuleNotFoundError:
        raise UserError(
            "Ray is not installed",
            remedy="install the extra: pip install 'motorspace[sweep]'",
        ) from None
    for attempt in range(1, CONNECTS + 1):
        try:
            _connect(ray, address)
            break
        except (OSError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
            if attempt < CONNECTS:
                time.sleep(attempt)
                continue
            reason = str(error).strip().partition("\n")[0].rstrip(".")
            raise UserError(
                f"no Ray cluster answers at {address} ({reason})",
                where="--address",
                remedy="start one with ray start --head, and give the address that it prints",
            ) from None
    try:
        yield ray
    finally:
        ray.shutdown()


def _connect(ray: Any, address: str) -> None:
    host, colon, port = address.rpartition(":")
    if colon and port.isdigit():
        # Where nothing listens, Ray itself would try for minutes.
        socket.create_connection((host.strip("[]"), int(port)), timeout=10).close()
    try:
        ray.init(
            address=address,
            include_dashboard=False,
            log_to_driver=False,
            logging_level="WARNING",
        )
    except BaseException:
        ray.shutdown()
        raise


def _found(ray: Any, done: Any) -> Result | Failure:
    try:
        found: Result | Failure = ray.get(done)
        return found
    except ray.exceptions.RayError as error:
        reason = str(error).strip().partition("\n")[0].rstrip(".")
        return Failure(
            f"its worker was lost, begun again {RETRIES} times and lost again ({reason})"
        )


def _stop(ray: Any, tasks: list[Any]) -> None:
    """Interrupt tasks as Ctrl-C would, so that they write their checkpoints."""
    for task in tasks:
        ray.cancel(task)
    if tasks:
        ray.wait(tasks, num_returns=len(tasks), timeout=STOP_SECONDS)
