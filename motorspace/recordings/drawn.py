"""Transitions of a recording, drawn anew for every epoch, short ones first."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from motorspace._types import Count, Key
from motorspace.recordings.recording import Recording, chained_per_interval, transition_starts
from motorspace.trajectories.curriculum import sequence_lengths
from motorspace.trajectories.transitions import Experience
from motorspace.worlds.checks import whole


class DrawnWindows(eqx.Module):
    """A function from a key and the epoch to transitions; `draw_windows` makes it."""

    sensors: Float[Array, "N K"]
    motors: Float[Array, "I M"]
    """What was commanded from each scan to the next."""
    starts: Int[Array, "T W"]
    """The scans that transitions over 1, 2 ... T scans may begin at, filled up with zeros."""
    num_starts: Int[Array, " T"]
    curriculum_epochs: Count
    num: int = eqx.field(static=True)
    shortest: int = eqx.field(static=True)

    def __call__(self, key: Key, epoch: Count) -> Experience:
        """The transitions of one epoch."""
        horizon = len(self.num_starts)
        shortest, longest = sequence_lengths(
            epoch, self.curriculum_epochs, shortest=self.shortest, horizon=horizon
        )
        length_key, start_key = jax.random.split(key)
        length = jax.random.randint(length_key, (self.num,), shortest, longest + 1)
        share = jax.random.uniform(start_key, (self.num,), jnp.float32)
        count = self.num_starts[length - 1]
        chosen = jnp.minimum((share * count.astype(jnp.float32)).astype(jnp.int32), count - 1)
        first = self.starts[length - 1, chosen]
        steps = jnp.arange(horizon, dtype=jnp.int32)[None]
        rows = jnp.minimum(first[:, None] + steps, len(self.motors) - 1)
        executed = steps < length[:, None]
        return Experience(
            sensors=self.sensors[first],
            motors=jnp.where(executed[..., None], self.motors[rows], 0.0),
            num_steps=length,
            later_sensors=self.sensors[first + length],
        )


def draw_windows(
    recording: Recording,
    *,
    num: int,
    horizon: int,
    min_horizon: int | None = None,
    curriculum_epochs: int = 0,
) -> DrawnWindows:
    """Return a source of a recording's transitions for `train`, as a simulation is one.

    Args:
        recording: The walk. Intervals that are not usable are part of no transition; increments
            between two scans are one command.
        num: Transitions of an epoch.
        horizon: Scans from the first reading of a transition to the later one, at most.
        min_horizon: The shortest transition, where lengths vary; by default `horizon`.
        curriculum_epochs: Epochs over which the longest transition grows from 1 to `horizon`.

    Raises:
        UserError: For sizes below 1, and where no transition of some length is left.

    Example:
        >>> from motorspace.recordings.record import record
        >>> from motorspace.worlds.scenario import Scenario
        >>> walk = record(Scenario("empty"), num_steps=50, key=jax.random.key(0))
        >>> source = draw_windows(walk, num=10, horizon=3)
        >>> source(jax.random.key(1), jnp.int32(0)).motors.shape
        (10, 3, 2)
    """
    whole("horizon", horizon)
    starts = [transition_starts(recording, length) for length in range(1, horizon + 1)]
    most = max(map(len, starts))
    return DrawnWindows(
        sensors=jnp.asarray(recording.sensors, jnp.float32),
        motors=jnp.asarray(chained_per_interval(recording), jnp.float32),
        starts=jnp.asarray([np.pad(s, (0, most - len(s))) for s in starts], jnp.int32),
        num_starts=jnp.asarray([*map(len, starts)], jnp.int32),
        curriculum_epochs=jnp.int32(whole("curriculum_epochs", curriculum_epochs, at_least=0)),
        num=whole("num", num),
        shortest=horizon if min_horizon is None else whole("min_horizon", min_horizon),
    )
