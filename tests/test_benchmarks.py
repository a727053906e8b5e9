"""The harness measures what it says; the peers themselves are tried by `make bench`."""

import json
import time
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

from benchmarks import scaling
from benchmarks.claims import claims
from benchmarks.harness import Contender, Launch, report_once, take_turns
from benchmarks.suites import FOLDER, goals, setups, startup, suites
from benchmarks.suites.sensing import FAN, LAYOUT, MAX_RANGE, exact_ranges
from motorspace._types import Pose
from motorspace.training.settings import changed
from motorspace.worlds.layouts import layout
from motorspace.worlds.sensors.range_fan import RangeFan

ROOT = Path(__file__).parents[1]


def test_contenders_take_turns_and_rates_are_runs_per_second():
    order = []

    def slow():
        order.append("slow")
        time.sleep(0.02)

    def fast():
        order.append("fast")
        time.sleep(0.002)

    work = [Contender("slow", slow, 1), Contender("fast", fast, 1)]
    rates, first, foreign = take_turns(work, turns=2, seconds=0.05)
    turns = [name for name, before in zip(order, [None, *order], strict=False) if name != before]
    assert turns == ["slow", "fast", "slow", "fast", "slow", "fast"]
    assert len(rates["slow"]) == len(rates["fast"]) == 2
    assert max(rates["slow"]) <= 50 and max(rates["fast"]) <= 500
    assert first["slow"] >= 0.02 and foreign >= 0


def test_long_work_is_reported_by_its_seconds(tmp_path, monkeypatch):
    monkeypatch.setenv("BENCHMARK_OUT", str(tmp_path / "launch.json"))
    monkeypatch.setenv("BENCHMARK_THREADS", "2")
    report_once("long work", "times", lambda: {"motorspace": 2.0, "peer": 4.0})
    launch = Launch(**json.loads((tmp_path / "launch.json").read_text()))
    assert launch.rates == {"motorspace": [0.5], "peer": [0.25]}
    assert launch.threads == 2 and launch.peak_gib > 0


@pytest.mark.parametrize(("load", "counts"), [(0.05, True), (0.5, False)])
def test_a_launch_beside_a_busy_neighbour_does_not_count(load, counts):
    assert Launch("scans", "rays", 1, {}, {}, {}, load).counts is counts


def test_our_scans_agree_with_the_float64_oracle_of_the_benchmarks():
    world, rng = layout(LAYOUT), np.random.default_rng(0)
    assert len(world.walls) == 12
    x, y, heading = rng.uniform([[1], [1], [-3]], [[39], [39], [3]], (3, 200)).astype(np.float32)
    found = RangeFan().sense(world, Pose(*map(jnp.asarray, (x, y, heading, 0 * x))))
    exact = exact_ranges(
        np.asarray(world.walls, float), *(v.astype(float) for v in (x, y)), FAN[:, None] + heading
    )
    assert exact.min() < 2 and exact.max() == MAX_RANGE
    np.testing.assert_allclose(found, exact, atol=1e-3)


@pytest.mark.parametrize(("low", "holds"), [(20.0, True), (19.9, False)])
def test_a_rate_is_claimed_where_it_has_a_target(low, holds):
    ratio = {"median": 21.0, "low": low, "high": 22.0}
    row = {"work": "scans", "threads": 2, "peer": "Open3D", "ratio": ratio}
    (claim,) = claims([row, row | {"peer": "of no target"}])
    assert (claim.measured.mean, claim.met) == (21.0, holds)


def test_a_point_of_a_scaling_curve_is_measured_and_drawn():
    fan = RangeFan(4)
    few, many = (scaling.scans("rays", 4, layout("empty"), fan, num) for num in (10, 1000))
    assert 0 < many["seconds"] < few["seconds"]
    assert many["bytes"] >= 4 * fan.num_rays
    rows = [many | {"what": what} for what in (*scaling.CURVES, "walls, all visited")]
    panels = scaling.draw(rows).axes
    assert [len(panel.lines) for panel in panels] == [2, 1, 1, 1] * 2 + [1] * 8


@pytest.mark.slow
def test_an_update_is_measured_for_each_of_its_samples():
    sizes = {"hidden_size": 4, "code_size": 2, "width_size": 8}
    config = changed(scaling.FORWARD, {"horizon": 1, "layout": "empty"} | sizes)
    row = scaling.updates("batch", 100, config, 100)
    parameters_and_moments = 3 * 4 * 8 * 9  # one layer of the predictor, in 4 bytes each
    assert row["value"] == 100 and row["seconds"] > 0
    assert row["bytes"] * 400 > parameters_and_moments


def test_the_table_is_claimed_in_minutes():
    samples_per_second = {"median": 40_000.0, "low": 30_000.0, "high": 50_000.0}
    row = {"work": "the whole table", "threads": 2, "peer": "FMA peak", "ours": samples_per_second}
    (claim,) = claims([row | {"ratio": samples_per_second}])
    assert claim.measured.mean == pytest.approx(50.0)
    assert claim.measured.range[0] == pytest.approx(40.0)
    assert not claim.met, "the slowest launch takes 67 minutes"


@pytest.mark.parametrize(
    ("work", "ours", "measured", "holds"),
    [
        ("an epoch of the paper", 1.0, [0.01], [True]),
        ("make demo", 1 / 120, [2.0, 1.0], [True] * 2),
        ("a report on 100,000 codes", 1 / 30, [0.5, 4.5], [True, False]),
    ],
)
def test_shares_and_minutes_are_claimed_to_be_at_most_something(work, ours, measured, holds):
    even = lambda rate: dict.fromkeys(("median", "low", "high"), rate)  # noqa: E731
    row = {"work": work, "threads": 1, "peer": "another", "ours": even(ours)}
    row |= {"theirs": even(1 / 60), "ratio": even(0.01), "peak GiB": even(4.5)}
    made = claims([row])
    assert [claim.measured.mean for claim in made] == pytest.approx(measured)
    assert [claim.met for claim in made] == holds


def test_every_suite_is_a_module_with_its_launches_beside_it():
    modules = {path.stem for path in FOLDER.glob("*.py")} - {"__init__"}
    assert set(suites()) == modules
    for suite in modules:
        assert "def main() -> None:" in (FOLDER / f"{suite}.py").read_text()
        assert {setup.threads for setup in setups(suite)} <= {1, 2}


def test_every_target_is_for_a_piece_of_work_that_is_measured():
    rows = json.loads((ROOT / "results" / "benchmarks.json").read_text())["rows"]
    measured = {row["work"] for row in rows} | {name for name, *_ in startup.STARTS.values()}
    for goal in goals():
        assert goal.work in measured and (goal.at_least is None) != (goal.at_most is None)


@pytest.mark.parametrize("name", startup.STARTS)
def test_motorspace_answers_as_the_suite_expects(name, monkeypatch):
    monkeypatch.chdir(ROOT)
    _, arguments, code = startup.STARTS[name]
    startup.start(name, arguments, code=code).run()
    with pytest.raises(AssertionError):
        startup.start(name, arguments, code=code + 1).run()
