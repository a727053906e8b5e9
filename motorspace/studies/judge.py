"""How near to the floor does a judge come that knows the place, and does it lead to readings?"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from motorspace.analysis.measures import Measure, define
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import CONTINUOUS, ROTATIONS, oracle, system
from motorspace.studies.rows import Numbers, Row, Spread, chosen
from motorspace.studies.study import Budget, Line, Study, Table, Target
from motorspace.studies.tables import columns
from motorspace.training.config import RunConfig
from motorspace.training.settings import changed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace.training.run import Run

SQUARED = "sensor units²"
SEVERAL = (("forward", 0.4), ("holonomic", 0.4))
"""Cells that are measured with every seed, and act; the others with one."""
COMPARED = SEVERAL[0]
"""The cell in which errors are compared over what they cost."""
LARGER = {"depth": 4, "width_size": 512}
MEMBERS = 3
"""Networks of an ensemble."""
TESTED_SHARE = 3 / 2_000
"""Test transitions, of those that networks are tested on: each is located on its own."""
GOALS_SHARE, FAR_SHARE = 1 / 2_000, 1 / 4_000
"""Goals one sequence away, and far ones."""
ERROR, SHOWN, SECONDS = "judge.error", "prediction.error", "seconds of one core"
define(
    Measure(ERROR, "judge", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.error.{steps}", "{steps} steps", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.motors", "judge, from commands", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.network", "network", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.network_seconds", "training", goal="low", unit="s"),
    Measure("judge.persistence", "no change", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.floor", "floor", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.unseen", "judge, unseen layout", goal="low", perfect=0.0, unit=SQUARED),
    Measure("judge.unseen_network", "network, unseen layout", goal="low", unit=SQUARED),
    Measure("judge.standard_error", "standard error", unit=SQUARED),
    Measure("judge.calibration_seconds", "calibration", goal="low", unit="s"),
    Measure("judge.seconds.{steps}", "{steps} steps", goal="low", unit="s"),
    Measure("judge.num", "test transitions"),
    Measure("judge.to_floor", "judge / floor", goal="low", perfect=1.0),
    Measure("judge.motors_to_floor", "from commands / floor", goal="low", perfect=1.0),
    Measure("judge.seen.{kind}", "{kind}", goal="high", perfect=1.0, chance=0.0),
    Measure(
        "judge.elsewhere.{kind}", "unseen layout, {kind}", goal="high", perfect=1.0, chance=0.0
    ),
    Measure(
        "judge.far.{kind}", "five sequences away, {kind}", goal="high", perfect=1.0, chance=0.0
    ),
    Measure("judge.seen_to_simulated", "guided / simulated", goal="high", perfect=1.0),
    Measure("judge.elsewhere_to_simulated", "unseen, guided / simulated", goal="high", perfect=1.0),
)


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Every system of the paper's table I with one seed, two of them with all; other predictors."""
    every = [
        Job(
            "judge",
            cell(agent=agent, rotation=rotation),
            system(agent, rotation, budget, seed, "best"),
            "acting" if (agent, rotation) in SEVERAL else "judge",
        )
        for seed in range(seeds)
        for agent in CONTINUOUS
        for rotation in ROTATIONS
        if seed == 0 or (agent, rotation) in SEVERAL
    ]
    return [*every, *(_of_network(budget, name) for name in NETWORKS if seeds)]


NETWORKS = ("larger", "ensemble", "oracle")
"""Predictors that do not know the place either, of one cell and one seed."""


def _of_network(budget: Budget, name: str) -> Job:
    agent, rotation = COMPARED
    usual = system(agent, rotation, budget, 0, "best")
    configs: dict[str, RunConfig] = {
        "larger": changed(usual, LARGER),
        "ensemble": usual,
        "oracle": oracle(system(agent, rotation, budget, 0)),
    }
    measure = "ensemble" if name == "ensemble" else "network"
    place = cell(agent=agent, rotation=rotation, network=name)
    return Job("judge", place, configs[name], measure)


def measured(run: "Run", num: int) -> Numbers:
    """The judge's errors after longer and longer walks, and elsewhere."""
    from motorspace.judge.scores import explore, measure_judge

    return measure_judge(run, explore(run), num=_share(TESTED_SHARE, num))


def acted(run: "Run", num: int) -> Numbers:
    """The same, and which goals of readings are reached that the judge plans for."""
    from motorspace.control.controller import learn_controller
    from motorspace.control.guided_trials import measure_guide
    from motorspace.judge.scores import explore, measure_judge

    explored = explore(run)
    goals, far = _share(GOALS_SHARE, num), _share(FAR_SHARE, num)
    reached = measure_guide(run, learn_controller(run), explored, num=goals, num_far=far)
    return measure_judge(run, explored, num=_share(TESTED_SHARE, num)) | reached


def of_network(run: "Run", num: int) -> Numbers:
    """The error of the run's predictor, and what its training costs."""
    from motorspace.judge.scores import measure_networks

    return measure_networks(run, num=_share(TESTED_SHARE, num))


def of_ensemble(run: "Run", num: int) -> Numbers:
    """The error of the mean of several predictors; the others are trained here."""
    from motorspace.judge.scores import measure_networks

    return measure_networks(run, num=_share(TESTED_SHARE, num), members=MEMBERS)


def _share(share: float, num: int) -> int:
    return max(1, round(share * num))


def related(found: Sequence[Row]) -> list[Row]:
    """The rows with their errors over the floor, and success over that of true search."""
    return [_related(row) for row in found]


def _related(row: Row) -> Row:
    def ratio(above: str, below: str) -> Spread | None:
        if above not in row or below not in row or not min(row[below].values) > 0:
            return None
        pairs = zip(row[above].values, row[below].values, strict=True)
        return Spread(tuple(one / other for one, other in pairs))

    return row.with_measures(
        {
            "judge.to_floor": ratio(ERROR, "judge.floor"),
            "judge.motors_to_floor": ratio("judge.motors", "judge.floor"),
            "judge.seen_to_simulated": ratio("judge.seen.guided", "judge.seen.simulated"),
            "judge.elsewhere_to_simulated": ratio(
                "judge.elsewhere.guided", "judge.elsewhere.simulated"
            ),
        }
    )


def _judged(*keys: str) -> Table:
    """A table of the cells that have all of these measures."""
    made = columns("agent", "rotation", *keys)
    return Table(lambda rows: made([row for row in rows if all(key in row for key in keys)]))


def over_compute(found: Sequence[Row]) -> list[Line]:
    """Errors of one cell and seed, and what each predictor costs beyond its data."""
    agent, rotation = COMPARED
    same = chosen(found, agent=agent, rotation=rotation)
    lines: list[Line] = []
    for row in same:
        first = row.runs.get(0, {})
        if "judge.network" in first:
            name = f"network, {row.cell['network']}" if "network" in row.cell else "network"
            lines.append(_line(name, first["judge.network"], first["judge.network_seconds"]))
        for key in STEPS:
            if key in first:
                steps = key.rpartition(".")[2]
                walked = first[f"judge.seconds.{steps}"] + first["judge.calibration_seconds"]
                cost = first["judge.network_seconds"] + walked
                lines.append(_line(f"judge, {int(steps):,} steps", first[key], cost))
    return lines


def _line(who: str, error: float, seconds: float) -> Line:
    return {"predictor": who, "error": error, SECONDS: seconds}


def figure(found: Sequence[Row]) -> "Figure":
    """Error over compute, with the floor."""
    from motorspace.reports.figures.measures import Axis, curves_figure

    agent, rotation = COMPARED
    rows = [
        {"who": "judge" if who.startswith("judge") else who, SECONDS: seconds, SHOWN: error}
        for who, error, seconds in (line.values() for line in over_compute(found))
    ]
    floors = [
        row.runs[0]["judge.floor"]
        for row in chosen(found, agent=agent, rotation=rotation)
        if "judge.floor" in row.runs.get(0, {})
    ]
    axis = Axis(SECONDS, scale="log")
    targets = {SHOWN: floors[0]} if floors else {}
    return curves_figure(rows, axis, [SHOWN], series=["who"], targets=targets)


STEPS = ("judge.error.2000", "judge.error.5000", "judge.error.15000")
WHO = ("guided", "simulated", "predictor", "stay")
STUDY = Study(
    name="judge",
    question="How near to the floor does a prediction come that remembers the place?",
    jobs=jobs,
    measures={
        "judge": measured,
        "acting": acted,
        "network": of_network,
        "ensemble": of_ensemble,
    },
    rows=related,
    tables={
        "judge_short": _judged("judge.network", ERROR, "judge.floor", "judge.to_floor"),
        "judge": _judged(
            "judge.network",
            *STEPS,
            "judge.motors",
            "judge.floor",
            "judge.to_floor",
            "judge.motors_to_floor",
        ),
        "judge_unseen": _judged("judge.unseen", "judge.unseen_network"),
        "judge_compute": Table(over_compute),
        "judge_goals": _judged(
            *(f"judge.seen.{who}" for who in WHO[:3]), "judge.seen_to_simulated"
        ),
        "judge_elsewhere": _judged(
            *(f"judge.elsewhere.{who}" for who in WHO[:3]), "judge.elsewhere_to_simulated"
        ),
        "judge_stay": _judged(*(f"judge.{where}.stay" for where in ("seen", "elsewhere", "far"))),
        "judge_far": _judged(*(f"judge.far.{who}" for who in WHO)),
    },
    targets=(
        Target("error over the floor", "judge.to_floor", at_most=2.0),
        Target(
            "goals of readings, over search in the true simulator",
            "judge.seen_to_simulated",
            at_least=0.5,
        ),
        Target("the same in an unseen layout", "judge.elsewhere_to_simulated", at_least=0.4),
        Target("goals of readings five sequences away", "judge.far.guided", at_least=0.6),
    ),
    figures={"judge": figure},
)
