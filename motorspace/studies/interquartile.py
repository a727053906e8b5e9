"""Interquartile means with stratified bootstrap intervals (Agarwal et al., 2021)."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

NUM_RESAMPLES = 9999


def interquartile(scores: Sequence[Sequence[float]]) -> dict[str, float]:
    """Returns the mean of the middle half of all scores, and its 95 % interval.

    Args:
        scores: Those of the runs of each task. Every resample draws as many runs of each task as
            there are; the interval is that of the percentiles.

    >>> interquartile([[0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 9.0]])["mean"]
    1.0
    """
    random, tasks = np.random.default_rng(0), [np.asarray(task, float) for task in scores]
    resampled = [random.choice(task, (NUM_RESAMPLES, len(task))) for task in tasks]
    low, high = np.percentile(_middle(np.concatenate(resampled, axis=1)), [2.5, 97.5])
    mean = _middle(np.concatenate(tasks)[None])[0]
    return {"mean": float(mean), "low": float(low), "high": float(high)}


def _middle(values: Float[np.ndarray, "R N"]) -> Float[np.ndarray, " R"]:
    """The mean of the values between the quartiles, row by row."""
    ordered, cut = np.sort(values, axis=-1), values.shape[-1] // 4
    return np.asarray(ordered[:, cut : values.shape[-1] - cut].mean(axis=-1))
