"""The page of `motorspace demo`: what an agent learned, from the numbers of its runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from motorspace._types import Pose
from motorspace.analysis.measures import measure
from motorspace.reports.codes_view import View, codes_view
from motorspace.reports.figures.measures import learning_figure
from motorspace.reports.figures.worlds import trajectories_figure, world_figure
from motorspace.reports.page import Section, picture, report_page
from motorspace.reports.tables import Row
from motorspace.worlds.scenario import Scenario

STRUCTURE = (
    "linear_r2.worst",
    "orientation_error",
    "rank_correlation",
    "trustworthiness.20",
    "equivalence_ratio",
    "intrinsic_dimension",
)
"""The measures of the small table, where they could be taken: the last needs an extra."""

NEXT = """Measure these codes in every way: `motorspace topology {best}`

Train for longer: `motorspace train forward --max-rotation 0.4 --preset best --epochs 1000`

Try another body, sensor and world: `motorspace train holonomic --num-rays 15 --layout four_rooms`

Learn from a robot's log: `motorspace train --data LOG`

Do it in Python: `examples/first_steps.py`; with an agent, a sensor, an encoder or a log of your
own: `examples/own_classes.py`

Repeat the paper's table: `motorspace reproduce table1`"""


@dataclass(frozen=True)
class Network:
    """What the page shows of a trained network."""

    metrics: Mapping[str, float]
    """What it was measured at, by the keys of measures."""
    curve: Float[np.ndarray, " E"]
    """Its mean squared error after each epoch, sensor units squared."""
    coordinates: Float[np.ndarray, "N P"]
    """Codes of random motor sequences on their principal components."""
    explained: Float[np.ndarray, " P"]
    """Which share of their variance each component has."""
    displacements: Float[np.ndarray, "N 3"]
    """What each sequence does where no wall is: longitudinal, lateral, orientation change."""


def demo_page(
    scenario: Scenario,
    walks: Sequence[Pose],
    networks: Mapping[str, Network],
    oracle: Mapping[str, float],
    *,
    best: str,
) -> str:
    """Returns the page as HTML.

    Args:
        scenario: The world, the agent and its sensor.
        walks: Example trajectories: one batch of poses each, in order of time.
        networks: `"paper"` and `"best"`.
        oracle: What the predictor was measured at that is given the true displacement.
        best: The folder of the network `best`, as a person types it.
    """
    epochs = len(networks["paper"].curve)
    return report_page(
        "An agent learns the space it moves in",
        [
            _world(scenario, walks),
            _learning(networks, oracle, epochs),
            _errors(networks, oracle),
            _codes(networks),
            _structure(networks),
            Section("Where to go next", NEXT.format(best=best)),
        ],
        lead="It turns, moves ahead, and measures distances to walls. A network learns to predict"
        " these distances from its motor commands. Nothing tells it where it is, and yet the codes"
        " of its commands come to have the structure of space.",
    )


def _world(scenario: Scenario, walks: Sequence[Pose]) -> Section:
    starts = [_at(walk, 0) for walk in walks[:2]]
    return Section(
        "The world, and an agent in it",
        "Rooms, corridors and obstacles on 40 by 40 units. The agent measures nine distances over"
        " half a circle, up to ten units away. At each step it turns by a random angle of up to"
        " 0.4 π and moves ahead by up to one unit. The network is given what is sensed before and"
        " after six such commands, and the commands: no position, and no displacement.",
        pictures=[
            picture(
                "Two agents, where they look, and what they sense",
                lambda: world_figure(scenario.world, starts, scenario.sensor),
            ),
            picture(
                f"{len(walks)} trajectories of {len(walks[0].x) - 1} commands",
                lambda: trajectories_figure(scenario.world, walks),
            ),
        ],
    )


def _learning(networks: Mapping[str, Network], oracle: Mapping[str, float], epochs: int) -> Section:
    levels = {
        "no change": networks["paper"].metrics["prediction.persistence"],
        "oracle": oracle["prediction.error"],
    }
    curves = {name: network.curve for name, network in networks.items()}
    return Section(
        "Learning",
        "Two networks learn the same task. `paper` is the published one: an LSTM encodes the"
        " commands. `best` turns each command into a matrix and multiplies them. At first"
        " sequences are short; as they grow to six commands, the task becomes harder and the error"
        " rises in steps.\n\n"
        f"This is a first look, of a minute or two: {epochs} epochs, where the paper has 5,000.",
        pictures=[picture("Prediction error over epochs", lambda: learning_figure(curves, levels))],
    )


def _errors(networks: Mapping[str, Network], oracle: Mapping[str, float]) -> Section:
    metrics = networks["paper"].metrics
    errors = {
        "network `paper`": metrics["prediction.error"],
        "network `best`": networks["best"].metrics["prediction.error"],
        "oracle": oracle["prediction.error"],
        "mean of the sensors": metrics["prediction.mean"],
        "no change": metrics["prediction.persistence"],
    }
    return Section(
        "How well it predicts",
        f"On {int(metrics['prediction.num']):,} trajectories that training never saw. The oracle is"
        " the same predictor, given the true displacement instead of a code: what it still gets"
        " wrong lies behind corners. Mean squared errors, and their share of that of no change.",
        rows=[
            {"predictor": name, "error": value, "relative": f"{share:.0%}"}
            for name, value in errors.items()
            for share in [value / metrics["prediction.persistence"]]
        ],
    )


def _codes(networks: Mapping[str, Network]) -> Section:
    return Section(
        "What the codes look like",
        "Each point is the code of one random sequence of six commands, on the first three"
        " principal components of all codes. Its colour is the displacement that the sequence"
        " causes, which no network was given. Neighbours have similar colours: nearby codes stand"
        " for nearby displacements. Drag to turn, choose a component to colour by.",
        views=[_view(name, network) for name, network in networks.items()],
    )


def _view(name: str, network: Network) -> View:
    share = network.explained.sum()
    title = f"{name}: {share:.0%} of the variance of the codes"
    return codes_view(network.coordinates, network.displacements, title)


def _structure(networks: Mapping[str, Network]) -> Section:
    rows: list[Row] = [
        {"measure": measure(key).title}
        | {name: network.metrics[key] for name, network in networks.items()}
        | {"perfect": measure(key).perfect, "what it is": measure(key).meaning}
        for key in STRUCTURE
        if all(key in network.metrics for network in networks.values())
    ]
    return Section(
        "How the codes are structured",
        "Perfect codes are a copy of displacements: of three dimensions, equal where displacements"
        " are equal, with distances in proportion. The networks differ most in the equivalence"
        " ratio: whether sequences that end alike share a code, even if one of them has turned"
        " once more around.",
        rows=rows,
    )


def _at(walk: Pose, step: int) -> Pose:
    return Pose(*(field[step] for field in (walk.x, walk.y, walk.heading, walk.head)))
