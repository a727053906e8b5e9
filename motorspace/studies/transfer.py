"""Does a policy that acts in codes serve another body, other layouts, another sensor?

The policy observes nothing but the chained code of its goal and bumps, and its actions are codes.
A new body learns an encoder with the predictor as it is, so that its codes mean the same; a new
sensor learns a predictor with the encoder as it is.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from motorspace._kinds import Part
from motorspace.analysis.measures import Measure, define
from motorspace.navigation.config import NavigationConfig
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import system
from motorspace.studies.navigation import CONTROL_UPDATES
from motorspace.studies.observations import IN_CODES
from motorspace.studies.rows import Numbers, Row, chosen, under
from motorspace.studies.study import Budget, Study, Table, Target
from motorspace.studies.tables import columns
from motorspace.training.config import RunConfig
from motorspace.training.data import Simulated, simulated
from motorspace.training.settings import changed
from motorspace.worlds.catalog import AGENTS, SENSORS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace.control.controller import Controller
    from motorspace.navigation.learning import TrainedPolicy
    from motorspace.training.run import Run
    from motorspace.worlds.agents import AbstractAgent

define(
    Measure("transfer.success", "goals reached, transferred", goal="high", perfect=1.0),
    Measure("transfer.diagonal", "trained there", goal="high", perfect=1.0),
    Measure("transfer.spl", "SPL, transferred", goal="high", perfect=1.0),
    Measure("transfer.diagonal_spl", "SPL, trained there", goal="high", perfect=1.0),
    Measure("transfer.chance", "chance"),
    Measure(
        "transfer.reach", "displacements, by the other body's labels", goal="high", perfect=1.0
    ),
    Measure("transfer.share", "share of that", goal="high"),
    Measure("transfer.loss", "prediction loss of the adapter", goal="low"),
)

STEPS, NUM_GOALS = 300_000, 1000
ADAPTER = {"epochs": 400, "restarts": 1}
"""How adapters learn, of five times as many epochs in the paper's budget."""

BODIES = ("forward", "holonomic")
FANS: Mapping[str, Part] = {
    "9 rays, 180 degrees": Part("range_fan"),
    "7 rays, 270 degrees": SENSORS.part(
        "range_fan", {"num_rays": 7, "field_of_view": 1.5 * math.pi}
    ),
}
LAYOUTS = {"training rooms": "train", "unseen rooms": "test", "paper": "paper"}

NINE, SEVEN = FANS
ALIGNED, OWN, UNTRAINED = "aligned", "with a predictor of its own", "untrained"


@dataclass(frozen=True)
class Place:
    """A body with a sensor, and how its codes came about."""

    body: str
    fan: str
    codes: str = ALIGNED

    @property
    def name(self) -> str:
        """The beginning of the keys of its measures."""
        return f"{self.body}/{self.fan}/{self.codes}"


PLACES = (
    *(Place(body, fan) for body in BODIES for fan in FANS),
    Place("holonomic", NINE, OWN),
    Place("holonomic", NINE, UNTRAINED),
)
"""The first is where the policy learns; of the last two nothing makes the codes mean the same."""


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """A network of the preset `best` for each seed."""
    measure = "quick" if budget == "quick" else "full"
    return [
        Job(
            "transfer",
            cell(agent="forward", rotation=0.4),
            system("forward", 0.4, budget, seed, "best"),
            measure,
        )
        for seed in range(seeds)
    ]


def measured(run: "Run", num: int, *, share: float = 1.0) -> Numbers:
    """Every cell: {BODY/FAN/CODES/LAYOUT/MEASURE: value}, after a share of all learning."""
    import jax

    from motorspace.control.controller import learn_controller
    from motorspace.control.learning import ControlConfig
    from motorspace.navigation.measuring import evaluate_in

    del num
    seed, found = run.config.training.seed, dict[str, float]()
    control = ControlConfig(updates=round(share * CONTROL_UPDATES), restarts=1)
    policy, home = None, None
    for place, there in _runs(run, share).items():
        controller = learn_controller(there, control)
        home = controller if home is None else home
        reach = _reached(controller, _agent(there), home, seed)
        for layout, split in LAYOUTS.items():
            config = configuration(place, seed, round(share * STEPS))
            own = _learned(config, there, controller, split)
            policy = own if policy is None else policy
            acting = _moved(policy, config, there, controller, home)
            moved, trained = (evaluate_in(who, config, split, seed=seed) for who in (acting, own))
            scores = {
                "success": moved["success"],
                "diagonal": trained["success"],
                "spl": moved["spl"],
                "diagonal_spl": trained["spl"],
                "reach": reach,
                "chance": evaluate_in(None, config, split, seed=seed)["success"],
                "loss": float(there.log[-1]["prediction_loss"]) if there.log else math.nan,
            }
            found |= {f"{place.name}/{layout}/transfer.{key}": v for key, v in scores.items()}
            jax.clear_caches()  # as in the study of navigation
    return found


def _runs(run: "Run", share: float) -> "dict[Place, Run]":
    """The network of each place."""
    from motorspace.training.adapt import adapt
    from motorspace.training.run import initial_run, train

    config = changed(run.config, ADAPTER | {"epochs": max(1, round(share * ADAPTER["epochs"]))})
    training = config.training

    def data(body: str, fan: str) -> Simulated:
        base: Any = run.config.data
        part = AGENTS.part(body, {"max_rotation": dict(base.agent.options)["max_rotation"]})
        return Simulated(part, FANS[fan])

    seven = adapt(run, data("forward", SEVEN), learn="predictor", training=training)
    judge = {NINE: run, SEVEN: seven}
    found = {PLACES[0]: run}
    for place in PLACES[1:4]:
        there = data(place.body, place.fan)
        found[place] = adapt(judge[place.fan], there, learn="encoder", training=training)
    alone = RunConfig(data("holonomic", NINE), run.config.model, training)
    return found | {PLACES[4]: train(alone), PLACES[5]: initial_run(alone)}


def configuration(place: Place, seed: int, steps: int) -> NavigationConfig:
    """A policy that finds home by codes and bumps, and acts in codes."""
    part = AGENTS.part(place.body, {"max_rotation": 0.4 * math.pi})
    return NavigationConfig(
        agent=part,
        sensor=FANS[place.fan],
        observe=("bump", "code"),
        act="codes",
        ppo=IN_CODES,
        steps=steps,
        seed=seed,
    )


def _learned(config: NavigationConfig, there: "Run", body: "Controller", split: str) -> Any:
    """A policy that learns in a place."""
    from motorspace.navigation.arenas import codes_of
    from motorspace.navigation.learning import learn_with

    return learn_with(config, codes_of(there, body), there.config, split=split)


def _agent(run: "Run") -> "AbstractAgent":
    return simulated(run.config.data).scenario().agent


def _reached(body: "Controller", agent: "AbstractAgent", home: "Controller", seed: int) -> float:
    """The share of displacements that a body reaches by the codes that they have at home.

    It decodes them at once; no labels of its own are used.
    """
    import jax

    from motorspace.control.trials import displacement_goals, displacement_trials

    goal_key, key = jax.random.split(jax.random.fold_in(jax.random.key(seed), 11))
    goals = displacement_goals(agent, NUM_GOALS, body.horizon, key=goal_key)
    labelled = replace(body, probe=home.probe)
    return displacement_trials(labelled, agent, goals, "amortised", key=key).success()


def _moved(
    policy: "TrainedPolicy",
    config: NavigationConfig,
    there: "Run",
    body: "Controller",
    home: "Controller",
) -> "TrainedPolicy":
    """The policy in another place: the networks are of there, its actions are those of home."""
    from motorspace.navigation.arenas import codes_of
    from motorspace.navigation.coded import code_commands

    codes = codes_of(there)._replace(code_commands=code_commands(body, home.whitening))
    return replace(policy, config=config, codes=codes)


def rows(found: Sequence[Row]) -> list[Row]:
    """A row for each body, sensor, layout, and origin of the codes."""
    return [
        replace(
            row,
            cell={
                "body": place.body,
                "sensor": place.fan,
                "layout": layout,
                "codes": place.codes,
            },
            runs={
                seed: _of(numbers, f"{place.name}/{layout}/") for seed, numbers in row.runs.items()
            },
        )
        for row in found
        for place in PLACES
        for layout in LAYOUTS
    ]


def _of(numbers: Numbers, place: str) -> Numbers:
    own = under(numbers, place)
    if "transfer.success" in own and own.get("transfer.diagonal", 0) > 0:
        own["transfer.share"] = own["transfer.success"] / own["transfer.diagonal"]
    return own


def unseen(*keys: str) -> Table:
    """These measures in unseen rooms; some have no layout."""
    made = columns("body", "sensor", "codes", *keys)
    return Table(lambda found: made(chosen(found, layout="unseen rooms")))


def figure(found: Sequence[Row]) -> "Figure":
    """Goals reached by the policy that was moved, and by one that was trained there."""
    from motorspace.reports.figures.measures import changes_figure

    keys = ("transfer.success", "transfer.diagonal", "transfer.chance")
    made = [{"place": row.name} | row.line(*keys) for row in found]
    return changes_figure(made, "place", keys)


STUDY = Study(
    name="transfer",
    question="Does a policy in codes serve another body, other layouts, another sensor?",
    jobs=jobs,
    measures={"full": measured, "quick": partial(measured, share=0.1)},
    rows=rows,
    tables={
        "transfer_unseen": unseen("transfer.success", "transfer.diagonal", "transfer.chance"),
        "transfer_reach": unseen("transfer.reach"),
        "transfer": Table(
            columns(
                *("body", "sensor", "layout", "codes"),
                "transfer.success",
                "transfer.diagonal",
                "transfer.share",
                "transfer.chance",
                "transfer.spl",
                "transfer.diagonal_spl",
                "transfer.reach",
                "seeds",
            )
        ),
    },
    targets=(
        Target(
            "goals reached, relative to a policy trained there",
            "transfer.share",
            at_least=0.9,
            cells={"codes": ALIGNED},
        ),
    ),
    figures={"transfer": figure},
)
