"""The one table of measures: what every number in a report or a result is called and means.

Reports and results hold {key: number}. Tables, figures, targets and the documentation look a key
up here, so that nobody else spells a label, a unit or a perfect value. The table itself is
`measures.toml`, beside this file.
"""

import re
import tomllib
from dataclasses import dataclass, replace
from difflib import get_close_matches
from importlib.resources import files
from typing import Literal

from motorspace._errors import UserError


@dataclass(frozen=True)
class Measure:
    """One measure: its key, and how people read its values.

    A key with a field in braces, as in `trustworthiness.{k}`, stands for a family of measures.
    """

    key: str
    """Dotted slug, as results hold it."""
    label: str
    """What tables and figures call it."""
    meaning: str = ""
    """One sentence for the documentation."""
    goal: Literal["high", "low", "near", "none"] = "none"
    """Whether high values are better, low ones, or those near the perfect one."""
    perfect: float | None = None
    """The value of codes with perfect structure, or of predictions without error."""
    chance: float | None = None
    """The value of codes that have nothing to do with displacement."""
    unit: str = ""
    """What it is measured in; empty for plain numbers."""
    log_scale: bool = False
    """Whether figures show it on a logarithmic scale."""
    arbitrary_sign: bool = False
    """Whether its sign is a convention: aggregate magnitudes."""

    @property
    def title(self) -> str:
        """The label with its unit, for an axis or the head of a column."""
        return f"{self.label} ({self.unit})" if self.unit else self.label

    def shortfall(self, value: float) -> float:
        """Returns a number to rank values by: the less, the better.

        Args:
            value: A value of this measure.

        Raises:
            UserError: For a measure of which no value is better than another.

        Example:
            >>> dimension = measure("intrinsic_dimension")
            >>> dimension.shortfall(3.2) < dimension.shortfall(2.5)
            True
        """
        size = abs(value) if self.arbitrary_sign else value
        if self.goal == "near" and self.perfect is not None:
            return abs(size - self.perfect)
        if self.goal in ("high", "low"):
            return -size if self.goal == "high" else size
        raise UserError(
            f"no value of {self.key} is better than another",
            remedy="rank by another measure, for example prediction.error",
        )


FIELDS = {
    "component": "longitudinal|lateral|cos|sin|worst",
    "kind": "[a-z_0-9]+",
    "map": "linear|bilinear|network",
    "side": "left|right",
}
"""What may stand for a field of a family; any other field is a whole number."""

PREFIXES = {
    r"standard\.(?P<rest>.+)": "{label}, standard form",
    r"epoch\.(?P<epoch>\d+)\.(?P<rest>.+)": "{label}, epoch {epoch}",
}
"""Circumstances in which any measure may be taken: of codes in standard form, at an epoch."""


def _read_table() -> dict[str, Measure]:
    rows = tomllib.loads(files(__package__).joinpath("measures.toml").read_text("utf-8"))
    return {key: Measure(key, **row) for key, row in rows.items()}


_defined = _read_table()


def measure(key: str) -> Measure:
    """Returns the measure of a key, with its label filled in for a member of a family.

    Args:
        key: A dotted slug, as results hold it.

    Raises:
        UserError: For a key that no measure has.

    Example:
        >>> measure("trustworthiness.20").label
        'trustworthiness, k = 20'
        >>> measure("standard.linear_r2.cos").label
        'linear R², cos, standard form'
    """
    found = _defined.get(key) or _under_prefix(key) or _member(key)
    if found is None:
        near = get_close_matches(key, _defined, 3)
        raise UserError(
            f"there is no measure {key!r}" + (f" (perhaps {', '.join(near)})" if near else ""),
            remedy="choose a key that a report or a result holds, or define the measure with"
            " motorspace.analysis.measures.define",
        )
    return found


def measures() -> tuple[Measure, ...]:
    """Returns every measure that is defined, families by their pattern, in the table's order."""
    return tuple(_defined.values())


def define(*added: Measure) -> None:
    """Adds measures to the table, as a study does with its own.

    Args:
        added: The measures; defining the same again changes nothing.

    Raises:
        UserError: For a key that already stands for another measure.
    """
    for one in added:
        if _defined.setdefault(one.key, one) != one:
            raise UserError(
                f"there already is another measure {one.key!r}", remedy="choose another key"
            )


def _under_prefix(key: str) -> Measure | None:
    for pattern, label in PREFIXES.items():
        if match := re.fullmatch(pattern, key):
            rest = measure(match["rest"])
            return replace(rest, key=key, label=label.format(label=rest.label, **match.groupdict()))
    return None


def _member(key: str) -> Measure | None:
    for family in _defined.values():
        if "{" in family.key and (match := _pattern(family.key).fullmatch(key)):
            words = {name: value.replace("_", " ") for name, value in match.groupdict().items()}
            return replace(family, key=key, label=family.label.format(**words))
    return None


def _pattern(family: str) -> re.Pattern[str]:
    """`trustworthiness.{k}` as a regular expression."""
    fields = re.sub(
        r"\\\{(\w+)\\\}",
        lambda field: f"(?P<{field[1]}>{FIELDS.get(field[1], '[0-9]+')})",
        re.escape(family),
    )
    return re.compile(fields)
