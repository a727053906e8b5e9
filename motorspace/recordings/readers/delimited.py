"""Tables as text: comma, semicolon, tab or space between the cells."""

import csv
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.recordings.readers.about import about_in
from motorspace.recordings.readers.columns import (
    DECIMAL_COMMA,
    MISSING,
    Table,
    check_names,
    is_used,
    plain_name,
    seconds,
    value,
    with_point,
)
from motorspace.recordings.readers.faults import Faults
from motorspace.recordings.readers.text import read_text

Separator = Literal["auto", "comma", "semicolon", "tab", "bar", "space"]
Decimal = Literal["auto", "point", "comma"]

SIGNS = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|", "space": " "}


class Header(NamedTuple):
    """The row of names."""

    line: int
    separator: str
    names: list[str]
    """Plain names, as many as there are columns."""


def read_delimited(path: Path, faults: Faults, *, separator: Separator, decimal: Decimal) -> Table:
    """The table in a text file.

    A row that is broken goes to `faults`; if these go on, it has no values, so that no transition
    crosses it. Raises `UserError` for all other faults.
    """
    lines = read_text(path, faults).splitlines()
    header = find_header(lines, separator)
    if header is None:
        raise UserError("the table is empty", where=path, remedy="begin with a row of names")
    check_names(header.names, where=path)
    notes: list[str] = []
    rows, numbers = _rows(lines, header, notes, faults, where=path)
    used = [index for index, name in enumerate(header.names) if is_used(name)]
    if rows and (units := _units(rows[0], used)):
        notes.append(f"line {numbers[0]} holds units ({units})")
        rows, numbers = rows[1:], numbers[1:]
    places = [f"{path}, line {number}" for number in numbers]
    comma = _decimal_comma(rows, used, decimal, where=path)
    columns = {}
    for index in used:
        words = [row[index] for row in rows]
        columns[header.names[index]] = _numbers(words, header.names[index], comma, places, faults)
    ignored = [name or "without a name" for name in header.names if not is_used(name)]
    dated = any(seconds(row[index]) is not None for row in rows[:1] for index in used)
    return Table(columns, ignored, places, notes, dated, about_in(lines, where=path))


def find_header(lines: list[str], separator: Separator = "auto") -> Header | None:
    """The first row that is neither blank nor a comment, or a comment that names columns."""
    for number, line in enumerate(lines):
        if not line.strip() or line.lower().startswith("sep="):
            continue
        found = _header(number, line.lstrip("# "), separator)
        if not line.lstrip().startswith("#") or sum(map(is_used, found.names)) > 1:
            return found
    return None


def _header(number: int, line: str, separator: Separator) -> Header:
    signs = SIGNS.values() if separator == "auto" else (SIGNS[separator],)

    def score(names: list[str]) -> tuple[int, int]:
        return sum(map(is_used, names)), len(names)

    split = {sign: [plain_name(cell) for cell in _split(line, sign)] for sign in signs}
    best = max(split, key=lambda sign: score(split[sign]))
    names = split[best]
    while len(names) > 1 and not names[-1]:
        names.pop()
    return Header(number, best, names)


def _split(line: str, sign: str) -> list[str]:
    return (
        line.split()
        if sign == " "
        else next(csv.reader([line], delimiter=sign, skipinitialspace=True), [])
    )


def _rows(
    lines: list[str], header: Header, notes: list[str], faults: Faults, *, where: object
) -> tuple[list[list[str]], list[int]]:
    """The rows with a cell for every column, and their line numbers."""
    rows: list[list[str]] = []
    numbers: list[int] = []
    repeated = 0
    num = len(header.names)
    last = max(index for index, line in enumerate(lines) if line.strip()) + 1
    for number, cells in _cells(lines, header, faults, where=where):
        if not any(cell.strip() for cell in cells) or cells[0].lstrip().startswith("#"):
            continue
        again = plain_name(cells[0]) == header.names[0]
        if again and [plain_name(cell) for cell in cells[:num]] == header.names:
            repeated += 1
            continue
        while len(cells) > num and not cells[-1].strip():
            cells = cells[:-1]
        if len(cells) < num and number == last and rows:
            notes.append(f"line {number}, the last one, is cut off: left out")
            continue
        if len(cells) != num:
            faults.add(_ragged(len(cells), header, f"{where}, line {number}"))
            cells = [""] * num
        rows.append(cells)
        numbers.append(number)
    if repeated:
        notes.append(f"the row of names is repeated {repeated} times")
    return rows, numbers


def _cells(
    lines: list[str], header: Header, faults: Faults, *, where: object
) -> Iterator[tuple[int, list[str]]]:
    """The line number and the cells of every row after the header."""
    below = header.line + 1
    if header.separator == " ":
        for number, line in enumerate(lines[below:], start=below + 1):
            yield number, line.split()
        return
    reader = csv.reader(
        lines[below:], delimiter=header.separator, skipinitialspace=True, strict=True
    )
    try:
        for cells in reader:
            yield below + reader.line_num, cells
    except csv.Error as error:
        broken = UserError(
            f"the row cannot be split ({error}), so the rest of the table is lost",
            where=f"{where}, line {below + reader.line_num}",
            remedy="check its quotes",
        )
        faults.add(broken)


def _ragged(found: int, header: Header, place: str) -> UserError:
    num = len(header.names)
    remedy = "complete the row: without it the motors that it names would be lost"
    if header.separator == "," and found > num:
        remedy = "if its numbers have decimal commas, put semicolons or tabs between the cells"
    return UserError(f"{found} values for {num} columns", where=place, remedy=remedy)


def _units(row: list[str], used: list[int]) -> str:
    """The cells of a row of units, joined; empty if it is a row of values."""
    words = [row[index].strip() for index in used]
    known = [word for word in words if not _is_text(word) and word.lower() not in MISSING]
    return ", ".join(words) if not known and any(map(_is_text, words)) else ""


def _is_text(word: str) -> bool:
    numbers = [value(with_point(word, comma=comma)) for comma in (False, True)]
    return numbers == [None, None] and seconds(word) is None


def _decimal_comma(
    rows: list[list[str]], used: list[int], decimal: Decimal, *, where: object
) -> bool:
    """Whether numbers have a decimal comma. Raises `UserError` where it is not clear."""
    if decimal != "auto":
        return decimal == "comma"
    words = [row[index].strip() for row in rows for index in used]
    comma = next((w for w in words if "," in w and DECIMAL_COMMA.fullmatch(w)), None)
    if comma is None:
        return False
    if point := next((w for w in words if "." in w and value(w) is not None), None):
        raise UserError(
            f"the decimal sign is not clear: there are {comma} and {point}",
            where=where,
            remedy="set decimal to comma or point",
        )
    return True


def _numbers(
    words: list[str], name: str, comma: bool, places: list[str], faults: Faults
) -> Float[np.ndarray, " N"]:
    """The numbers in a column, NaN where one is missing."""
    try:
        if not comma:
            return np.array(words, np.str_).astype(np.float64)
    except ValueError:  # a cell that is empty, grouped, a date, or wrong
        pass
    found = np.full(len(words), np.nan)
    for index, (word, place) in enumerate(zip(words, places, strict=True)):
        try:
            found[index] = _number(word, name, comma, place)
        except UserError as error:
            faults.add(error)
    return found


def _number(word: str, name: str, comma: bool, place: str) -> float:
    """The number in a cell, NaN where it is missing. Raises `UserError` for other words."""
    found = value(with_point(word, comma=comma))
    if found is None and name == "time":
        found = seconds(word)
    if found is None and name == "time":
        return math.nan
    if found is None:
        raise UserError(
            f"{word.strip()!r} is not a number (column {name})",
            where=place,
            remedy="correct it, or leave the cell empty: transitions that need it are left out",
        )
    return found
