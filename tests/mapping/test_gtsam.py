"""Our pose graph against GTSAM's, where that is installed (see CONTRIBUTING)."""

import numpy as np
import pytest

from motorspace import se2
from motorspace.mapping.motion import chained
from motorspace.mapping.pose_graph import DOUBT, Edges, chordal, joined, optimised
from motorspace.mapping.survey import NO_EDGES
from tests.mapping.rooms import walk

gtsam = pytest.importorskip("gtsam", reason="the oracle of pose graphs, gtsam, is not installed")

NUM = 60
TRUTH = walk(NUM - 1)


def measured(first, second, seed, noise=(0.05, 0.03, 0.02)):
    """Noisy displacements whose covariances are no multiples of one another."""
    random = np.random.default_rng(seed)
    true = se2.relative(TRUTH[:, first], TRUTH[:, second])
    off = np.array(noise)[:, None] * random.normal(size=(3, len(first)))
    mixed = np.eye(3) + 0.3 * random.normal(size=(len(first), 3, 3))
    deviation = np.array(noise) * random.uniform(0.5, 2, (len(first), 1))
    covariance = deviation[:, :, None] * (mixed @ np.swapaxes(mixed, 1, 2)) * deviation[:, None]
    return Edges(first, second, np.asarray(se2.compose(true, off)), np.linalg.inv(covariance))


ODOMETRY = measured(np.arange(NUM - 1), np.arange(1, NUM), seed=0)
LOOPS = measured(np.array([0, 3, 5, 10, 17, 20]), np.array([30, 33, 34, 40, 46, 59]), seed=1)
FIXED = gtsam.noiseModel.Constrained.All(3)


def between(edges, row, noise):
    """GTSAM's own factor, whose error is a twist."""
    keys = int(edges.first[row]), int(edges.second[row])
    return gtsam.BetweenFactorPose2(*keys, gtsam.Pose2(*edges.displacement[:, row]), noise)


def frames(edges, row, noise):
    """A factor whose error is a frame, x, y, angle, as ours is."""
    keys = [int(edges.first[row]), int(edges.second[row])]
    measured = gtsam.Pose2(*edges.displacement[:, row]).inverse()

    def off(first, second):
        pose = measured.compose(first.between(second))
        return np.array([pose.x(), pose.y(), pose.theta()])

    def error(factor, values, jacobians):
        poses = [values.atPose2(key) for key in keys]
        for place in range(2 if jacobians is not None else 0):
            columns = []
            for small in 1e-6 * np.eye(3):
                ends = []
                for twist in (small, -small):
                    moved = list(poses)
                    moved[place] = poses[place].retract(twist)
                    ends.append(off(*moved))
                columns.append((ends[0] - ends[1]) / 2e-6)
            jacobians[place] = np.array(columns).T
        return off(*poses)

    return gtsam.CustomFactor(noise, keys, error)


def graph_of(trusted, doubted, factor):
    graph = gtsam.NonlinearFactorGraph()
    graph.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(0, 0, 0), FIXED))
    for edges, cauchy in ((trusted, False), (doubted, True)):
        for row in range(len(edges.first)):
            noise = gtsam.noiseModel.Gaussian.Information(edges.information[row])
            if cauchy:
                loss = gtsam.noiseModel.mEstimator.Cauchy.Create(np.sqrt(DOUBT))
                noise = gtsam.noiseModel.Robust.Create(loss, noise)
            graph.add(factor(edges, row, noise))
    return graph


def values_of(poses):
    values = gtsam.Values()
    for index, pose in enumerate(poses.T):
        values.insert(index, gtsam.Pose2(*pose))
    return values


def oracle(graph, start):
    """GTSAM's minimum from there, [3, N]."""
    settings = gtsam.LevenbergMarquardtParams()
    settings.setRelativeErrorTol(1e-14)
    settings.setAbsoluteErrorTol(1e-14)
    settings.setMaxIterations(200)
    found = gtsam.LevenbergMarquardtOptimizer(graph, values_of(start), settings).optimize()
    poses = [found.atPose2(index) for index in range(start.shape[1])]
    return np.array([[pose.x(), pose.y(), pose.theta()] for pose in poses]).T


@pytest.mark.parametrize(
    ("trusted", "doubted"),
    [(joined(ODOMETRY, LOOPS), NO_EDGES), (ODOMETRY, LOOPS)],
    ids=["least squares", "Cauchy loss"],
)
def test_our_minimum_is_that_of_gtsam(trusted, doubted):
    start = chained(ODOMETRY.displacement)
    ours = optimised(trusted, doubted, start)
    graph = graph_of(trusted, doubted, frames)
    theirs = oracle(graph, start)
    least = graph.error(values_of(theirs))
    assert graph.error(values_of(start)) > 2 * least
    assert graph.error(values_of(ours)) == pytest.approx(least, rel=1e-6)
    np.testing.assert_allclose(ours, theirs, atol=1e-4)


def test_an_error_that_is_a_twist_makes_hardly_a_difference():
    edges = joined(ODOMETRY, LOOPS)
    ours = optimised(edges, NO_EDGES, chordal(edges, NUM))
    graph = graph_of(edges, NO_EDGES, between)
    theirs = oracle(graph, chained(ODOMETRY.displacement))
    assert graph.error(values_of(ours)) < 1.001 * graph.error(values_of(theirs))
    np.testing.assert_allclose(ours, theirs, atol=2e-3)
