"""Many runs: each is done once, and none outlives the command that started it."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from motorspace._errors import UserError
from motorspace._files import locked
from motorspace.running import work as working
from motorspace.running.executors import OneProgram, run_jobs
from motorspace.running.processes import Processes
from motorspace.running.store import read_lines
from motorspace.running.work import import_modules
from tests.running.toy import execute, jobs

ROOT = Path(__file__).parents[2]


def values(folder):
    return {r.key: r.metrics for r in read_lines(folder / "toy.jsonl")}


def begun(folder):
    """How often each run was begun."""
    return [len(path.read_text().split()) for path in sorted((folder / "toy").glob("*/begun"))]


def wait_until(condition, *, seconds=30):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it never came true"
        time.sleep(0.05)


def is_free(place):
    try:
        with locked(place / ".job"):
            return True
    except UserError:
        return False


def test_jobs_are_done_once_and_finished_ones_are_not_repeated(tmp_path):
    wanted, said = jobs(0.2, 0.4, seeds=2), []
    run_jobs([*wanted, wanted[0]], tmp_path, execute, executor=Processes(2), report=said.append)
    assert begun(tmp_path) == [1] * 4
    assert len(said) == 4 and said[-1].startswith("[4/4] agent=forward rotation=0.")
    assert sum(r["value"] for r in values(tmp_path).values()) == pytest.approx(12.666666)
    more = [*wanted, *jobs(0.6)]
    run_jobs(more, tmp_path, execute, executor=OneProgram(), report=said.append)
    assert begun(tmp_path) == [1] * 5
    assert said[4] == "4 of 5 runs are finished already"
    assert len((tmp_path / "toy.jsonl").read_text().splitlines()) == 5


def test_a_run_that_fails_does_not_end_the_others(tmp_path):
    wanted, said = [*jobs(0.2), *jobs(0.4, fails="bug"), *jobs(0.6, fails="user")], []
    with pytest.raises(UserError, match=r"2 of 3 runs have failed, agent=.* tries them again"):
        run_jobs(wanted, tmp_path, execute, executor=OneProgram(), report=said.append)
    assert len(values(tmp_path)) == 1
    assert any("ZeroDivisionError: it is broken\n" in f"{line}\n" for line in said)
    reasons = {p.read_text().splitlines()[0] for p in tmp_path.glob("toy/*/.job/failure.txt")}
    assert reasons == {"ZeroDivisionError: it is broken", "it is broken."}


def test_a_killed_worker_is_begun_again_from_its_checkpoint(tmp_path):
    (job,) = jobs(0.2, epochs=50, seconds=0.1)
    place = tmp_path / "toy" / job.folder
    script = (
        "import signal\n"
        "from pathlib import Path\n"
        "from motorspace.running.executors import run_jobs\n"
        "from motorspace.running.processes import Processes\n"
        "from tests.running.toy import execute, jobs\n"
        "if __name__ == '__main__':\n"
        # A shell lets its commands in the background ignore Ctrl-C.
        "    signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        f"    run_jobs(jobs(0.2, epochs=50, seconds=0.1), Path({str(tmp_path)!r}), execute,\n"
        "             executor=Processes(1))\n"
    )
    (tmp_path / "drive.py").write_text(script)
    command = [sys.executable, str(tmp_path / "drive.py")]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}

    def counted(num):
        epochs = place / "epochs"
        return lambda: epochs.exists() and len(epochs.read_text().split()) >= num

    # The worker dies; the command begins the job again.
    driver = subprocess.Popen(command, env=environment)
    wait_until(counted(2))
    os.kill(int((place / "begun").read_text().split()[-1]), signal.SIGKILL)
    wait_until(lambda: len((place / "begun").read_text().split()) == 2)
    # The command dies: its worker ends with it.
    wait_until(counted(6))
    driver.kill()
    driver.wait()
    wait_until(lambda: is_free(place))
    # The command is stopped: its worker ends before it does, and lets go of the folder.
    driver = subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL)
    wait_until(counted(10))
    driver.send_signal(signal.SIGINT)
    assert driver.wait(timeout=30) != 0
    assert is_free(place)
    assert values(tmp_path) == {}
    subprocess.run(command, env=environment, check=True)
    assert [r["epochs"] for r in values(tmp_path).values()] == [50]
    assert begun(tmp_path) == [4]


def test_an_outcome_that_no_driver_has_taken_is_not_made_again(tmp_path):
    (job,) = jobs(0.2)
    assert working.work(execute, job, tmp_path).metrics["epochs"] == 3
    run_jobs([job], tmp_path, execute, executor=OneProgram())
    assert begun(tmp_path) == [1] and len(values(tmp_path)) == 1
    # Whoever deletes a line wants the run measured again.
    (tmp_path / "toy.jsonl").unlink()
    run_jobs([job], tmp_path, execute, executor=OneProgram())
    assert begun(tmp_path) == [2] and len(values(tmp_path)) == 1


def test_two_commands_do_not_run_the_same_study(tmp_path):
    with locked(tmp_path / "toy"), pytest.raises(UserError, match="another process"):
        run_jobs(jobs(0.2), tmp_path, execute, executor=OneProgram())


def test_a_folder_that_another_process_holds_is_waited_for_and_then_named(tmp_path, monkeypatch):
    monkeypatch.setattr(working, "WAIT_SECONDS", 0.3)
    (job,) = jobs(0.2)
    with locked(tmp_path / "toy" / job.folder / ".job"):
        found = working.work(execute, job, tmp_path)
    assert "another process" in found.what


def test_runs_that_differ_by_seed_and_numbers_are_trained_as_one_program(tmp_path):
    teams = []

    def together(team, places):
        teams.append([(job.config.max_rotation, job.seed) for job in team])
        raise UserError("one of them failed")

    wanted = jobs(0.2, 0.4, seeds=3)
    run_jobs(wanted, tmp_path, execute, executor=OneProgram(together))
    (team,) = teams
    assert sorted(team) == [(r, seed) for r in (0.2, 0.4) for seed in range(3)]
    assert len(values(tmp_path)) == 6


def test_modules_of_the_user_are_imported_by_the_workers(tmp_path, monkeypatch):
    (tmp_path / "my_agents_for_a_test.py").write_text(
        "from pathlib import Path\nPath('seen').touch()"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    executor = Processes(1, modules=("my_agents_for_a_test",))
    run_jobs(jobs(0.2), tmp_path, execute, executor=executor)
    assert (tmp_path / "seen").exists()
    with pytest.raises(UserError, match="--import nothing_here: there is no module 'nothing_here'"):
        import_modules(["nothing_here"])


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="cores cannot be chosen here")
def test_each_worker_has_a_core_of_its_own(tmp_path):
    run_jobs(jobs(0.2, 0.4), tmp_path, where_it_runs, executor=Processes(2))
    cores = [r["core"] for r in values(tmp_path).values()]
    assert len(set(cores)) == min(2, len(os.sched_getaffinity(0)))
    assert {r["threads"] for r in values(tmp_path).values()} == {1}


def where_it_runs(job, folder):
    cores = os.sched_getaffinity(0)
    threads = "--xla_cpu_multi_thread_eigen=false" in os.environ["XLA_FLAGS"]
    time.sleep(0.3)
    return {"core": min(cores) if len(cores) == 1 else -1, "threads": int(threads)}


def test_at_least_one_process_is_asked_for():
    with pytest.raises(UserError, match="must be at least 1, got 0"):
        Processes(0)
