"""The studies of navigation: their rows, their tables, and one row of each in small."""

from dataclasses import replace
from functools import partial

import pytest

from motorspace.navigation.config import PPOConfig
from motorspace.studies import navigation, transfer
from motorspace.studies.rows import Row, known_measure
from motorspace.training.run import initial_run
from motorspace.training.settings import changed
from tests.tiny import TINY

LEARNED = {"agent": "forward", "codes": "learned"}


def numbers(task, name, **values):
    """What a network was measured at in one row: each value for two policies."""
    return {
        f"{policy}/{task}/{name}/navigation.{key.replace('_', '.')}": value
        for key, both in values.items()
        for policy, value in enumerate(both)
    }


def found():
    coded, true, chance = (
        partial(numbers, task="home", name=name)
        for name in ("chained code", "true displacement", "chance")
    )
    first = coded(unseen_success=(0.90, 0.96), unseen_steps=(9.0, 11.0))
    first |= true(unseen_success=(0.95, 0.95), unseen_steps=(10.0, 10.0))
    second = coded(unseen_success=(0.97, 1.00), unseen_steps=(9.0, 11.0))
    second |= true(unseen_success=(0.98, 0.99), unseen_steps=(10.0, 10.0))
    runs = {0: first | chance(unseen_success=(0.2, 0.2)), 1: second}
    labelled = {0: numbers("home", "supervised code", unseen_success=(0.5, 0.7))}
    return [
        Row("navigation", LEARNED, 10, runs),
        Row("navigation", LEARNED | {"codes": "supervised"}, 10, labelled),
    ]


def test_the_policies_of_all_networks_are_the_seeds_of_a_row():
    rows = navigation.rows(found())
    by_name = {row.cell["observed"]: row for row in rows if row.cell["task"] == "home"}
    assert sorted(by_name["chained code"].runs) == [0, 1, 2, 3]
    assert sorted(by_name["supervised code"].runs) == [0, 1]
    shown = {
        line["observed"]: line for line in navigation.STUDY.tables["navigation_home"].lines(rows)
    }
    assert shown["chained code"]["goals reached, unseen"]["mean"] == pytest.approx(0.965)
    assert shown["chained code"]["policies"] == 4


def test_rows_are_held_against_the_true_displacement_seed_by_seed():
    by_name = {row.cell["observed"]: row for row in navigation.rows(found())}
    lead = by_name["chained code"]["navigation.lead.success"].values
    assert lead == pytest.approx((0.05, -0.01, 0.01, -0.01))
    assert by_name["chained code"]["navigation.share.steps"].mean == pytest.approx(1.0)
    assert by_name["true displacement"]["navigation.lead.success"].values == (0, 0, 0, 0)
    assert "navigation.lead.success" not in by_name["supervised code"], "it has no commands"


def test_a_row_of_both_tasks_stands_in_the_aggregate():
    rows = navigation.rows(found())
    assert navigation.aggregated(rows) == []
    far = numbers("displacement_goal", "chained code", unseen_success=(0.5, 0.5))
    spl = numbers("home", "chained code", unseen_spl=(0.5, 0.5))
    spl |= numbers("displacement_goal", "chained code", unseen_spl=(0.3, 0.3))
    first = found()[0].runs[0] | far | spl
    rows = navigation.rows([Row("navigation", LEARNED, 10, {0: first})])
    (line,) = navigation.aggregated(rows)
    assert line["observed"] == "chained code" and line["SPL"]["mean"] == pytest.approx(0.4)


def test_every_target_and_head_is_a_measure():
    for study in (navigation.STUDY, transfer.STUDY):
        assert all(known_measure(target.measure) for target in study.targets)
    assert all(map(known_measure, navigation.HEADS.values()))


def test_every_row_is_learned_by_somebody():
    for row in navigation.OBSERVATIONS.values():
        assert row.codes in navigation.CODES and set(row.tasks) <= set(navigation.STEPS)
    jobs = navigation.jobs("fifth", 2)
    assert {job.measure for job in jobs} <= set(navigation.STUDY.measures)
    assert len({(job.cell, job.seed) for job in jobs}) == len(jobs) == 6


def test_scores_of_transfer_are_relative_to_a_policy_trained_there():
    place = transfer.PLACES[1]
    keys = {"success": 0.9, "diagonal": 0.96, "chance": 0.3}
    runs = {0: {f"{place.name}/paper/transfer.{key}": value for key, value in keys.items()}}
    rows = transfer.rows([Row("transfer", {"agent": "forward"}, 10, runs)])
    assert len(rows) == len(transfer.PLACES) * len(transfer.LAYOUTS)
    (row,) = [row for row in rows if "transfer.share" in row]
    assert row["transfer.share"].mean == pytest.approx(0.9375)
    assert row.matches({"body": place.body, "sensor": place.fan, "layout": "paper"})


SMALL = {
    "num_layouts": 2, "level": 1, "max_steps": 4,
    "ppo": PPOConfig(num_agents=4, num_steps=4, num_minibatches=1, num_epochs=1),
}  # fmt: skip


@pytest.fixture
def few(monkeypatch):
    """Few problems, and few updates of what decodes."""
    monkeypatch.setattr("motorspace.navigation.measuring.AGENTS_AT_ONCE", 4)
    monkeypatch.setattr("motorspace.navigation.measuring.NUM_PROBLEMS", 4)
    monkeypatch.setattr(navigation, "NUM_BESIDE", 4)
    monkeypatch.setattr(navigation, "CONTROL_UPDATES", 2)
    monkeypatch.setattr(transfer, "CONTROL_UPDATES", 2)


@pytest.mark.slow
def test_a_row_is_learned_and_measured(monkeypatch, few):
    config = changed(TINY, {"encoder": "matrix_product", "code_size": 6, "seed": 3})
    row = navigation.Observed({"observe": ("ranges", "code")} | SMALL, ("displacement_goal",))
    once = replace(row, networks=4)
    monkeypatch.setattr(navigation, "OBSERVATIONS", {"ranges": row, "once": once})
    monkeypatch.setattr(navigation, "STEPS", {"displacement_goal": 10})
    measured = navigation.measured(initial_run(config), 0, codes="learned")
    place = "displacement_goal/ranges/navigation"
    assert measured[f"0/{place}.seen.num"] == measured[f"1/{place}.unseen.num"] == 4
    assert 0 <= measured["1/displacement_goal/chance/navigation.unseen.success"] <= 1
    assert measured["0/displacement_goal/planner/navigation.unseen.success"] == 1
    assert any(key.startswith("0/displacement_goal/once") for key in measured)
    assert not any(key.startswith("1/displacement_goal/once") for key in measured)


@pytest.mark.slow
def test_cells_of_transfer_are_filled(monkeypatch, few):
    config = changed(TINY, {"encoder": "matrix_product", "code_size": 6})
    monkeypatch.setattr(transfer, "ADAPTER", {"epochs": 1, "restarts": 1})
    monkeypatch.setattr(transfer, "STEPS", 10)
    monkeypatch.setattr(transfer, "LAYOUTS", {"training rooms": "train"})
    small = transfer.configuration

    def configuration(*given):
        return replace(small(*given), **SMALL)

    monkeypatch.setattr(transfer, "configuration", configuration)
    measured = transfer.measured(initial_run(config), 0)
    rows = transfer.rows([Row("transfer", {}, 1, {0: measured})])
    assert all("transfer.chance" in row for row in rows) and len(rows) == 6
