"""The file of results and the table that is printed last."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.gpu.timing import Row
from motorspace._files import write_json
from motorspace.reports.tables import number

COLUMNS = ("work", "size", "rate", "unit", "beside", "ratio")
COMMAND = "python -m benchmarks.gpu"


class Results:
    """Rows by part, in a file where there is one; parts that are measured anew replace theirs."""

    def __init__(self, out: Path | None) -> None:
        self.out = out
        kept: dict[str, Any] = json.loads(out.read_text()) if out and out.exists() else {}
        self.measured: dict[str, dict[str, Any]] = kept.get("measured", {})
        self.rows: list[Row] = kept.get("rows", [])

    def begin(self, part: str, described: dict[str, Any]) -> None:
        """Forget a part's rows of before, and note on what it is measured now."""
        self.rows = [row for row in self.rows if row["part"] != part]
        self.measured[part] = described

    def add(self, part: str, rows: Sequence[Row]) -> None:
        """Keep more rows of a part, in the file too."""
        self.rows += [{"part": part} | dict(row) for row in rows]
        if self.out:
            self.out.parent.mkdir(parents=True, exist_ok=True)
            rows = with_ratios(self.rows)
            write_json(self.out, {"command": COMMAND, "measured": self.measured, "rows": rows})


def with_ratios(rows: Sequence[Row]) -> list[Row]:
    """Each row with its rate over its bound, or over that of the row of its part it is beside."""
    return [dict(row) | {"ratio": _ratio(row, rows)} for row in rows]


def _ratio(row: Row, rows: Sequence[Row]) -> float | None:
    against = row.get("bound") or _rate_beside(row, rows)
    return row["rate"] / against if against and "rate" in row else None


def _rate_beside(row: Row, rows: Sequence[Row]) -> float | None:
    """The rate of the row that is named, by work and size or else by work alone."""
    beside = row.get("beside")
    found = [other for other in rows if other["part"] == row["part"] and "rate" in other]
    exact = [r for r in found if beside == f"{r['work']}, {r['size']}"]
    same_size = [r for r in found if beside == r["work"] and r["size"] == row["size"]]
    same_work = [r for r in found if beside == r["work"]]
    return next((r["rate"] for r in (*exact, *same_size, *same_work)), None)


def table(rows: Sequence[Row]) -> str:
    """The rows as columns of text; what was not measured stands with its reason."""
    rows = with_ratios(rows)
    cells = [COLUMNS, *(_cells(row) for row in rows if "rate" in row)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = [_line(cells[0], widths), "-+-".join("-" * width for width in widths)]
    for row in rows:
        lines.append(_line(_cells(row), widths) if "rate" in row else reason(row))
    return "\n".join(lines)


def reason(row: Row) -> str:
    """A row that was not measured, as a sentence."""
    return f"{row['work']}: {row['reason']}"


def shown(row: Row) -> str:
    """A row on a line of its own."""
    if "rate" not in row:
        return reason(row)
    return f"{row['work']}, {row['size']}: {number(row['rate'])} {row['unit']}"


def _cells(row: Row) -> tuple[str, ...]:
    numbers = ["" if row[key] is None else number(row[key]) for key in ("rate", "ratio")]
    texts = (row["work"], row["size"], numbers[0], row["unit"], row.get("beside", ""))
    return (*texts, numbers[1])


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    aligned = [
        cell.rjust(width) if column in ("rate", "ratio") else cell.ljust(width)
        for cell, width, column in zip(cells, widths, COLUMNS, strict=True)
    ]
    return " | ".join(aligned).rstrip()
