"""A result says what made it; broken, stale and double lines are found."""

import json
import math
import threading

import pytest

from motorspace._errors import UserError
from motorspace.running import store
from motorspace.running.jobs import cell
from tests.running.toy import jobs, other


@pytest.fixture
def job():
    return jobs(0.2)[0]


def put(folder, job, metrics):
    store.append_result(folder, job.study, store.result_of(job, metrics), job.config)


def test_a_line_holds_six_digits_and_what_made_it(tmp_path, job):
    put(tmp_path, job, {"linear_r2.cos": 0.123456789, "num": 100_000_000, "undefined": math.nan})
    (line,) = (tmp_path / "toy.jsonl").read_text().splitlines()
    found = json.loads(line)
    assert found["metrics"] == {"linear_r2.cos": 0.123457, "num": 100_000_000, "undefined": None}
    assert found["cell"] == {"agent": "forward", "rotation": 0.2}
    assert (found["seed"], found["epochs"], found["config"]) == (0, 3, job.config.hash())
    assert found["code"] == store.code_version() and len(found["date"]) == 10
    assert store.read_configs(tmp_path) == {job.config.hash(): job.config.as_json()}
    (read,) = store.read_lines(tmp_path / "toy.jsonl")
    assert read.as_line() == line and math.isnan(read.metrics["undefined"])


def test_a_job_is_finished_when_a_line_has_its_cell_seed_and_configuration(tmp_path, job):
    path = tmp_path / "toy.jsonl"
    assert store.read_lines(path) == []
    put(tmp_path, job, {"error": 1.0})
    results = store.read_lines(path)
    assert store.finished(job, results)
    for unfinished in (other(job, hidden_size=7), jobs(0.4)[0], jobs(0.2, seeds=2)[1]):
        assert not store.finished(unfinished, results)


def test_results_of_another_configuration_are_stale_and_not_shown(tmp_path, job):
    for changed in (job, other(job, hidden_size=7), jobs(0.4)[0]):
        put(tmp_path, changed, {"error": 1.0})
    results = store.read_lines(tmp_path / "toy.jsonl")
    old = other(job, hidden_size=7).config.hash()
    assert store.stale_names(results, [job]) == [
        f"agent=forward rotation=0.2 seed=0 (configuration {old})"
    ]
    assert store.current(results, [job]) == results[:1]
    assert store.stale(results, [job, other(job, hidden_size=7)]) == [], "another budget is not"


@pytest.mark.parametrize(
    "line",
    [
        "{",
        "[1]",
        "<<<<<<< HEAD",
        '{"cell": {}, "seed": 0}',
        '{"cell": {"a": [1]}, "seed": 0, "epochs": 1, "config": "a", "code": "b", "date": "c",'
        ' "metrics": {}}',
        '{"cell": {}, "seed": "0", "epochs": 1, "config": "a", "code": "b", "date": "c",'
        ' "metrics": {}}',
        '{"cell": {}, "seed": 0, "epochs": 1, "config": "a", "code": "b", "date": "c",'
        ' "metrics": {"error": "low"}}',
    ],
)
def test_a_broken_line_is_named_with_its_number(tmp_path, job, line):
    put(tmp_path, job, {"error": 1.0})
    path = tmp_path / "toy.jsonl"
    path.write_text(path.read_text() + "\n" + line + "\n")
    with pytest.raises(UserError, match=r"toy\.jsonl, line 3: this is not the result of a run; de"):
        store.read_lines(path)


def test_a_broken_configuration_is_named_with_its_number(tmp_path):
    (tmp_path / "configs.jsonl").write_text("{}\nx\n")
    with pytest.raises(UserError, match=r"configs\.jsonl, line 2: this is not a configuration"):
        store.read_configs(tmp_path)


def test_a_line_after_a_torn_one_stands_alone(tmp_path):
    path = tmp_path / "a.jsonl"
    path.write_text('{"a": ')
    store.append_line(path, "{}")
    assert path.read_text() == '{"a": \n{}\n'


def test_lines_of_many_writers_are_whole(tmp_path):
    path, line = tmp_path / "a.jsonl", "x" * 10_000
    writers = [
        threading.Thread(target=lambda: [store.append_line(path, line) for _ in range(20)])
        for _ in range(4)
    ]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert path.read_text() == f"{line}\n" * 80


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="the results cannot be written"):
        store.append_line(tmp_path / "file" / "a.jsonl", "{}")


def test_results_of_two_machines_merge_and_conflicts_are_named(tmp_path):
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    first, second, third = jobs(0.2, 0.4, 0.6)
    put(ours, first, {"error": 1.0})
    put(ours, second, {"error": 2.0})
    for job, error in ((first, 1.0), (second, 2.5), (third, 3.0)):
        put(theirs, job, {"error": error})
    (conflict,) = store.merge(ours, theirs)
    assert conflict.startswith("toy: agent=forward rotation=0.4 seed=0")
    found = {r.cell: r.metrics["error"] for r in store.read_lines(ours / "toy.jsonl")}
    assert [*found.values()] == [1.0, 2.0, 3.0] and cell(agent="forward", rotation=0.6) in found
    assert len(store.read_configs(ours)) == 3


def test_lines_put_together_by_hand_count_once(tmp_path, job):
    put(tmp_path, job, {"error": 1.0})
    path = tmp_path / "toy.jsonl"
    path.write_text(path.read_text() * 2)
    assert len(store.read_lines(path)) == 1
