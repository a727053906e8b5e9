"""A job is plain data with a folder name that any file system takes."""

import pytest

from motorspace.running.jobs import Job, cell, described
from tests.running.toy import ToyConfig, ToyTraining, jobs
from tests.sending import sent


def test_a_cell_does_not_depend_on_the_order_in_which_it_is_written():
    assert cell(b=1, a="x") == cell({"a": "x"}, b=1) == (("a", "x"), ("b", 1))
    assert described(cell(rotation=1.0, sense_head=True)) == "rotation=1 sense_head=true"


@pytest.mark.parametrize("value", ["a/b", "../up", "a b, c", "ä" * 300, "", "CON:", 1e-7])
def test_a_folder_name_holds_no_separators_and_is_short(value):
    job = Job("toy", cell(x=value), ToyConfig())
    assert len(job.folder.encode()) < 200
    assert not set(job.folder) & set("/\\: ,")
    assert job.folder.endswith(f"seed0_{job.config.hash()}")


def test_jobs_differ_by_cell_seed_and_configuration():
    (first, second, third) = (*jobs(0.2, 0.4), Job("toy", (), ToyConfig(training=ToyTraining(1))))
    assert len({job.key for job in (first, second, third)}) == 3
    assert sent(first) == first
