"""When in training do full turns fold?"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import system
from motorspace.studies.rows import Row
from motorspace.studies.study import Budget, Line, Study, Table
from motorspace.training.presets import PresetName

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace._types import Record
    from motorspace.training.run import Run

PRESETS: tuple[PresetName, ...] = ("best", "paper")
TIMES = 20
"""How often in the course of training the codes are measured."""
TURNS = "equivalence.full_turns"


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Both presets on the forward agent with large rotations, from their initial networks."""
    return [
        Job(
            "folding",
            cell(variant=preset),
            system("forward", 0.8, budget, seed, preset),
            "course",
            trains=False,
        )
        for seed in range(seeds)
        for preset in PRESETS
    ]


def measured(run: "Run", num: int) -> Mapping[str, float]:
    """The equivalence ratio by full turns, as training goes on from the initial network."""
    import jax

    from motorspace.evaluation.structure import equivalence, subject_of
    from motorspace.training.fit import TrainState, fit, init
    from motorspace.training.run import Run
    from motorspace.training.sources import source_of

    del num
    config, course = run.config, dict[str, float]()
    training, data = config.training, source_of(config)

    def note(state: TrainState, record: "Record") -> None:
        epoch = record["epoch"]
        if epoch % max(1, training.epochs // TIMES) == 0:
            subject = subject_of(Run(config, state.model))
            found = equivalence(subject, key=jax.random.key(training.seed))
            by_turns = {key: value for key, value in found.items() if key.startswith(TURNS)}
            course.update({f"epoch.{epoch}.{key}": value for key, value in by_turns.items()})

    state = init(config, data.scaling, horizon=run.config.data.horizon)
    fit(config, state, data.experience, callback=note)
    return course


def courses(row: Row) -> dict[int, list[tuple[float, float, float, float]]]:
    """{full turns: points of the equivalence ratio over the epochs}."""
    found: dict[int, list[tuple[float, float, float, float]]] = {}
    first, *_ = row.runs.values()
    for key in first:
        _, epoch, rest = key.split(".", 2)
        if key in row:
            turns = int(rest.rpartition(".")[2])
            found.setdefault(turns, []).append(row[key].at(int(epoch)))
    return dict(sorted(found.items()))


def lines(found: Sequence[Row]) -> list[Line]:
    """The equivalence ratio by full turns in the course of training, means over seeds."""
    return [
        {"codes": row.cell["variant"], "epoch": int(points[0])}
        | {f"{turns} full turns": mean for turns, (_, mean, *_) in zip(of, at, strict=True)}
        for row in found
        for of in [courses(row)]
        for at in zip(*of.values(), strict=True)
        for points in [at[0]]
    ]


def figure(found: Sequence[Row]) -> "Figure":
    """The course of every number of full turns, a panel for each preset."""
    from motorspace.reports.curves import Curve, Panel, panels_figure

    panels = [
        Panel(
            str(row.cell["variant"]),
            {f"{turns} full turns apart": Curve(p) for turns, p in courses(row).items()},
            {"xlabel": "epoch", "yscale": "log", "ylabel": "squared distance / that of all pairs"},
        )
        for row in found
    ]
    return panels_figure(panels, size=(9, 3.8), share_y=True)


STUDY = Study(
    name="folding",
    question="When in training do full turns fold?",
    jobs=jobs,
    measures={"course": measured},
    tables={"folding": Table(lines)},
    figures={"folding": figure},
)
