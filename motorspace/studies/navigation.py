"""What do learned codes add to reinforcement learning of navigation?"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from motorspace.analysis.measures import Measure, define
from motorspace.navigation.config import NavigationConfig
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import derived, system
from motorspace.studies.interquartile import interquartile
from motorspace.studies.observations import BESIDE, CODES, GOALS, OBSERVATIONS, STEPS, Observed
from motorspace.studies.rows import Numbers, Row, Settings, Spread, paired, under
from motorspace.studies.study import Budget, Line, Study, Table, Target
from motorspace.training.data import simulated
from motorspace.training.settings import changed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace.navigation.arenas import Codes
    from motorspace.training.run import Run

define(
    Measure("navigation.{kind}.success", "goals reached, {kind}", goal="high", perfect=1.0),
    Measure("navigation.{kind}.success.around", "behind walls, {kind}", goal="high", perfect=1.0),
    Measure("navigation.{kind}.spl", "SPL, {kind}", goal="high", perfect=1.0),
    Measure("navigation.{kind}.steps", "commands to the goal, {kind}", goal="low"),
    Measure("navigation.{kind}.decisions", "decisions to the goal, {kind}", goal="low"),
    Measure("navigation.{kind}.cells", "cells entered, {kind}", goal="high"),
    Measure("navigation.{kind}.num", "problems, {kind}"),
    Measure("navigation.lead.success", "goals that true displacement reaches beyond", goal="low"),
    Measure("navigation.share.steps", "commands, relative to true displacement", goal="low"),
)

POLICIES = 2
"""Policies that learn with each network: two networks of five make four runs of ten."""

CONTROL_UPDATES = 3000
"""Of the controller, or of what composes codes that are no products."""
LABELLED = {"learning_rate": 1e-3, "curriculum": 0.5}
"""How networks learn from displacements: as `best` does, most of them end in matrices that are no
motions."""
NUM_BESIDE = 512
"""Problems for chance and the planner: a planner that tries many commands takes its time."""


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """For each seed a network of the preset `best`, one that learned by labels, the paper's."""

    def job(codes: str, seed: int) -> Job:
        config = system("forward", 0.4, budget, seed, "paper" if codes == "paper" else "best")
        if codes == "supervised":
            config = changed(derived(config, "supervised"), LABELLED)
        measure = f"quick {codes}" if budget == "quick" else codes
        return Job("navigation", cell(agent="forward", codes=codes, rotation=0.4), config, measure)

    return [job(codes, seed) for codes in CODES for seed in range(seeds)]


def measured(run: "Run", num: int, *, codes: str, share: float = 1.0) -> Numbers:
    """Every row of a network: {POLICY/TASK/ROW/MEASURE: value}, after a share of the steps."""
    import jax

    from motorspace.navigation.learning import learn_with
    from motorspace.navigation.measuring import evaluate_others, evaluate_policy

    del num
    found, networks = dict[str, float](), _networks(run, codes)
    for number, seed in enumerate(policy_seeds(run)):
        for task, steps in STEPS.items():
            for row, observed in _rows(run, number, task, codes):
                config = configuration(run, task, observed, round(share * steps), seed)
                trained = learn_with(config, networks, run.config)
                numbers = evaluate_policy(trained, beside=False, seed=seed)
                found |= _placed(numbers, f"{number}/{task}", row)
            if codes == "learned":
                config = configuration(run, task, OBSERVATIONS["ranges"], steps, seed)
                numbers = evaluate_others(config, num=NUM_BESIDE, seed=seed)
                found |= _placed(numbers, f"{number}/{task}")
            # Every row compiles programs of its own: all of them together exceed the memory
            # mappings that a process may have.
            jax.clear_caches()
    return found


def _placed(numbers: Numbers, place: str, row: str = "") -> dict[str, float]:
    """{PLACE/ROW/MEASURE: value}; chance and the planner, measured in unseen layouts, are rows."""
    placed = dict[str, float]()
    for key, value in numbers.items():
        kind, _, measure = key.partition(".")
        name, split = (kind, "unseen") if kind in BESIDE else (row, kind)
        placed[f"{place}/{name}/navigation.{split}.{measure}"] = float(value)
    return placed


def policy_seeds(run: "Run") -> range:
    """The seeds of the policies that learn with a network."""
    first = POLICIES * run.config.training.seed
    return range(first, first + POLICIES)


def _rows(run: "Run", number: int, task: str, codes: str) -> list[tuple[str, Observed]]:
    """The rows that the policy of this number learns with a network."""

    def wanted(row: Observed) -> bool:
        if task not in row.tasks or row.codes != codes:
            return False
        if row.networks is None:
            return True
        return number == 0 and run.config.training.seed < row.networks

    return [(name, row) for name, row in OBSERVATIONS.items() if wanted(row)]


def _networks(run: "Run", codes: str) -> "Codes":
    """The network, and what its controller adds where a row needs it."""
    from motorspace.control.controller import learn_controller
    from motorspace.control.learning import ControlConfig
    from motorspace.navigation.arenas import codes_of
    from motorspace.navigation.composed import learn_composition

    config = ControlConfig(updates=CONTROL_UPDATES, restarts=1)
    match codes:
        case "learned":
            return codes_of(run, learn_controller(run, config))
        case "paper":
            return codes_of(run)._replace(composition=learn_composition(run, config))
    return codes_of(run)


def configuration(
    run: "Run", task: str, observed: Observed, steps: int, seed: int
) -> NavigationConfig:
    """A policy for the body of a run."""
    data: Any = simulated(run.config.data)
    config = NavigationConfig(task=task, agent=data.agent, sensor=data.sensor, seed=seed)
    return replace(config, steps=observed.times * steps, **observed.options)


def rows(found: Sequence[Row]) -> list[Row]:
    """A row for each task and observation, with the policies of all networks as its seeds."""
    made = []
    for task in STEPS:
        for name in (*OBSERVATIONS, *BESIDE):
            runs = {
                POLICIES * seed + number: numbers
                for row in found
                for seed, all_numbers in row.runs.items()
                for number in range(POLICIES)
                if (numbers := under(all_numbers, f"{number}/{task}/{name}/"))
            }
            if runs:
                cells = {"task": task, "observed": name}
                made.append(Row("navigation", cells, found[0].epochs, dict(sorted(runs.items()))))
    return [_against_truth(row, made) for row in made]


SUCCESS, COMMANDS = "navigation.unseen.success", "navigation.unseen.steps"


def _against_truth(row: Row, rows: Sequence[Row]) -> Row:
    """The row with what the true displacement does beyond it, seed by seed."""
    known = {"task": row.cell["task"], "observed": "true displacement"}
    true = next((other for other in rows if other.matches(known)), None)
    if true is None or not row.runs.keys() <= true.runs.keys():
        return row
    pairs = paired(row, true)
    if not all(key in numbers for key in (SUCCESS, COMMANDS) for pair in pairs for numbers in pair):
        return row
    lead = Spread(tuple(float(best[SUCCESS]) - float(own[SUCCESS]) for own, best in pairs))
    share = Spread(tuple(float(own[COMMANDS]) / float(best[COMMANDS]) for own, best in pairs))
    return row.with_measures({"navigation.lead.success": lead, "navigation.share.steps": share})


def lines(found: Sequence[Row], *, task: str, heads: Collection[str] = ()) -> list[Line]:
    """Interquartile means over policies with bootstrapped 95 % intervals.

    Args:
        found: Rows of all tasks.
        task: The task whose rows are shown.
        heads: The columns beside the names; by default all, and the number of policies.
    """
    return [
        {"observed": row.cell["observed"]}
        | {head: value for head, value in _line(row).items() if head in heads or not heads}
        for row in found
        if row.cell["task"] == task
    ]


def _line(row: Row) -> Line:
    return _means(row, HEADS) | {"policies": len(row.runs)}


def _means(row: Row, shown: Mapping[str, str]) -> dict[str, Any]:
    return {head: interquartile([row[key].values]) for head, key in shown.items() if key in row}


def aggregated(found: Sequence[Row]) -> list[Line]:
    """The rows that stand in both tasks with goals, over tasks and policies."""
    by_place = {(row.cell["task"], row.cell["observed"]): row for row in found}

    def line(name: str) -> Line | None:
        both = [by_place.get((task, name)) for task in GOALS]
        ours = [row for row in both if row is not None and SUCCESS in row]
        if len(ours) < len(GOALS):
            return None
        shown = {"goals reached, unseen": SUCCESS, "SPL": "navigation.unseen.spl"}
        return {"observed": name} | {
            head: interquartile([row[key].values for row in ours]) for head, key in shown.items()
        }

    return [made for name in (*OBSERVATIONS, *BESIDE) if (made := line(name))]


HEADS = {
    "goals reached, seen": "navigation.seen.success",
    "goals reached, unseen": SUCCESS,
    "behind walls": "navigation.unseen.success.around",
    "SPL": "navigation.unseen.spl",
    "commands": COMMANDS,
    "decisions": "navigation.unseen.decisions",
    "cells entered, seen": "navigation.seen.cells",
    "cells entered, unseen": "navigation.unseen.cells",
}

SHORT: Mapping[str, Collection[str]] = {
    "home": ("goals reached, seen", "goals reached, unseen", "SPL", "commands", "decisions"),
    "displacement_goal": ("goals reached, seen", "goals reached, unseen", "behind walls", "SPL"),
    "sensor_goal": ("goals reached, seen", "goals reached, unseen", "SPL"),
    "explore": ("cells entered, seen", "cells entered, unseen"),
}
"""The columns that a page shows of a task; the appendix shows all."""


def figure(found: Sequence[Row]) -> "Figure":
    """How many come home, how straight, and in how many commands, by what they observe."""
    from motorspace.reports.figures.measures import changes_figure

    keys = (SUCCESS, "navigation.unseen.spl", COMMANDS)
    made = [
        {"observed": row.cell["observed"]} | _means(row, {key: key for key in keys})
        for row in found
        if row.cell["task"] == "home"
    ]
    return changes_figure(made, "observed", keys)


HOME = {"task": "home", "observed": "chained code"}
REACH: Settings = {"task": "displacement_goal", "observed": ("chained code", "chained code + GRU")}

STUDY = Study(
    name="navigation",
    question="What do learned codes add to reinforcement learning of navigation?",
    jobs=jobs,
    measures={codes: partial(measured, codes=codes) for codes in CODES}
    | {f"quick {codes}": partial(measured, codes=codes, share=0.1) for codes in CODES},
    rows=rows,
    tables={f"navigation_{task}": Table(partial(lines, task=task)) for task in STEPS}
    | {
        f"navigation_{task}_short": Table(partial(lines, task=task, heads=heads))
        for task, heads in SHORT.items()
    }
    | {"navigation": Table(aggregated)},
    targets=(
        Target("home, seen layouts", "navigation.seen.success", at_least=0.97, cells=HOME),
        Target("home, unseen layouts", SUCCESS, at_least=0.97, cells=HOME),
        Target(
            "home, below true displacement", "navigation.lead.success", at_most=0.02, cells=HOME
        ),
        Target(
            "home, commands over those of the true displacement",
            "navigation.share.steps",
            at_most=1.1,
            cells=HOME,
        ),
        Target(
            "displacement goals behind walls, unseen layouts",
            "navigation.unseen.success.around",
            at_least=0.85,
            cells=REACH,
        ),
    ),
    figures={"navigation": figure},
)
