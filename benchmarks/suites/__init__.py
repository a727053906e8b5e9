"""The suites. Each is a module of this folder, with its launches and targets in the file beside it:
`sensing.py` and `sensing.toml`.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Literal

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Setup:
    """How a suite is launched."""

    threads: int
    settings: Mapping[str, str] = field(default_factory=dict)
    """Environment variables that it reads."""


@dataclass(frozen=True)
class Goal:
    """What a suite is to reach: at least so much, or at most."""

    work: str
    """The piece of work, as its rows name it."""
    claim: str = ""
    """What is claimed; by default of our rate over that of the peer."""
    threads: int | None = None
    peer: str | None = None
    measure: Literal["ratio", "seconds", "minutes", "GiB"] = "ratio"
    """Our rate over the peer's, the time for an amount of work, or the most memory."""
    side: Literal["ours", "theirs"] = "ours"
    """Whose time."""
    amount: float = 1.0
    """Units of work whose time is meant."""
    at_least: float | None = None
    at_most: float | None = None
    shown: bool = False
    """Whether the short table of the documentation has this row."""

    def fits(self, row: Mapping[str, Any]) -> bool:
        """Whether it is about a row of the results."""
        return (
            self.work == row["work"]
            and self.threads in (None, row["threads"])
            and self.peer in (None, row["peer"])
        )


def suites() -> list[str]:
    """Every suite by its name."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def setups(suite: str) -> list[Setup]:
    """How a suite is launched."""
    return [Setup(**entry) for entry in _file(suite)["launches"]]


def goals() -> list[Goal]:
    """What all suites are to reach."""
    return [Goal(**entry) for suite in suites() for entry in _file(suite).get("targets", ())]


@cache
def _file(suite: str) -> dict[str, Any]:
    return tomllib.loads((FOLDER / f"{suite}.toml").read_text())
