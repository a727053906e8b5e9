"""Targets of studies, judged by their rows; why those that are missed are missed."""

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace.studies.rows import Row, Spread
from motorspace.studies.study import Line, Study, Target

UNKNOWN = "not known"


@dataclass(frozen=True)
class Claim:
    """A target in one cell."""

    target: Target
    row: Row
    measured: Spread
    reason: str = ""
    """Why it is missed."""

    @property
    def met(self) -> bool:
        """Whether the target is reached."""
        return self.target.met(self.measured)

    @property
    def sentence(self) -> str:
        """The target with its bound."""
        return f"{self.target.claim}: {self.target.bound}"


@dataclass(frozen=True)
class Reason:
    """Why a target is missed in some cells: an entry of `targets.toml`."""

    study: str
    claim: str
    measure: str
    bound: str
    reason: str
    cells: Mapping[str, Any]
    """The settings that these cells have; a list stands for any of its values."""

    def explains(self, claim: Claim) -> bool:
        """Whether it is about this claim."""
        target = claim.target
        ours = (claim.row.study, target.claim, target.measure, target.bound)
        cells = {n: tuple(v) if isinstance(v, list) else v for n, v in self.cells.items()}
        return ours == (self.study, self.claim, self.measure, self.bound) and (
            claim.row.matches(cells)
        )


def read_reasons(path: Path) -> list[Reason]:
    """The reasons in a file. Raises `UserError` when it is broken."""
    try:
        entries = tomllib.loads(path.read_text())["missed"] if path.exists() else []
        return [Reason(**{"cells": {}} | entry) for entry in entries]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(f"the reasons cannot be read ({error})", where=path) from None


def claims(study: Study, rows: Iterable[Row], reasons: Sequence[Reason] = ()) -> list[Claim]:
    """Every target of a study in each cell that it is for and that has the measure."""
    made = [
        Claim(target, row, measured)
        for row in rows
        for target in study.targets
        if row.study == study.name and row.matches(target.cells)
        if (measured := row.get(target.measure))
    ]
    return [explained(claim, reasons) for claim in made]


def explained(claim: Claim, reasons: Sequence[Reason]) -> Claim:
    """The claim with the reason why it is missed, if it is."""
    if claim.met:
        return claim
    known = (reason.reason for reason in reasons if reason.explains(claim))
    return replace(claim, reason=next(known, UNKNOWN))


def complaints(found: Sequence[Claim], reasons: Sequence[Reason]) -> list[str]:
    """A sentence for each missed target without a reason, and each reason without such a one."""
    missed = [claim for claim in found if not claim.met]
    return [
        f"{claim.row.study} {claim.row.name}: no reason why {claim.target.claim} is missed"
        for claim in missed
        if claim.reason == UNKNOWN
    ] + [
        f"{known.study}: nothing is missed that the reason for {known.claim!r} explains"
        for known in reasons
        if not any(known.explains(claim) for claim in missed)
    ]


def missed_lines(found: Iterable[Claim]) -> list[Line]:
    """The targets that are missed: one line for each claim, cell by cell."""
    return [
        {
            "cell": claim.row.name,
            "target": claim.sentence,
            "measured": claim.measured.ends,
            "seeds": len(claim.measured.values),
            "reason": claim.reason,
        }
        for claim in found
        if not claim.met
    ]


def reached_lines(found: Iterable[Claim]) -> list[Line]:
    """In how many cells each target is reached."""
    by_target: dict[str, list[Claim]] = {}
    for claim in found:
        by_target.setdefault(claim.sentence, []).append(claim)
    return [
        {"target": target, "cells": len(cells), "reached in": sum(claim.met for claim in cells)}
        for target, cells in by_target.items()
    ]


def all_lines(found: Iterable[Claim]) -> list[Line]:
    """Every claim, and whether it is met."""
    return [
        {
            "study": claim.row.study,
            "cell": claim.row.name,
            "target": claim.sentence,
            "measured": claim.measured.ends,
            "seeds": len(claim.measured.values),
            "met": claim.met,
        }
        for claim in found
    ]
