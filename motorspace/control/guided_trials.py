"""Goals of readings, planned by a judge that has walked through the layout."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from motorspace._types import Key, Pose
from motorspace.control.controller import Controller
from motorspace.control.following import carry_out, last_of
from motorspace.control.guide import Guide
from motorspace.control.sensor_trials import away, places
from motorspace.control.trials import Trials
from motorspace.judge.judge import NUM_EXPLORED, Judge, calibrate
from motorspace.judge.walks import walk
from motorspace.training.data import simulated
from motorspace.training.run import Run

NUM_GOALS = 100


def guided_trials(
    run: Run,
    controller: Controller,
    num: int = NUM_GOALS,
    *,
    num_explored: int = NUM_EXPLORED,
    key: Key,
) -> Trials:
    """What comes of goals of readings after one walk through the run's layout.

    Raises:
        UserError: For a run whose codes or readings the judge cannot read.
    """
    scenario = simulated(run.config.data).scenario()
    body_key, walk_key, place_key, key = jax.random.split(key, 4)
    explored = walk(scenario, num_steps=num_explored, key=walk_key)
    guide = Guide(controller, Judge(calibrate(run, key=body_key), explored))
    wanted = places(scenario, num, controller.horizon, key=place_key)
    now = np.asarray(scenario.sense(wanted.start)).T
    step = eqx.filter_jit(lambda pose, motors: carry_out(scenario, pose, motors)[0])

    def end(index: int, key: Key) -> Pose:
        motors = guide.plan(now[index], np.asarray(wanted.sensors[index]), key=key)
        start = jax.tree.map(lambda field: field[index], wanted.start)
        return last_of(step(start, jnp.asarray(motors, jnp.float32)))

    ends = [end(index, k) for index, k in enumerate(jax.random.split(key, num))]
    return away(jax.tree.map(lambda *fields: jnp.stack(fields), *ends), wanted.goal)
