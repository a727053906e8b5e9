"""Jobs on a real cluster of two nodes, whose workers are killed while they train."""

import os
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from motorspace._errors import UserError
from motorspace.running.executors import OneProgram, run_jobs
from motorspace.running.ray_cluster import RayExecutor
from motorspace.running.store import read_lines
from tests.running.toy import execute, jobs

pytest.importorskip("ray", reason="needs the extra: sweep")

ROOT = Path(__file__).parents[2]

# Starting Ray takes seconds and several hundred MB.
pytestmark = pytest.mark.slow

ENVIRONMENT = os.environ | {
    "PYTHONPATH": str(ROOT),
    "RAY_USAGE_STATS_ENABLED": "0",
    # Nothing listens on other interfaces than loopback: without this, Ray does.
    "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0",
    # And only who knows this may give it work.
    "RAY_AUTH_MODE": "token",
    "RAY_AUTH_TOKEN": secrets.token_hex(32),
}


@pytest.fixture(scope="module")
def cluster():
    """The address of a cluster that is ours, and ends with the tests."""
    # Ray's sockets lie in it, and their paths must be short.
    folder = tempfile.mkdtemp(prefix="motorspace-")
    started = subprocess.Popen(
        [sys.executable, "-m", "tests.running.cluster"],
        cwd=ROOT,
        env=ENVIRONMENT | {"RAY_TMPDIR": folder},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        text=True,
    )
    try:
        yield started.stdout.readline().strip()
    finally:
        started.stdin.close()
        try:
            started.wait(timeout=60)
        except subprocess.TimeoutExpired:
            os.killpg(started.pid, signal.SIGKILL)
            started.wait()
        started.stdout.close()
        shutil.rmtree(folder, ignore_errors=True)


ROTATIONS = (0.2, 0.4, 0.6, 0.8)
NUM = 2 * len(ROTATIONS)

DRIVE = """
import sys
from pathlib import Path
from motorspace.running.executors import run_jobs
from motorspace.running.ray_cluster import RayExecutor
from tests.running.toy import execute, jobs

wanted = jobs(0.2, 0.4, 0.6, 0.8, seeds=2, epochs=15, seconds=0.1)
run_jobs(wanted, Path(sys.argv[1]), execute, executor=RayExecutor(sys.argv[2]), report=print)
"""


@contextmanager
def driver(script, folder, *address):
    """A command that runs jobs."""
    command = [sys.executable, str(script), str(folder), *address]
    with subprocess.Popen(command, cwd=ROOT, env=ENVIRONMENT) as started:
        try:
            yield started
        finally:
            started.kill()


def wait_until(condition, *, seconds=60):
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, "it never came true"
        time.sleep(0.02)
    return found


def training(folder, since):
    """Workers of our cluster in the middle of a run's epochs: run and process."""
    found = []
    for place in (folder / "toy").glob("agent*"):
        counted = place / "epochs"
        if counted.exists() and since <= len(counted.read_text().split()) < 12:
            pid = last_worker(place)
            if is_worker(pid):
                found.append((place, pid))
    return found


def last_worker(place):
    return int((place / "begun").read_text().split()[-1])


def is_worker(pid):
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().startswith(b"ray::_on_ray")
    except OSError:
        return False


def kill_a_worker(folder, since):
    place, pid = wait_until(lambda: training(folder, since))[0]
    os.kill(pid, signal.SIGKILL)
    return place


def values(folder):
    return {(r.cell, r.seed): r.metrics for r in read_lines(folder / "toy.jsonl")}


def test_cells_whose_workers_are_killed_are_done_once_and_the_table_is_the_same(cluster, tmp_path):
    script = tmp_path / "drive.py"
    script.write_text(DRIVE)
    with driver(script, tmp_path, cluster) as stopped:
        killed = [kill_a_worker(tmp_path, since=2), kill_a_worker(tmp_path, since=5)]
        # The command is stopped, and begun again.
        wait_until(lambda: len(values(tmp_path)) >= 2)
        stopped.send_signal(signal.SIGINT)
        assert stopped.wait(timeout=60) != 0
    assert 2 <= len(values(tmp_path)) < NUM
    with driver(script, tmp_path, cluster) as again:
        killed.append(kill_a_worker(tmp_path, since=3))
        assert again.wait(timeout=120) == 0

    undisturbed = tmp_path / "undisturbed"
    wanted = jobs(*ROTATIONS, seeds=2, epochs=15)
    run_jobs(wanted, undisturbed, execute, executor=OneProgram())
    assert len((tmp_path / "toy.jsonl").read_text().splitlines()) == NUM
    assert values(tmp_path) == values(undisturbed)
    for place in (tmp_path / "toy").glob("agent*"):
        # Each epoch once: what was killed went on where it was.
        assert (place / "epochs").read_text().split() == [str(epoch) for epoch in range(15)]
    for place in killed:
        assert len((place / "begun").read_text().split()) >= 2


TRAIN = """
import sys
from pathlib import Path
from motorspace.running.executors import run_jobs
from motorspace.running.processes import Processes
from motorspace.running.ray_cluster import RayExecutor
from tests.running.real import execute, jobs

if __name__ == "__main__":
    executor = RayExecutor(sys.argv[2]) if len(sys.argv) > 2 else Processes(2)
    run_jobs(jobs(), Path(sys.argv[1]), execute, executor=executor)
"""


def test_a_network_whose_worker_is_killed_has_the_weights_of_an_undisturbed_one(cluster, tmp_path):
    script = tmp_path / "drive.py"
    script.write_text(TRAIN)
    disturbed, undisturbed = tmp_path / "disturbed", tmp_path / "undisturbed"
    with driver(script, disturbed, cluster) as started:
        log = wait_until(lambda: [*disturbed.glob("real/*/log.jsonl")], seconds=300)[0]
        wait_until(lambda: len(log.read_text().splitlines()) > 20)
        os.kill(last_worker(log.parent), signal.SIGKILL)
        assert started.wait(timeout=300) == 0
    with driver(script, undisturbed) as started:
        assert started.wait(timeout=300) == 0
    assert len((log.parent / "begun").read_text().split()) == 2
    for place in (disturbed / "real").glob("agent*"):
        assert same(place, undisturbed / "real" / place.name, "weights.safetensors")
        assert same(place, undisturbed / "real" / place.name, "log.jsonl")
    first, second = (
        {r.key: r.metrics for r in read_lines(folder / "real.jsonl")}
        for folder in (disturbed, undisturbed)
    )
    assert len(first) == 2 and first == second


def same(one, other, name):
    return (one / name).read_bytes() == (other / name).read_bytes()


FAILING = """
import sys
from pathlib import Path
from motorspace._errors import UserError
from motorspace.running.executors import run_jobs
from motorspace.running.ray_cluster import RayExecutor
from tests.running.toy import execute, jobs

for wanted, executor in (
    (jobs(0.2, fails="user"), RayExecutor(sys.argv[2])),
    (jobs(0.2), RayExecutor(sys.argv[2], gpus=1)),
    (jobs(0.2), RayExecutor(sys.argv[2], modules=("my_agents_for_a_test",))),
):
    try:
        run_jobs(wanted, Path(sys.argv[1]), execute, executor=executor)
        print("finished")
    except UserError as error:
        print(error)
"""


def test_errors_modules_and_resources_are_the_users(cluster, tmp_path):
    (tmp_path / "my_agents_for_a_test.py").write_text("open('seen', 'w').close()")
    done = subprocess.run(
        [sys.executable, "-c", FAILING, "runs", cluster],
        cwd=tmp_path,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        check=True,
    )
    failed, resources, finished = done.stdout.splitlines()
    assert (
        "1 of 1 runs have failed, agent=forward rotation=0.2 seed=0 for instance: it is" in failed
    )
    assert "the cluster has 0 GPUs, and a job takes 1; ask for less, or add machines" in resources
    assert finished == "finished" and (tmp_path / "seen").exists(), "in the folder of the command"


def test_nothing_listens_beyond_this_machine(cluster):
    host, _, port = cluster.partition(":")
    assert host == "127.0.0.1"
    listening = [
        line.split()[1].partition(":")
        for table in ("tcp", "tcp6")
        for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]
    ]
    hosts = {host for host, _, found in listening if int(found, 16) == int(port)}
    assert hosts and not any(set(host) == {"0"} for host in hosts), "all zeros: every interface"


def test_where_no_cluster_is_the_error_says_so(monkeypatch):
    monkeypatch.setattr("motorspace.running.ray_cluster.CONNECTS", 1)
    with pytest.raises(
        UserError, match=r"--address: no Ray cluster answers at 127.0.0.1:9 \(.*ref"
    ):
        next(RayExecutor("127.0.0.1:9").run(execute, [], Path()))
