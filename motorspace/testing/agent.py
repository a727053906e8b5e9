"""What any agent must satisfy."""

import jax
import jax.numpy as jnp
import numpy as np

from motorspace._types import Motor, Pose
from motorspace.testing.require import require, require_equal
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.catalog import AGENTS
from motorspace.worlds.scenario import WorldLike, world_of

NUM = 64


def check_agent(agent: AbstractAgent, world: WorldLike = "empty") -> None:
    """Check an agent: its options, its commands, and how it moves.

    Args:
        agent: An object of the class to check.
        world: A world that it can move in.

    Raises:
        AssertionError: Naming what is wrong.

    Example:
        >>> from motorspace.worlds.agents import ForwardAgent
        >>> check_agent(ForwardAgent())  # doctest: +SKIP
    """
    part = AGENTS.part_of(agent)
    require_equal(AGENTS.build(part), agent, "an agent built from its own options differs from it")
    place = world_of(world)
    agent.check(place)
    keys = jax.random.split(jax.random.key(0), NUM)
    motors = jax.vmap(lambda key: agent.commands.sample(key=key), out_axes=-1)(keys)
    _check_commands(agent, motors)
    poses = jax.vmap(lambda key: agent.start(place.place(key=key), key=key), out_axes=-1)(keys)
    _check_moves(agent, poses, motors)


def _check_commands(agent: AbstractAgent, motors: Motor) -> None:
    commands = agent.commands
    require(
        motors.shape == (commands.size, NUM),
        f"commands have the shape {motors.shape[:-1]}, their space says ({commands.size},)",
    )
    require(bool(jnp.isfinite(motors).all()), "random commands must be finite")
    inside = jnp.abs(commands.clip(motors) - motors) < 1e-6
    require(bool(inside.all()), "random commands must lie within the bounds of their space")
    again = commands.sample(key=jax.random.split(jax.random.key(0), NUM)[0])
    require(bool((again == motors[:, 0]).all()), "the same key must give the same command")


def _check_moves(agent: AbstractAgent, poses: Pose, motors: Motor) -> None:
    legs = agent.move(poses, motors)
    require(len(legs) > 0, "`move` must give at least one leg")
    turned = agent.turn(poses, motors)
    for pose in (*legs, turned):
        for name, value in vars(pose).items():
            require(value.shape == (NUM,), f"`{name}` loses the batch: it has shape {value.shape}")
            require(bool(jnp.isfinite(value).all()), f"`{name}` must be finite")
    still = (turned.x == poses.x) & (turned.y == poses.y)
    require(bool(still.all()), "`turn` must not translate the body")
    one = jax.tree.map(lambda field: field[3], poses)
    alone = agent.move(one, motors[:, 3])[-1]
    compiled = jax.jit(agent.move)(poses, motors)[-1]
    for name in ("x", "y", "heading", "head"):
        together = np.asarray(getattr(legs[-1], name))
        np.testing.assert_allclose(
            getattr(alone, name), together[3], atol=1e-5, err_msg=f"one and many differ in `{name}`"
        )
        np.testing.assert_allclose(
            getattr(compiled, name), together, atol=1e-5, err_msg=f"jit changes `{name}`"
        )
