"""What is claimed of the rates."""

from collections.abc import Mapping, Sequence
from typing import Any

from benchmarks.suites import Goal, goals
from motorspace.reports.tables import shown
from motorspace.studies.rows import Row, Spread
from motorspace.studies.study import Line, Target
from motorspace.studies.targets import Claim, Reason, explained


class Launches(Spread):
    """Lowest, median and highest over launches; tables show the median."""

    @property
    def mean(self) -> float:
        """The median."""
        return sorted(self.values)[len(self.values) // 2]

    @property
    def ends(self) -> dict[str, float]:
        """The median, without a range."""
        return {"mean": self.mean, "low": self.mean, "high": self.mean}


def claims(rows: Sequence[Mapping[str, Any]], reasons: Sequence[Reason] = ()) -> list[Claim]:
    """Every target that is measured in `rows`, with the reasons for those that are missed."""
    found = [(row, goal) for row in rows for goal in goals() if goal.fits(row)]
    beside_peers_first = sorted(found, key=lambda pair: bool(pair[1].claim))
    return [explained(_claim(row, goal), reasons) for row, goal in beside_peers_first]


def _claim(row: Mapping[str, Any], goal: Goal) -> Claim:
    rate = f"{row['work']}, {row['threads']} threads: rate over that of {row['peer']}"
    named = f"{goal.claim or rate}" + f", in {goal.measure}" * (goal.measure != "ratio")
    target = Target(named, goal.measure, goal.at_least, goal.at_most, every_seed=True)
    return Claim(target, Row("benchmarks", {}, 0, {}), _measured(row, goal))


def _measured(row: Mapping[str, Any], goal: Goal) -> Launches:
    match goal.measure:
        case "ratio":
            return launches(row["ratio"])
        case "GiB":
            return launches(row["peak GiB"])
    second = 1.0 if goal.measure == "seconds" else 1 / 60
    return Launches(tuple(goal.amount / r * second for r in launches(row[goal.side]).values))


def launches(spread: Mapping[str, float]) -> Launches:
    """The launches behind a median and its range."""
    return Launches((spread["low"], spread["median"], spread["high"]))


def tables(rows: Sequence[Mapping[str, Any]], found: Sequence[Claim]) -> dict[str, Sequence[Line]]:
    """The tables of the documentation, from what `make bench` has measured and all claims."""
    return {
        "benchmarks": [_rates(row) for row in rows],
        "benchmarks_short": [_medians(row) for row in rows if _shown(row)],
        "performance_targets": [
            {"target": c.sentence, "measured": c.measured.mean, "range": _range(c), "met": c.met}
            for c in found
        ],
        "performance_missed": [
            {"target": c.sentence, "measured": c.measured.mean, "reason": c.reason}
            for c in found
            if not c.met
        ],
    }


def _shown(row: Mapping[str, Any]) -> bool:
    return any(goal.shown and goal.fits(row) for goal in goals())


def rounded(rate: float) -> str:
    """A rate to three digits."""
    return f"{float(f'{rate:.3g}'):,.0f}" if rate >= 1000 else shown(rate)


def _medians(row: Mapping[str, Any]) -> Line:
    return {
        "work": row["work"],
        "unit": f"{row['unit']}/s",
        "motorspace": rounded(row["ours"]["median"]),
        "peer": row["peer"],
        "its rate": rounded(row["theirs"]["median"]),
        "ratio": row["ratio"]["median"],
    }


def _rates(row: Mapping[str, Any]) -> Line:
    """Ours beside a peer, the median and the range over launches."""

    def spread(values: Mapping[str, float]) -> str:
        low, median, high = map(rounded, launches(values).values)
        return f"{median} ({low} to {high})"

    return {
        "work": row["work"],
        "threads": row["threads"],
        "vectors": row["processor"].split(", ")[-1],
        "unit": f"{row['unit']}/s",
        "motorspace": spread(row["ours"]),
        "peer": row["peer"],
        "its rate": spread(row["theirs"]),
        "ratio": spread(row["ratio"]),
    }


def _range(claim: Claim) -> str:
    low, high = map(shown, claim.measured.range)
    return f"{low} to {high}"
