"""A controller in numbers, beside chance and beside search that is judged by the true simulator."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._types import Displacement, Key, Motors, Pose
from motorspace.control.codes import fit_probe, random_sequences
from motorspace.control.composing import is_product
from motorspace.control.controller import Controller
from motorspace.control.following import follow, last_of
from motorspace.control.planning import USUAL, Effort, Method, code_target, reach
from motorspace.control.sensor_trials import away, places, sensor_trials
from motorspace.control.trials import (
    CHUNK_SIZE,
    Trials,
    apart,
    displacement_goals,
    displacement_trials,
    diversity,
    judged,
)
from motorspace.se2 import relative
from motorspace.training.data import simulated
from motorspace.training.run import Run
from motorspace.trajectories.commands import nominal
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.scenario import Scenario

FEW_LABELS = 20
FAR = 4
"""Sequences in a row that lead to a goal that is far."""
ROUNDS = 8
"""Plans to reach it."""
LOOSE = 2.0
"""How many times the usual slack is allowed where goals are only to be approached."""
TEST_SEED = 3_000_017

Scores = dict[str, float]


def measure_controller(
    run: Run, controller: Controller, *, num: int = 1000, seed: int = 0
) -> Scores:
    """Returns the share of goals that a controller reaches.

    A goal is reached within 0.25 world units and 10 degrees, as the true simulator has it.

    Args:
        run: The run of the controller.
        controller: The controller.
        num: Goals of each kind.
        seed: Seed of the goals.

    Returns:
        `control.success.KIND` for displacements in free space, `control.sensors.KIND` for readings
        in the run's layout, `control.cost.KIND` relative to the search that the simulator
        judges, and `control.diversity` of the answers to one goal.
    """
    scenario = simulated(run.config.data).scenario()
    keys = jax.random.split(jax.random.key(TEST_SEED + seed), 3)
    found = _free_space(controller, scenario.agent, num, key=keys[0])
    if is_product(controller.model):
        found["control.success.far"] = far_trials(
            controller, scenario.agent, num, key=keys[1]
        ).success(LOOSE)
    return found | _sensors(controller, scenario, num, key=keys[2])


def _free_space(controller: Controller, agent: AbstractAgent, num: int, *, key: Key) -> Scores:
    goal_key, key = jax.random.split(key)
    goals = displacement_goals(agent, num, controller.horizon, key=goal_key)

    def tried(method: Method, effort: Effort = USUAL, *, by_simulator: bool = False) -> Trials:
        return displacement_trials(
            controller, agent, goals, method, effort, simulated=by_simulator, key=key
        )

    rows = {
        "amortised": tried("amortised"),
        "best_of_8": tried("hybrid", Effort(refinements=0)),
        "hybrid": tried("hybrid"),
        "shooting": tried("shooting"),
        "cross_entropy": tried("cross_entropy"),
        "simulated_shooting": tried("shooting", by_simulator=True),
        "simulated_cross_entropy": tried("cross_entropy", by_simulator=True),
        "few_labels": displacement_trials(
            _with_labels(controller, agent, FEW_LABELS, key=key), agent, goals, "hybrid", key=key
        ),
        "replanned": _replanned(controller, agent, goals, key=key),
        "random": _random(controller, agent, goals, key=key),
    }
    success = {f"control.success.{name}": trials.success() for name, trials in rows.items()}
    search = rows["simulated_cross_entropy"].seconds
    cost = {f"control.cost.{n}": rows[n].seconds / search for n in ("best_of_8", "hybrid")}
    varied = diversity(controller, goals[:50], key=key)
    return success | cost | {"control.diversity": varied}


def _random(
    controller: Controller, agent: AbstractAgent, goals: Float[Array, "N 3"], *, key: Key
) -> Trials:
    """What chance reaches: a random sequence for each goal."""
    size = len(goals), controller.horizon
    return judged(agent, random_sequences(agent.commands, size, key=key), goals, 0.0)


@eqx.filter_jit
def _halfway(
    controller: Controller, goals: Float[Array, "N 3"], keys: Array
) -> Float[Array, "N L M"]:
    """Half a plan, and a plan for what then remains."""
    half = controller.horizon // 2

    def one(goal: Displacement, key: Key) -> Motors:
        code = controller.probe(goal)
        first_key, then_key = jax.random.split(key)
        first = reach(controller, code_target(controller, code), "hybrid", key=first_key)
        left = controller.remaining(code, first, jnp.arange(controller.horizon) < half)
        then = reach(controller, code_target(controller, left), "hybrid", key=then_key)
        return jnp.concatenate([first[:half], then])

    return jax.vmap(one)(goals, keys)


def _replanned(
    controller: Controller, agent: AbstractAgent, goals: Float[Array, "N 3"], *, key: Key
) -> Trials:
    """What comes of planning again halfway."""
    motors = _halfway(controller, goals, jax.random.split(key, len(goals)))
    return judged(agent, motors, goals, 0.0)


def _with_labels(controller: Controller, agent: AbstractAgent, num: int, *, key: Key) -> Controller:
    """The controller with a probe fitted on so many examples."""
    motors = controller.bank.motors[:num]
    probe = fit_probe(nominal(agent, np.asarray(motors)), controller.bank.codes[:num])
    return eqx.tree_at(lambda c: c.probe, controller, probe)


def far_trials(controller: Controller, agent: AbstractAgent, num: int, *, key: Key) -> Trials:
    """What comes of displacement goals `FAR` sequences away, in free space."""
    scenario = Scenario("empty", agent)
    goals = displacement_goals(agent, num, FAR * controller.horizon, key=key)
    middle = Pose(*jnp.array([20.0, 20.0, 0.0, 0.0], jnp.float32))

    @eqx.filter_jit
    def ends(controller: Controller, keys: Array) -> Float[Array, "N 3"]:
        def one(case: tuple[Displacement, Key]) -> Displacement:
            goal, key = case
            code = controller.probe(goal)
            way = follow(controller, scenario, middle, code, rounds=ROUNDS, key=key)
            return relative(middle.frame, last_of(way.poses).frame)

        return jax.lax.map(one, (goals, keys), batch_size=CHUNK_SIZE)

    return apart(ends(controller, jax.random.split(key, num)) - goals, 0.0)


def _sensors(controller: Controller, scenario: Scenario, num: int, *, key: Key) -> Scores:
    place_key, key = jax.random.split(key)
    wanted = places(scenario, num, controller.horizon, key=place_key)
    rows = {
        "hybrid": sensor_trials(controller, scenario, wanted, "hybrid", key=key),
        "cross_entropy": sensor_trials(controller, scenario, wanted, "cross_entropy", key=key),
        "simulated": sensor_trials(
            controller, scenario, wanted, "cross_entropy", simulated=True, key=key
        ),
        "stay": away(wanted.start, wanted.goal),
    }
    strict = {f"control.sensors.{name}": trials.success() for name, trials in rows.items()}
    loose = {f"control.sensors.loose.{n}": trials.success(LOOSE) for n, trials in rows.items()}
    return strict | loose
