"""Errors of paths, against what is known of them and against a library that measures the same."""

import numpy as np
import pytest

from motorspace import se2
from motorspace._errors import UserError
from motorspace.analysis.paths import (
    absolute_error,
    alignment,
    coverage,
    drift,
    relative_error,
    relative_errors,
)


def wandering(num: int, seed: int = 0) -> np.ndarray:
    random = np.random.default_rng(seed)
    steps = np.stack(
        [random.uniform(0, 1, num - 1), np.zeros(num - 1), random.normal(0, 0.4, num - 1)]
    )
    path = [np.zeros(3)]
    for step in steps.T:
        path.append(se2.compose(path[-1], step))
    return np.stack(path, axis=1)


TRUTH = wandering(200)
PATH = TRUTH + np.random.default_rng(1).normal(0, 0.1, TRUTH.shape)
ELSEWHERE = np.array([3.0, -2.0, 1.2])


def moved(path: np.ndarray) -> np.ndarray:
    return np.asarray(se2.compose(np.broadcast_to(ELSEWHERE[:, None], path.shape), path))


def test_where_a_path_begins_does_not_count():
    assert absolute_error(moved(TRUTH), TRUTH) == pytest.approx(0, abs=1e-9)
    assert absolute_error(moved(PATH), TRUTH) == pytest.approx(absolute_error(PATH, TRUTH))
    np.testing.assert_allclose(
        alignment(moved(TRUTH), TRUTH)(moved(TRUTH))[:2], TRUTH[:2], atol=1e-9
    )


def test_a_mirrored_path_is_not_laid_on_the_true_one():
    mirrored = TRUTH * np.array([[1.0], [-1.0], [-1.0]])
    assert absolute_error(mirrored, TRUTH) > 0.5


def test_scaling_hides_a_collapse():
    small = TRUTH * np.array([[0.01], [0.01], [1.0]])
    assert absolute_error(small, TRUTH) > 1
    assert absolute_error(small, TRUTH, scaled=True) == pytest.approx(0, abs=1e-6)


def test_drift_is_a_share_of_the_way():
    straight = np.stack([np.arange(11.0), np.zeros(11), np.zeros(11)])
    assert drift(1.1 * straight, straight) == pytest.approx(0.1)
    with pytest.raises(UserError, match="no length"):
        drift(straight, np.zeros((3, 11)))


def test_errors_over_a_gap_are_seen_from_the_true_end():
    late = TRUTH.copy()
    ahead = np.repeat([[0.5], [0.0], [0.0]], 100, axis=1)
    late[:, 100:] = se2.compose(TRUTH[:, 100:], ahead)
    x, y, angle = relative_errors(late, TRUTH, gap=10)
    crossing = np.arange(90, 100)
    np.testing.assert_allclose(np.hypot(x, y)[crossing], 0.5, atol=1e-9)
    assert np.hypot(x, y)[:90].max() < 1e-9
    assert np.abs(angle).max() < 1e-9
    assert relative_error(TRUTH, TRUTH, gap=10)[0] == pytest.approx(0, abs=1e-12)
    with pytest.raises(UserError, match="no displacement over 200 steps"):
        relative_errors(late, TRUTH, gap=200)


def test_coverage_of_what_is_normally_distributed():
    random = np.random.default_rng(0)
    root = random.normal(size=(3, 3))
    errors = root @ random.normal(size=(3, 20_000))
    covered = coverage(errors, np.broadcast_to(root @ root.T, (20_000, 3, 3)))
    assert covered[0.68] == pytest.approx(0.68, abs=0.01)
    assert covered[0.95] == pytest.approx(0.95, abs=0.01)


def test_a_path_of_one_moment_cannot_be_compared():
    with pytest.raises(UserError, match="cannot be compared"):
        absolute_error(TRUTH[:, :1], TRUTH[:, :1])


def test_errors_are_those_of_evo():
    metrics = pytest.importorskip("evo.core.metrics", reason="evo is not installed")
    trajectory = pytest.importorskip("evo.core.trajectory")

    def as_evo(path):
        rotated = np.stack(
            [np.cos(path[2] / 2), *np.zeros((2, path.shape[1])), np.sin(path[2] / 2)]
        )
        places = np.stack([*path[:2], np.zeros(path.shape[1])])
        times = np.arange(path.shape[1], dtype=float)
        return trajectory.PoseTrajectory3D(places.T, rotated.T, times)

    truth, estimate = as_evo(TRUTH), as_evo(moved(PATH))
    error = metrics.RPE(
        metrics.PoseRelation.translation_part, 10, metrics.Unit.frames, all_pairs=True
    )
    error.process_data((truth, estimate))
    found, _ = relative_error(moved(PATH), TRUTH, gap=10)
    assert error.get_statistic(metrics.StatisticsType.rmse) == pytest.approx(found, rel=1e-6)
    estimate.align(truth)
    error = metrics.APE(part)
    error.process_data((truth, estimate))
    found = absolute_error(moved(PATH), TRUTH)
    assert error.get_statistic(metrics.StatisticsType.rmse) == pytest.approx(found, rel=1e-6)
