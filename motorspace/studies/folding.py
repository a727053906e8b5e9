"""When in training do full turns fold?"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from motorspace.analysis.measures import Measure, define
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import system
from motorspace.studies.rows import Numbers, Row
from motorspace.studies.study import Budget, Line, Study, Table
from motorspace.training.presets import PresetName

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace._types import Record
    from motorspace.training.run import Run

define(Measure("folding.share.{turns}", "share of random sequences, {turns} full turns"))

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


def measured(run: "Run", num: int) -> Numbers:
    """The equivalence ratio by full turns, as training goes on from the initial network."""
    import jax

    from motorspace.evaluation.structure import equivalence
    from motorspace.evaluation.subject import subject_of
    from motorspace.training.fit import fit, horizon_of, init
    from motorspace.training.program import TrainState
    from motorspace.training.run import Run
    from motorspace.training.sources import source_of

    del num
    config, course = run.config, dict[str, float]()
    training, data = config.training, source_of(config)

    every = max(1, training.epochs // TIMES)

    def note(state: TrainState, records: "Sequence[Record]") -> None:
        epoch = records[-1]["epoch"]
        if epoch % every == 0:
            subject = subject_of(Run(config, state.model))
            found = equivalence(subject, key=jax.random.key(training.seed))
            by_turns = {key: value for key, value in found.items() if key.startswith(TURNS)}
            course.update({f"epoch.{epoch}.{key}": value for key, value in by_turns.items()})

    state = init(config, data.scaling, horizon=horizon_of(data.experience))
    fit(config, state, data.experience, callback=note, every=every)
    return course


def courses(found: Sequence[Row]) -> list[Line]:
    """A line for each preset, measured epoch and number of full turns."""
    return [
        {"variant": row.cell["variant"], "epoch": int(epoch), "turns": int(turns)}
        | {TURNS: row[key].ends}
        for row in found
        for key in next(iter(row.runs.values()))
        for _, epoch, *_, turns in [key.split(".")]
        if key.startswith("epoch.") and key in row
    ]


def lines(found: Sequence[Row]) -> list[Line]:
    """The equivalence ratio by full turns in the course of training, means over seeds."""
    by_epoch: dict[tuple[str, int], dict[str, float]] = {}
    for line in courses(found):
        means = by_epoch.setdefault((line["variant"], line["epoch"]), {})
        means[f"{line['turns']} full turns"] = line[TURNS]["mean"]
    return [
        {"codes": variant, "epoch": epoch, **means} for (variant, epoch), means in by_epoch.items()
    ]


def figure(found: Sequence[Row]) -> "Figure":
    """The course of every number of full turns, a panel for each preset."""
    from motorspace.reports.figures.measures import curves_figure

    named = [{**line, "apart": f"{line['turns']} full turns"} for line in courses(found)]
    return curves_figure(named, "epoch", [TURNS], series=("apart",), panels="variant")


STUDY = Study(
    name="folding",
    question="When in training do full turns fold?",
    jobs=jobs,
    measures={"course": measured},
    tables={"folding": Table(lines)},
    figures={"folding": figure},
)
