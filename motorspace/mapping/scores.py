"""A survey in numbers, where true poses are known: nothing here is used for mapping."""

import numpy as np
from jaxtyping import Float

from motorspace.analysis.paths import (
    absolute_error,
    aligned,
    coverage,
    drift,
    relative_error,
    relative_errors,
    standing_still,
)
from motorspace.mapping.motion import Motion, chained, chained_covariance
from motorspace.mapping.occupancy import agreement, grid_around, occupancy
from motorspace.mapping.pose_graph import Edges
from motorspace.mapping.survey import APART, Scans, Survey
from motorspace.se2 import relative

RIGHT = (0.05, 0.1)
"""How far off a right loop may be: share of the reach, radians."""
REVISITED = 0.1
"""Places nearer than this are the same, share of the reach."""
ALIKE = 0.8
"""How far the agent may be turned when it comes back, radians."""
CELL = 0.05
"""Side of the cells that maps are compared in, share of the reach."""
GAPS = (6, 24)
"""Steps over which displacements are scored."""

Scores = dict[str, float]
Path = Float[np.ndarray, "3 N"]


def measure_path(path: Path, truth: Path) -> Scores:
    """`path.KIND`: errors of a path, absolute and relative, and drift.

    Args:
        path: Where the sensors were, [3, N], in world units.
        truth: The same in truth.
    """
    scores = {"path.ate": absolute_error(path, truth), "path.drift": drift(path, truth)}
    scores["path.ate_scaled"] = absolute_error(path, truth, scaled=True)
    for gap in GAPS:
        if gap < path.shape[1]:
            shift, turn = relative_error(path, truth, gap=gap)
            scores |= {f"path.rpe_shift.{gap}": shift, f"path.rpe_turn.{gap}": np.rad2deg(turn)}
    return scores


def measure_survey(
    scans: Scans, survey: Survey, paths: dict[str, Path], truth: Path
) -> dict[str, Scores]:
    """Every measure of a survey: {path: {measure: value}}.

    Args:
        scans: Readings and odometry.
        survey: What was made of them; its path is the one "with loops".
        paths: Paths by name, [3, N].
        truth: The true path.
    """
    scores = {name: measure_path(path, truth) for name, path in paths.items()}
    scores["standing still"] = measure_path(standing_still(truth), truth)
    scores["corrected"] |= measure_covariance(scans, survey.motion, truth)
    scores["with loops"] |= measure_loops(survey.loops, truth, reach=scans.mounting.reach)
    scores["with loops"] |= measure_map(scans, survey, truth)
    return scores


def measure_covariance(scans: Scans, motion: Motion, truth: Path) -> Scores:
    """`covariance.SHARE`: how many displacements lie where so many of 100 should.

    Over `GAPS` steps each, by corrected odometry without loops.
    """
    steps = motion.corrected(scans.steps)
    covariance = motion.covariance(steps)
    path = chained(steps)
    found: dict[float, list[float]] = {}
    for gap in GAPS:
        if gap > len(covariance):
            continue
        errors = relative_errors(path, truth, gap=gap)
        claimed = chained_covariance(steps, covariance, gap=gap)
        for share, value in coverage(errors, claimed).items():
            found.setdefault(share, []).append(value)
    return {f"covariance.{share * 100:.0f}": float(np.mean(v)) for share, v in found.items()}


def measure_loops(loops: Edges, truth: Path, *, reach: float) -> Scores:
    """`loops.precision` and `loops.recall`.

    A loop is right whose displacement is. Recall is of all moments that come back to a place they
    have left, looking about the same way: how many of them are near one with a right loop.
    """
    right = right_loops(loops, truth, reach=reach)
    scores = {"loops.num": float(len(right))}
    if len(right):
        scores["loops.precision"] = float(right.mean())
    back = _comes_back(truth, reach)
    closed = np.zeros(truth.shape[1], bool)
    closed[loops.second[right]] = True
    near = np.convolve(closed, np.ones(2 * NEAR + 1), mode="same") > 0
    if back.any():
        scores["loops.recall"] = float(near[back].mean())
    return scores


NEAR = 2
"""Moments around a loop that it closes as well: only keyframes are matched."""


def right_loops(loops: Edges, truth: Path, *, reach: float) -> np.ndarray:
    """Which loops are right, [E]."""
    moved = relative(truth[:, loops.first], truth[:, loops.second])
    x, y, turn = relative(moved, loops.displacement)
    shift, angle = RIGHT
    return np.asarray((np.hypot(x, y) < shift * reach) & (np.abs(turn) < angle))


def _comes_back(truth: Path, reach: float) -> np.ndarray:
    """Which moments are at a place where the agent has been before, some way ago, [N]."""
    way = np.append(0.0, np.cumsum(np.hypot(*np.diff(truth[:2], axis=1))))
    back = np.zeros(truth.shape[1], bool)
    for moment in range(truth.shape[1]):
        before = np.searchsorted(way, way[moment] - APART * reach)
        x, y, turn = relative(np.repeat(truth[:, [moment]], before, axis=1), truth[:, :before])
        back[moment] = np.any((np.hypot(x, y) < REVISITED * reach) & (np.abs(turn) < ALIKE))
    return back


def measure_map(scans: Scans, survey: Survey, truth: Path) -> Scores:
    """`map.iou`: the map over the same readings, drawn at the true poses.

    Intersection over union of occupied cells, after the path is laid on the true one.
    """
    cell = CELL * scans.mounting.reach
    poses = aligned(survey.poses, truth)
    grid = grid_around(truth, scans.sensors, scans.mounting, cell=cell)
    drawings = [
        occupancy(path, scans.sensors, scans.mounting, cell=cell, grid=grid)
        for path in (poses, truth)
    ]
    return {"map.iou": agreement(*drawings)}
