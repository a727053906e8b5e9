"""Simulated walks that nobody has seen before, and how well they are put together."""

import time
from collections.abc import Callable
from dataclasses import replace

import equinox as eqx
import jax
import numpy as np

from motorspace._types import Count, Key
from motorspace.analysis.paths import absolute_error, standing_still
from motorspace.mapping.motion import chained
from motorspace.mapping.odometry import distilled
from motorspace.mapping.rig import calibrate_rig, coded_frames, learn_rig
from motorspace.mapping.scores import Scores, measure_covariance, measure_path, measure_survey
from motorspace.mapping.survey import corrected_odometry, survey
from motorspace.recordings.record import commanded, record, with_motor_errors
from motorspace.recordings.recording import Recording, sensor_frames
from motorspace.training.config import RunConfig
from motorspace.training.data import simulated
from motorspace.training.run import Run, train
from motorspace.training.sources import Simulation, source_of
from motorspace.trajectories.transitions import Experience
from motorspace.worlds.layouts import Layout
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.sensors.range_fan import RangeFan

NUM_STEPS = 1000
NUM_BEAMS = 61
NOISE, BIAS = 0.05, 0.02
"""Relative error of each command, and what the body adds to it, in the command's own unit."""

OPEN = Layout("Walls out of reach", (-1000.0, -1000.0, 1000.0, 1000.0))


def unseen_walk(
    run: Run, world: str | Layout, *, noise: float = 0.0, bias: float = 0.0, key: Key
) -> Recording:
    """A walk of a run's agent through a world, with many rays and motors that may be wrong."""
    agent = simulated(run.config.data).scenario().agent
    walk_key, noise_key = jax.random.split(key)
    scenario = Scenario(world, agent, RangeFan(num_rays=NUM_BEAMS))
    walk = record(scenario, num_steps=NUM_STEPS, key=walk_key)
    return with_motor_errors(walk, noise=noise, bias=bias, key=noise_key)


def measure_odometry(run: Run, walk: Recording) -> dict[str, Scores]:
    """How far off odometry alone is along a walk, without loops.

    Returns:
        {path: {measure: value}}. Codes alone have a frame, a unit and perhaps a mirror image of
        their own: the best similarity lays them on the true path.
    """
    truth, rig = sensor_frames(walk), learn_rig(run, walk)
    scans = rig.scans(walk)
    corrected = corrected_odometry(scans).corrected(scans.steps)
    alone = min(
        absolute_error(coded_frames(codes, walk, per_scan=rig.per_scan), truth, scaled=True)
        for codes in (rig.odometry, rig.odometry.mirrored())
    )
    return {
        "still": measure_path(standing_still(truth), truth),
        "codes": {"path.ate": alone},
        "chained": measure_path(chained(scans.steps), truth),
        "corrected": measure_path(chained(corrected), truth),
    }


class MotorErrors(eqx.Module):
    """Transitions of a body that does not do exactly what it was commanded."""

    source: Callable[[Key, Count], Experience]
    noise: float
    bias: float

    def __call__(self, key: Key, epoch: Count) -> Experience:
        """New transitions, with the commands that have led to them."""
        experience = self.source(key, epoch)
        executed = experience.motors
        random = jax.random.normal(jax.random.fold_in(key, 1), executed.shape)
        motors = commanded(executed, random, noise=self.noise, bias=self.bias)
        return eqx.tree_at(lambda e: e.motors, experience, motors)


def trained_with_motor_errors(config: RunConfig, *, noise: float, bias: float) -> Run:
    """A run of the configuration whose body does m (1 + noise N(0, 1)) + bias when told m."""
    source = source_of(config)
    assert isinstance(source.experience, Simulation)
    biased = MotorErrors(source.experience, noise, bias)
    trained = train(config, biased, scaling=source.scaling)
    return replace(trained, config=config)


def bias_in_codes(run: Run, walk: Recording) -> float:
    """The share of the bias of a body's turns that codes hold: how far they turn beyond commands.

    Args:
        run: A run of an agent whose first command is its turn.
        walk: A walk of a body with the bias `BIAS`.
    """
    odometry = distilled(run, walk.increments).odometry
    commanded = walk.increments[:, 0]
    turned = odometry.steps(walk.increments)[2]
    beyond = np.sin(turned - commanded), np.sin(-turned - commanded)
    # Codes may be mirrored.
    plain = min(beyond, key=lambda off: float(np.mean(off**2)))
    return float(np.median(plain)) / BIAS


def measure_mapping(run: Run, walk: Recording) -> dict[str, Scores]:
    """Learn odometry and rays from a walk, put it together, and measure all of it.

    Returns:
        {path: {measure: value}}; seconds of computing time under "with loops".
    """
    began = time.process_time()
    scans = learn_rig(run, walk).scans(walk)
    found = survey(scans)
    seconds = time.process_time() - began
    paths = {"chained": chained(scans.steps), "corrected": found.local, "with loops": found.poses}
    scores = measure_survey(scans, found, paths, sensor_frames(walk))
    scores["with loops"]["seconds"] = seconds
    return scores


def measure_open(
    run: Run, world: str, *, noise: float = NOISE, bias: float = BIAS, key: Key
) -> Scores:
    """Calibrate a robot on one walk, and measure its odometry where no wall is in sight.

    Args:
        run: A run whose codes are products of 3 x 3 matrices.
        world: Where the robot is calibrated.
        noise: Relative error of each command, on both walks.
        bias: What the body adds to each command, on both.
        key: Randomness of the walks.

    Returns:
        Measures of the corrected path, and how much of it lies where its covariance says.
    """
    there, here = jax.random.split(key)
    robot = calibrate_rig(run, unseen_walk(run, world, noise=noise, bias=bias, key=there))
    after = unseen_walk(run, OPEN, noise=noise, bias=bias, key=here)
    scans, truth = robot.rig.scans(after), sensor_frames(after)
    path = chained(robot.motion.corrected(scans.steps))
    return measure_path(path, truth) | measure_covariance(scans, robot.motion, truth)
