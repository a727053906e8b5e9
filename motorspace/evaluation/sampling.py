"""Fresh trajectories to measure on, and probes of their codes."""

import jax
import numpy as np
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.analysis.coordinates import COMPONENTS
from motorspace.analysis.probes import linear_probe
from motorspace.training.data import Data, Derived, Logged, base_of, simulated
from motorspace.training.run import Run
from motorspace.training.sources import derive, logged_data
from motorspace.trajectories.sampling import sample
from motorspace.trajectories.transitions import Trajectories

TEST_SEED = 1_000_003
"""Evaluation draws from its own stream: training seeds stay far below it."""


def present_data(run: Run, data: Data | None) -> Data:
    """What a run learned from, at its present place. Raises `UserError` for other data."""
    if data is None:
        return run.config.data
    ours, given = (base_of(d) for d in (run.config.data, data))
    same_log = (
        isinstance(ours, Logged) and isinstance(given, Logged) and given.sha256 == ours.sha256
    )
    if data != run.config.data and not same_log:
        raise UserError(
            "these are not the data that the run has learned from",
            remedy="give the same log at its new place: run.config.data.at(path)",
        )
    return data


def draw_test(data: Data, num: int, *, key: Key) -> Trajectories:
    """Fresh trajectories of a simulated run's own kind, at its full horizons."""
    base = simulated(data)
    return sample(
        base.scenario(),
        num=num,
        horizon=base.horizon,
        min_horizon=base.min_horizon,
        collision=base.collision,
        key=key,
    )


def test_trajectories(data: Data, num: int, *, key: Key) -> Trajectories:
    """What a run is measured on, as its network is given it.

    `num` fresh trajectories of a simulation, or at most as many from the test blocks of a log.
    Raises `UserError` for data of one's own, which only their owner has.
    """
    if isinstance(base_of(data), Logged):
        return logged_data(data).test[:num]
    drawn = draw_test(data, num, key=key)
    if not isinstance(data, Derived):
        return drawn
    return Trajectories(derive(data, drawn, key=key), drawn.displacements)


def test_key(seed: int) -> jax.Array:
    """The key of what a run with this seed is measured on."""
    return jax.random.key(TEST_SEED + seed)


def probe_halves(
    codes: Float[Array | np.ndarray, "N C"], targets: Float[Array | np.ndarray, "N 4"]
) -> dict[str, float]:
    """R2 on one half of the codes of a linear probe fitted on the other, per component."""
    half = len(codes) // 2
    r2 = linear_probe(codes[:half], targets[:half], codes[half:], targets[half:])
    return named_r2(r2)


def named_r2(r2: Float[Array | np.ndarray, "4"]) -> dict[str, float]:
    """The R2 of each component of displacement by its name, to four digits."""
    return dict(zip(COMPONENTS, (round(float(v), 4) for v in r2), strict=True))
