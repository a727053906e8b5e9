"""The runs of the study of vision: what learns from colours, and what stands beside it."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from motorspace.running.jobs import Job, Value, cell
from motorspace.studies.cells import derived, oracle, system, untrained
from motorspace.studies.study import Budget
from motorspace.training.config import RunConfig
from motorspace.training.presets import PresetName
from motorspace.training.settings import changed
from motorspace.worlds.paint import parse_paint


class Place(NamedTuple):
    """Who learns, and what is to be seen."""

    agent: str
    rotation: float
    """The largest, in units of pi."""
    paint: str

    def seen(self, budget: Budget, seed: int, preset: PresetName = "vision") -> RunConfig:
        """A run with a retina in a painted room, whose colours are of this seed."""
        config = system(self.agent, self.rotation, budget, seed, preset)
        painted = replace(parse_paint(self.paint), seed=seed).name
        return changed(config, {"sensor": "retina", "paint": painted})

    def job(self, variant: str, config: RunConfig, measure: str = "codes", **further: Value) -> Job:
        """One run of the study, in a cell of this place."""
        named = cell(**self._asdict(), variant=variant, **further)
        return Job("vision", named, config, measure, trains=measure != "images")


PAPER, SCALED = "paper's network", "oracle, scaled angles"
"""Variants that tables name."""

ROTATION = 0.4
FLAT, FINE = Place("forward", ROTATION, "flat"), Place("forward", ROTATION, "texture:4")
SMALL = Place("forward", 0.2, "flat")
MAIN = (
    SMALL,
    FLAT,
    Place("forward", 0.8, "flat"),
    Place("holonomic", ROTATION, "flat"),
    Place("holonomic", 0.8, "flat"),
    Place("forward", ROTATION, "texture:12"),
    FINE,
    Place("forward", 0.8, "texture:4"),
    Place("holonomic", ROTATION, "texture:4"),
    Place("forward", ROTATION, "texture:1"),
)
"""What stands beside baselines."""

CURVE = (
    *(("texture:4", pixels) for pixels in (9, 16, 128)),
    ("texture:2", 32),
    *(("texture:1", pixels) for pixels in (64, 128)),
)
"""Further points of the curve over wavelengths and pixels."""

HALF = "texture:1:0.5"
"""A texture that leaves half of the colour to the wall, which can be told from far off."""

FEATURES = {"blur_weight": 0.0, "latent_weight": 1.0}
LOSSES = {"pixels alone": {"blur_weight": 0.0}, "features": FEATURES}
"""What is predicted, if it is not pixels and blurred pixels together."""

SEQUENCES = {
    "one command": {"horizon": 1, "curriculum": 0.0},
    "six commands": {"curriculum": 0.0},
    "six commands, small steps": {"curriculum": 0.0, "learning_rate": 1e-3},
}
"""What is learned from, if it is not ever longer sequences."""

ANGLES = (0.8, 1.0, 1.25)
"""What an oracle's rotations are multiplied by where codes turn too far."""

WITHOUT_CODES = {"encoder": "identity", "code_noise": 0.0, "isometry_weight": 0.0}


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Seed after seed: what learns from colours first, then what stands beside it."""
    return [
        job
        for seed in range(seeds)
        for some in (_learned, _curve, _varied, _used, _scaled, _beside)
        for job in some(budget, seed)
    ]


def _learned(budget: Budget, seed: int) -> Iterator[Job]:
    for place in MAIN:
        yield place.job("vision", place.seen(budget, seed))
    yield FLAT.job(PAPER, FLAT.seen(budget, seed, "vision_paper"))


def _curve(budget: Budget, seed: int) -> Iterator[Job]:
    for paint, num_rays in CURVE:
        place = Place("forward", ROTATION, paint)
        config = changed(place.seen(budget, seed), {"num_rays": num_rays})
        yield place.job("pixels", config, pixels=num_rays)
    half = Place("forward", ROTATION, HALF)
    yield half.job("vision", half.seen(budget, seed))


def _varied(budget: Budget, seed: int) -> Iterator[Job]:
    """Other light, other losses, other sequences, and a camera instead of the retina."""
    flat, fine = FLAT.seen(budget, seed), FINE.seen(budget, seed)
    for light in ("trajectory", "view"):
        yield FLAT.job("light", changed(flat, {"light": light}), light=light)
    for name, settings in LOSSES.items():
        yield FLAT.job(name, changed(flat, settings))
        yield FINE.job(name, changed(fine, settings))
    for name, settings in SEQUENCES.items():
        yield FINE.job(name, changed(fine, settings))
    walking = system("forward", ROTATION, budget, seed, "vision")
    yield Place("forward", ROTATION, "MiniWorld").job("images", walking, "images")


def _used(budget: Budget, seed: int) -> Iterator[Job]:
    flat = FLAT.seen(budget, seed)
    yield FLAT.job("use", flat, "use", used="colours")
    yield FLAT.job("use", changed(flat, FEATURES), "use", used="features of colours")
    distances = system("forward", ROTATION, budget, seed, "best")
    yield FLAT.job("use", distances, "use", used="distances")


def _scaled(budget: Budget, seed: int) -> Iterator[Job]:
    for angle in ANGLES:
        config = derived(SMALL.seen(budget, seed), "scaled_rotations", angle=angle)
        yield SMALL.job(SCALED, changed(config, WITHOUT_CODES), "scaled angles", angle=angle)


def _beside(budget: Budget, seed: int) -> Iterator[Job]:
    for place in MAIN:
        config = place.seen(budget, seed)
        curriculum = {"curriculum": config.training.curriculum}
        informed = changed(oracle(config), WITHOUT_CODES | curriculum)
        nothing = changed(config, WITHOUT_CODES | {"encoder": "none"})
        yield place.job("oracle", informed, "errors")
        yield place.job("no motors", nothing, "errors")
        yield place.job("untrained", changed(untrained(config), curriculum))
