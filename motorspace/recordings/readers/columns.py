"""What a table of one row per time step holds: its columns by name, whatever its format."""

import math
import re
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.recordings.readers.about import About

POSE = ("x", "y", "theta")

USED = re.compile(r"time|x|y|theta|(motor|sensor)s?([\s_./:\-\[(].*|\d+)?")
"""Names of columns that are read, without their case and their unit."""

UNIT = re.compile(r"\s*[\[(](?!\d+[\])]$).*[\])]$")

DECIMAL_COMMA = re.compile(r"[+-]?(\d*|\d{1,3}(\.\d{3})+),\d*([eE][+-]?\d+)?")
GROUPED_BY_POINT = re.compile(r"[+-]?\d{1,3}(\.\d{3})+")
GROUPED_BY_COMMA = re.compile(r"[+-]?\d{1,3}(,\d{3})+(\.\d*)?")

MISSING = {"", "na", "n/a", "#n/a", "nan", "null", "none", "nil", "-", "--", "?", "<na>"}

TRUTH = {"true": 1.0, "false": 0.0}


class Table(NamedTuple):
    """The columns that are read, as numbers; NaN where a value is missing."""

    columns: dict[str, Float[np.ndarray, " N"]]
    ignored: list[str]
    """Names of all other columns."""
    places: list[str]
    """Where each row is in the file."""
    notes: list[str]
    dated: bool
    """Whether time stands as dates, so that its unit is known to be the second."""
    about: About = About()


def plain_name(name: str) -> str:
    """A column's name without its case, its unit in brackets, quotes and spaces around it."""
    return UNIT.sub("", name.strip().strip("\"'").lower())


def is_used(name: str) -> bool:
    """Whether a column of this plain name is read."""
    return USED.fullmatch(name) is not None


def check_names(names: list[str], *, where: object) -> None:
    """Raise `UserError` unless the plain names of a table's columns are enough to learn from."""
    used = [name for name in names if is_used(name)]
    if not all(any(name.startswith(kind) for name in used) for kind in ("time", "motor", "sensor")):
        raise UserError(
            f"the columns are {', '.join(names[:12])}" + ", ..." * (len(names) > 12),
            where=where,
            remedy="a table needs time, at least one motor_* and at least one sensor_* column",
        )
    if repeated := sorted({name for name in used if used.count(name) > 1}):
        raise UserError(
            f"more than one column is named {', '.join(repeated)}",
            where=where,
            remedy="give every column its own name",
        )


def value(word: str) -> float | None:
    """The number in a cell with a decimal point; NaN if it is missing, None if it is no number."""
    word = word.strip()
    try:
        return float(word)
    except ValueError:
        if word.lower() in MISSING:
            return math.nan
        return TRUTH.get(word.lower())


def with_point(word: str, *, comma: bool) -> str:
    """A number in a cell with a decimal point, and without the signs that group its digits.

    A comma, or with a decimal comma a point, that does not group three digits makes it no number.
    """
    word = word.strip()
    if not comma and "," not in word:
        return word
    if comma and (DECIMAL_COMMA.fullmatch(word) or GROUPED_BY_POINT.fullmatch(word)):
        return word.replace(".", "").replace(",", ".")
    if not comma and GROUPED_BY_COMMA.fullmatch(word):
        return word.replace(",", "")
    return f"{word} with a decimal point" if comma and "." in word else word


def seconds(word: str) -> float | None:
    """Seconds since 1970 of a date and time in ISO 8601, UTC where it names no zone."""
    try:
        moment = datetime.fromisoformat(word.strip())
    except ValueError:
        return None
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
