"""What happened: the part that learning sees, and the part that only evaluation sees."""

from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax
from jaxtyping import Array, Float, Int

from motorspace._types import Key


class Experience(eqx.Module):
    """N transitions (s_t, motor sequence, s_{t+T}): all that learning may see.

    Args:
        sensors: What is sensed at first, [N, K], raw units.
        motors: The commands that follow, [N, T, M], in the agent's units. Rows beyond `num_steps`
            are zero and no part of the sequence.
        num_steps: How many commands each sequence holds, [N], from 1 to T.
        later_sensors: What is sensed after them, [N, K], raw units.
    """

    sensors: Float[Array, "*N K"]
    motors: Float[Array, "*N T M"]
    num_steps: Int[Array, "*N"]
    later_sensors: Float[Array, "*N K"]

    def __len__(self) -> int:
        return self.sensors.shape[0]

    def __getitem__(self, rows: object) -> "Experience":
        """The transitions selected by a slice or an index array."""
        return jax.tree.map(lambda leaf: leaf[rows], self)


class Displacements(NamedTuple):
    """True displacements of N transitions, for evaluation alone; see `Displacement`.

    `nominal` is what the commands would do with no walls, `achieved` what happened.
    """

    nominal: Float[Array, "*N 3"]
    achieved: Float[Array, "*N 3"]


class Trajectories(eqx.Module):
    """Experience with its displacements.

    Args:
        experience: N transitions.
        displacements: What was displaced in each, for evaluation alone.
    """

    experience: Experience
    displacements: Displacements

    def __len__(self) -> int:
        return len(self.experience)

    def __getitem__(self, rows: object) -> "Trajectories":
        """The transitions selected by a slice or an index array."""
        return jax.tree.map(lambda leaf: leaf[rows], self)


ExperienceSource = Experience | Callable[[Key, Int[Array, ""]], Experience]
"""Where learning draws from: a fixed set, or fresh transitions from a key and the epoch."""
