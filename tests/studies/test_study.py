"""A study is one file: registered, it is run, kept, shown and judged like our own."""

import json
from functools import partial

import pytest

from motorspace._errors import UserError
from motorspace.reports.tables import filled
from motorspace.running.executors import OneProgram
from motorspace.studies import cells, study
from motorspace.studies.reproduce import execute, reproduce
from motorspace.studies.study import BUDGETS, register_study, studies, study_named
from motorspace.studies.tables import Results

PAGE = "before\n<!-- table: toy -->\n<!-- end -->\nafter\n"


@pytest.fixture
def toy(monkeypatch):
    """The toy study, known for the time of a test."""
    monkeypatch.setattr(study, "_registered", {})
    from tests.studies import toy

    register_study(toy.STUDY)
    return toy.STUDY


def test_a_study_of_ones_own_is_run_kept_shown_and_judged(toy, tmp_path, monkeypatch):
    monkeypatch.setitem(cells.TEST_TRAJECTORIES, "fifth", 8000)
    told = []
    what = {"budget": "fifth", "seeds": 1, "executor": OneProgram(), "report": told.append}
    reproduce(["toy"], tmp_path, **what)
    lines = [json.loads(line) for line in (tmp_path / "toy.jsonl").read_text().splitlines()]
    assert [line["cell"] for line in lines] == [{"trained": "no"}, {"trained": "yes"}]
    before, after = (line["metrics"]["prediction.error"] for line in lines)
    assert before > after > 0 and len(told) == 2

    results = Results(tmp_path)
    page = filled(PAGE, results.tables())
    assert page.startswith("before\n") and page.endswith("<!-- end -->\nafter\n")
    assert "| trained | prediction error | seeds |" in page
    assert len(page.splitlines()) == 8
    claims = [claim for claim in results.claims() if claim.row.study == "toy"]
    assert [claim.met for claim in claims] == [False, False]

    again = []
    reproduce(["toy"], tmp_path, **what | {"report": again.append})
    assert again == ["2 of 2 runs are finished already"]


def test_what_is_measured_is_what_the_job_asks_for(toy, tmp_path):
    job = toy.jobs("fifth", 1)[1]
    metrics = execute(job, tmp_path / "run", num=8000)
    assert metrics["prediction.num"] == 8000
    assert metrics == execute(job, tmp_path / "run", num=8000), "the run goes on where it was"


def test_a_study_may_not_take_the_name_of_ours(toy):
    other = study.Study("table1", "Which?", toy.jobs, {})
    with pytest.raises(UserError, match="already is a study 'table1'"):
        register_study(other)


def test_an_unknown_study_is_named_with_those_there_are():
    with pytest.raises(UserError, match=r"no study 'tabel1'.*choose one of ablation, "):
        study_named("tabel1")


def test_every_module_with_a_study_is_found():
    assert {"table1", "lattice", "open_points", "floor", "structure", "ablation"} < {*studies()}
    assert {"closing", "mixed_lengths", "angle_scale", "folding", "robots"} < {*studies()}


@pytest.mark.parametrize("name", [*studies()])
def test_every_job_has_a_key_of_its_own_and_a_measure(name):
    own = studies()[name]
    found = [job for budget in BUDGETS for job in own.jobs(budget, 2)]
    assert {job.study for job in found} == {name}
    assert len({job.key for job in found}) == len(found)
    assert {job.measure for job in found} <= own.measures.keys()
    assert len({job.folder for job in found}) == len(found)
    assert own.question.endswith("?")


def test_logs_are_asked_for_where_a_study_needs_them(tmp_path):
    run = partial(reproduce, out=tmp_path, budget="quick", seeds=1, executor=OneProgram())
    with pytest.raises(UserError, match=r"logs are no part of motorspace; .*--logs"):
        run(["robots"])
    with pytest.raises(UserError, match=r"freiburg-079-corrected\.log\.gz"):
        run(["robots"], logs=tmp_path)


def test_no_seeds_are_refused(tmp_path):
    with pytest.raises(UserError, match="seeds must be at least 1, got 0"):
        reproduce(["toy"], tmp_path, budget="quick", seeds=0, executor=OneProgram())
