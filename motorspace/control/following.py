"""Acting on plans: carry out a part, see what is left of the goal, plan again."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from motorspace._types import Code, Key, Motors, Pose
from motorspace.control.controller import Controller
from motorspace.control.planning import USUAL, Effort, Method, code_target, reach
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.simulation import select


class Way(NamedTuple):
    """What an agent did on its way to a goal: L commands, in plans of T each."""

    motors: Float[Array, "L M"]
    poses: Pose
    """Before every command and after the last: fields [L + 1]."""
    blocked: Bool[Array, " L"]
    carried_out: Bool[Array, " L"]
    """Commands after a bump are not carried out: the agent plans again."""


def follow(
    controller: Controller,
    scenario: Scenario,
    start: Pose,
    goal: Code,
    *,
    rounds: int,
    method: Method = "hybrid",
    effort: Effort = USUAL,
    key: Key,
) -> Way:
    """Returns the way of an agent that acts towards a code, round after round.

    A bump ends a round. A goal farther than one sequence is approached by the sequence whose code
    is nearest. The agent senses what a wall forbids; that much more is left to be done.

    Args:
        controller: A controller. One whose codes are no products knows what remains of goals within
            one sequence only.
        scenario: Where the agent acts.
        start: Its pose.
        goal: The code of what is to be undergone.
        rounds: Plans, each of T commands.
        method: How each sequence is planned.
        effort: How hard the method tries.
        key: Source of randomness.

    Returns:
        Every command and every pose of the way.
    """

    def round_of(
        carry: tuple[Pose, Code], key: Key
    ) -> tuple[tuple[Pose, Code], tuple[Motors, Pose, Array, Array]]:
        pose, goal = carry
        near = _within_reach(controller, goal)
        target = code_target(controller, near)
        motors = reach(controller, target, method, effort, key=key)
        poses, blocked, done = carry_out(scenario, pose, motors)
        happened = controller.commands.without_translation(motors.T, blocked).T
        left = controller.remaining(goal, happened, done)
        return (last_of(poses), left), (motors, poses, blocked, done)

    _, (motors, poses, blocked, done) = jax.lax.scan(
        round_of, (start, goal), jax.random.split(key, rounds)
    )
    flat = jax.tree.map(lambda field: field.reshape(-1, *field.shape[2:]), (motors, poses))
    along = jax.tree.map(lambda first, rest: jnp.concatenate([first[None], rest]), start, flat[1])
    return Way(flat[0], along, blocked.reshape(-1), done.reshape(-1))


def last_of(poses: Pose) -> Pose:
    """The last of poses in order of time."""
    return jax.tree.map(lambda field: field[-1], poses)


Each = Bool[Array, " T"]


def carry_out(
    scenario: Scenario, start: Pose, motors: Float[Array, "T M"]
) -> tuple[Pose, Each, Each]:
    """Poses after each command, which were blocked, and which were carried out at all."""

    def advance(
        carry: tuple[Pose, Array], motor: Array
    ) -> tuple[tuple[Pose, Array], tuple[Pose, Array, Array]]:
        pose, going = carry
        after, blocked = scenario.step(pose, motor)
        after = select(going, after, pose)
        return (after, going & ~blocked), (after, blocked & going, going)

    going = jnp.array(True)
    _, (poses, blocked, done) = jax.lax.scan(advance, (start, going), motors)
    return poses, blocked, done


carry_out_compiled = eqx.filter_jit(carry_out)
"""The same outside of compiled programs."""


def _within_reach(controller: Controller, goal: Code) -> Code:
    """The goal, or of the bank's codes the nearest to it if the goal lies beyond them."""
    away = jax.vmap(lambda code: controller.whitening.distance(code, goal))(controller.bank.codes)
    nearest = controller.bank.codes[jnp.argmin(away)]
    return jnp.where(jnp.min(away) > FARTHEST, nearest, goal)


FARTHEST = 1.0
"""Squared whitened distance from the nearest code of the bank, beyond which a goal is too far."""
