"""The first look: train a forward agent, measure it, write one page about it."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from motorspace._files import write_atomically
from motorspace._types import Watch
from motorspace.analysis.projections import pca
from motorspace.experiments import references
from motorspace.experiments.figures import codes_of, example_walks
from motorspace.experiments.measurement import measure
from motorspace.models.config import ModelConfig
from motorspace.reports.codes_view import codes_view
from motorspace.reports.figures.codes import codes_figure
from motorspace.reports.figures.measures import learning_figure
from motorspace.reports.figures.worlds import trajectories_figure, world_figure
from motorspace.reports.page import Section, picture, report_page
from motorspace.training.config import (
    RunConfig,
    SimulationConfig,
    TrainingConfig,
    fresh_experience,
    simulation_scaling,
)
from motorspace.training.runs import Run, train

EPOCHS = 200
ORACLE_EPOCHS = 200
NUM_TEST = 24_000


def demo(out: Path, *, seed: int = 0, watch: Watch = lambda record: None) -> Path:
    """Train, measure, and write `report.html` in `out`; returns the page's path.

    A demo that was stopped goes on where it was; a finished one is only measured again.
    """
    config = RunConfig(
        SimulationConfig(agent="forward", max_rotation=0.4),
        ModelConfig(),
        TrainingConfig(epochs=EPOCHS, seed=seed),
    )
    source, scaling = fresh_experience(config), simulation_scaling(config)
    run = train(config, source, scaling, out / "run", resume=True, watch=watch)

    model, training = (
        replace(config.model, encoder="identity"),
        replace(config.training, epochs=ORACLE_EPOCHS, curriculum=0.0),
    )
    told = replace(config, model=model, training=training)
    oracle = train(told, *references.oracle(told))

    measured = measure(run, num=NUM_TEST)
    best = measure(oracle, num=NUM_TEST)["errors"]["model"]
    page = out / "report.html"
    html = report_page(
        "A forward agent learns displacements",
        [*_result_sections(run, measured, best), _world_section(config)],
        lead="It turns and moves ahead, senses nine distances, and learns to predict them. Nobody"
        " tells it where it is: the codes of its motor sequences take the structure of space.",
    )
    write_atomically(page, html.encode())
    return page


def _world_section(config: RunConfig) -> Section:
    world, fan, starts, paths = example_walks(config.simulation)
    return Section(
        "The world",
        "40 by 40 units of rooms, corridors and obstacles. The agent senses nine distances over"
        " half a circle, up to ten units away. At every step it turns by a random angle and moves"
        " ahead by up to one unit. The network sees what is sensed before and after six commands,"
        " and the commands: no position and no displacement.",
        pictures=[
            picture("Two agents and their rays", lambda: world_figure(world, starts[:2], fan)),
            picture(
                "Eight trajectories of twelve steps", lambda: trajectories_figure(world, paths)
            ),
        ],
    )


def _result_sections(run: Run, measured: dict[str, Any], oracle: float) -> list[Section]:
    errors = measured["errors"]
    rows = [
        {"prediction by": "this network", "mean squared error": errors["model"]},
        {
            "prediction by": "the same predictor, given the true displacement",
            "mean squared error": oracle,
        },
        {"prediction by": "the sensors' mean", "mean squared error": errors["mean"]},
        {
            "prediction by": "no change (persistence)",
            "mean squared error": errors["persistence"],
        },
    ]
    scale = run.model.scaling.sensors[0] ** 2
    curve = np.array([record["prediction_loss"] * scale for record in run.log])
    levels = {"persistence": errors["persistence"], "oracle": oracle}
    learning = picture("Error over epochs", lambda: learning_figure({"training": curve}, levels))

    codes, displacements = codes_of(run)
    projection = pca(codes)
    shown = [("", projection.coordinates, displacements)]
    share = projection.explained_variance_ratio.sum()
    r2 = measured["probe_r2"]
    facts = [
        ("prediction error", errors["model"]),
        ("of the same predictor, given the true displacement", oracle),
        ("R² of a linear probe, worst component", min(r2.values())),
    ]
    return [
        Section(
            "The codes of motor sequences",
            "Each point is one motor sequence, on the first three principal components of its "
            f"code ({share:.0%} of the variance), coloured by the displacement that it caused. "
            "Drag to turn.",
            facts=facts,
            views=[codes_view(projection.coordinates, displacements, "forward, r = 0.4 π")],
            pictures=[picture("Codes by displacement", lambda: codes_figure(shown))],
        ),
        Section(
            "Learning",
            "In the first third the sequences grow from one command to six, so the error rises "
            "in steps while the task becomes harder.",
            pictures=[learning],
        ),
        Section(
            "Error on fresh trajectories",
            f"{errors['num_trajectories']:,} trajectories that training never saw, squared world "
            "units per sensor.",
            rows=rows,
        ),
        Section(
            "What a linear probe decodes from the code",
            "Share of the variance of each component of the displacement, held out.",
            rows=[{"component": k, "R²": v} for k, v in r2.items()],
        ),
    ]
