"""Simulated walks that nobody has seen before, and how well they are put together."""

import time

import jax
import numpy as np
from jaxtyping import Float

from motorspace._types import Key
from motorspace.mapping.calibration import Calibrated
from motorspace.mapping.motion import chained
from motorspace.mapping.rig import calibrate_rig, coded_frames, learn_rig
from motorspace.mapping.scores import Scores, measure_covariance, measure_path, measure_survey
from motorspace.mapping.survey import survey
from motorspace.recordings.record import record, with_motor_errors
from motorspace.recordings.recording import Recording
from motorspace.training.data import simulated
from motorspace.training.run import Run
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


def truth_of(walk: Recording) -> Float[np.ndarray, "3 N"]:
    """The true frames of the sensors along a simulated walk."""
    x, y, heading, head = walk.poses.T
    return np.stack([x, y, heading + head])


def measure_chained(run: Run, walk: Recording) -> Scores:
    """Errors of chained codes along a walk."""
    return measure_path(chained(learn_rig(run, walk).scans(walk).steps), truth_of(walk))


def measure_calibrated(body: Calibrated, walk: Recording) -> Scores:
    """Errors of a body's calibrated odometry along a walk."""
    odometry = body.odometry
    # Codes are as consistent in a mirror; rays are listed counter-clockwise.
    if np.median(np.sin(np.diff(body.mounting.angles))) < 0:
        odometry = odometry.mirrored()
    return measure_path(coded_frames(odometry, walk, per_scan=True), truth_of(walk))


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
    scores = measure_survey(scans, found, paths, truth_of(walk))
    scores["with loops"]["seconds"] = seconds
    return scores


def measure_uncharted(
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
    scans, truth = robot.rig.scans(after), truth_of(after)
    path = chained(robot.motion.corrected(scans.steps))
    return measure_path(path, truth) | measure_covariance(scans, robot.motion, truth)
