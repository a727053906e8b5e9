"""A walk put together from biased and noisy odometry, and its parts one by one."""

import numpy as np
import pytest

from motorspace import se2
from motorspace._errors import UserError
from motorspace.analysis.paths import absolute_error, coverage, relative_errors
from motorspace.mapping.matching import Matches, match
from motorspace.mapping.motion import chained, chained_covariance, fit_motion
from motorspace.mapping.occupancy import agreement, grid_around, occupancy
from motorspace.mapping.pose_graph import Edges, chordal, joined, optimised
from motorspace.mapping.scores import measure_loops
from motorspace.mapping.search import Window, images, search
from motorspace.mapping.survey import NO_EDGES, Scans, survey
from tests.mapping.rooms import REACH, mounting, ranges, steps_of, walk

TRUTH = walk()
RAYS = mounting()
SENSORS = ranges(TRUTH, RAYS.angles)


def badly_known(steps: np.ndarray, seed: int = 0) -> np.ndarray:
    random = np.random.default_rng(seed)
    noisy = steps * (1 + 0.05 * random.normal(size=steps.shape))
    return noisy + np.array([[0.0], [0.0], [0.02]])


def certain(displacement: np.ndarray) -> Matches:
    num = displacement.shape[1]
    return Matches(displacement, np.tile(1e6 * np.eye(3), (num, 1, 1)), np.ones(num))


@pytest.fixture(scope="module")
def found():
    return survey(Scans(SENSORS, badly_known(steps_of(TRUTH)), RAYS))


def test_a_walk_comes_out_right(found):
    raw = absolute_error(chained(badly_known(steps_of(TRUTH))), TRUTH)
    assert raw > 1.0
    assert absolute_error(found.local, TRUTH) < raw
    assert absolute_error(found.poses, TRUTH) < 0.1


def test_loops_are_found_and_right(found):
    scores = measure_loops(found.loops, TRUTH, reach=REACH)
    assert scores["loops.num"] > 20
    assert scores["loops.precision"] > 0.9
    assert scores["loops.recall"] > 0.5


def test_maps_agree_where_paths_do(found):
    grid = grid_around(TRUTH, SENSORS, RAYS, cell=0.5)
    aligned = se2.compose(np.broadcast_to(TRUTH[:, :1], TRUTH.shape), found.poses)
    lost = se2.compose(
        np.broadcast_to(TRUTH[:, :1], TRUTH.shape), chained(badly_known(steps_of(TRUTH)))
    )
    drawn, bad, true = (
        occupancy(np.asarray(path), SENSORS, RAYS, cell=0.5, grid=grid)
        for path in (aligned, lost, TRUTH)
    )
    assert agreement(true, true) == 1
    assert agreement(drawn, true) > 0.6
    assert agreement(bad, true) < agreement(drawn, true)


def test_scans_without_walls_cannot_be_matched():
    nothing = np.full_like(SENSORS, REACH)
    with pytest.raises(UserError, match="pairs of neighbouring scans can be matched"):
        survey(Scans(nothing, steps_of(TRUTH), RAYS))


def test_a_match_finds_the_displacement():
    views = Scans(SENSORS, steps_of(TRUTH), RAYS).views()
    pairs = np.stack([np.arange(0, 100, 10), np.arange(2, 102, 10)])
    right = se2.relative(TRUTH[:, pairs[0]], TRUTH[:, pairs[1]])
    guess = right + np.array([[0.15], [-0.1], [0.05]])
    found = match(views, pairs, guess, reach=REACH, spread=(0.1, 0.2))
    x, y, turn = se2.relative(right, found.displacement)
    assert np.median(np.hypot(x, y)) < 0.02
    assert np.median(np.abs(turn)) < 0.005
    assert found.share.min() > 0.3


def test_poses_from_a_graph_whose_start_is_nonsense():
    random = np.random.default_rng(0)
    num = TRUTH.shape[1]
    first = np.concatenate([np.arange(num - 1), random.integers(0, num // 2, 60)])
    second = np.concatenate([np.arange(1, num), random.integers(num // 2, num, 60)])
    displacement = np.asarray(se2.relative(TRUTH[:, first], TRUTH[:, second]))
    edges = Edges(first, second, displacement, np.broadcast_to(np.eye(3) * 1e4, (len(first), 3, 3)))
    should = se2.relative(np.broadcast_to(TRUTH[:, :1], TRUTH.shape), TRUTH)
    start = chordal(edges, num)
    np.testing.assert_allclose(start[:2], np.asarray(should)[:2], atol=1e-5)
    off = start + 0.1 * random.normal(size=start.shape) * (np.arange(num) > 0)
    np.testing.assert_allclose(optimised(edges, NO_EDGES, off)[:2], start[:2], atol=1e-5)


def test_a_wrong_loop_is_not_believed():
    num = TRUTH.shape[1]
    steps = steps_of(TRUTH)
    odometry = Edges(
        np.arange(num - 1),
        np.arange(1, num),
        steps,
        np.broadcast_to(np.eye(3) * 1e4, (num - 1, 3, 3)),
    )
    wrong = Edges(
        np.array([3]), np.array([90]), np.array([[5.0], [4.0], [2.0]]), np.eye(3)[None] * 1e3
    )
    poses = optimised(odometry, wrong, chained(steps))
    assert absolute_error(poses, TRUTH) < 0.2
    assert len(joined(odometry, wrong).first) == num


def test_covariance_holds_what_it_says():
    random = np.random.default_rng(0)
    num = 4000
    true = np.stack([random.uniform(0, 1, num), np.zeros(num), random.uniform(-1, 1, num)])
    noise = np.stack([0.05 * true[0], np.full(num, 0.02), 0.05 * np.abs(true[2])])
    said = true + noise * random.normal(size=true.shape) + np.array([[0.0], [0.0], [0.02]])
    motion = fit_motion(said[:, :2000], certain(true[:, :2000]), reach=REACH)
    steps = motion.corrected(said[:, 2000:])
    errors = relative_errors(chained(steps), chained(true[:, 2000:]), gap=12)
    claimed = chained_covariance(steps, motion.covariance(steps), gap=12)
    covered = coverage(errors, claimed)
    assert covered[0.68] == pytest.approx(0.68, abs=0.06)
    assert covered[0.95] == pytest.approx(0.95, abs=0.04)


def test_what_matches_do_not_say_corrects_nothing():
    random = np.random.default_rng(0)
    num = 400
    true = np.stack([random.uniform(0, 1, num), np.zeros(num), random.uniform(-0.02, 0.02, num)])
    said = true * np.array([[1.1], [1.0], [1.0]])
    # In most places walls are parallel to the way: matches leave the length as odometry has it.
    noise = 1e-3 * random.normal(size=true.shape)
    matches = certain(np.where(np.arange(num) % 4 == 0, true, said) + noise)
    corridor = (np.arange(num) % 4 != 0)[:, None, None]
    forward = np.stack([np.cos(said[2]), -np.sin(said[2]), np.zeros(num)], axis=-1)
    across = 1e6 * (np.eye(3) - forward[:, :, None] * forward[:, None])
    matches = matches._replace(information=np.where(corridor, across, matches.information))
    motion = fit_motion(said, matches, reach=REACH)
    np.testing.assert_allclose(motion.corrected(said), true, atol=3e-3)


def test_turns_are_found_and_matched_within_half_a_turn():
    rooms = Scans(SENSORS, steps_of(TRUTH), RAYS).views()
    pairs = np.stack([np.arange(60), np.arange(60) + 1])
    guess, _ = search(images(rooms, reach=REACH), pairs, np.zeros((3, 60)), WINDOW, reach=REACH)
    found = match(rooms, pairs, guess, reach=REACH, spread=(0.1, 0.2)).displacement
    turned = steps_of(TRUTH)[2, :60]
    assert turned.min() < -0.05
    for angle in (guess[2], found[2]):
        assert np.abs(angle).max() <= np.pi
        assert np.median(np.abs(angle - turned)) < 0.2


WINDOW = Window(0.2, 0.8)


def test_rays_that_meet_nothing_are_no_part_of_a_share():
    blind = SENSORS[:1].copy()
    blind[:, 30:] = REACH
    view = Scans(blind, np.zeros((3, 0)), RAYS).views()
    assert 20 < view.exist.sum() <= 30
    pairs = np.zeros((2, 1), int)
    found = match(view, pairs, np.zeros((3, 1)), reach=REACH, spread=(0.1, 0.2))
    on_walls = np.any(view.normals != 0, axis=-1).sum()
    assert found.share[0] == pytest.approx(on_walls / view.exist.sum())


def test_scans_are_matched_with_views_of_more_points():
    scans = Scans(SENSORS, steps_of(TRUTH), RAYS)
    few = scans.views().chosen(np.arange(3))
    many = few._replace(points=few.points[:, :40], normals=few.normals[:, :40])
    both = few.beside(many)
    assert both.points.shape == (6, 61, 2)
    np.testing.assert_array_equal(both.points[3:, :40], many.points)
    assert not both.exist[3:, 40:].any()
