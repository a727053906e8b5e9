"""A job: one run of a study as plain data, which travels to any process and any machine."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

Value = str | int | float
Cell = tuple[tuple[str, Value], ...]
"""The place of a run in its study: settings by name, in the order of the names."""

SLUG_LENGTH = 150
"""Characters of a cell in a folder's name: file systems allow 255 for all of it."""


@runtime_checkable
class Schedule(Protocol):
    """What a job needs to know about how its configuration trains."""

    @property
    def seed(self) -> int:
        """Seed of the run."""

    @property
    def epochs(self) -> int:
        """Epochs of the run."""


@runtime_checkable
class Configuration(Protocol):
    """What a job needs to know about its configuration (`RunConfig`)."""

    @property
    def training(self) -> Schedule:
        """Seed and epochs."""

    def as_json(self) -> dict[str, Any]:
        """Everything that determines the run."""

    def hash(self) -> str:
        """12 hexadecimal digits of the canonical JSON."""

    def program(self) -> str:
        """The same for runs that one compiled program may train."""


@dataclass(frozen=True)
class Job:
    """One run of a study: its place there, what it trains, and what it measures."""

    study: str
    """Name of the study: results go to STUDY.jsonl, runs to a folder of this name."""
    cell: Cell
    """The run's place in the study (see `cell`); its seed is in the configuration."""
    config: Configuration
    """Everything that determines the run."""
    measure: str = ""
    """Name of the function that measures the run, one of those that its study has registered."""
    trains: bool = True
    """False measures the network at its initial weights."""
    place: str = ""
    """Name of the run's folder, if it is not to be made from the cell."""

    @property
    def seed(self) -> int:
        """Seed of the run."""
        return self.config.training.seed

    @property
    def key(self) -> tuple[Cell, int, str]:
        """What identifies the run among the results of its study: cell, seed, configuration."""
        return self.cell, self.seed, self.config.hash()

    @property
    def folder(self) -> str:
        """Name of the run's folder within its study: `agent-forward_rotation-0.2_seed3_HASH`."""
        if self.place:
            return self.place
        slug = "_".join(f"{_slug(name)}-{_slug(shown(value))}" for name, value in self.cell)
        start = f"{slug[:SLUG_LENGTH]}_" if slug else ""
        return f"{start}seed{self.seed}_{self.config.hash()}"

    def __str__(self) -> str:
        return " ".join([described(self.cell), f"seed={self.seed}"]).strip()


def cell(settings: Mapping[str, Value] = {}, /, **more: Value) -> Cell:
    """A cell from its settings.

    >>> cell(rotation=0.2, agent="forward")
    (('agent', 'forward'), ('rotation', 0.2))
    """
    return tuple(sorted({**settings, **more}.items()))


def described(cell: Cell) -> str:
    """A cell for people.

    >>> described(cell(agent="forward", rotation=1.0))
    'agent=forward rotation=1'
    """
    return " ".join(f"{name}={shown(value)}" for name, value in cell)


def shown(value: Value) -> str:
    """A setting as people write it: 1.0 and 1 are the same."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def _slug(words: str) -> str:
    return re.sub(r"[^A-Za-z0-9.+-]+", "-", words).strip("-")
