"""Where a robot's log leads without codes: reference rows, most of which are given true things."""

import math

import numpy as np
from jaxtyping import Float

from motorspace.analysis.paths import standing_still
from motorspace.mapping.motion import chained, terms
from motorspace.mapping.mounting import Mounting
from motorspace.mapping.survey import Scans, survey
from motorspace.recordings.recording import Recording, chained_per_interval
from motorspace.se2 import compose, exponential, logarithm, relative

Path = Float[np.ndarray, "3 N"]

NUM_BLOCKS = 20
"""Blocks of time, each of which is predicted from the others."""
RIDGE = 1e-3
"""Penalty of the regression from standardised features, for each example."""


def reference_paths(log: Recording, truth: Path) -> dict[str, Path]:
    """Paths of a log of planar increments and distances over half a circle.

    Args:
        log: The log.
        truth: The true path, [3, N].

    Returns:
        `still`; `raw`, the commands as they are; `kinematics`, commands after the linear correction
        that is best for the true steps; `regressor`, the steps of each block of time by a
        regression from commands and readings that has learned true ones of the other blocks;
        `matcher` and `matcher_loops`, scans that are matched
        beginning with the commands, by rays whose directions are given.
    """
    steps = chained_per_interval(log).T
    should = np.asarray(relative(truth[:, :-1], truth[:, 1:]))
    reach = max(log.sensor_scale)
    directions = np.linspace(-math.pi / 2, math.pi / 2, log.sensors.shape[1])
    matched = survey(Scans(log.sensors, steps, Mounting(directions, np.zeros(2), reach)))
    return {
        "still": standing_still(truth),
        "raw": chained(steps),
        "kinematics": chained(_best_kinematics(steps, should, reach)),
        "regressor": chained(_regressed(log, steps, should)),
        "matcher": matched.local,
        "matcher_loops": matched.poses,
    }


def _best_kinematics(steps: Path, should: Path, reach: float) -> Path:
    """Steps with the correction that is linear in them and fits the true ones best."""
    known, lacking = terms(steps, reach), logarithm(np.asarray(relative(steps, should)))
    correction = np.linalg.lstsq(known, lacking, rcond=None)[0]
    return np.asarray(compose(steps, exponential(known @ correction)))


def _regressed(log: Recording, steps: Path, should: Path) -> Path:
    """Each block's steps by ridge regression on commands and readings of the other blocks."""
    readings, changes = log.sensors[:-1], np.diff(log.sensors, axis=0)
    features = np.concatenate([steps.T, changes, readings], axis=1)
    features = (features - features.mean(axis=0)) / (features.std(axis=0) + 1e-9)
    wanted = logarithm(should)
    block = np.arange(len(features)) * NUM_BLOCKS // len(features)
    predicted = np.empty_like(wanted)
    for here in range(NUM_BLOCKS):
        others = block != here
        predicted[~others] = _ridge(features[others], wanted[others], features[~others])
    return np.asarray(exponential(predicted))


def _ridge(
    features: Float[np.ndarray, "E F"],
    wanted: Float[np.ndarray, "E 3"],
    asked: Float[np.ndarray, "Q F"],
) -> Float[np.ndarray, "Q 3"]:
    mean = wanted.mean(axis=0)
    normal = features.T @ features + RIDGE * len(features) * np.eye(features.shape[1])
    return np.asarray(asked @ np.linalg.solve(normal, features.T @ (wanted - mean)) + mean)
