"""The study of navigation: its rows, its tables, and one row of it in small."""

import pytest

from motorspace.navigation.config import PPOConfig
from motorspace.studies import navigation
from motorspace.studies.rows import Row, known_measure
from motorspace.training.run import initial_run
from motorspace.training.settings import changed
from tests.tiny import TINY


def test_every_row_stands_in_its_table():
    place = "home/chained code/navigation"
    numbers = [{f"{place}.seen.success": value} for value in (0.9, 0.96, 0.97, 1.0)]
    numbers[0]["home/chance/navigation.unseen.success"] = 0.2
    found = navigation.rows([Row("navigation", {"agent": "forward"}, 10, dict(enumerate(numbers)))])
    lines = navigation.STUDY.tables["navigation_home"].lines(found)
    by_name = {line["observed"]: line for line in lines}
    assert set(by_name) == {*navigation.OBSERVATIONS, "chance", "planner"}
    shown = by_name["chained code"]
    assert shown["goals reached, seen"]["mean"] == pytest.approx(0.965) and shown["seeds"] == 4
    assert "goals reached, unseen" not in by_name["chance"], "one seed of four has it"


def test_every_target_and_head_is_a_measure():
    keys = [target.measure for target in navigation.STUDY.targets]
    assert all(map(known_measure, [*keys, *navigation.HEADS.values()]))


@pytest.mark.slow
def test_a_row_is_learned_and_measured(monkeypatch):
    config = changed(TINY, {"encoder": "matrix_product", "code_size": 6})
    small = {
        "observe": ("ranges", "code"), "num_layouts": 2, "level": 1, "max_steps": 4,
        "ppo": PPOConfig(num_agents=4, num_steps=4, num_minibatches=1, num_epochs=1),
    }  # fmt: skip
    monkeypatch.setattr(navigation, "OBSERVATIONS", {"chained code": small})
    monkeypatch.setattr(navigation, "STEPS", {"displacement_goal": 10})
    monkeypatch.setattr("motorspace.navigation.measuring.AGENTS_AT_ONCE", 4)
    monkeypatch.setattr("motorspace.navigation.measuring.NUM_PROBLEMS", 4)
    found = navigation.measured(initial_run(config), 0, share=1.0)
    place = "displacement_goal/chained code/navigation"
    assert found[f"{place}.seen.num"] == found[f"{place}.unseen.num"] == 4
    assert 0 <= found["displacement_goal/chance/navigation.unseen.success"] <= 1
    assert found["displacement_goal/planner/navigation.unseen.success"] == 1
