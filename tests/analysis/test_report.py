"""Reports: how their measures are reached, printed and stored."""

import copy
import json

import numpy as np
import pytest

from motorspace.analysis.measures import measure
from motorspace.analysis.report import Estimate, over_subsets, report
from motorspace.analysis.topology import topology
from tests.sending import sent

FOUND = report(
    400,
    1.4,
    0,
    {
        "rank_correlation": Estimate(0.98, 0.004),
        "linear_r2.cos": Estimate(0.99),
        "linear_r2.worst": Estimate(0.97),
        "trustworthiness.20": Estimate(1.0, 0.0),
        "equivalence_ratio": Estimate(float("nan")),
    },
)


def test_an_estimate_is_a_float_that_knows_its_error():
    value = FOUND.rank_correlation
    assert value > 0.9 and value.standard_error == 0.004 and type(value.mean) is float
    assert repr(value) == "0.98 ± 0.004" and repr(FOUND["linear_r2.cos"]) == "0.99"
    assert FOUND["linear_r2.cos"].standard_error is None


def test_measures_are_reached_by_key_and_families_by_attribute():
    assert FOUND["linear_r2.cos"] == FOUND.linear_r2["cos"] == 0.99
    assert FOUND.trustworthiness[20] == 1.0
    assert FOUND.get("partial_motors") is None and len(FOUND) == 4
    with pytest.raises(AttributeError, match="has no 'partial_motors'; it has rank_correlation"):
        _ = FOUND.partial_motors


def test_what_is_undefined_is_left_out():
    assert "equivalence_ratio" not in FOUND
    added = FOUND.updated({"equivalence_ratio": 0.1, "rank_correlation": 0.5})
    assert (added.equivalence_ratio, added.rank_correlation, FOUND.rank_correlation) == (
        *(0.1, 0.5),
        0.98,
    )


def test_a_report_becomes_valid_json():
    stored = json.loads(json.dumps(FOUND.to_dict(), allow_nan=False))
    assert stored["rank_correlation"] == [0.98, 0.004]
    assert stored["linear_r2.cos"] == [0.99, None]
    infinite = FOUND.updated({"metric_error": float("inf")}).to_dict()
    assert infinite["metric_error"] == [None, None]


def test_a_report_prints_labels_values_and_what_is_perfect():
    lines = str(FOUND).splitlines()
    assert lines[0] == "400 points, weight of orientation 1.4"
    assert lines[2].split() == ["measure", "value", "std.", "error", "perfect", "chance"]
    assert lines[3].split() == ["rank", "correlation", "0.98", "0.004", "1", "0"]


def test_a_report_can_be_copied_and_sent():
    for again in (copy.deepcopy(FOUND), sent(FOUND)):
        assert again == FOUND and again.rank_correlation.standard_error == 0.004


def test_the_mean_over_subsets_and_its_standard_error():
    values = iter([1.0, 2.0, 3.0])
    found = over_subsets(lambda rows: {"x": next(values)}, [np.arange(2)] * 3)
    assert found["x"] == 2.0
    assert found["x"].standard_error == pytest.approx(1 / np.sqrt(3))


def test_every_measure_of_a_report_is_in_the_table():
    rng = np.random.default_rng(0)
    groups = np.repeat(np.arange(50), 3)
    displacements = rng.normal(size=(50, 3))[groups]
    codes = displacements + 0.1 * rng.normal(size=(150, 3))
    found = topology(codes, displacements, rng.normal(size=(150, 4)))
    assert {"equivalence_auc", "partial_motors", "linear_r2.worst"} <= set(found)
    assert all(measure(key).label for key in found)
    assert found["linear_r2.worst"] == min(found.linear_r2.values())
