"""A judge in a room whose walls are known: what it learns of its body, where it is, what comes."""

import json
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace import se2
from motorspace._errors import UserError
from motorspace.judge import belief, codes, places, roadmap
from motorspace.judge.judge import Calibration, Judge
from motorspace.judge.store import ARRAYS, DESCRIPTION, load_judge, save_judge
from motorspace.mapping import calibration, lines, mounting, odometry, smoothing, walls
from motorspace.mapping.walks import Walk, joined, walk
from motorspace.worlds.agents import ForwardAgent, HolonomicAgent, LatticeAgent
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.sensors.node_index import NodeIndex

ROOM = """title a room with a corner of its own
bounds 0 0 12 9
wall 4 0 4 3
solid 8 5 10 5 10 7
"""
NUM_STEPS = 600


@pytest.fixture(scope="module")
def scenario():
    return Scenario(ROOM, ForwardAgent(max_rotation=0.4 * math.pi))


@pytest.fixture(scope="module")
def walked(scenario):
    return joined(
        walk(scenario, num_steps=NUM_STEPS, num_walks=4, manner="random", key=jax.random.key(0)),
        walk(scenario, num_steps=NUM_STEPS, num_walks=4, key=jax.random.key(1)),
    )


def true_odometry(turn=1.0, length=1.0):
    """The forward agent's, by what it multiplies rotations and moves with."""
    commands = np.random.default_rng(0).uniform([-1.2, 0.0], [1.2, 1.0], (500, 2))
    angle, ahead = turn * commands[:, 0], length * commands[:, 1]
    targets = [ahead * np.cos(angle), ahead * np.sin(angle), np.cos(angle), np.sin(angle)]
    known = odometry.features(commands)
    step = np.linalg.lstsq(known, np.stack(targets, axis=-1), rcond=None)[0]
    nothing = np.zeros((len(step), 3))
    return odometry.Odometry(step, step * 0, nothing, nothing, has_gaze=False)


def true_mounting():
    return mounting.Mounting(np.linspace(-np.pi / 2, np.pi / 2, 9), np.zeros(2), 10.0)


@pytest.fixture(scope="module")
def judge(scenario):
    body = calibration.Calibrated(true_odometry(), true_mounting())
    # Displacements for codes: what is read is what is given.
    drawn = np.random.default_rng(1).uniform(-2, 2, (3, 4_000))
    given = np.stack([drawn[0], drawn[1], np.cos(drawn[2]), np.sin(drawn[2])], axis=-1)
    explored = walk(scenario, num_steps=NUM_STEPS, key=jax.random.key(2))
    return Judge(Calibration(body, codes.fitted(given, drawn)), explored)


def test_a_walk_is_what_its_commands_do(scenario, walked):
    frames = true_odometry().bodies(walked.motors)
    assert walked.sensors.shape == (NUM_STEPS + 1, 8, 9)
    # Who sensed a wall straight ahead and moved towards it senses it nearer by the move.
    moves = se2.relative(frames[:, :-1], frames[:, 1:])
    ahead, calm = walked.sensors[..., 4], np.abs(moves[2]) < 0.01
    shorter = (ahead[:-1] - ahead[1:])[calm]
    assert np.median(np.abs(shorter - moves[0][calm])) < 0.03


def test_straight_walks_get_farther(walked):
    frames = true_odometry().bodies(walked.motors[:20])
    reached = np.hypot(*frames[:2, -1])
    assert reached[4:].mean() > reached[:4].mean()


def test_windows_are_pieces_of_the_walks(walked):
    pieces = walked.windows(50, 16)
    assert pieces.motors.shape == (50, 16, 2) and pieces.sensors.shape == (51, 16, 9)
    assert np.array_equal(pieces.motors[:, :8], walked.motors[:50])


def test_discrete_commands_are_refused():
    lattice = Scenario("lattice:4", LatticeAgent(), NodeIndex())
    with pytest.raises(UserError, match="discrete"):
        walk(lattice, num_steps=2, key=jax.random.key(0))


def test_features_span_rigid_motions():
    learned = true_odometry()
    commands = np.random.default_rng(5).uniform([-1.2, 0.0], [1.2, 1.0], (50, 2))
    angle, ahead = commands.T
    expected = np.stack([ahead * np.cos(angle), ahead * np.sin(angle), angle])
    assert np.allclose(learned.steps(commands), expected, atol=1e-9)


def test_twists_compose():
    half = np.array([0.3, -0.2, 0.4])
    whole = odometry.exponential(2 * half)
    assert np.allclose(se2.compose(odometry.exponential(half), odometry.exponential(half)), whole)


def test_rays_are_found_by_how_readings_change(walked):
    frames = true_odometry().bodies(walked.motors)
    found, unit = mounting.find_mounting(
        frames / np.array([2.0, 2.0, 1.0])[:, None, None],
        walked.sensors,
        point=np.zeros(2),
        reach=10.0,
    )
    assert unit == pytest.approx(2.0, rel=0.15)
    assert np.abs(found.angles - true_mounting().angles).max() < 0.25


def test_readings_that_are_no_distances_are_refused(walked):
    frames = true_odometry().bodies(walked.motors)
    strange = walked.sensors.copy()
    strange[..., 3] = 1.0
    with pytest.raises(UserError, match="readings 3 do not shorten"):
        mounting.find_mounting(frames, strange, point=np.zeros(2), reach=10.0)


def test_calibration_mends_odometry_and_rays(walked):
    rays = true_mounting()
    bent = rays._replace(angles=rays.angles + 0.05 * np.sin(np.arange(9)))
    wrong = calibration.Calibrated(true_odometry(turn=1.02), bent)
    level = calibration.Level(12, 300, 0.1, (0.04, 0.03, 0.02, 0.01, 0.01, 0.005))
    mended = calibration.calibrate_on(walked, wrong, (level,))
    commands = np.stack([np.linspace(-1.2, 1.2, 20), np.full(20, 0.5)], axis=-1)
    off = [
        np.abs(body.odometry.steps(commands)[2] - commands[:, 0]).mean() for body in (wrong, mended)
    ]
    assert off[1] < 0.15 * off[0]
    spacing = np.diff(mended.mounting.angles)
    assert np.abs(spacing - np.pi / 8).max() < 0.2 * np.abs(np.diff(bent.angles) - np.pi / 8).max()


def test_smoothing_closes_a_drifting_walk(scenario):
    explored = walk(scenario, num_steps=NUM_STEPS, key=jax.random.key(3))
    true = calibration.Calibrated(true_odometry(), true_mounting()).eyes(explored)[..., 0]
    drifting = calibration.Calibrated(true_odometry(1.001, 1.002), true_mounting())
    eyes = drifting.eyes(explored)[..., 0]
    rays = true_mounting()
    found = smoothing.smoothed(eyes, explored.sensors[:, 0], rays)

    def inconsistency(eyes):
        """How far the frames are from a common motion of the true ones."""
        offsets = se2.compose(eyes, se2.inverse(true))
        return np.hypot(*(offsets[:2] - np.median(offsets[:2], axis=1)[:, None])).mean()

    assert inconsistency(found) < 0.3 * inconsistency(eyes)


def test_lines_ignore_outliers():
    x = np.linspace(0.1, 0.9, 50)
    points = np.stack([x, 0.5 + 0 * x])
    points[1, 7] = 0.9
    found = lines.fit_lines(points, np.zeros(50, int), cell=1.0, tolerance=0.02)
    assert abs(found.off[7]) == pytest.approx(0.4, abs=0.01)
    assert found.weight[7] < 1e-4 < found.weight[8]
    assert found.usable(10.0).all()


def test_a_map_shows_the_walls_that_made_it():
    side = np.linspace(-4, 4, 4_000)
    points = np.stack([np.full(4_000, 3.0), side])
    seen = walls.map_walls(points, reach=10.0)
    eyes = jnp.array([[0.0, 0.0], [0.0, 1.0], [0.0, np.pi]])
    ranges = np.asarray(seen.ranges(eyes, jnp.array([-0.5, 0.0, 0.5])))
    assert ranges[0] == pytest.approx([3 / math.cos(0.5), 3.0, 3 / math.cos(0.5)], abs=1e-3)
    assert ranges[1] == pytest.approx([10.0] * 3)


def test_places_that_sense_alike_are_found(judge):
    true = judge.eyes[:, 77]
    found = judge.where(judge.sensors[77])
    assert found.weight.sum() == pytest.approx(1.0)
    best = found.eyes[:, np.argmax(found.weight)]
    assert np.hypot(*(best - true)[:2]) < 0.05
    assert abs(np.sin((best - true)[2] / 2)) < 0.02


def test_a_judge_foresees_its_own_walk(judge):
    moved = se2.relative(judge.eyes[:, :-6], judge.eyes[:, 6:])
    given = np.stack([moved[0], moved[1], np.cos(moved[2]), np.sin(moved[2])], axis=-1)
    rows = range(10, 500, 25)
    off = np.array(
        [
            judge.predict(judge.sensors[row], given[row : row + 1])[0] - judge.sensors[row + 6]
            for row in rows
        ]
    )
    still = np.array([judge.sensors[row] - judge.sensors[row + 6] for row in rows])
    assert np.mean(off**2) < 0.1 * np.mean(still**2)


def test_the_likeliest_code_is_the_one_that_leads_there(judge):
    moved = se2.relative(judge.eyes[:, :-6], judge.eyes[:, 6:])[:, 50:250:10]
    given = np.stack([moved[0], moved[1], np.cos(moved[2]), np.sin(moved[2])], axis=-1)
    scores = judge.log_likelihood(judge.sensors[100], given, judge.sensors[106])
    assert scores.shape == (20,) and int(np.argmax(scores)) == 5


def test_the_way_to_what_it_senses_elsewhere_is_found(judge):
    displacements, weight = judge.ways(judge.sensors[100], judge.sensors[106])
    true = se2.relative(judge.eyes[:, 100], judge.eyes[:, 106])
    assert weight.sum() == pytest.approx(1.0)
    assert np.abs(displacements[:, np.argmax(weight)] - true).max() < 0.1


def test_the_origin_of_rays_moves_differently_from_the_body():
    aside = true_mounting()._replace(origin=np.array([0.5, 0.0]))
    turned = np.array([[0.0], [0.0], [np.pi]])
    assert np.allclose(aside.seen(turned)[:2, 0], [-1.0, 0.0])
    assert np.allclose(aside.unseen(aside.seen(turned)), turned)


def test_a_saved_judge_is_the_same(judge, tmp_path):
    save_judge(judge, tmp_path)
    codes_given = np.array([[1.0, 0.0, 1.0, 0.0], [0.0, 0.5, 0.0, 1.0]])
    first = judge.predict(judge.sensors[5], codes_given)
    assert np.allclose(load_judge(tmp_path).predict(judge.sensors[5], codes_given), first, atol=0.1)


def test_broken_folders_are_refused(judge, tmp_path):
    with pytest.raises(UserError, match="no judge here"):
        load_judge(tmp_path)
    save_judge(judge, tmp_path)
    (tmp_path / ARRAYS).write_bytes(b"damaged")
    with pytest.raises(UserError, match="cannot be read"):
        load_judge(tmp_path)
    save_judge(judge, tmp_path)
    (tmp_path / DESCRIPTION).write_text(json.dumps({"format_version": 9}))
    with pytest.raises(UserError, match="version 9"):
        load_judge(tmp_path)


def test_hypotheses_that_are_the_same_count_as_one():
    eyes = np.array([[0.0, 0.001, 5.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    found = places._merged(eyes, np.array([0.1, 0.0, 0.0]), 10.0)
    assert len(found.weight) == 2
    assert found.weight[0] == pytest.approx((1 + math.exp(-0.2)) / (2 + math.exp(-0.2)))
    assert found.eyes[0, 0] == 0.001


def test_a_walk_that_meets_no_wall_teaches_nothing():
    body = calibration.Calibrated(true_odometry(), true_mounting())
    book = codes.fitted(np.random.default_rng(0).normal(size=(99, 3)), np.zeros((3, 99)))
    unmet = Walk(np.full((600, 1, 2), 0.1), np.full((601, 1, 9), 10.0))
    with pytest.raises(UserError, match="no ray has met"):
        Judge(Calibration(body, book), unmet)


def test_gazes_follow_the_head():
    agent = HolonomicAgent(max_rotation=0.4)
    explored = walk(Scenario(ROOM, agent), num_steps=3, key=jax.random.key(0))
    assert explored.motors.shape == (3, 1, 4)
    assert odometry.features(explored.motors).shape[-1] == 4 * 4 + 4 + 2 * 4 * 3 + 1


def test_who_looks_aside_is_known_at_rest():
    looking = odometry.Odometry(*true_odometry()[:4], has_gaze=True)
    # The gaze of this body turns and moves with the command as its steps do.
    looking = looking._replace(gaze=looking.step)
    body = calibration.Calibrated(looking, true_mounting())
    motor = np.array([0.7, 0.3])
    aside = looking.gazes(motor[None])
    back = body.at_rest(np.asarray(aside), motor)
    assert np.allclose(back, looking.gazes(np.zeros((1, 2))), atol=1e-6)


def test_odometry_tells_places_apart_that_sense_alike(judge):
    """After some steps the belief is one place, though it began with a wrong one as likely."""
    begun = judge.eyes[:, 200]
    wrong = np.array([begun[0] + 3.0, begun[1] - 2.0, begun[2] + 1.0])
    alike = places.Hypotheses(np.stack([wrong, begun], axis=1), np.array([0.9, 0.1]))
    explored = walk(
        Scenario(ROOM, ForwardAgent(max_rotation=0.4 * math.pi)),
        num_steps=NUM_STEPS,
        key=jax.random.key(2),
    )
    found = belief.updated(
        judge,
        belief.Belief(alike, np.zeros(2)),
        explored.motors[200:206, 0],
        judge.sensors[206],
    )
    assert np.hypot(*(found.likeliest - judge.eyes[:, 206])[:2]) < 0.1


def test_an_unexpected_place_is_found_again(judge):
    lost = places.Hypotheses(judge.eyes[:, 400:401] + 2.0, np.ones(1))
    found = judge.places.tracked(judge.sensors[100], lost)
    best = found.eyes[:, np.argmax(found.weight)]
    assert np.hypot(*(best - judge.eyes[:, 100])[:2]) < 0.1


@pytest.fixture(scope="module")
def divided():
    """A roadmap on both sides of a wall with a gap at its upper end."""
    along = np.linspace(0.0, 6.0, 3_000)
    seen = walls.map_walls(np.stack([np.full(3_000, 4.0), along]), reach=10.0)
    x, y = np.meshgrid(np.arange(0.2, 8.0, 0.5), np.arange(0.2, 8.0, 0.5))
    return roadmap.Roadmap(seen, np.stack([x.ravel(), y.ravel(), 0 * x.ravel()]))


def test_ways_lead_around_walls(divided):
    lengths = divided.lengths(np.array([5.0, 1.0]))
    left = divided.left(np.array([[3.0, 5.0, 5.0], [1.0, 1.0, 3.0]]), lengths)
    around = 2 * math.hypot(1.0, 5.2)
    assert around < left[0] < 1.3 * around
    assert left[1] < 0.8 and 2.0 <= left[2] < 2.4


def test_walls_stand_before_or_behind_the_end_of_a_way(divided):
    ends = np.array([[3.5, 4.5], [3.0, 3.0]])
    room = walls.clearance(divided.walls, np.array([[1.0, 1.0], [3.0, 3.0]]), ends)
    assert np.allclose(room, [0.5, -0.5], atol=0.02)
