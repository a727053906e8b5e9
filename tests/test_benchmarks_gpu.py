"""What is measured on a GPU: every row is kept, whatever becomes of the others."""

import json
import math
import sys
import time
from dataclasses import replace
from types import SimpleNamespace

import jax
import pytest

from benchmarks.gpu import __main__ as gpu
from benchmarks.gpu import report
from benchmarks.gpu.sizes import SMALL
from benchmarks.gpu.timing import Skipped, rate, timed, value
from benchmarks.gpu.training import counted
from benchmarks.gpu.whole_table import compilations


@pytest.fixture(autouse=True)
def environment(monkeypatch):
    monkeypatch.setenv("XLA_PYTHON_CLIENT_PREALLOCATE", "false")


def test_without_a_gpu_it_is_skipped_with_one_sentence(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(jax, "default_backend", lambda: "cpu")
    gpu.main(["scans", "--out", str(tmp_path / "gpu.json")])
    said = capsys.readouterr().out
    assert said.startswith("benchmarks.gpu: skipped, since JAX sees no GPU")
    assert said.count("\n") == 1 and not list(tmp_path.iterdir())


def test_packages_that_are_missing_are_named(monkeypatch):
    monkeypatch.setattr(gpu, "NEEDED", ("jax", "no_such_package"))
    assert gpu.lacks(small=True) == "these packages are not installed: no_such_package"


def test_an_unknown_part_is_refused(capsys):
    with pytest.raises(SystemExit) as left:
        gpu.main(["scan", "--small"])
    assert left.value.code == 2 and "no part scan" in capsys.readouterr().err


def good(sizes):
    yield lambda: value("good", "1", 2.0, "apples", beside="better")
    yield lambda: value("better", "1", 4.0, "apples")


def bad(sizes):
    yield lambda: value("bad", "1", 1.0, "apples")
    yield lambda: [][1]
    yield lambda: value("bad", "2", 3.0, "apples")
    raise Skipped("the rest is missing")


@pytest.fixture
def toys(monkeypatch):
    monkeypatch.setitem(sys.modules, "benchmarks.gpu.toy", SimpleNamespace(good=good, bad=bad))
    monkeypatch.setattr(gpu, "PARTS", {"bad": "toy", "good": "toy"})


def test_what_fails_does_not_lose_the_others(toys, tmp_path, capsys):
    out = tmp_path / "new" / "gpu.json"
    gpu.main(["--small", "--out", str(out)])
    kept = json.loads(out.read_text())
    rates = [row.get("rate", row.get("reason", "")[:7]) for row in kept["rows"]]
    assert rates == [1.0, "failed:", 3.0, "skipped", 2.0, 4.0]
    assert set(kept["measured"]) == {"bad", "good"}
    _, table = capsys.readouterr().out.split("\n\n")
    assert "bad: failed: IndexError: list index out of range\n" in table
    assert table.splitlines()[0].split() == " | ".join(report.COLUMNS).split()
    assert table.splitlines()[-2].split(" | ")[-2:] == ["better", "0.500"]


def test_parts_that_are_named_replace_just_their_rows(toys, tmp_path, monkeypatch):
    out = tmp_path / "gpu.json"
    gpu.main(["--small", "--out", str(out)])
    again = SimpleNamespace(good=lambda sizes: iter([lambda: value("good", "2", 7.0, "pears")]))
    monkeypatch.setitem(sys.modules, "benchmarks.gpu.toy", again)
    gpu.main(["good", "--small", "--out", str(out)])
    rows = json.loads(out.read_text())["rows"]
    assert [row["part"] for row in rows] == ["bad"] * 4 + ["good"]
    assert rows[-1]["rate"] == 7.0


def test_a_row_stands_beside_its_bound_or_the_row_that_it_names():
    rows = [
        {"part": "p"} | row
        for row in (
            *value("a", "1 run", 2.0, "x", beside="b"),
            *value("b", "2 runs", 8.0, "x"),
            *value("b", "1 run", 4.0, "x", beside="b, 2 runs"),
            *value("c", "1 run", 3.0, "x", beside="a limit", bound=6.0),
            *value("d", "1 run", 3.0, "x", beside="what was not measured"),
        )
    ]
    found = [row["ratio"] for row in report.with_ratios(rows)]
    assert found == [0.5, None, 0.5, 0.5, None]


def test_the_median_counts_and_the_range_is_kept():
    timing = timed(lambda: time.sleep(0.002), replace(SMALL, seconds=0.02))
    assert 0.002 <= timing.low <= timing.median <= timing.high
    (row,) = rate("sleep", "1", 10.0, "naps/s", timing)
    assert row["low"] <= row["rate"] <= row["high"] and row["rate"] <= 5000


def test_compilations_are_counted_while_they_are_watched():
    with compilations() as seconds:
        jax.jit(lambda x: x + 12345).lower(1).compile()
    num = len(seconds)
    jax.jit(lambda x: x + 54321).lower(1).compile()
    assert len(seconds) == num >= 1 and min(seconds) > 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("part", "num"),
    [("trajectories", 3), ("scans", 7), ("training", 4), ("precision", 6), ("roofline", 11)],
)
def test_a_small_trial_gives_finite_rates(part, num, capsys):
    gpu.main([part, "--small"])
    rows = capsys.readouterr().out.split("\n\n")[1].splitlines()[2:]
    rates = [float(row.split(" | ")[2].replace(",", "")) for row in rows]
    assert len(rates) == num and all(math.isfinite(rate) and rate > 0 for rate in rates)


@pytest.mark.slow
def test_a_small_table_says_its_seconds_its_programs_and_its_losses(tmp_path):
    out = tmp_path / "gpu.json"
    gpu.main(["table", "--small", "--epochs", "1", "--out", str(out)])
    rows = json.loads(out.read_text())["rows"]
    assert [row["unit"] for row in rows].count("s") == 6
    losses = [row for row in rows if row["unit"] == "sensor units²"]
    assert [len(row["losses"]) for row in losses] == [SMALL.seeds] * 2
    assert all("1 epoch" in row["size"] for row in rows if row["unit"] == "s")


def test_numbers_of_things_are_words():
    assert (counted(1), counted(1024)) == ("1 run", "1,024 runs")
