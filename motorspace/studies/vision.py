"""Does prediction build the space of displacements when no sensor tells how far anything is?

Walls carry flat colours or textures, and a retina sees nothing else. Every seed has colours of its
own.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

from motorspace.analysis.measures import Measure, define
from motorspace.running.jobs import Job, Value, cell
from motorspace.studies import angle_scale
from motorspace.studies.cells import derived, oracle, system, untrained
from motorspace.studies.rows import Numbers
from motorspace.studies.structure import structure_or_collapse
from motorspace.studies.study import Budget, Study
from motorspace.studies.vision_rows import FIGURES, HALF, SCALED, TABLES, TARGETS, rows
from motorspace.training.config import RunConfig
from motorspace.training.presets import PresetName
from motorspace.training.settings import changed
from motorspace.worlds.paint import parse_paint

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

ROTATION = 0.4
FLAT = (
    *(("forward", rotation, "flat") for rotation in (0.2, ROTATION, 0.8)),
    *(("holonomic", rotation, "flat") for rotation in (ROTATION, 0.8)),
)
TEXTURED = (
    ("forward", ROTATION, "texture:12"),
    ("forward", ROTATION, "texture:4"),
    ("forward", 0.8, "texture:4"),
    ("holonomic", ROTATION, "texture:4"),
    ("forward", ROTATION, "texture:1"),
)
MAIN = (*FLAT, *TEXTURED)
"""Agent, largest rotation in units of pi, and paint: what stands beside baselines."""

CURVE = (
    *(("texture:4", pixels) for pixels in (9, 16, 128)),
    ("texture:2", 32),
    *(("texture:1", pixels) for pixels in (64, 128)),
)
"""Further points of the curve over wavelengths and pixels."""

FEATURES = {"blur_weight": 0.0, "latent_weight": 1.0}
LOSSES = {"pixels alone": {"blur_weight": 0.0}, "features": FEATURES}
"""What is predicted, if it is not pixels and blurred pixels together."""

SEQUENCES = {
    "one command": {"horizon": 1, "curriculum": 0.0},
    "six commands": {"curriculum": 0.0},
    "six commands, small steps": {"curriculum": 0.0, "learning_rate": 1e-3},
}
"""What is learned from, if it is not ever longer sequences."""
HORIZON = 6

ANGLES = (0.8, 1.0, 1.25)
"""What an oracle's rotations are multiplied by where codes turn too far."""
WITHOUT_CODES = {"encoder": "identity", "code_noise": 0.0, "isometry_weight": 0.0}

SHORTER, NUM_TEST = (1, 2, 3), 20_000
HOME_STEPS = 300_000
NUM_IMAGES, NUM_TEST_IMAGES = 30_000, 3_000
IMAGE_SIZE = 12, 16
"""Rows and columns."""


def seen(
    agent: str,
    rotation: float,
    paint: str,
    budget: Budget,
    seed: int,
    preset: PresetName = "vision",
) -> RunConfig:
    """A run of an agent with a retina in a painted room, whose colours are of this seed."""
    config = system(agent, rotation, budget, seed, preset)
    painted = replace(parse_paint(paint), seed=seed).name
    return changed(config, {"sensor": "retina", "paint": painted})


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Seed after seed: what learns from colours first, then what stands beside it."""
    return [job for seed in range(seeds) for job in _of_seed(budget, seed)]


def _of_seed(budget: Budget, seed: int) -> list[Job]:
    def job(
        place: tuple[str, float, str],
        variant: str,
        config: RunConfig,
        measure: str = "codes",
        **further: Value,
    ) -> Job:
        agent, rotation, paint = place
        named = cell(agent=agent, rotation=rotation, paint=paint, variant=variant, **further)
        return Job("vision", named, config, measure, trains=measure != "images")

    configs = {place: seen(*place, budget, seed) for place in MAIN}
    flat, fine = ("forward", ROTATION, "flat"), ("forward", ROTATION, "texture:4")
    found = [job(place, "vision", config) for place, config in configs.items()]
    paper = seen(*flat, budget, seed, "vision_paper")
    found.append(job(flat, "paper's network", paper))
    for paint, num_rays in CURVE:
        place = ("forward", ROTATION, paint)
        config = changed(seen(*place, budget, seed), {"num_rays": num_rays})
        found.append(job(place, "pixels", config, pixels=num_rays))
    half = ("forward", ROTATION, HALF)
    found.append(job(half, "vision", seen(*half, budget, seed)))
    found += [
        job(flat, "light", changed(configs[flat], {"light": light}), light=light)
        for light in ("trajectory", "view")
    ]
    found += [
        job(place, name, changed(configs[place], settings))
        for name, settings in LOSSES.items()
        for place in (flat, fine)
    ]
    found += [
        job(fine, name, changed(configs[fine], settings)) for name, settings in SEQUENCES.items()
    ]
    by_camera = ("forward", ROTATION, "MiniWorld")
    walking = system("forward", ROTATION, budget, seed, "vision")
    found.append(job(by_camera, "images", walking, "images"))
    distances = system("forward", ROTATION, budget, seed, "best")
    found += [
        job(flat, "use", configs[flat], "use", used="colours"),
        job(flat, "use", changed(configs[flat], FEATURES), "use", used="features of colours"),
        job(flat, "use", distances, "use", used="distances"),
    ]
    small = ("forward", 0.2, "flat")
    for angle in ANGLES:
        turned = changed(derived(configs[small], "scaled_rotations", angle=angle), WITHOUT_CODES)
        found.append(job(small, SCALED, turned, "scaled angles", angle=angle))
    for place, config in configs.items():
        curriculum = {"curriculum": config.training.curriculum}
        informed = changed(oracle(config), WITHOUT_CODES | curriculum)
        nothing = changed(config, WITHOUT_CODES | {"encoder": "none"})
        found += [
            job(place, "oracle", informed, "errors"),
            job(place, "no motors", nothing, "errors"),
            job(place, "untrained", changed(untrained(config), curriculum)),
        ]
    return found


def measured_codes(run: "Run", num: int) -> Numbers:
    """The structure of codes, and errors of prediction by the length of the sequence."""
    from motorspace.evaluation.subject import subject_of

    # Whatever they are learned from, codes are those of six commands.
    composed = replace(run, config=changed(run.config, {"horizon": HORIZON, "min_horizon": None}))
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
        config = changed(run.config, {"horizon": length, "min_horizon": None})
        errors = evaluate(replace(run, config=config), num=NUM_TEST)
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
