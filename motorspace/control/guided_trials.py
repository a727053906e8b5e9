"""Goals of readings, planned by a judge that has walked through the layout."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np

from motorspace._types import Key, Pose
from motorspace.control.controller import Controller
from motorspace.control.following import carry_out_compiled, last_of
from motorspace.control.guide import Guide
from motorspace.control.journey import seek
from motorspace.control.scores import LOOSE, Scores
from motorspace.control.sensor_trials import Places, away, places, sensor_trials
from motorspace.control.trials import Trials
from motorspace.judge.roadmap import Roadmap
from motorspace.judge.scores import Explored
from motorspace.training.data import simulated
from motorspace.training.run import Run
from motorspace.worlds.scenario import Scenario

FAR = 5
"""Sequences in a row that lead to a goal that is far."""
ROUNDS = 15
"""Plans to reach it; a bump ends one."""
GOAL_SEED = 3_000_029


def guided_trials(guide: Guide, scenario: Scenario, wanted: Places, *, key: Key) -> Trials:
    """What comes of goals of readings one sequence away, each with one plan."""
    now = np.asarray(scenario.sense(wanted.start)).T

    def end(start: Pose, index: int, key: Key) -> Pose:
        motors = guide.plan(now[index], np.asarray(wanted.sensors[index]), key=key)
        poses, *_ = carry_out_compiled(scenario, start, jnp.asarray(motors, jnp.float32))
        return last_of(poses)

    return _each(wanted, end, key=key)


def journey_trials(
    guide: Guide, roadmap: Roadmap, scenario: Scenario, wanted: Places, *, key: Key
) -> Trials:
    """What comes of goals of readings farther away, with at most `ROUNDS` plans each."""

    def end(start: Pose, index: int, key: Key) -> Pose:
        goal = np.asarray(wanted.sensors[index])
        return last_of(seek(guide, roadmap, scenario, start, goal, rounds=ROUNDS, key=key).poses)

    return _each(wanted, end, key=key)


def _each(wanted: Places, end: Callable[[Pose, int, Key], Pose], *, key: Key) -> Trials:
    keys = jax.random.split(key, len(wanted.sensors))

    def one(index: int) -> Pose:
        start = jax.tree.map(lambda field: field[index], wanted.start)
        return end(start, index, keys[index])

    ends = [one(index) for index in range(len(keys))]
    return away(jax.tree.map(lambda *fields: jnp.stack(fields), *ends), wanted.goal)


def measure_guide(
    run: Run, controller: Controller, explored: Explored, *, num: int, num_far: int
) -> Scores:
    """The share of goals of readings that are reached, by who judges where commands lead.

    Args:
        run: The run.
        controller: Of the run.
        explored: What judges of the run know.
        num: Goals one sequence away, in the run's layout and in another one.
        num_far: Goals `FAR` sequences away, in the run's layout.

    Returns:
        `judge.seen.JUDGE` and `judge.elsewhere.JUDGE`, within 0.25 units and 10 degrees after one
        sequence; `judge.far.JUDGE`, within 0.5 units and 20 degrees after at most `ROUNDS`. JUDGE
        is guided, simulated (search in the true simulator), predictor, or stay.
    """
    scenario, seed = simulated(run.config.data).scenario(), run.config.training.seed
    *keys, far_key, key = jax.random.split(jax.random.key(GOAL_SEED + seed), 4)
    seen = Guide(controller, explored.most)
    layouts = {
        "seen": (seen, scenario),
        "elsewhere": (Guide(controller, explored.unseen), explored.elsewhere),
    }
    scores: Scores = {}
    for (name, (guide, layout)), place_key in zip(layouts.items(), keys, strict=True):
        wanted = places(layout, num, controller.horizon, key=place_key)
        rows = _others(controller, layout, wanted, 1, key=key)
        rows["guided"] = guided_trials(guide, layout, wanted, key=key)
        scores |= {f"judge.{name}.{who}": trials.success() for who, trials in rows.items()}
    wanted = places(scenario, num_far, FAR * controller.horizon, key=far_key)
    rows = _others(controller, scenario, wanted, ROUNDS, key=key)
    roadmap = Roadmap(explored.most.walls, explored.most.eyes)
    rows["guided"] = journey_trials(seen, roadmap, scenario, wanted, key=key)
    return scores | {f"judge.far.{who}": trials.success(LOOSE) for who, trials in rows.items()}


def _others(
    controller: Controller, scenario: Scenario, wanted: Places, rounds: int, *, key: Key
) -> dict[str, Trials]:
    """What comes of the same goals by other judges."""
    return {
        "simulated": sensor_trials(
            controller, scenario, wanted, "cross_entropy", rounds=rounds, simulated=True, key=key
        ),
        "predictor": sensor_trials(controller, scenario, wanted, "hybrid", rounds=rounds, key=key),
        "stay": away(wanted.start, wanted.goal),
    }
