"""Recorded robots: where do codes lead, and what map do they make, without a pose?

The logs are public, and no part of motorspace: `motorspace reproduce logs --logs FOLDER` finds them
by their names. Their corrected poses score, and nothing else; reference rows that use them say so.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from motorspace.analysis.measures import Measure, define
from motorspace.recordings.catalog import READERS
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import budgeted, evaluated, system
from motorspace.studies.robots import RECORDINGS
from motorspace.studies.rows import COMPONENTS, Numbers, Row, Spread, chosen
from motorspace.studies.study import Budget, Line, Study, Table, Target
from motorspace.studies.tables import columns
from motorspace.training.config import RunConfig
from motorspace.training.data import Logged, Simulated
from motorspace.worlds.catalog import SENSORS

if TYPE_CHECKING:
    from motorspace.recordings.recording import Recording
    from motorspace.training.run import Run

HORIZONS: Mapping[str, int] = {"freiburg-079-corrected": 12, "intel-corrected": 3}
"""Scans of a transition: in the second log they are half a metre apart."""
NUM_RAYS, NUM_BEAMS = 30, 121
"""Readings that the network learns from; those of maps."""
MAX_RANGE = 10.0
"""Metres beyond which readings count as met nothing."""

PRETRAINING: Budget = "fifth"
"""Epochs in simulation of a predictor that learns on logs then."""

WAYS = {
    "still": "standing still",
    "raw": "commands as they are",
    "kinematics": "commands, best linear correction",
    "regressor": "supervised regression",
    "matcher": "matcher told the geometry, no loops",
    "matcher_loops": "matcher told the geometry, loops",
    "chained": "codes, chained",
    "corrected": "codes, corrected",
    "loops": "codes, loops",
}
define(
    *(
        Measure(f"logs.ate.{way}", head, goal="low", perfect=0.0, unit="metres")
        for way, head in WAYS.items()
    ),
    *(
        Measure(f"logs.rpe_shift.{way}", f"RPE, {head}", goal="low", perfect=0.0, unit="metres")
        for way, head in WAYS.items()
    ),
    *(
        Measure(f"logs.drift.{way}", f"drift, {head}", goal="low", perfect=0.0)
        for way, head in WAYS.items()
    ),
    Measure("logs.to_still", "ATE with loops / standing still", goal="low", chance=1.0),
    Measure("logs.to_matcher", "ATE with loops / matcher's", goal="low"),
    Measure("logs.loops", "loops"),
    Measure("logs.precision", "precision", goal="high", perfect=1.0),
    Measure("logs.recall", "recall", goal="high", perfect=1.0),
    Measure("logs.iou", "IoU", goal="high", perfect=1.0),
    Measure("logs.within_68", "within 68 %", perfect=0.68),
    Measure("logs.within_95", "within 95 %", perfect=0.95),
    Measure("logs.seconds", "computing time", goal="low", unit="s"),
    Measure("logs.error", "error / the better of persistence and mean", goal="low", chance=1.0),
    Measure("logs.lowest_r2", "lowest R²", goal="high", perfect=1.0, chance=0.0),
)


VARIANTS = {"codes": 5, "references": 1, "pretrained": 3, "frozen": 3}
"""What the jobs are, and for how many seeds at most."""


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """Each log: codes, the same with a predictor that simulation has trained, references."""
    return [
        Job("logs", cell(recording=name, variant=variant), config, variant, variant == "codes")
        for seed in range(seeds)
        for name, horizon in HORIZONS.items()
        for variant, most in VARIANTS.items()
        if seed < most
        for config in [_config(name, horizon, budget, seed)]
    ]


def _config(name: str, horizon: int, budget: Budget, seed: int) -> RunConfig:
    data = Logged(
        f"{name}.log.gz",
        "carmen",
        sha256=RECORDINGS[name]["sha256"],
        horizon=horizon,
        min_horizon=1,
        num_rays=NUM_RAYS,
        max_range=MAX_RANGE,
    )
    return budgeted(RunConfig(data, preset="log"), budget, seed)


def measured(run: "Run", num: int) -> Numbers:
    """The log put together by codes, and how well they predict."""
    from motorspace.mapping.trials import measure_mapping

    scores = measure_mapping(run, log_with_beams(run))
    made, body = scores["with loops"], scores["corrected"]
    kept: dict[str, float] = {}
    for way, path in (("chained",) * 2, ("corrected",) * 2, ("loops", "with loops")):
        kept |= _errors(way, scores[path])
    kept |= {f"logs.{name}": made[f"loops.{name}"] for name in LOOPS if f"loops.{name}" in made}
    kept |= {f"logs.within_{share}": body[f"covariance.{share}"] for share in (68, 95)}
    kept |= {"logs.loops": made["loops.num"], "logs.iou": made["map.iou"]}
    kept["logs.seconds"] = made["seconds"]
    return kept | _learned(run, num)


LOOPS, WITHIN = ("precision", "recall"), ("within_68", "within_95")


def _errors(way: str, scores: Mapping[str, float]) -> dict[str, float]:
    kept = {"ate": "path.ate", "drift": "path.drift", "rpe_shift": "path.rpe_shift.6"}
    return {f"logs.{name}.{way}": scores[key] for name, key in kept.items() if key in scores}


def _learned(run: "Run", num: int) -> dict[str, float]:
    found = evaluated(run, num)
    level = min(found["prediction.persistence"], found["prediction.mean"])
    lowest = min(found[f"probe_r2.{component}"] for component in COMPONENTS)
    return {"logs.error": found["prediction.error"] / level, "logs.lowest_r2": lowest}


def measured_references(run: "Run", num: int) -> Numbers:
    """What is reached without codes; all but commands and standing still are given true things."""
    del num
    from motorspace.mapping.references import reference_paths
    from motorspace.mapping.scores import measure_path
    from motorspace.recordings.recording import sensor_frames

    log = log_with_beams(run)
    truth = sensor_frames(log)
    found: dict[str, float] = {}
    for way, path in reference_paths(log, truth).items():
        found |= _errors(way, measure_path(path, truth))
    return found


def log_with_beams(run: "Run") -> "Recording":
    """The run's log, with as many rays as maps are made of."""
    data = run.config.data
    assert isinstance(data, Logged)
    options = dict(data.reader.options) | {"num_rays": NUM_BEAMS}
    return replace(data, reader=READERS.part(data.reader.kind, options)).recording()


def measured_pretrained(run: "Run", num: int) -> Numbers:
    """Learning on the log with a predictor that simulation has trained, and that learns on."""
    return _learned(_pretrained(run, frozen=False), num)


def measured_frozen(run: "Run", num: int) -> Numbers:
    """The same with the predictor as simulation has left it."""
    return _learned(_pretrained(run, frozen=True), num)


def _pretrained(run: "Run", *, frozen: bool) -> "Run":
    from motorspace.models.model import with_parts
    from motorspace.training.fit import fit, horizon_of, init
    from motorspace.training.run import Run
    from motorspace.training.sources import source_of

    config, parts = run.config, ("predictor",)
    data = source_of(config)
    state = init(config, data.scaling, horizon=horizon_of(data.experience), validated=True)
    model = with_parts(state.model, _simulated(config.training.seed).model, parts)
    state = replace(state, model=model, average=model)
    trained = fit(
        config,
        state,
        data.experience,
        validation=data.validation,
        frozen=parts if frozen else (),
    )
    return Run(config, trained.selected)


@lru_cache(maxsize=1)
def _simulated(seed: int) -> "Run":
    """A network of `best` that has learned with a log's sensor in simulated rooms."""
    from motorspace.training.run import train

    walker = system("forward", 0.2, PRETRAINING, seed, "best")
    assert isinstance(walker.data, Simulated)
    sensor = SENSORS.part(
        "range_fan",
        {"num_rays": NUM_RAYS, "field_of_view": math.pi, "max_range": MAX_RANGE},
    )
    rooms = Simulated(walker.data.agent, sensor, "rooms:0", horizon=6, min_horizon=1)
    return train(replace(walker, data=rooms))


def rows(found: Sequence[Row]) -> list[Row]:
    """A row for each log and variant; that of codes has the references beside it."""
    made = []
    for row in found:
        if row.cell["variant"] == "references":
            continue
        if row.cell["variant"] == "codes":
            row = _beside(row, chosen(found, variant="references", **_log_of(row)))
        made.append(row)
    return made


def _log_of(row: Row) -> dict[str, Any]:
    return {"recording": row.cell["recording"]}


def _beside(row: Row, references: Sequence[Row]) -> Row:
    if not references:
        return row
    (reference,) = references
    keys = [f"logs.{name}.{way}" for name in ("ate", "drift", "rpe_shift") for way in WAYS]
    others: dict[str, Spread | None] = {key: reference.get(key) for key in keys}
    ratios = {
        f"logs.to_{name}": row["logs.ate.loops"] / reference[f"logs.ate.{way}"].mean
        for name, way in (("still", "still"), ("matcher", "matcher_loops"))
    }
    return row.with_measures({k: v for k, v in others.items() if k not in row} | ratios)


def _ways(rows: Sequence[Row]) -> list[Line]:
    """A line for each log and way to a path."""
    return [
        {
            "recording": row.cell["recording"],
            "path": head,
            "ATE (metres)": row[f"logs.ate.{way}"].ends,
            "RPE over 6 scans (metres)": row[f"logs.rpe_shift.{way}"].ends,
            "drift": row[f"logs.drift.{way}"].ends,
        }
        for row in chosen(rows, variant="codes")
        for way, head in WAYS.items()
        if f"logs.ate.{way}" in row
    ]


CODES = {"variant": "codes"}
FREIBURG = CODES | {"recording": "freiburg-079-corrected"}
INTEL = CODES | {"recording": "intel-corrected"}

STUDY = Study(
    name="logs",
    question="Recorded robots: where do codes lead, and what map do they make?",
    jobs=jobs,
    measures={
        "codes": measured,
        "references": measured_references,
        "pretrained": measured_pretrained,
        "frozen": measured_frozen,
    },
    budget="paper",
    rows=rows,
    tables={
        "logs_paths": Table(_ways),
        "logs_maps": Table(
            columns(
                "recording",
                *(f"logs.{name}" for name in ("loops", *LOOPS, "iou", "seconds")),
                cells=CODES,
            )
        ),
        "logs_ratios": Table(
            columns(
                "recording",
                *(f"logs.{name}" for name in ("to_still", "to_matcher", *WITHIN)),
                cells=CODES,
            )
        ),
        "logs_learned": Table(columns("recording", "variant", "logs.error", "logs.lowest_r2")),
    },
    targets=(
        Target("freiburg-079: ATE in metres", "logs.ate.loops", at_most=2.5, cells=FREIBURG),
        Target("intel: ATE in metres", "logs.ate.loops", at_most=4.0, cells=INTEL),
        Target("ATE over standing still", "logs.to_still", at_most=1 / 3, cells=CODES),
        Target("ATE over the matcher's", "logs.to_matcher", at_most=2.0, cells=CODES),
    ),
)
