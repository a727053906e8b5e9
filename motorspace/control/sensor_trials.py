"""Goals of readings, tried in a layout: the true simulator says whether the place was reached."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float
from jaxtyping import Key as KeyArray

from motorspace._types import Key, Motors, Pose, Sensors
from motorspace.control.codes import random_sequence
from motorspace.control.controller import Controller
from motorspace.control.following import carry_out, last_of
from motorspace.control.planning import USUAL, Effort, Method, Target, reach, sensor_target
from motorspace.control.trials import CHUNK_SIZE, Trials, apart, searched
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.simulation import rollout, to_rows


class Places(NamedTuple):
    """N places to go to, from where, and what is sensed there."""

    start: Pose
    goal: Pose
    sensors: Float[Array, "N K"]


def places(scenario: Scenario, num: int, length: int, *, key: Key) -> Places:
    """Places that random commands lead to, walls respected."""

    def one(key: Key) -> tuple[Pose, Pose]:
        start_key, motor_key = jax.random.split(key)
        start = scenario.start(key=start_key)
        motors = random_sequence(scenario.commands, length, key=motor_key)
        return start, last_of(rollout(scenario.world, scenario.agent, start, motors))

    start, goal = eqx.filter_jit(jax.vmap(one))(jax.random.split(key, num))
    return Places(start, goal, to_rows(scenario.sense(goal)))


def true_target(scenario: Scenario, start: Pose, goal: Sensors) -> Target:
    """Reach readings, judged by the true simulator from the true pose."""
    scale = jnp.array(scenario.space.scale)

    def residual(motors: Motors) -> Float[Array, " R"]:
        pose, *_ = carry_out(scenario, start, motors)
        return (scenario.sense(last_of(pose)) - goal) / scale

    return searched(residual)


@eqx.filter_jit
def ends(
    controller: Controller,
    scenario: Scenario,
    wanted: Places,
    method: Method,
    effort: Effort,
    simulated: bool,
    keys: KeyArray[Array, "N R"],
) -> Pose:
    """Where the agent is after R rounds of planning and carrying out, one plan a round."""

    def one(case: tuple[Pose, Sensors, KeyArray[Array, " R"]]) -> Pose:
        start, goal, keys = case

        def round_of(pose: Pose, key: Key) -> tuple[Pose, None]:
            now = scenario.sense(pose)
            target = (
                true_target(scenario, pose, goal)
                if simulated
                else sensor_target(controller, now, goal)
            )
            motors = reach(controller, target, method, effort, key=key)
            after, *_ = carry_out(scenario, pose, motors)
            return last_of(after), None

        return jax.lax.scan(round_of, start, keys)[0]

    return jax.lax.map(one, (wanted.start, wanted.sensors, keys), batch_size=CHUNK_SIZE)


def sensor_trials(
    controller: Controller,
    scenario: Scenario,
    wanted: Places,
    method: Method,
    effort: Effort = USUAL,
    *,
    rounds: int = 1,
    simulated: bool = False,
    key: Key,
) -> Trials:
    """What comes of goals of readings in a layout."""
    keys = jax.random.split(key, (len(wanted.sensors), rounds))
    there = ends(controller, scenario, wanted, method, effort, simulated, keys)
    return away(there, wanted.goal)


def away(there: Pose, goal: Pose) -> Trials:
    """How far poses are from those wanted."""
    off = [a - b for a, b in zip(there.frame, goal.frame, strict=True)]
    return apart(jnp.stack(off, axis=-1), 0.0)
