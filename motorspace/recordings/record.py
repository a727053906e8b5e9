"""Walks of simulated agents."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from motorspace._errors import UserError
from motorspace._types import Collision, Flag, Key, Keys, Motor, Pose
from motorspace.recordings.recording import Recording
from motorspace.se2 import Batch
from motorspace.worlds.exploration import Policy
from motorspace.worlds.scenario import Scenario

MAX_REFUSALS = 30
"""So many commands are sampled for a step before the agent counts as stuck."""


def record(
    scenario: Scenario,
    *,
    num_steps: int,
    collision: Collision = "resample",
    policy: Policy | None = None,
    key: Key,
) -> Recording:
    """One walk of random commands, with a reading before, between and after them.

    Args:
        scenario: The world, the agent and its sensor.
        num_steps: Commands in a row.
        collision: What happens to a command whose movement crosses a wall. "resample" samples
            another one; where 30 in a row are refused, the agent only turns, the walk says so,
            and no transition goes through this step. "block" keeps the command and discards its
            translation.
        policy: Commands as a function of a key; uniform in the agent's command space by default.
        key: Source of the start and of the commands.

    Returns:
        `num_steps` + 1 scans, one command between each two of them, true poses. A step lasts one
        second.

    Raises:
        UserError: Fewer than one step, or a world without a free place.
    """
    if num_steps < 1:
        raise UserError(f"num_steps must be at least 1, got {num_steps}")
    start_key, walk_key = jax.random.split(key)
    start = scenario.start(key=start_key)
    tries = MAX_REFUSALS if collision == "resample" else 1
    keys = jax.random.split(walk_key, num_steps)
    poses, motors, blocked = _walk(scenario, policy, start, keys, tries)
    usable = np.ones(num_steps, bool)
    if collision == "resample":
        usable = ~np.asarray(blocked)
        motors = scenario.commands.without_translation(motors.T, blocked).T
    stuck = int((~usable).sum())
    return Recording(
        name=f"simulated {type(scenario.agent).__name__}",
        time=np.arange(num_steps + 1, dtype=np.float64),
        sensors=np.asarray(scenario.sense(poses).T, np.float64),
        increments=np.asarray(motors, np.float64),
        interval=np.arange(num_steps),
        poses=np.stack([poses.x, poses.y, poses.heading, poses.head], axis=-1).astype(np.float64),
        sensor_scale=tuple(scenario.space.scale),
        planar=False,
        usable=usable,
        notes=(f"the agent was stuck in {stuck} of {num_steps} steps: left out",) * bool(stuck),
    )


def with_motor_errors(
    recording: Recording, *, noise: float = 0.0, bias: float = 0.0, key: Key
) -> Recording:
    """The same walk of a body that does not do exactly what it was commanded.

    The body does m (1 + noise N(0, 1)) + bias where m was commanded, in every channel anew: the
    walk stays as it was, and its commands become those that have led to it.

    Args:
        recording: A simulated walk.
        noise: Standard deviation of the relative error of each command.
        bias: What is added to each command, in its own unit.
        key: Randomness of the noise.
    """
    random = np.asarray(jax.random.normal(key, recording.increments.shape))
    motors = commanded(recording.increments, random, noise=noise, bias=bias)
    return replace(recording, increments=motors)


def commanded(executed: Batch, random: Batch, *, noise: float, bias: float) -> Batch:
    """The commands of a body that has executed these: m where m (1 + noise random) + bias was done.

    Args:
        executed: Commands of any shape, NumPy or JAX.
        random: A standard normal number for each.
        noise: Standard deviation of the relative error of each command.
        bias: What is added to each command, in its own unit.
    """
    return (executed - bias) / (1 + noise * random)


@eqx.filter_jit
def _walk(
    scenario: Scenario, policy: Policy | None, start: Pose, keys: Keys, tries: int
) -> tuple[Pose, Float[Array, "T M"], Bool[Array, " T"]]:
    """The poses from the start on, the commands, and which of them a wall blocked."""

    explores = scenario.commands.sample if policy is None else policy

    def advance(pose: Pose, key: Key) -> tuple[Pose, tuple[Pose, Motor, Flag]]:
        def sampled(key: Key) -> Motor:
            return explores(key=key)

        motors = jax.vmap(sampled, out_axes=-1)(jax.random.split(key, tries))
        here = jax.tree.map(lambda field: jnp.broadcast_to(field, (tries,)), pose)
        after, blocked = scenario.step(here, motors)
        first = jnp.argmin(blocked)
        then = jax.tree.map(lambda field: field[first], after)
        return then, (then, motors[:, first], blocked[first])

    _, (poses, motors, blocked) = jax.lax.scan(advance, start, keys)
    poses = jax.tree.map(lambda a, b: jnp.concatenate([a[None], b]), start, poses)
    return poses, motors, blocked
