"""What a table of one row per time step holds: its columns by name, whatever its format."""

import math
import re
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

POSE = ("x", "y", "theta")

USED = re.compile(r"time|x|y|theta|(motor|sensor)s?([\s_./:\-\[(].*|\d+)?")
"""Names of columns that are read, without their case and their unit."""

UNIT = re.compile(r"\s*[\[(](?!\d+[\])]$).*[\])]$")

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


def plain_name(name: str) -> str:
    """A column's name without its case, its unit in brackets, quotes and spaces around it."""
    return UNIT.sub("", name.strip().strip("\"'").lower())


def is_used(name: str) -> bool:
    """Whether a column of this plain name is read."""
    return USED.fullmatch(name) is not None


def value(word: str) -> float | None:
    """The number in a cell with a decimal point; NaN if it is missing, None if it is no number."""
    word = word.strip()
    try:
        return float(word)
    except ValueError:
        if word.lower() in MISSING:
            return math.nan
        return TRUTH.get(word.lower())


def with_point(word: str) -> str:
    """A cell with a decimal comma as one with a decimal point, and no signs between its digits."""
    comma, point = word.rfind(","), word.rfind(".")
    if point > comma >= 0 or word.count(",") > 1:
        return word.replace(",", "")
    return word.replace(".", "").replace(",", ".") if comma >= 0 else word


def seconds(word: str) -> float | None:
    """Seconds since 1970 of a date and time in ISO 8601, UTC where it names no zone."""
    try:
        moment = datetime.fromisoformat(word.strip())
    except ValueError:
        return None
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
