"""What a robot learns of its rays, and of its codes' frame, on a walk through a synthetic room."""

import numpy as np
import pytest

from motorspace import se2
from motorspace._errors import UserError
from motorspace.mapping.bearings import find_bearings
from motorspace.mapping.frame import find_frame, in_frame
from motorspace.mapping.mounting import Mounting
from motorspace.mapping.order import neighbours_in_order
from motorspace.mapping.survey import Scans
from tests.mapping.rooms import REACH, ranges, walk


def seen(angles: np.ndarray, num_steps: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Poses that look into all directions, and slightly noisy readings there."""
    random = np.random.default_rng(0)
    poses = walk(num_steps)
    poses[2] += random.uniform(-0.5, 0.5, poses.shape[1])
    sensors = ranges(poses, angles)
    return poses, sensors * (1 + 0.003 * random.normal(size=sensors.shape))


def test_alike_rays_are_neighbours_whatever_their_order():
    _, sensors = seen(np.linspace(-np.pi / 2, np.pi / 2, 31))
    shuffled = np.random.default_rng(1).permutation(31)
    order = shuffled[neighbours_in_order(sensors[:, shuffled], reach=REACH)]
    assert order.tolist() in (list(range(31)), list(range(31))[::-1])


def test_rays_all_around_are_one_ring():
    _, sensors = seen(np.linspace(-np.pi, np.pi, 48, endpoint=False))
    shuffled = np.random.default_rng(1).permutation(48)
    order = shuffled[neighbours_in_order(sensors[:, shuffled], reach=REACH)]
    assert set(np.abs(np.diff(order)) % 46) == {1}


@pytest.mark.parametrize("spread", [0.0, 0.3])
@pytest.mark.parametrize("view", [2.0, np.pi])
def test_straight_walls_show_where_rays_point(view, spread):
    random = np.random.default_rng(2)
    angles = np.cumsum(np.exp(spread * random.normal(size=31)))
    angles = view * ((angles - angles[0]) / (angles[-1] - angles[0]) - 0.5)
    _, sensors = seen(angles)
    found = find_bearings(sensors, reach=REACH)
    assert np.abs(found - angles).max() < np.deg2rad(3)
    assert np.std(found - angles) < np.deg2rad(1)


def test_rays_that_are_listed_in_no_order_keep_their_places():
    angles = np.linspace(-np.pi / 2, np.pi / 2, 31)
    shuffled = np.random.default_rng(1).permutation(31)
    _, sensors = seen(angles)
    found = find_bearings(sensors[:, shuffled], reach=REACH)
    off = min(np.abs(found - angles[shuffled]).max(), np.abs(found + angles[shuffled]).max())
    assert off < np.deg2rad(3)


def test_few_rays_and_no_walls_are_refused():
    _, sensors = seen(np.linspace(-1, 1, 31))
    with pytest.raises(UserError, match="9 rays are too few"):
        find_bearings(sensors[:, :9], reach=REACH)
    with pytest.raises(UserError, match="neighbouring rays all meet something"):
        find_bearings(np.full_like(sensors, REACH), reach=REACH)


@pytest.mark.parametrize("mirrored", [1.0, -1.0])
def test_codes_of_any_frame_are_laid_into_that_of_the_rays(mirrored):
    angles = np.linspace(-np.pi / 2, np.pi / 2, 31)
    poses = walk(250)
    true = np.asarray(se2.relative(poses[:, :-1], poses[:, 1:]))
    mounting = Mounting(angles, np.zeros(2), REACH)
    # Codes: a frame elsewhere on the body, turned, in a unit of their own, perhaps in a mirror.
    offset = np.array([0.4, -0.3, 0.8])[:, None] * np.ones((1, true.shape[1]))
    codes = se2.compose(se2.compose(se2.inverse(offset), true), offset)
    codes = np.asarray(codes) * np.array([[0.25], [0.25 * mirrored], [mirrored * 0.8]])
    views = Scans(ranges(poses, angles), codes, mounting).views()
    found = in_frame(codes, find_frame(views, codes, reach=REACH))
    off = np.asarray(se2.relative(true, found))
    assert np.median(np.hypot(off[0], off[1])) < 0.05 * np.median(np.hypot(true[0], true[1]))
    assert np.median(np.abs(off[2])) < 0.05 * np.median(np.abs(true[2])) + 1e-3


def test_scans_that_do_not_match_show_no_frame():
    angles = np.linspace(-np.pi / 2, np.pi / 2, 31)
    steps = np.ones((3, 60)) * np.array([[0.1], [0.0], [0.1]])
    noise = np.random.default_rng(0).uniform(0.1, 1, (61, 31)) * REACH
    views = Scans(noise, steps, Mounting(angles, np.zeros(2), REACH)).views()
    with pytest.raises(UserError, match="pairs of neighbouring scans can be matched"):
        find_frame(views, steps, reach=REACH)
