"""The paper's lattice: is every case predicted exactly, and do equal displacements share a code?"""

from collections.abc import Sequence

from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import LATTICES, evaluated, lattice, untrained
from motorspace.studies.rows import Row, Spread
from motorspace.studies.study import Budget, Line, Study, Table, Target
from motorspace.studies.tables import columns

TITLES = {kind: kind.replace("-", " ") for kind in LATTICES} | {"untrained": "untrained encoder"}
CASES = 900_240
"""All sequences of one to five commands that stay on the lattice, from every start."""


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Every kind of lattice system, and an untrained encoder."""
    found = []
    for seed in range(seeds):
        systems = {kind: lattice(kind, budget, seed) for kind in LATTICES}
        systems["untrained"] = untrained(systems["without-inverse"])
        found += [
            Job("lattice", cell(variant=variant), config, "evaluate")
            for variant, config in systems.items()
        ]
    return found


def rows(found: Sequence[Row]) -> list[Row]:
    """The rows with the number of wrong cases."""
    return [row.with_measures({"lattice.wrong": _wrong(row)}) for row in found]


def _wrong(row: Row) -> Spread:
    lengths = [key.rpartition(".")[2] for key in next(iter(row.runs.values())) if ".valid." in key]
    return Spread(
        tuple(
            float(sum(run[f"lattice.valid.{n}"] - run[f"lattice.correct.{n}"] for n in lengths))
            for run in row.runs.values()
        )
    )


def cases(found: Sequence[Row]) -> list[Line]:
    """Exact predictions by the length of the sequence."""
    trained = [row for row in found if row.cell["variant"] in LATTICES]
    keys = [f"lattice.{{}}.{n}" for n in range(1, 6)]
    return [
        {"T": key[-1], "cases": f"{trained[0][key.format('valid')].mean:,.0f}"}
        | {f"correct, {TITLES[str(row.cell['variant'])]}": _count(row, key) for row in trained}
        for key in keys
        if trained
    ]


def _count(row: Row, key: str) -> str:
    return f"{row[key.format('correct')].mean:,.0f}"


PROBES = tuple(f"lattice.r2.{n}.{c}" for n in (2, 3) for c in ("longitudinal", "lateral"))
HEADS = {
    "variant": "run",
    "lattice.within_to_total_pose": "within / total, pose",
    "lattice.within_to_total": "within / total, translation",
} | {key: "R² {3}, {2} PCs".format(*key.split(".")) for key in PROBES}
SHORT = ("variant", "lattice.wrong", "lattice.within_to_total_pose", *PROBES[2:])
FULL = (
    *("variant", "seeds", "epochs", "lattice.wrong"),
    *("lattice.within_to_total_pose", "lattice.within_to_total", *PROBES, "code_variance"),
)

STUDY = Study(
    name="lattice",
    question="Is every case on the lattice predicted exactly, and what do the codes look like?",
    jobs=jobs,
    measures={"evaluate": evaluated},
    budget="paper",
    rows=rows,
    tables={
        "lattice_short": Table(columns(*SHORT, heads=HEADS, titles=TITLES)),
        "lattice": Table(columns(*FULL, heads=HEADS, titles=TITLES)),
        "lattice_cases": Table(cases),
    },
    targets=(
        Target(
            f"wrong of {CASES:,} cases, all there are",
            "lattice.wrong",
            at_most=0.0,
            cells={"variant": tuple(LATTICES)},
            every_seed=True,
        ),
        *(
            Target(
                f"R² of {component} displacement from 3 components",
                f"lattice.r2.3.{component}",
                at_least=0.9,
                cells={"variant": "with-slowness"},
                every_seed=True,
            )
            for component in ("longitudinal", "lateral")
        ),
    ),
)
