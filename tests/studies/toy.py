"""A study outside of motorspace, in one file: does training lower the error?"""

from motorspace.evaluation.evaluate import evaluate
from motorspace.running.jobs import Job, cell
from motorspace.studies.study import Study, Table, Target, register_study
from motorspace.studies.tables import columns
from motorspace.training.settings import changed
from tests.tiny import TINY


def jobs(budget, seeds):
    return [
        Job("toy", cell(trained=trained), changed(TINY, {"seed": seed}), trains=trained == "yes")
        for seed in range(seeds)
        for trained in ("no", "yes")
    ]


STUDY = Study(
    name="toy",
    question="Does training lower the error?",
    jobs=jobs,
    measures={"": lambda run, num: evaluate(run, num=num)},
    tables={"toy": Table(columns("trained", "prediction.error", "seeds"))},
    targets=(Target("a low error", "prediction.error", at_most=1e-6),),
)
register_study(STUDY)
