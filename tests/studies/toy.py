"""A study outside of motorspace, in one file: does the size of the code matter?"""

from motorspace.evaluation.evaluate import evaluate
from motorspace.running.jobs import Job, cell
from motorspace.studies.study import Study, Table, Target, register_study
from motorspace.studies.tables import columns
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Simulated
from motorspace.training.settings import changed

BASE = RunConfig(
    Simulated(layout="empty", horizon=2),
    training=TrainingConfig(epochs=2, trajectories_per_epoch=64, batch_size=32),
)
SIZES = {"hidden_size": 8, "width_size": 8, "depth": 1}


def jobs(budget, seeds):
    return [
        Job("toy", cell(units=units), changed(BASE, SIZES | {"code_size": units, "seed": seed}))
        for seed in range(seeds)
        for units in (4, 6)
    ]


STUDY = Study(
    name="toy",
    question="Does the size of the code matter?",
    jobs=jobs,
    measures={"": lambda run, num: evaluate(run, num=num)},
    tables={"toy": Table(columns("units", "prediction.error", "seeds"))},
    targets=(Target("a low error", "prediction.error", at_most=1e-6),),
)
register_study(STUDY)
