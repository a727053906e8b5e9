"""Interquartile means against SciPy's, and intervals whose resamples keep to their task."""

import numpy as np
import pytest
from scipy.stats import trim_mean

from motorspace.studies.interquartile import interquartile


@pytest.mark.parametrize("runs", [4, 5, 10, 11])
def test_means_are_those_of_scipy(runs):
    scores = np.random.default_rng(runs).normal(size=(3, runs)) ** 3
    found = interquartile(scores.tolist())
    assert found["mean"] == pytest.approx(trim_mean(scores, 0.25, axis=None))
    assert found["low"] < found["mean"] < found["high"]


def test_resamples_keep_to_their_task():
    far = [[0.0, 0.1, 0.2, 0.3], [10.0, 10.1, 10.2, 10.3]]
    together = interquartile(far)
    pooled = interquartile([[score for task in far for score in task]])
    assert together["mean"] == pytest.approx(pooled["mean"])
    assert together["high"] - together["low"] < 0.2 * (pooled["high"] - pooled["low"])
