"""Tables of numbers as text, however their columns are separated."""

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from motorspace._errors import UserError

MISSING = ("", "na", "n/a", "nan", "null", "none")
"""Cells that hold no number, and become NaN."""
TRUTH = {"false": 0.0, "true": 1.0}


def text_table(content: bytes, where: Path) -> dict[str, np.ndarray]:
    """Returns the columns of a table by name, or by number where no line of names is above.

    Columns are separated by commas, semicolons, tabs or spaces; all but the first allow decimal
    commas. Lines that are empty or begin with # are skipped. A cell without a number is NaN.

    Args:
        content: The text, in UTF-8 or Latin-1.
        where: Its file, for messages.

    Raises:
        UserError: For lines of different lengths, and for cells that hold something else.
    """
    lines = list(_lines(content))
    cells = _cells([line for _, line in lines])
    named = bool(cells) and _are_names(cells[0])
    if len(cells) <= named:
        raise UserError("the file holds no numbers", where=where, remedy="write the file again")
    names = [str(i) for i in range(len(cells[0]))]
    rows = [(number, row) for (number, _), row in zip(lines, cells, strict=True)]
    if named:
        names, rows = _distinct(cells[0]), rows[1:]
    numbers = [_numbers(row, len(names), f"line {line}", where) for line, row in rows]
    table = np.array(numbers, np.float64).reshape(len(rows), len(names))
    return dict(zip(names, table.T, strict=True))


def _lines(content: bytes) -> Iterator[tuple[int, str]]:
    """The lines that hold something, by number."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    for number, line in enumerate(text.splitlines(), 1):
        if line.strip() and not line.lstrip().startswith("#"):
            yield number, line


def _are_names(row: Sequence[str]) -> bool:
    """Whether it is the line of names, which pandas numbers from 0 where there are none."""
    numbered = row[1:] if row[0] == "" else row
    counted = [str(i) for i in range(len(numbered))]
    return any(_number(c) is None for c in row) or (len(row) > 1 and numbered == counted)


def _distinct(names: Sequence[str]) -> list[str]:
    return [n if names.count(n) == 1 else f"{n}.{i}" for i, n in enumerate(names)]


def _cells(lines: Sequence[str]) -> list[list[str]]:
    """The cells of each line, with decimal points, without an empty last column."""
    delimiter = max(";\t,", key=lambda d: sum(d in line for line in lines))
    if not any(delimiter in line for line in lines):
        delimiter = ""
    split = csv.reader(lines, delimiter=delimiter) if delimiter else map(str.split, lines)
    rows = [[cell.strip() for cell in row] for row in split]
    if delimiter and all(row[-1] == "" for row in rows):
        rows = [row[:-1] for row in rows]
    if delimiter != ",":
        rows = [[cell.replace(",", ".") for cell in row] for row in rows]
    return rows


def _numbers(row: Sequence[str], size: int, line: str, where: Path) -> list[float]:
    if len(row) != size:
        raise UserError(
            f"{line} has {len(row)} values, and the first has {size}",
            where=where,
            remedy="give equally many in every line",
        )
    numbers = []
    for cell in row:
        if (number := _number(cell)) is None:
            raise UserError(
                f"{line} holds {cell!r}, which is no number",
                where=where,
                remedy="give a table of numbers, with at most one line of names above",
            )
        numbers.append(number)
    return numbers


def _number(cell: str) -> float | None:
    if cell.lower() in MISSING:
        return float("nan")
    if cell.lower() in TRUTH:
        return TRUTH[cell.lower()]
    try:
        return float(cell)
    except ValueError:
        return None
