"""The tables and figures of every study, made from the results: what the documentation shows.

Results of a configuration that no study has any more are stale: they are named, never shown.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from motorspace.reports.tables import markdown_table
from motorspace.running.jobs import described
from motorspace.running.store import Result, read_lines
from motorspace.studies import targets
from motorspace.studies.rows import (
    SYMBOLS,
    Row,
    Spread,
    known_measure,
    rows_of,
    setting,
)
from motorspace.studies.study import BUDGETS, Budget, Line, Study, studies, study_named

EMPTY = "Not measured yet.\n"
NONE_MISSED = "Every target that was set before is reached.\n"


def columns(
    *keys: str,
    heads: Mapping[str, str] = {},
    titles: Mapping[Any, str] = {},
    means: bool = False,
    cells: Mapping[str, Any] = {},
) -> Callable[[Sequence[Row]], list[Line]]:
    """What makes a table of rows, with a column for each key.

    Args:
        keys: Settings of the cells, keys of measures (mean and half the confidence interval over
            seeds), `"seeds"` or `"epochs"`.
        heads: {key: head of its column}; by default the label of the measure.
        titles: {value of a setting: what the table writes}.
        means: Write means alone, without the interval.
        cells: Settings of the rows that the table shows; by default all.
    """

    def value(row: Row, key: str) -> Any:
        if key in row.cell:
            return titles.get(row.cell[key], setting(key, row.cell[key]))
        found = {"seeds": len(row.runs), "epochs": row.epochs}.get(key, row.get(key))
        if isinstance(found, Spread):
            return found.mean if means else found.ends
        return found

    def head(key: str) -> str:
        known = known_measure(key)
        return heads.get(key) or (known.label if known else SYMBOLS.get(key, key))

    return lambda rows: [
        {head(key): value(row, key) for key in keys} for row in rows if row.matches(cells)
    ]


class Results:
    """The results in a folder, as the documentation shows them.

    Args:
        folder: Holds STUDY.jsonl for each study, and `targets.toml`.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._rows: dict[tuple[str, Budget], list[Row]] = {}

    def rows(self, study: Study, budget: Budget | None = None) -> list[Row]:
        """The rows of a study under a budget, by default its own."""
        budget = budget or study.budget
        together = [study_named(name) for name in study.beside] + [study]
        return [*study.rows([row for one in together for row in self._of(one, budget)])]

    def _of(self, study: Study, budget: Budget) -> list[Row]:
        place = study.name, budget
        if place not in self._rows:
            found = {result.key: result for result in self._lines(study)}
            keys = [job.key for job in study.jobs(budget, _num_seeds(found.values()))]
            self._rows[place] = rows_of(study.name, [found[key] for key in keys if key in found])
        return self._rows[place]

    def _lines(self, study: Study) -> list[Result]:
        return read_lines(self.folder / f"{study.name}.jsonl")

    def stale(self) -> list[str]:
        """A name for each line of the results that no study has any more."""
        names = []
        for study in studies().values():
            lines = self._lines(study)
            jobs = [job for budget in BUDGETS for job in study.jobs(budget, _num_seeds(lines))]
            known = {job.key for job in jobs}
            names += [
                f"{study.name}: {described(line.cell)} seed={line.seed} ({line.config})"
                for line in lines
                if line.key not in known
            ]
        return names

    def claims(self) -> list[targets.Claim]:
        """Every target of every study, with the reasons for those that are missed."""
        return [
            claim
            for study in studies().values()
            if study.targets
            for claim in targets.claims(study, self.rows(study), self.reasons())
        ]

    def reasons(self) -> list[targets.Reason]:
        """Why targets are missed."""
        return targets.read_reasons(self.folder / "targets.toml")

    def tables(self) -> dict[str, str]:
        """Every table of the studies by the name of its place, as Markdown.

        Of a study with targets also NAME_targets, in how many cells each is reached, and
        NAME_missed, those that are not, with the reasons.
        """
        lines: dict[str, Sequence[Line]] = {}
        claims = self.claims()
        for study in studies().values():
            for name, table in study.tables.items():
                lines[name] = table.lines(self.rows(study, table.budget))
            if study.targets:
                own = [claim for claim in claims if claim.row.study == study.name]
                lines[f"{study.name}_targets"] = targets.reached_lines(own)
                lines[f"{study.name}_missed"] = targets.missed_lines(own)
        lines["targets"] = targets.all_lines(claims)
        judged = {f"{claim.row.study}_missed" for claim in claims}
        return {
            name: markdown_table(found) or (NONE_MISSED if name in judged else EMPTY)
            for name, found in lines.items()
        }

    def pictures(self) -> dict[str, bytes]:
        """Every figure of a study that has rows, by its name, as a PNG file."""
        from motorspace.reports.figures.style import png

        return {
            name: png(draw(rows), dots_per_inch=80)
            for study in studies().values()
            if study.figures and (rows := self.rows(study))
            for name, draw in study.figures.items()
        }


def _num_seeds(lines: Iterable[Result]) -> int:
    return 1 + max((line.seed for line in lines), default=-1)
