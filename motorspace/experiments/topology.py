"""Presets, and what organises codes better: runs as data, and their rows beside references."""

from dataclasses import asdict, replace
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from motorspace._errors import UserError
from motorspace._types import Key, Record
from motorspace.analysis import circle
from motorspace.analysis.coordinates import displacement_coordinates
from motorspace.analysis.errors import prediction_errors
from motorspace.analysis.inputs import CollapsedCodesError
from motorspace.analysis.projections import pca
from motorspace.analysis.standard_form import standard_form
from motorspace.experiments import paper, references
from motorspace.experiments.measurement import TEST_SEED, draw_test, measure
from motorspace.experiments.organisation import (
    NUM_SEQUENCES,
    Codes,
    Encode,
    Motors,
    Sampled,
    collapse,
    encoder_of,
    measures,
    organisation,
    random_commands,
    sampled,
)
from motorspace.models.encoder import GroupEncoder
from motorspace.reports import figures
from motorspace.reports.page import Section, report_page
from motorspace.training.config import RunConfig, fresh_experience, simulation_scaling
from motorspace.training.fit import TrainState, fit, init
from motorspace.training.runs import Run
from motorspace.trajectories import derived
from motorspace.trajectories.commands import nominal
from motorspace.trajectories.transitions import Experience

Changes = dict[str, dict[str, Any]]

BEST: Changes = {
    "model": {"encoder": "group", "hidden_size": 64, "code_size": 6, "isometry_weight": 1.0},
    "training": {"learning_rate": 4e-3, "curriculum": 0.1, "code_noise": 0.3, "starts": 3},
}
"""What the preset `best` changes in the paper's system."""

PRESETS: dict[str, Changes] = {"best": BEST, "paper": {}}

ABLATION: dict[str, dict[str, Changes]] = {
    "paper": {
        "smaller step": {"training": {"learning_rate": 3e-3}},
        "shorter curriculum": {"training": {"curriculum": 0.1}},
        "noise on the code": {"training": {"code_noise": 0.3}},
        "mixed horizons": {"simulation": {"min_horizon": 1}},
        "smaller code": {"model": {"code_size": 10}},
        "inverse model": {"model": {"inverse_weight": 0.04}},
        "slowness": {"model": {"slowness_weight": 0.04}},
        "composition": {"model": {"composition_weight": 0.1}},
        "gru": {"model": {"encoder": "gru"}},
        "linear recurrence": {"model": {"encoder": "linear"}},
        "attention": {"model": {"encoder": "attention"}},
        "attention, step of 1e-3": {
            "model": {"encoder": "attention"},
            "training": {"learning_rate": 1e-3},
        },
    },
    "best": {
        "group, no noise": {"training": {"code_noise": 0.0}},
        "group, lengths free": {"model": {"isometry_weight": 0.0}},
        "group of 6 x 6": {"model": {"code_size": 30}},
    },
}
"""What may organise codes better: one change at a time to either preset."""

ABLATION_CELL = ("holonomic", 0.8)

FIXED = ("untrained", "raw motors", "motor components", "dead reckoned")
"""The reference rows that nothing is trained for."""

REFERENCE_ROTATION = 0.8
"""The largest rotation, in units of pi, for which the references are measured."""

SHUFFLED_AND_SUPERVISED: tuple[paper.Part, ...] = ("shuffled", "supervised")


def topology_jobs(budget: paper.Budget, *, seeds: int) -> list[paper.Job]:
    """The runs behind the table of organisation, one seed of every cell before the next seed."""
    return [job for seed in range(seeds) for job in _of_seed(budget, seed)]


def _of_seed(budget: paper.Budget, seed: int) -> list[paper.Job]:
    cells = {
        f"{agent}-{rotation}": paper.cell(agent, rotation, budget, seed)
        for rotation in paper.ROTATIONS
        for agent in paper.PAPER_ERRORS
    }
    jobs = []
    for name, changes in PRESETS.items():
        for cell, config in cells.items():
            changed = paper.changed(config, changes)
            jobs.append(paper.Job(f"topology/{cell} {name}", changed, measure=organised))
    for kind, config in paper.lattices(budget, seed).items():
        jobs.append(paper.Job(f"topology/lattice {kind}", config, measure=organised))
    # What the references show does not hang on r: one rotation does.
    for cell in (f"{agent}-{REFERENCE_ROTATION}" for agent in paper.PAPER_ERRORS):
        for row in FIXED:
            told = partial(organised_fixed, row=row)
            jobs.append(paper.Job(f"topology/{cell} {row}", cells[cell], "initial", told))
        for part in SHUFFLED_AND_SUPERVISED:
            name = f"topology/{cell} {part}"
            jobs.append(paper.Job(name, cells[cell], part, organised_encoder))
    return jobs


def ablation_jobs(budget: paper.Budget, *, seeds: int) -> list[paper.Job]:
    """The runs behind the table of what organises codes better."""
    jobs = []
    for seed in range(seeds):
        for preset, rows in ABLATION.items():
            base = paper.changed(paper.cell(*ABLATION_CELL, budget, seed), PRESETS[preset])
            jobs += [_compared(f"ablation/{name}", base, change) for name, change in rows.items()]
    return jobs


def _compared(name: str, base: RunConfig, changes: Changes) -> paper.Job:
    """A run with these changes, measured at the length of the one that it is compared with."""
    told = partial(organised_at, horizon=base.simulation.horizon)
    return paper.Job(name, paper.changed(base, changes), measure=told)


MIXED: Changes = {"simulation": {"min_horizon": 1, "horizon": 12}}
"""Trajectories of one to twelve commands, in place of six."""

MIXED_ROTATIONS = (0.2, 0.4)
"""Where `best`, trained on six commands, is least right about twenty-four."""


def mixed_jobs(budget: paper.Budget, *, seeds: int) -> list[paper.Job]:
    """The runs that show what `best` gains from trajectories of many lengths."""
    jobs = []
    for seed in range(seeds):
        for rotation in MIXED_ROTATIONS:
            base = paper.changed(paper.cell("forward", rotation, budget, seed), BEST)
            jobs.append(_compared(f"mixed/forward-{rotation}", base, MIXED))
    return jobs


CLOSING: dict[str, tuple[int, float]] = {
    "T = 1, r = 1.0 pi": (1, 1.0),
    "T = 1, r = 1.2 pi": (1, 1.2),
    "T = 2, r = 0.5 pi": (2, 0.5),
    "T = 2, r = 1.0 pi": (2, 1.0),
}
"""Forward agents that can all turn by any angle, with and without going round more than once.

In the first and the third a net turn beyond half a circle does not happen, so no two rotations
are equivalent. If equivalent rotations are what bends the space, it stays flat and open there.
"""


def closing_jobs(budget: paper.Budget, *, seeds: int) -> list[paper.Job]:
    """The runs that decide whether equivalent rotations close the space of codes."""
    jobs = []
    for seed in range(seeds):
        for name, (horizon, rotation) in CLOSING.items():
            config = paper.cell("forward", rotation, budget, seed)
            config = paper.changed(config, {"simulation": {"horizon": horizon}})
            jobs.append(paper.Job(f"closing/{name}", config, measure=closed))
    return jobs


def closed(run: Run, num: int) -> dict[str, Any]:
    """Prediction errors, and whether orientation closes in the codes."""
    simulation, seed = run.config.simulation, run.config.training.seed
    _, agent, _ = simulation.build()
    encode = encoder_of(run.encode)
    codes, displacements, _ = found = sampled(
        encode, agent, horizon=simulation.horizon, seed=seed, subsets=1
    )
    points, turns = displacement_coordinates(displacements).points, displacements[:, 2]
    return measure(run, num) | {
        "winding": found.topology.winding_number,
        "seam gap": circle.seam_gap(codes, points, turns),
        "loop": found.topology.loop_persistence,
        "probe_r2": found.topology.linear_r2,
        "nonlinear_r2": found.topology.nonlinear_r2,
    }


ANGLES = (0.8, 0.9, 1.0, 1.1, 1.25)
ANGLE_ROTATIONS = (0.2, 0.8)


def angle_jobs(budget: paper.Budget, *, seeds: int) -> list[paper.Job]:
    """The runs that show how much prediction minds codes whose angles are wrong by a factor.

    The predictor is told what displacements seem to be to a forward agent that takes its turns
    for more or less than they are.
    """
    return [
        paper.Job(
            f"angle/{rotation} x {angle}",
            paper.variant(paper.cell("forward", rotation, budget, seed), "oracle"),
            "oracle",
            partial(told_misjudged, angle=angle),
            partial(references.misjudged, angle=angle),
        )
        for seed in range(seeds)
        for rotation in ANGLE_ROTATIONS
        for angle in ANGLES
    ]


def told_misjudged(run: Run, num: int, *, angle: float) -> dict[str, Any]:
    """Prediction errors of a run that was told such displacements."""
    config = run.config
    _, agent, _ = config.simulation.build()

    def draw(key: Key, count: int) -> Experience:
        return derived.scaled_rotations(agent, draw_test(config, count, key=key), angle=angle)

    key = jax.random.key(TEST_SEED + config.training.seed)
    errors = prediction_errors(run.predict, draw, num=num, key=key)
    return _unpredicted(run) | {"errors": asdict(errors)}


FOLDING_CELL = ("forward", 0.8)
FOLDING_MEASURED = 20
"""How often in the course of training collapse is measured."""


def folding_jobs(budget: paper.Budget, *, seeds: int) -> list[paper.Job]:
    """The runs that show when in training whole turns fold."""
    return [
        paper.Job(
            f"folding/{name}",
            paper.changed(paper.cell(*FOLDING_CELL, budget, seed), changes),
            "initial",
            folded,
        )
        for seed in range(seeds)
        for name, changes in PRESETS.items()
    ]


def folded(run: Run, num: int) -> dict[str, Any]:
    """Collapse by whole turns as training goes on from the initial network `run`."""
    del num
    config = run.config
    training, horizon = config.training, config.simulation.horizon
    _, agent, _ = config.simulation.build()
    course: list[dict[str, Any]] = []
    step = max(1, training.epochs // FOLDING_MEASURED)

    def watch(state: TrainState, record: Record) -> None:
        if record["epoch"] % step == 0:
            encode = encoder_of(Run(config, state.model).encode)
            key = jax.random.key(training.seed)
            found = collapse(encode, agent, horizon=horizon, key=key)
            course.append({"epoch": record["epoch"]} | found["by full turns"])

    scaling = simulation_scaling(config)
    state = init(training, config.model, scaling, horizon=horizon)
    fit(training, config.model, state, fresh_experience(config), watch=watch)
    return _unpredicted(run) | {"course": course}


def organised(run: Run, num: int) -> dict[str, Any]:
    """Prediction errors over `num` trajectories, and how the codes are organised."""
    found = _organisation(run, encoder_of(run.encode)) | measure(run, num)
    if found["organisation"] and isinstance(run.model.encoder, GroupEncoder):
        simulation, seed = run.config.simulation, run.config.training.seed
        _, agent, _ = simulation.build()
        encode = standard_encoder_of(run)
        told = measures(encode, agent, horizon=simulation.horizon, seed=seed)
        found["organisation"]["standard form"] = told
    return found


def standard_encoder_of(run: Run) -> Encode:
    """The run's codes in standard form. Raises `UserError` if its encoder is not a group."""
    encoder, encode = run.model.encoder, encoder_of(run.encode)
    if not isinstance(encoder, GroupEncoder):
        raise UserError(
            f"codes of the encoder {run.config.model.encoder!r} have no standard form",
            remedy="leave it out, or train a run with the encoder 'group'",
        )
    _, agent, _ = run.config.simulation.build()
    key = jax.random.key(run.config.training.seed)
    commands = jnp.asarray(random_commands(agent, (NUM_SEQUENCES, 1), key=key))[:, 0]
    scaled = commands / jnp.array(run.model.scaling.motors)
    transitions, readouts = (
        np.asarray(matrices, np.float64) for matrices in jax.vmap(encoder.matrices)(scaled)
    )
    return lambda motors: standard_form(encode(motors), transitions, readouts)


def organised_at(run: Run, num: int, *, horizon: int) -> dict[str, Any]:
    """The same at one length, whatever lengths the run has learned from."""
    one_length = {"simulation": {"horizon": horizon, "min_horizon": None}}
    return organised(replace(run, config=paper.changed(run.config, one_length)), num)


def organised_encoder(run: Run, num: int) -> dict[str, Any]:
    """How the codes are organised of a run that has learned to predict something else."""
    del num
    return _organisation(run, encoder_of(run.encode))


def organised_fixed(run: Run, num: int, *, row: str) -> dict[str, Any]:
    """The same of codes that are not learned; `row` is one of `FIXED`."""
    del num
    _, agent, _ = run.config.simulation.build()

    def components(motors: Motors) -> Codes:
        return pca(motors.reshape(len(motors), -1), 8).coordinates

    encoders: dict[str, Encode] = {
        "untrained": encoder_of(run.encode),
        "raw motors": lambda motors: motors.reshape(len(motors), -1),
        "motor components": components,
        "dead reckoned": lambda motors: displacement_coordinates(nominal(agent, motors)).points,
    }
    return _organisation(run, encoders[row])


def _organisation(run: Run, encode: Encode) -> dict[str, Any]:
    simulation, seed = run.config.simulation, run.config.training.seed
    _, agent, _ = simulation.build()
    try:
        found = organisation(encode, agent, horizon=simulation.horizon, seed=seed)
    except CollapsedCodesError:
        # That a network has died is what its run has shown; the runs beside it go on.
        found = None
    return _unpredicted(run) | {"organisation": found}


def _unpredicted(run: Run) -> dict[str, Any]:
    """What every run's results tell, of one whose predictions are not measured."""
    training = run.config.training
    nothing = {"recipe": "", "errors": {}, "probe_r2": {}}
    return nothing | {"seed": training.seed, "epochs": training.epochs}


SHOWN = 5000
MEASURES_TEXT = (
    "Displacement is (longitudinal, lateral, w cos, w sin); the weight w gives orientation the "
    "variance of translation unless another was asked for. The error is the standard error that "
    "drawing random subsets of pairs brings."
)


def topology_of(run: Run, *, seed: int, standard: bool = False) -> Sampled:
    """The report on a run's codes of fresh random sequences, equivalent ones included.

    With `standard` of its codes in standard form.
    """
    simulation = run.config.simulation
    _, agent, _ = simulation.build()
    encode = standard_encoder_of(run) if standard else encoder_of(run.encode)
    found = sampled(encode, agent, horizon=simulation.horizon, seed=seed)
    if "equivalence_ratio" in found.topology:
        return found
    key = jax.random.key(seed)
    collapsed = collapse(encode, agent, horizon=simulation.horizon, key=key)
    added = {"equivalence_ratio": collapsed["ratio"], "equivalence_auc": collapsed["auc"]}
    return found._replace(topology=found.topology.updated(added))


def topology_page(found: Sampled, *, what: str = "codes") -> str:
    """The report as one self-contained page; `what` it is about."""
    rows = [
        {"measure": name, "value": value, "error": error, "perfect": perfect}
        for name, value, error, perfect in found.topology.rows()
    ]
    shown = slice(None, None, -(-len(found.codes) // SHOWN))
    coordinates, displacements = pca(found.codes).coordinates[shown], found.displacements[shown]
    picture = figures.png(figures.codes_figure([("", coordinates, displacements)]))
    return report_page(
        f"How {what} are organised by displacement",
        [
            Section("Measures", MEASURES_TEXT, rows),
            Section(
                "The codes",
                "Each point is one motor sequence, on the first three principal components.",
                pictures=[("codes coloured by displacement", picture)],
            ),
        ],
    )
