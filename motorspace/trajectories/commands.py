"""Motor sequences by themselves, with no world around them."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from jaxtyping import Key as KeyArray

from motorspace._types import Pose
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.simulation import nominal_displacement, to_agents_last, to_rows

PADDED_LENGTH = 24
"""Sequences up to this length share one compiled program."""


@eqx.filter_jit
def random_commands(agent: AbstractAgent, keys: KeyArray[Array, "N T"]) -> Float[Array, "N T M"]:
    """Uniformly random commands of an agent's command space, one for each key.

    Example:
        >>> from motorspace.worlds.agents import ForwardAgent
        >>> random_commands(ForwardAgent(), jax.random.split(jax.random.key(0), (5, 3))).shape
        (5, 3, 2)
    """
    commands = agent.commands
    return jax.vmap(jax.vmap(lambda key: commands.sample(key=key)))(keys)


def nominal(agent: AbstractAgent, motors: Float[np.ndarray, "N T M"]) -> Float[np.ndarray, "N 3"]:
    """The displacement that each motor sequence causes where there are no walls.

    Returns:
        (longitudinal, lateral, orientation change) of each sequence; world units and radians.

    Example:
        >>> from motorspace.worlds.agents import ForwardAgent
        >>> nominal(ForwardAgent(), np.array([[[0.5, 0.0], [-0.5, 1.0]]])).round(3)
        array([[1., 0., 0.]], dtype=float32)
    """
    num, length, _ = motors.shape
    here = Pose(*jnp.zeros((4, num), jnp.float32))
    commands = to_agents_last(jnp.asarray(padded(motors)))
    return np.asarray(to_rows(_nominal(agent, here, commands, jnp.full(num, length, jnp.int32))))


_nominal = eqx.filter_jit(nominal_displacement)


def padded(motors: Float[np.ndarray, "N T M"]) -> Float[np.ndarray, "N L M"]:
    """The sequences as float32, with rows of zeros up to `PADDED_LENGTH`."""
    num, length, size = motors.shape
    filled = np.zeros((num, max(length, PADDED_LENGTH), size), np.float32)
    filled[:, :length] = motors
    return filled
