"""Pictures of robots' logs."""

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure

from motorspace import se2
from motorspace._errors import UserError
from motorspace.recordings.recording import Recording, path_by_increments
from motorspace.reports.figures.style import SERIES, ink, new_figure, styled

SAME = 1e-6
"""World units; where the odometry stands for the true poses, both paths are one."""


@styled
def path_figure(recording: Recording) -> Figure:
    """Returns a picture of the path by odometry and, where they are known, by true poses.

    Args:
        recording: A log with planar increments, or with true poses.

    Raises:
        UserError: The log says neither how the robot moved nor where it was.
    """
    paths = _paths(recording)
    if not paths:
        raise UserError(
            "there is no path to draw: the motors are not planar, and true poses are unknown",
            where=recording.name,
            remedy="add the columns x, y, theta",
        )
    figure = new_figure(6.4, 6)
    axes = figure.add_subplot()
    for (name, path), colour in zip(paths.items(), SERIES, strict=False):
        axes.plot(path[:, 0], path[:, 1], color=colour, lw=1.2, label=name)
    first = next(iter(paths.values()))
    left_out = np.where(~recording.usable[:, None], first[1:], np.nan)
    if not recording.usable.all():
        axes.scatter(
            left_out[:, 0],
            left_out[:, 1],
            s=14,
            color=SERIES[4],
            label="left out",
            zorder=3,
            linewidths=0,
        )
    start = first[np.isfinite(first[:, 0])][0]
    axes.scatter(
        start[:1], start[1:], s=40, color=ink("text"), zorder=4, label="start", linewidths=0
    )
    axes.set(aspect="equal", xlabel="x (world units)", ylabel="y (world units)")
    axes.set_title(f"{recording.name}: {len(recording)} scans", wrap=True)
    axes.legend()
    return figure


def _paths(recording: Recording) -> dict[str, Float[np.ndarray, "N 2"]]:
    found: dict[str, Float[np.ndarray, "N 2"]] = {}
    known = np.isfinite(recording.poses[:, :3]).all(axis=1)
    if recording.planar:
        moved = path_by_increments(recording)
        if known.any():
            # The frame of the odometry begins anywhere: it is laid on the first known pose.
            row = int(np.argmax(known))
            origin = se2.compose(recording.poses[row, :3], se2.inverse(moved[row]))
            moved = se2.compose(np.broadcast_to(origin[:, None], moved.T.shape), moved.T).T
        found["odometry"] = moved[:, :2]
    if known.any() and not _same(found.get("odometry"), recording.poses[:, :2]):
        found["poses of the log"] = recording.poses[:, :2]
    return found


def _same(path: Float[np.ndarray, "N 2"] | None, poses: Float[np.ndarray, "N 2"]) -> bool:
    return path is not None and bool(np.nanmax(np.abs(path - poses)) < SAME)
