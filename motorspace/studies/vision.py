"""Does prediction build the space of displacements when no sensor tells how far anything is?

Walls carry flat colours or textures, and a retina sees nothing else. Every seed has colours of its
own.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

from motorspace.analysis.measures import Measure, define
from motorspace.studies import angle_scale
from motorspace.studies.rows import Numbers
from motorspace.studies.structure import at_horizon, structure_or_collapse
from motorspace.studies.study import Study
from motorspace.studies.vision_jobs import jobs
from motorspace.studies.vision_rows import FIGURES, SHORTER, TABLES, TARGETS, rows

if TYPE_CHECKING:
    from motorspace.training.run import Run

define(
    Measure("vision.error", "error / mean", goal="low", chance=1.0),
    Measure("vision.persistence", "persistence / mean", goal="low"),
    Measure("vision.error.{length}", "error / mean, T = {length}", goal="low", chance=1.0),
    Measure("vision.to_oracle", "error / oracle's", goal="low", perfect=1.0),
    Measure("vision.lost_to_light", "R² lost", goal="low", perfect=0.0),
    Measure("vision.untrained", "R², untrained", goal="high", perfect=1.0, chance=0.0),
    Measure("vision.home", "came home", goal="high", perfect=1.0),
    Measure("vision.home.chance", "came home, chance", goal="high", perfect=1.0),
)

HORIZON = 6
"""Commands of the sequences whose codes are measured, whatever they are learned from."""
NUM_TEST = 20_000
"""Sequences of each shorter length."""
HOME_STEPS = 300_000
NUM_IMAGES, NUM_TEST_IMAGES = 30_000, 3_000
IMAGE_SIZE = 12, 16
"""Rows and columns."""


def measured_codes(run: "Run", num: int) -> Numbers:
    """The structure of codes, and errors of prediction by the length of the sequence."""
    from motorspace.evaluation.subject import subject_of

    composed = at_horizon(run, HORIZON)
    found = structure_or_collapse(subject_of(composed), run.config.training.seed)
    return {**found, **measured_errors(composed, num)}


def measured_errors(run: "Run", num: int) -> Numbers:
    """Errors of prediction over that of the mean view, also of shorter sequences."""
    from motorspace.evaluation.evaluate import evaluate

    found = dict(evaluate(run, num=num))
    mean = found["prediction.mean"]
    found["vision.error"] = found["prediction.error"] / mean
    found["vision.persistence"] = found["prediction.persistence"] / mean
    for length in SHORTER:
        errors = evaluate(at_horizon(run, length), num=NUM_TEST)
        ratio = errors["prediction.error"] / errors["prediction.mean"]
        found[f"vision.error.{length}"] = ratio
    return found


def measured_images(run: "Run", num: int) -> Numbers:
    """The same from a camera's images along a walk of the run's agent, which the network learns."""
    import jax
    import numpy as np

    from motorspace.evaluation.prediction import mean_error, mean_squared_error, persistence_error
    from motorspace.evaluation.subject import subject_of
    from motorspace.models.model import Scaling
    from motorspace.recordings.drawn import draw_windows
    from motorspace.recordings.images import Camera, with_images
    from motorspace.recordings.record import record
    from motorspace.recordings.windows import windows
    from motorspace.training.data import Given, simulated
    from motorspace.training.run import train

    del num
    training, data = run.config.training, simulated(run.config.data)
    keys = jax.random.split(jax.random.key(training.seed), 2)
    learned, tested = (
        with_images(record(data.scenario(), num_steps=size, key=key), "paper", Camera(*IMAGE_SIZE))
        for size, key in zip((NUM_IMAGES, NUM_TEST_IMAGES), keys, strict=True)
    )
    source = draw_windows(
        learned,
        num=training.trajectories_per_epoch,
        horizon=data.horizon,
        curriculum_epochs=training.curriculum_epochs,
    )
    own = replace(run.config, data=Given("images of a walk", shape=learned.shape))
    scaling = Scaling(learned.sensor_scale, (1.0,) * learned.increments.shape[1])
    trained = train(own, source, scaling=scaling)
    seen = windows(tested, horizon=data.horizon, per_scan=True).experience
    mean = mean_error(seen, source.sensors.mean(axis=0))
    before = structure_or_collapse(subject_of(run), training.seed)
    after = structure_or_collapse(subject_of(replace(trained, config=run.config)), training.seed)
    return after | {
        "vision.error": mean_squared_error(trained.predict(seen), seen.later_sensors) / mean,
        "vision.persistence": persistence_error(seen) / mean,
        "vision.untrained": before.get("linear_r2.worst", np.nan),
    }


def measured_use(run: "Run", num: int) -> Numbers:
    """What codes are good for: displacement goals, the way home, odometry in unseen rooms."""
    from motorspace.control.controller import learn_controller
    from motorspace.control.scores import measure_controller
    from motorspace.studies.odometry import chained_errors

    del num
    odometry = chained_errors(run, biased=False)
    return measure_controller(run, learn_controller(run)) | odometry | _home(run)


def _home(run: "Run") -> dict[str, float]:
    """How many come home in unseen rooms by the chained code, beside chance."""
    from motorspace.navigation.arenas import codes_of
    from motorspace.navigation.learning import learn_with
    from motorspace.navigation.measuring import evaluate_others, evaluate_policy
    from motorspace.studies.navigation import NUM_BESIDE, configuration
    from motorspace.studies.observations import OBSERVATIONS

    seed = run.config.training.seed
    config = configuration(run, "home", OBSERVATIONS["chained code"], HOME_STEPS, seed)
    policy = learn_with(config, codes_of(run), run.config)
    numbers = evaluate_policy(policy, beside=False, seed=seed)
    beside = evaluate_others(config, num=NUM_BESIDE, seed=seed)
    return {
        "vision.home": float(numbers["unseen.success"]),
        "vision.home.chance": float(beside["chance.success"]),
    }


STUDY = Study(
    name="vision",
    question="Does prediction build the space of displacements from colours alone?",
    jobs=jobs,
    measures={
        "codes": measured_codes,
        "errors": measured_errors,
        "scaled angles": angle_scale.measured,
        "images": measured_images,
        "use": measured_use,
    },
    beside=("structure",),
    rows=rows,
    tables=TABLES,
    targets=TARGETS,
    figures=FIGURES,
)
