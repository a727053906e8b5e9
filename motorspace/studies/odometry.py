"""How far do chained codes lead, and what does a map without odometry reach?"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from motorspace.analysis.measures import Measure, define
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import CONTINUOUS, system
from motorspace.studies.rows import Numbers, Row
from motorspace.studies.study import Budget, Study, Table, Target
from motorspace.studies.tables import columns

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from motorspace.training.run import Run

ROTATION = 0.4
ROOMS, NUM_WALKS = 7_000, 4
"""The first seed of layouts that nothing was chosen on, and walks in each kind of layout."""
MAPPED = ("rooms", "four_rooms")
KINDS = ("chained", "calibrated", "still")
define(
    Measure("odometry.ate.{kind}", "ATE, {kind}", goal="low", perfect=0.0, unit="world units"),
    Measure("odometry.drift.{kind}", "drift, {kind}", goal="low", perfect=0.0),
    Measure("mapping.ate.{kind}", "ATE, {kind}", goal="low", perfect=0.0, unit="world units"),
    Measure("mapping.corrected.{kind}", "ATE, no loops, {kind}", goal="low", unit="world units"),
    Measure("mapping.raw.{kind}", "ATE, chained, {kind}", goal="low", unit="world units"),
    Measure("mapping.still.{kind}", "ATE, standing still, {kind}", goal="low", unit="world units"),
    Measure("mapping.iou.{kind}", "IoU, {kind}", goal="high", perfect=1.0),
    Measure("mapping.precision.{kind}", "precision of loops, {kind}", goal="high", perfect=1.0),
    Measure("mapping.recall.{kind}", "recall of loops, {kind}", goal="high", perfect=1.0),
    Measure("mapping.within_68.{kind}", "within 68 %, {kind}"),
    Measure("mapping.within_95.{kind}", "within 95 %, {kind}"),
    Measure("mapping.seconds.{kind}", "computing time, {kind}", goal="low", unit="s"),
)


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Both agents with `best`; seed after seed."""
    return [
        Job("odometry", cell(agent=agent), system(agent, ROTATION, budget, seed, "best"), "walks")
        for seed in range(seeds)
        for agent in CONTINUOUS
    ]


def measured(run: "Run", num: int) -> Numbers:
    """Medians over walks in layouts that the run has not seen."""
    del num
    return _chained(run) | _mapped(run)


def _chained(run: "Run") -> dict[str, float]:
    """Exact motors, no loops: the codes alone, and with the body calibrated by readings."""
    import jax
    import numpy as np

    from motorspace.judge.judge import calibrate
    from motorspace.mapping.scores import measure_path
    from motorspace.mapping.trials import (
        measure_calibrated,
        measure_chained,
        truth_of,
        unseen_walk,
    )

    body = calibrate(run, key=jax.random.key(run.config.training.seed)).body
    found: dict[str, list[dict[str, float]]] = {kind: [] for kind in KINDS}
    for index in range(NUM_WALKS):
        walk = unseen_walk(run, f"rooms:{ROOMS + index}", key=jax.random.key(ROOMS + index))
        truth = truth_of(walk)
        still = np.repeat(truth[:, :1], truth.shape[1], axis=1)
        found["chained"].append(measure_chained(run, walk))
        found["calibrated"].append(measure_calibrated(body, walk))
        found["still"].append(measure_path(still, truth))
    return {
        f"odometry.{name}.{kind}": float(np.median([scores[f"path.{name}"] for scores in walks]))
        for kind, walks in found.items()
        for name in ("ate", "drift")
    }


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
SHORT = ("still", "raw", "corrected", "ate", "iou")


def _mapped(run: "Run") -> dict[str, float]:
    """Noisy and biased motors, many rays, loops."""
    import jax
    import numpy as np

    from motorspace.mapping.trials import BIAS, NOISE, measure_mapping, unseen_walk

    found: dict[str, float] = {}
    for kind in MAPPED:
        walks = []
        for index in range(NUM_WALKS):
            world = f"rooms:{ROOMS + index}" if kind == "rooms" else kind
            key = jax.random.key(2 * ROOMS + index)
            walk = unseen_walk(run, world, noise=NOISE, bias=BIAS, key=key)
            walks.append(measure_mapping(run, walk))
        for name, (path, key_of) in PARTS.items():
            values = [scores[path][key_of] for scores in walks if key_of in scores[path]]
            found[f"mapping.{name}.{kind}"] = float(np.median(values))
    return found


def figure(found: Sequence[Row]) -> "Figure":
    """Absolute errors of paths, with and without loops."""
    from motorspace.reports.figures.measures import changes_figure

    keys = ("odometry.ate.chained", "odometry.ate.calibrated", "mapping.ate.rooms")
    lines = [{"system": row.name} | row.line(*keys) for row in found]
    return changes_figure(lines, "system", keys)


STUDY = Study(
    name="odometry",
    question="How far do chained codes lead, and what does a map without odometry reach?",
    jobs=jobs,
    measures={"walks": measured},
    tables={
        "odometry": Table(
            columns("agent", *(f"odometry.ate.{k}" for k in KINDS), "odometry.drift.calibrated")
        ),
        "mapping_rooms": Table(
            columns(
                "agent",
                *(f"mapping.{name}.rooms" for name in ("still", "raw", "corrected", "ate", "iou")),
            )
        ),
        "mapping": Table(
            columns(
                "agent", *(f"mapping.{name}.{kind}" for kind in MAPPED for name in PARTS), "seeds"
            )
        ),
    },
    targets=(
        Target("exact motors, no loops: absolute error", "odometry.ate.calibrated", at_most=1.2),
        Target("exact motors, no loops: drift", "odometry.drift.calibrated", at_most=0.01),
        Target("noisy motors, loops, unseen rooms", "mapping.ate.rooms", at_most=0.7),
        Target("the same in four rooms that look alike", "mapping.ate.four_rooms", at_most=1.5),
        Target("precision of loops", "mapping.precision.rooms", at_least=0.95),
        Target("recall of loops", "mapping.recall.rooms", at_least=0.7),
        Target("agreement of maps", "mapping.iou.rooms", at_least=0.4),
        Target("seconds for a map of 1,000 steps", "mapping.seconds.rooms", at_most=60.0),
    ),
    figures={"odometry": figure},
)
