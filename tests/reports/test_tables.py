"""Tables: numbers as people read them, columns by key."""

import numpy as np
import pytest

from motorspace.analysis.report import Estimate
from motorspace.reports.tables import (
    interval_of,
    markdown_table,
    measured_rows,
    number,
    report_rows,
    shown,
)


def about(mean, half):
    return {"mean": mean, "low": mean - half, "high": mean + half}


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (True, "yes"),
        (3, "3"),
        (12345, "12,345"),
        ("words", "words"),
        (0.12345, "0.123"),
        (np.float32(0.5), "0.500"),
        (3.0, "3"),
        (float("nan"), "nan"),
        (1234.5, "1,234"),
        (0.000123, "1.23e-4"),
        (-0.000123, "-1.23e-4"),
        (about(3.803, 0.02), "3.80 ± 0.02"),
        (about(0.9967, 0.0004), "0.997 ± 0.0004"),
        (about(0.99952, 0.000007), "1.000 ± 7e-6"),
        (about(123.4, 25.0), "123 ± 25"),
        (about(12345.0, 500.0), "12,345 ± 500"),
        (about(0.0, 0.1), "0.00 ± 0.10"),
        (about(1.3e-5, 2.6e-6), "1.30e-5 ± 3e-6"),
        (about(1.0, 0.0), "1"),
    ],
)
def test_values_are_shown_in_three_digits_with_half_their_interval(value, text):
    assert shown(value) == text


def test_numbers_of_every_size():
    shown_as = {0.0: "0", 1e10: "10,000,000,000", -2.5: "-2.50", 0.001: "0.00100", 12.34: "12.3"}
    assert {value: number(value) for value in shown_as} == shown_as


def test_what_is_an_interval():
    assert interval_of(about(2.0, 0.5)).half_width == 0.5
    assert interval_of(2).mean == 2.0
    assert interval_of(True) is None and interval_of("2") is None and interval_of(None) is None


def test_markdown():
    rows = [{"cell": "a|b", "error": about(2.344, 0.2)}, {"cell": "b", "error": None}]
    table = markdown_table(rows)
    assert table.splitlines()[2:] == ["| a\\|b | 2.34 ± 0.20 |", "| b | – |"]
    assert markdown_table([]) == ""


def test_columns_of_measures_are_called_by_their_labels():
    rows = [{"agent": "forward", "length_error.translation.6": 0.1}]
    assert measured_rows(rows, ["agent"], ["length_error.translation.6", "rank_correlation"]) == [
        {
            "agent": "forward",
            "translation error, T = 6 (world units)": 0.1,
            "rank correlation": None,
        }
    ]


def test_a_report_is_a_table_of_what_it_measured():
    first, second = report_rows({"rank_correlation": Estimate(0.9, 0.01), "seam_gap": 2.0})
    assert first["measure"] == "rank correlation" and shown(first["value"]) == "0.900 ± 0.010"
    assert (first["perfect"], first["chance"]) == ("1", "0")
    assert shown(second["value"]) == "2" and second["chance"] == ""
