"""Do recorded robots learn what their commands do?

The two logs are public, and no part of motorspace: `motorspace reproduce robots --logs FOLDER`
finds them by their names.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from motorspace.analysis.measures import Measure, define
from motorspace.models.config import ModelConfig
from motorspace.running.jobs import Job, cell
from motorspace.studies.cells import budgeted, evaluated
from motorspace.studies.rows import COMPONENTS, Numbers, Row, Spread, chosen
from motorspace.studies.study import Budget, Study, Table, Target
from motorspace.studies.tables import columns
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Derived, Logged
from motorspace.training.settings import changed

if TYPE_CHECKING:
    from motorspace.training.run import Run

RECORDINGS: Mapping[str, Mapping[str, Any]] = {
    "freiburg-079-corrected": {
        "sha256": "0631d30baf4b9d1d209af47da9096e876e1b4cb3d5a2d68ef9c39c5a2360a466",
        "horizon": 6,
        "min_horizon": 1,
        "per_scan": True,
    },
    "intel-corrected": {
        "sha256": "71bef16e9926506cf7417995ef35ace09dbd5de067fd042a3aab85188b5480dc",
        "horizon": 1,
        "min_horizon": 1,
        "per_scan": False,
    },
}
"""How each log is cut into transitions: how many scans, with which commands."""

TRAINING = TrainingConfig(
    epochs=60,
    trajectories_per_epoch=2000,
    learning_rate=1e-3,
    schedule="constant",
    curriculum=0.0,
    ema_decay=0.99,
)

SQUARED = "sensor units²"
define(
    Measure("robots.oracle", "oracle", goal="low", perfect=0.0, unit=SQUARED),
    Measure("robots.untrained", "untrained encoder", goal="low", perfect=0.0, unit=SQUARED),
    Measure("robots.no_motors", "no motors", goal="low", perfect=0.0, unit=SQUARED),
    Measure(
        "robots.to_level", "error / the better of persistence and mean", goal="low", chance=1.0
    ),
    Measure("robots.to_no_motors", "error / the no-motor model's", goal="low", chance=1.0),
    Measure("robots.num_train", "transitions to train on"),
    Measure("robots.num_validation", "transitions to validate on"),
)


def jobs(budget: Budget, seeds: int) -> list[Job]:
    """The paper's network and its baselines on each log."""
    return [
        Job("robots", cell(recording=name, variant=variant), config, "robots")
        for seed in range(seeds)
        for name in RECORDINGS
        for variant, config in _variants(name, budget, seed).items()
    ]


def _variants(name: str, budget: Budget, seed: int) -> dict[str, RunConfig]:
    data = Logged(f"{name}.log.gz", "carmen", **RECORDINGS[name])
    model = ModelConfig(initial_weights="scaled")
    network = budgeted(RunConfig(data, model, TRAINING), budget, seed)
    # Without motors a short transition cannot be told from a long one: such a model is the
    # stronger baseline when it sees the tested length alone.
    blind = changed(network, {"encoder": "none", "min_horizon": data.horizon})
    told = replace(network, data=Derived(data, "oracle"))
    return {
        "paper": network,
        "untrained": changed(network, {"train_encoder": False}),
        "no-motors": blind,
        "oracle": changed(told, {"encoder": "identity"}),
    }


def measured(run: "Run", num: int) -> Numbers:
    """Errors on the test blocks beside baselines, probes of the codes, how many transitions."""
    from motorspace.training.sources import logged_data

    data = logged_data(run.config.data)
    counts = {"robots.num_train": len(data.train), "robots.num_validation": len(data.validation)}
    return dict(evaluated(run, num)) | counts


def rows(found: Sequence[Row]) -> list[Row]:
    """A row for each log with the paper's network, beside its baselines."""
    return [
        _beside(row, chosen(found, recording=row.cell["recording"]))
        for row in chosen(found, variant="paper")
    ]


def _beside(row: Row, found: Sequence[Row]) -> Row:
    error = row["prediction.error"]
    level = min(row["prediction.persistence"].mean, row["prediction.mean"].mean)
    others: dict[str, Spread | None] = {
        f"robots.{other.cell['variant']}".replace("-", "_"): other["prediction.error"]
        for other in found
        if other is not row
    }
    blind = others.get("robots.no_motors")
    ratios = {"robots.to_level": error / level}
    return row.with_measures(
        others | ratios | ({"robots.to_no_motors": error / blind.mean} if blind else {})
    )


BASELINES = ("robots.oracle", "robots.untrained", "robots.no_motors")
LEVELS = ("prediction.mean", "prediction.persistence")
HEADS = {"prediction.error": "error", "prediction.mean": "mean"}
HEADS |= {"prediction.persistence": "persistence", "robots.untrained": "untrained"}
HEADS |= {f"probe_r2.{component}": f"R² {component}" for component in COMPONENTS}

STUDY = Study(
    name="robots",
    question="Do recorded robots learn what their commands do?",
    jobs=jobs,
    measures={"robots": measured},
    budget="paper",
    rows=rows,
    tables={
        "robots_short": Table(
            columns("recording", "prediction.error", *BASELINES, LEVELS[1], heads=HEADS)
        ),
        "robots": Table(
            columns(
                *("recording", "seeds", "prediction.error", *BASELINES, *LEVELS),
                *("robots.num_train", "robots.num_validation", "prediction.num"),
                heads=HEADS,
            )
        ),
        "robots_probes": Table(
            columns("recording", *(f"probe_r2.{c}" for c in COMPONENTS), heads=HEADS)
        ),
    },
    targets=(
        Target(
            "error over the better of persistence and mean",
            "robots.to_level",
            at_most=0.75,
            every_seed=True,
        ),
        Target(
            "error over the no-motor model's", "robots.to_no_motors", at_most=0.85, every_seed=True
        ),
    ),
)
