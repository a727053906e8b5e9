"""Runs whose organisation is measured: what is measured is what it is called."""

import json
from dataclasses import replace

import equinox as eqx
import jax
import numpy as np
import pytest

import motorspace as ms
from motorspace import ForwardAgent, LatticeAgent, UserError
from motorspace.analysis.coordinates import displacement_coordinates
from motorspace.experiments import organisation, paper, references, topology, topology_summary
from motorspace.models.encoder import ConstantEncoder
from motorspace.training.runs import initial_run


@pytest.fixture(scope="module", autouse=True)
def few():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(organisation, "NUM_SEQUENCES", 600)
        patch.setattr(organisation, "NUM_COMPOSED", 300)
        patch.setattr(organisation, "NUM_GROUPS", 20)
        yield


AGENT = ForwardAgent(0.8 * np.pi)


def dead_reckoned(motors):
    return displacement_coordinates(organisation.nominal(AGENT, motors), weight=1.0).points


@pytest.fixture(scope="module")
def found(few):
    return organisation.organisation(dead_reckoned, AGENT, horizon=6, seed=0)


def test_displacements_themselves_are_organised_perfectly(found):
    json.dumps(found)
    assert found["collapse"]["ratio"] < 1e-9
    assert found["collapse"]["auc"] == pytest.approx(1.0)
    assert set(found["collapse"]["by kind"]) == {"split", "permuted", "full turns", "undone"}
    assert found["composition"]["bilinear"] < 1e-6 < found["composition"]["linear"]
    assert found["lengths"]["24"]["translation"] < 1e-3
    row = topology_summary._numbers({"organisation": found, "errors": {}})
    assert row["linear R2"] > 0.9999 and row["winding"] == 1.0
    rounded = found["topology"] | {"rank correlation": [1 + 1e-9, 0.0]}
    assert topology_summary._semipartial({k: v for k, (v, _) in rounded.items()}) == 0.0


def test_motors_themselves_are_not(found):
    copied = organisation.organisation(
        lambda motors: motors.reshape(len(motors), -1), AGENT, horizon=6, seed=0
    )
    assert copied["collapse"]["ratio"] > 0.1
    assert copied["collapse"]["auc"] < 0.8
    assert copied["topology"]["partial motors"][0] > 0.9
    assert copied["lengths"] == {}


def test_lattice_sequences_are_grouped_by_their_displacement():
    agent = LatticeAgent()
    collapsed = organisation.collapse(
        lambda motors: displacement_coordinates(organisation.nominal(agent, motors)).points,
        agent,
        horizon=4,
        key=jax.random.key(0),
    )
    assert collapsed["ratio"] < 1e-9 and collapsed["by kind"] == {}


def test_what_weights_do_to_the_partial_correlation_is_told_from_copies_of_the_motors():
    """Exact displacements that weigh orientation otherwise seem to know the motors a little."""
    agent = ForwardAgent(0.4 * np.pi)
    motors = organisation.random_commands(agent, (600, 6), key=jax.random.key(0))
    moved = organisation.nominal(agent, motors)
    points = displacement_coordinates(moved).points

    def told(weight, copied=0.0):
        copies = copied * np.asarray(motors).reshape(600, -1)
        codes = np.concatenate([points[:, :2], weight * points[:, 2:], copies], axis=1)
        found = ms.topology(codes, moved, motors)
        return found.partial_motors.mean, found.partial_motors_affine.mean

    assert abs(told(1.0)[0]) < 0.01
    halved, doubled = told(0.5), told(2.0)
    assert halved[0] > 0.05 and doubled[0] < -0.05
    assert halved[0] == pytest.approx(halved[1], abs=1e-3)
    assert doubled[0] == pytest.approx(doubled[1], abs=1e-3)
    copying = told(1.0, copied=0.5)
    assert copying[0] > copying[1] + 0.1


def test_shuffled_targets_are_those_of_other_sequences():
    config = paper.cell("forward", 0.4, "quick", 0)
    size = replace(config.training, trajectories_per_epoch=50)
    config = replace(config, training=size)
    key, epoch = jax.random.key(0), jax.numpy.array(300)
    as_it_is = references.learned(config)[0](key, epoch)
    mixed = references.shuffled(config)[0](key, epoch)
    np.testing.assert_array_equal(as_it_is.motors, mixed.motors)
    assert (as_it_is.later_sensors != mixed.later_sensors).any()
    np.testing.assert_allclose(as_it_is.later_sensors.sum(), mixed.later_sensors.sum(), rtol=1e-5)
    told = references.supervised(config)[0](key, epoch)
    assert told.later_sensors.shape == (50, 4) and not told.sensors.any()


def test_a_misjudged_angle_changes_what_displacement_the_predictor_is_told():
    config = paper.variant(paper.cell("forward", 0.4, "quick", 0), "oracle")
    config = replace(config, training=replace(config.training, trajectories_per_epoch=50))
    key, epoch = jax.random.key(0), jax.numpy.array(0)
    true = references.oracle(config)[0](key, epoch)
    right = references.misjudged(config, 1.0)[0](key, epoch)
    np.testing.assert_allclose(right.motors, true.motors, atol=1e-5)
    drawn = references.learned(config)[0](key, epoch)
    double = references.misjudged(config, 2.0)[0](key, epoch)
    taken = np.asarray(drawn.motors) * [2.0, 1.0]
    x, y, turn = organisation.nominal(AGENT, taken).T
    told = np.stack([x / 6, y / 6, np.cos(turn), np.sin(turn)], axis=1)
    np.testing.assert_allclose(double.motors[:, 0], told, atol=1e-5)
    np.testing.assert_array_equal(double.later_sensors, true.later_sensors)


def test_errors_of_misjudged_angles_are_compared_within_a_seed():
    runs = [
        {"name": f"angle/0.2 x {angle}", "seed": seed, "errors": {"model": factor * (1 + seed)}}
        for seed in range(2)
        for angle, factor in ((0.9, 1.5), (1.0, 1.0))
    ]
    wrong, right = topology_summary.angle_rows(runs)
    assert (wrong["angle"], wrong["error"]["mean"], wrong["ratio"]["mean"]) == (0.9, 2.25, 1.5)
    assert wrong["ratio"]["low"] == wrong["ratio"]["high"] == 1.5
    assert right["ratio"]["mean"] == 1.0


def test_every_job_has_a_folder_of_its_own_and_every_row_a_job():
    jobs = topology.topology_jobs("fifth", seeds=2) + topology.ablation_jobs("fifth", seeds=2)
    jobs += topology.closing_jobs("fifth", seeds=2) + topology.angle_jobs("fifth", seeds=2)
    jobs += topology.mixed_jobs("fifth", seeds=2)
    folders = [job.folder for job in jobs]
    assert len(set(folders)) == len(folders)
    named = {job.name for job in jobs}
    assert all(f"topology/forward-0.8 {row}" in named for row in topology_summary.ROWS)
    assert all(f"topology/lattice {kind}" in named for kind in paper.LATTICE_KINDS)
    best = next(job for job in jobs if job.name == "topology/holonomic-1.2 best")
    assert best.config.model.encoder == "group"
    assert best.config.training.epochs == 1000


def test_a_run_of_many_lengths_is_measured_at_one(monkeypatch):
    job = topology.mixed_jobs("quick", seeds=1)[0]
    simulation = job.config.simulation
    assert (simulation.min_horizon, simulation.horizon) == (1, 12)
    measured = []
    monkeypatch.setattr(topology, "organised", lambda run, num: measured.append(run.config) or {})
    job.measure(initial_run(job.config), 10)
    at_six = paper.changed(paper.cell("forward", 0.2, "quick", 0), topology.BEST)
    assert measured == [at_six]


@pytest.fixture(scope="module")
def untrained():
    """A fresh network of `best`."""
    return initial_run(paper.changed(paper.cell("forward", 0.2, "quick", 0), topology.BEST))


def test_a_group_is_told_in_standard_form_as_well(found, untrained):
    encode = topology.standard_encoder_of(untrained)
    standard = organisation.measures(encode, AGENT, horizon=6, seed=0)
    told = {"organisation": found | {"standard form": standard}, "errors": {}}
    row = topology_summary._numbers(told)
    assert row["rank correlation, standard"] == standard["rank correlation"][0] < 1
    assert row["rank correlation"] == found["topology"]["rank correlation"][0]


def test_codes_that_are_no_matrices_have_no_standard_form(untrained):
    model = eqx.tree_at(lambda m: m.encoder, untrained.model, ConstantEncoder(6))
    with pytest.raises(UserError, match="have no standard form"):
        topology.standard_encoder_of(replace(untrained, model=model))


def test_lengths_trained_at_stand_side_by_side(found):
    names = ("mixed/forward-0.2", "topology/forward-0.2 best", "topology/forward-0.6 best")
    runs = [{"name": n, "epochs": 10, "organisation": found, "errors": {}} for n in names]
    rows = topology_summary.mixed_rows(runs)
    assert {r["rotation"] for r in rows} == {0.2}
    assert [r["trained at"] for r in rows] == ["T = 6", "T = 1 to 12"]


def test_rows_and_targets(found):
    errors = {"model": 2.0}
    runs = [
        {"name": f"topology/forward-0.8 {row}", "epochs": 10, "organisation": found}
        | {"errors": errors if row in ("best", "paper") else {}}
        for row in ("best", "best", "paper", "raw motors")
    ]
    runs.append(runs[0] | {"name": "topology/lattice with-inverse"})
    rows = topology_summary.topology_rows(runs)
    counted = [("best", 2), ("paper", 1), ("raw motors", 1), ("with-inverse", 1)]
    assert [(r["row"], r["seeds"]) for r in rows] == counted
    assert (rows[-1]["agent"], rows[-1]["rotation"]) == ("lattice", None)
    claims = topology_summary.topology_claims(rows)
    assert len(claims) == len(topology_summary.TARGETS) + 1
    assert all(claim["holds"] for claim in claims if "R2" in claim["claim"])
    worse = json.loads(json.dumps(rows))
    worse[0]["linear R2"] = {"mean": 0.995, "low": 0.98, "high": 1.0}
    assert not topology_summary.topology_claims(worse)[0]["holds"]


def test_the_interval_of_the_mean():
    assert topology_summary.interval([3.0]) == {"mean": 3.0, "low": 3.0, "high": 3.0}
    found = topology_summary.interval([1.0, 2.0, 3.0, 4.0])
    assert found["mean"] == 2.5 and 1.0 <= found["low"] < 2.5 < found["high"] <= 4.0


def test_the_share_of_turns_is_that_of_random_commands():
    drawn = np.random.default_rng(0).uniform(-0.8, 0.8, (100_000, 6))
    turns = np.abs(np.round(drawn.sum(axis=1) / 2))
    for count in (1, 2):
        share = topology_summary.share_of_turns(0.8, count)
        assert share == pytest.approx(np.mean(turns == count), abs=0.005)
    assert topology_summary.share_of_turns(0.4, 2) == 0.0


def test_what_is_drawn_seldom_is_told_beside_how_seldom(found):
    run = {"name": "topology/forward-0.8 best", "epochs": 10, "organisation": found, "errors": {}}
    rows = topology_summary.drawn_rows(topology_summary.topology_rows([run]))
    assert [row["turns"] for row in rows] == [1, 2, 3]
    assert rows[0]["drawn"] > rows[1]["drawn"] > rows[2]["drawn"] >= 0
    assert all(row["ratio"]["mean"] < 1e-9 for row in rows)


def test_codes_that_are_dead_leave_their_error_alone(found, untrained):
    model = eqx.tree_at(lambda m: m.encoder, untrained.model, ConstantEncoder(6))
    dead = topology.organised_encoder(replace(untrained, model=model), 0)
    assert dead["organisation"] is None
    dead |= {"errors": {"model": 9.0}, "name": "topology/forward-0.8 best"}
    rows = topology_summary.topology_rows([dead | {"seed": 1}, dead | {"organisation": found}])
    assert [(r["seeds"], r["error"]["mean"], "linear R2" in r) for r in rows] == [(2, 9.0, False)]
    (claim,) = topology_summary.topology_claims(rows)
    assert (claim["measured"], claim["holds"]) == (1, False)


def test_changes_stand_between_the_papers_system_and_best(found):
    names = ("ablation/gru", "topology/holonomic-0.8 best", "topology/holonomic-0.8 paper")
    runs = [{"name": n, "epochs": 10, "organisation": found, "errors": {}} for n in names]
    rows = topology_summary.ablation_rows(runs)
    assert [row["change"] for row in rows] == ["paper", "gru", "best"]
