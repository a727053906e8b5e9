"""Transitions and splits of a recording."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from motorspace import se2
from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.recordings.recording import (
    Recording,
    chained_per_interval,
    sensor_frames,
    transition_starts,
)
from motorspace.trajectories.transitions import Displacements, Experience, Trajectories

FRACTIONS = (0.6, 0.2, 0.2)
"""Shares of the blocks for training, validation and test."""


def windows(recording: Recording, *, horizon: int, per_scan: bool) -> Trajectories:
    """Every transition from scan i to scan i + `horizon`, in order of i.

    Intervals that the recording marks as not usable are part of no transition.

    Args:
        recording: The walk.
        horizon: Scans from the first reading to the later one.
        per_scan: Chain (or sum) the increments of each interval into one command, so that
            T = `horizon`. Otherwise the sequence holds every increment, and zeros beyond its own
            length.

    Returns:
        W transitions. The nominal displacement is what the chained increments claim (NaN unless
        they are planar), the achieved one what the true poses say (NaN where unknown).

    Raises:
        UserError: No transition is left.
    """
    starts = transition_starts(recording, horizon)
    if per_scan:
        recording = replace(
            recording,
            increments=chained_per_interval(recording),
            interval=np.arange(len(recording) - 1),
        )
    motors, lengths = _sequences(recording, starts, horizon)
    experience = Experience(
        sensors=jnp.asarray(recording.sensors[starts], jnp.float32),
        motors=jnp.asarray(motors, jnp.float32),
        num_steps=jnp.asarray(lengths, jnp.int32),
        later_sensors=jnp.asarray(recording.sensors[starts + horizon], jnp.float32),
    )
    gaze = sensor_frames(recording)
    achieved = se2.relative(gaze[:, starts], gaze[:, starts + horizon]).T
    nominal = se2.chain(motors) if recording.planar else np.full_like(achieved, np.nan)
    return Trajectories(
        experience,
        Displacements(jnp.asarray(nominal, jnp.float32), jnp.asarray(achieved, jnp.float32)),
    )


def _sequences(
    recording: Recording, starts: Int[np.ndarray, " W"], horizon: int
) -> tuple[Float[np.ndarray, "W T M"], Int[np.ndarray, " W"]]:
    """The increments of every transition, padded with zeros, and how many there are."""
    first = np.searchsorted(recording.interval, starts)
    lengths = np.searchsorted(recording.interval, starts + horizon) - first
    longest = max(int(lengths.max()), 1)
    rows = first[:, None] + np.arange(longest)
    executed = np.arange(longest) < lengths[:, None]
    size = recording.increments.shape[1]
    padded = np.concatenate([recording.increments, np.zeros((longest + 1, size))])
    return np.where(executed[..., None], padded[np.minimum(rows, len(padded) - 1)], 0.0), lengths


def split_blocks(
    recording: Recording,
    *,
    horizon: int,
    num_blocks: int = 20,
    fractions: tuple[float, float, float] = FRACTIONS,
    key: Key,
) -> tuple[Int[np.ndarray, " A"], Int[np.ndarray, " B"], Int[np.ndarray, " C"]]:
    """Rows of `windows` for training, validation and test.

    The recording is cut into blocks of time, which are shuffled and shared out. A transition
    that crosses the border of a block is left out, so that no scan is on two sides.

    Args:
        recording: The walk.
        horizon: Scans from the first reading of a transition to the later one.
        num_blocks: Blocks of equal length.
        fractions: Shares of the blocks for training, validation and test.
        key: Source of the shuffling.

    Returns:
        Three arrays of indices into `windows(recording, horizon=horizon, ...)`.

    Raises:
        UserError: A part would be empty; says how many scans are enough.
    """
    cuts = np.round(np.cumsum(fractions)[:2] * num_blocks).astype(int)
    if num_blocks < 3 or min(np.diff([0, *cuts, num_blocks])) < 1:
        raise UserError(
            f"num_blocks is {num_blocks}, which leaves training, validation or test without one",
            where=recording.name,
            remedy="choose at least 5 blocks",
        )
    starts = transition_starts(recording, horizon)
    borders = np.linspace(0, len(recording), num_blocks + 1).astype(int).tolist()
    order = np.asarray(jax.random.permutation(key, num_blocks))
    parts = []
    for blocks in np.split(order, cuts):
        inside = [_within(starts, borders[b], borders[b + 1] - horizon) for b in sorted(blocks)]
        parts.append(np.concatenate(inside))
    if min(len(part) for part in parts) == 0:
        raise _too_few(recording, horizon, num_blocks)
    return parts[0], parts[1], parts[2]


def _within(starts: Int[np.ndarray, " W"], low: int, high: int) -> Int[np.ndarray, " P"]:
    """Positions of the starts from `low` to below `high`."""
    return np.arange(*np.searchsorted(starts, [low, max(low, high)]))


def _too_few(recording: Recording, horizon: int, num_blocks: int) -> UserError:
    enough = num_blocks * (horizon + 1)
    fewer = len(recording) // (horizon + 1)
    remedy = f"{enough} scans are enough for so many blocks"
    if 5 <= fewer < num_blocks:
        remedy += f", or choose num_blocks {fewer}"
    if len(recording) >= enough:
        remedy = "too many intervals are left out (see `motorspace inspect`); choose fewer blocks"
    return UserError(
        f"{len(recording)} scans are too few for {num_blocks} blocks over {horizon} scans",
        where=recording.name,
        remedy=remedy,
    )
