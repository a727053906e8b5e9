"""How far do chained codes lead, and what does a map without odometry reach?"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from motorspace.analysis.measures import Measure, define
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import CONTINUOUS, system
from motorspace.studies.rows import Numbers, Row, chosen
from motorspace.studies.study import Budget, Line, Study, Table, Target
from motorspace.studies.tables import columns

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace.recordings.recording import Recording
    from motorspace.training.run import Run

ROTATION = 0.4
ROOMS, NUM_WALKS = 7_000, 4
"""The first seed of layouts that nothing was chosen on, and walks in each kind of layout."""
FEW_SEEDS = 3
"""Seeds of the trials beside walks."""
MAPPED = ("rooms", "four_rooms")
PATHS = ("still", "codes", "chained", "corrected")

HEADS = {
    "still": "standing still",
    "codes": "codes alone",
    "chained": "codes in the rays' frame",
    "corrected": "corrected by neighbouring scans",
}
define(
    *(
        Measure(f"odometry.ate.{path}", f"ATE, {head}", goal="low", perfect=0.0, unit="world units")
        for path, head in HEADS.items()
    ),
    *(
        Measure(f"odometry.drift.{path}", f"drift, {head}", goal="low", perfect=0.0)
        for path, head in HEADS.items()
    ),
    Measure("odometry.bias", "share of the bias that codes hold"),
    Measure("mapping.ate.{kind}", "ATE, {kind}", goal="low", perfect=0.0, unit="world units"),
    Measure("mapping.corrected.{kind}", "ATE, no loops, {kind}", goal="low", unit="world units"),
    Measure("mapping.raw.{kind}", "ATE, chained, {kind}", goal="low", unit="world units"),
    Measure("mapping.still.{kind}", "ATE, standing still, {kind}", goal="low", unit="world units"),
    Measure("mapping.iou.{kind}", "IoU, {kind}", goal="high", perfect=1.0),
    Measure("mapping.precision.{kind}", "precision of loops, {kind}", goal="high", perfect=1.0),
    Measure("mapping.recall.{kind}", "recall of loops, {kind}", goal="high", perfect=1.0),
    Measure("mapping.within_68.{kind}", "within 68 %, {kind}", perfect=0.68),
    Measure("mapping.within_95.{kind}", "within 95 %, {kind}", perfect=0.95),
    Measure("mapping.seconds.{kind}", "computing time, {kind}", goal="low", unit="s"),
    Measure("mapping.failed.{kind}", "walks without a map, {kind}", goal="low", perfect=0.0),
)


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Both agents with `best`, in each of the `TRIALS`; seed after seed of each."""
    return [
        Job(
            "odometry",
            cell(agent=agent, trial=trial),
            system(agent, ROTATION, budget, seed, "best"),
            trial,
            trains=trial != "biased",
        )
        for trial in TRIALS
        for seed in range(seeds)
        for agent in CONTINUOUS
        if trial == "walks" or seed < FEW_SEEDS
    ]


TRIALS = ("walks", "biased", "open")
"""Codes of exact motors on walks; codes of biased ones; calibrated odometry without walls."""


def measured(run: "Run", num: int) -> Numbers:
    """Medians over walks in layouts that the run has not seen."""
    del num
    return chained_errors(run, biased=False) | _mapped(run)


def measured_biased(run: "Run", num: int) -> Numbers:
    """What codes of biased motors hold of the bias, and where they lead beside exact ones.

    The network learns anew, with the run's budget, from a body that does not do as commanded.
    """
    del num
    from motorspace.mapping.trials import BIAS, NOISE, trained_with_motor_errors

    learned = trained_with_motor_errors(run.config, noise=NOISE, bias=BIAS)
    return chained_errors(learned, biased=True)


def measured_open(run: "Run", num: int) -> Numbers:
    """Odometry that was calibrated in rooms, where no wall is in sight."""
    del num
    import jax
    import numpy as np

    from motorspace.mapping.trials import measure_open

    walks = [
        measure_open(run, f"rooms:{ROOMS + index}", key=jax.random.key(ROOMS + index))
        for index in range(NUM_WALKS)
    ]
    return {
        f"mapping.{name}.open": float(np.median([walk[PARTS[name][1]] for walk in walks]))
        for name in ("ate", "within_68", "within_95")
    }


def chained_errors(run: "Run", *, biased: bool) -> dict[str, float]:
    """Without loops: codes alone, in the rays' frame, and corrected by neighbouring scans."""
    import numpy as np

    from motorspace.mapping.trials import bias_in_codes, measure_odometry

    walks = _walks(run, "rooms", ROOMS, biased=biased)
    found = [measure_odometry(run, walk) for walk in walks]
    scores = {
        f"odometry.{name}.{path}": float(np.median([walk[path][f"path.{name}"] for walk in found]))
        for path in PATHS
        for name in ("ate", "drift")
        if (path, name) != ("codes", "drift")  # Their frame and unit are their own.
    }
    if biased:
        scores["odometry.bias"] = bias_in_codes(run, walks[0])
    return scores


PARTS = {
    "ate": ("with loops", "path.ate"),
    "corrected": ("corrected", "path.ate"),
    "raw": ("chained", "path.ate"),
    "still": ("standing still", "path.ate"),
    "iou": ("with loops", "map.iou"),
    "precision": ("with loops", "loops.precision"),
    "recall": ("with loops", "loops.recall"),
    "within_68": ("corrected", "covariance.68"),
    "within_95": ("corrected", "covariance.95"),
    "seconds": ("with loops", "seconds"),
}
"""What is kept of a map's scores: of which path, by which key."""


def _mapped(run: "Run") -> dict[str, float]:
    """Noisy and biased motors, many rays, loops."""
    import numpy as np

    from motorspace._errors import UserError
    from motorspace.mapping.trials import measure_mapping

    found: dict[str, float] = {}
    for kind in MAPPED:
        walks = []
        for walk in _walks(run, kind, 2 * ROOMS, biased=True):
            try:
                walks.append(measure_mapping(run, walk))
            except UserError:
                continue
        found[f"mapping.failed.{kind}"] = float(NUM_WALKS - len(walks))
        for name, (path, key) in PARTS.items():
            if values := [scores[path][key] for scores in walks if key in scores[path]]:
                found[f"mapping.{name}.{kind}"] = float(np.median(values))
    return found


def _walks(run: "Run", kind: str, first: int, *, biased: bool) -> "list[Recording]":
    """Walks in random rooms, each in its own, or in a bundled layout."""
    import jax

    from motorspace.mapping.trials import BIAS, NOISE, unseen_walk

    noise, bias = (NOISE, BIAS) if biased else (0.0, 0.0)
    return [
        unseen_walk(
            run,
            f"rooms:{ROOMS + index}" if kind == "rooms" else kind,
            noise=noise,
            bias=bias,
            key=jax.random.key(first + index),
        )
        for index in range(NUM_WALKS)
    ]


def figure(found: Sequence[Row]) -> "Figure":
    """Absolute errors of paths, with and without loops."""
    from motorspace.reports.figures.maps import errors_figure

    return errors_figure(
        {
            f"{row.cell['agent']}, {kind.replace('_', ' ')}": {
                PLACE_HEADS[name]: spread.ends
                for name in ("still", "raw", "corrected", "ate")
                if (spread := row.get(f"mapping.{name}.{kind}")) is not None
            }
            for row in chosen(found, trial="walks")
            for kind in MAPPED
        }
    )


ATES = tuple(f"odometry.ate.{path}" for path in PATHS)
SHORT = {f"odometry.ate.{path}": f"ATE, {head}" for path, head in HEADS.items()}
SHORT |= {f"odometry.drift.{path}": f"drift, {head}" for path, head in HEADS.items()}


def _places(names: Sequence[str]) -> Callable[[Sequence[Row]], Sequence[Line]]:
    """A line for each agent and kind of layout."""

    def lines(rows: Sequence[Row]) -> list[Line]:
        return [
            {"agent": row.cell["agent"], "layout": kind}
            | {
                PLACE_HEADS[name]: spread.ends
                for name in names
                if (spread := row.get(f"mapping.{name}.{kind}")) is not None
            }
            for row in chosen(rows, trial="walks")
            for kind in MAPPED
        ]

    return lines


OPEN = tuple(f"mapping.{name}.open" for name in ("ate", "within_68", "within_95"))
PLACE_HEADS = {
    "still": "standing still",
    "raw": "chained",
    "corrected": "corrected",
    "ate": "with loops",
    "iou": "IoU",
    "precision": "precision",
    "recall": "recall",
    "within_68": "within 68 %",
    "within_95": "within 95 %",
    "seconds": "seconds",
    "failed": "without a map",
}

BOUNDS = (
    ("exact motors, no loops: absolute error", "odometry.ate.corrected", 1.2, None),
    ("exact motors, no loops: drift", "odometry.drift.corrected", 0.01, None),
    ("noisy motors, loops, unseen rooms: absolute error", "mapping.ate.rooms", 0.7, None),
    ("the same in four rooms that look alike", "mapping.ate.four_rooms", 1.5, None),
    ("precision of loops in unseen rooms", "mapping.precision.rooms", None, 0.95),
    ("recall of loops in unseen rooms", "mapping.recall.rooms", None, 0.7),
    ("agreement of maps in unseen rooms", "mapping.iou.rooms", None, 0.4),
    ("covariance: at least 65 of 100 within 68 %", "mapping.within_68.rooms", None, 0.65),
    ("covariance: at most 71 of 100 within 68 %", "mapping.within_68.rooms", 0.71, None),
    ("covariance: at least 92 of 100 within 95 %", "mapping.within_95.rooms", None, 0.92),
    ("covariance: at most 98 of 100 within 95 %", "mapping.within_95.rooms", 0.98, None),
    ("seconds for a map of 1,000 steps, with learning", "mapping.seconds.rooms", 60.0, None),
)
"""Claim, measure, upper and lower bound."""

STUDY = Study(
    name="odometry",
    question="How far do chained codes lead, and what does a map without odometry reach?",
    jobs=jobs,
    measures={"walks": measured, "biased": measured_biased, "open": measured_open},
    tables={
        "odometry": Table(
            columns(
                "agent", *ATES, "odometry.drift.corrected", heads=SHORT, cells={"trial": "walks"}
            )
        ),
        "odometry_biased": Table(
            columns("agent", *ATES, "odometry.bias", heads=SHORT, cells={"trial": "biased"})
        ),
        "mapping_paths": Table(_places(("still", "raw", "corrected", "ate"))),
        "mapping_loops": Table(_places(("precision", "recall", "iou", "seconds"))),
        "mapping_covariance": Table(_places(("within_68", "within_95", "failed"))),
        "odometry_open": Table(columns("agent", *OPEN, cells={"trial": "open"})),
    },
    targets=tuple(
        Target(claim, key, at_most=most, at_least=least, cells={"trial": "walks"})
        for claim, key, most, least in BOUNDS
    ),
    figures={"odometry": figure},
)
