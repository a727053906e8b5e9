"""How well a controller does: the true simulator judges, on goals that nothing was learned from."""

import time
from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._types import Displacement, Key, Motors, Pose, Scalar
from motorspace.control.codes import random_sequence
from motorspace.control.controller import Controller
from motorspace.control.decoder import squash
from motorspace.control.learning import RANDOM_SPREAD, scaled
from motorspace.control.planning import USUAL, Effort, Method, Target, code_target, reach
from motorspace.se2 import wrap
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.simulation import nominal_displacement

NEAR, AIMED = 0.25, np.deg2rad(10.0)
"""A goal is reached within so many world units and radians."""


class Trials(NamedTuple):
    """What came of N goals."""

    distances: Float[np.ndarray, " N"]
    """World units from the goal."""
    angles: Float[np.ndarray, " N"]
    """Radians from the goal's direction."""
    seconds: float
    """Computing time per goal, in batches."""

    def success(self, slack: float = 1.0) -> float:
        """The share of goals that are reached, within so many times `NEAR` and `AIMED`."""
        return float(np.mean((self.distances <= slack * NEAR) & (self.angles <= slack * AIMED)))


def moved(agent: AbstractAgent, motors: Motors) -> Displacement:
    """The displacement that a motor sequence causes where there are no walls."""
    here = Pose(*jnp.zeros(4, jnp.float32))
    return nominal_displacement(agent, here, motors, jnp.array(len(motors), jnp.int32))


def displacement_goals(
    agent: AbstractAgent, num: int, horizon: int, *, key: Key
) -> Float[Array, "N 3"]:
    """Displacements that random sequences cause, so that all of them can be reached."""

    def one(key: Key) -> Displacement:
        return moved(agent, random_sequence(agent.commands, horizon, key=key))

    return eqx.filter_jit(jax.vmap(one))(jax.random.split(key, num))


def searched(residual: Callable[[Motors], Float[Array, " R"]]) -> Target:
    """What the true simulator judges: it can be searched for, and nothing knows where to start."""

    def guesses(num: int, key: Key) -> Float[Array, "S T M"]:
        raise NotImplementedError("only methods that search can be judged by the simulator")

    return Target(residual, guesses)


def simulator_target(agent: AbstractAgent, goal: Displacement) -> Target:
    """Reach a displacement, judged by the true simulator: what any other judge is held against."""

    def residual(motors: Motors) -> Float[Array, " R"]:
        off = moved(agent, motors) - goal
        return jnp.stack([off[0] / NEAR, off[1] / NEAR, wrap(off[2]) / AIMED])

    return searched(residual)


CHUNK_SIZE = 100


@eqx.filter_jit
def answers(
    controller: Controller,
    agent: AbstractAgent,
    goals: Float[Array, "N 3"],
    method: Method,
    effort: Effort,
    simulated: bool,
    key: Key,
) -> Float[Array, "N T M"]:
    """A motor sequence for each displacement."""

    def one(case: tuple[Displacement, Key]) -> Motors:
        goal, key = case
        code = controller.probe(goal)
        target = simulator_target(agent, goal) if simulated else code_target(controller, code)
        return reach(controller, target, method, effort, key=key)

    return jax.lax.map(one, (goals, jax.random.split(key, len(goals))), batch_size=CHUNK_SIZE)


def displacement_trials(
    controller: Controller,
    agent: AbstractAgent,
    goals: Float[Array, "N 3"],
    method: Method,
    effort: Effort = USUAL,
    *,
    simulated: bool = False,
    key: Key,
) -> Trials:
    """What comes of displacement goals in free space."""
    work = goals, method, effort, simulated
    jax.block_until_ready(answers(controller, agent, *work, key))
    began = time.process_time()
    motors = jax.block_until_ready(answers(controller, agent, *work, key))
    seconds = (time.process_time() - began) / len(goals)
    return judged(agent, motors, goals, seconds)


def judged(
    agent: AbstractAgent, motors: Float[Array, "N T M"], goals: Float[Array, "N 3"], seconds: float
) -> Trials:
    """Where motor sequences lead in free space, beside where they should have led."""
    ends = eqx.filter_jit(jax.vmap(lambda m: moved(agent, m)))(motors)
    return apart(ends - goals, seconds)


def apart(off: Float[Array, "N 3"], seconds: float) -> Trials:
    """Trials from differences of poses."""
    return Trials(
        np.asarray(jnp.hypot(off[:, 0], off[:, 1])), np.abs(np.asarray(wrap(off[:, 2]))), seconds
    )


def diversity(
    controller: Controller, goals: Float[Array, "N 3"], num: int = 16, *, key: Key
) -> float:
    """How much the decoder's answers to one goal differ, relative to random sequences."""

    @eqx.filter_jit
    def spread(controller: Controller, goal: Displacement, key: Key) -> Scalar:
        target = code_target(controller, controller.probe(goal))
        commands = controller.commands
        rows = jax.vmap(lambda one: scaled(commands, squash(commands, one)))(
            target.guesses(num, key)
        )
        pairs = jnp.mean((rows[:, None] - rows[None]) ** 2, axis=-1)
        return jnp.sum(jnp.sqrt(pairs)) / (num * (num - 1))

    keys = jax.random.split(key, len(goals))
    each = [spread(controller, goal, k) for goal, k in zip(goals, keys, strict=True)]
    return float(np.mean(each)) / RANDOM_SPREAD
