"""The tables and figures of every study, made from the results: what the documentation shows.

Results of a configuration that no study has any more are stale: they are named, never shown.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from motorspace._files import write_atomically
from motorspace.reports.tables import filled, markdown_table, places
from motorspace.running.jobs import described
from motorspace.running.store import read_lines
from motorspace.studies import targets
from motorspace.studies.rows import SYMBOLS, Row, known_measure, rows_of, setting
from motorspace.studies.study import BUDGETS, Budget, Line, Study, studies

TARGETS = "targets.toml"


def columns(
    *keys: str, heads: Mapping[str, str] = {}, titles: Mapping[Any, str] = {}
) -> Callable[[Sequence[Row]], list[Line]]:
    """What makes a table of rows, with a column for each key.

    Args:
        keys: Settings of the cells, keys of measures (mean and half the confidence interval over
            seeds), `"seeds"` or `"epochs"`.
        heads: {key: head of its column}; by default the label of the measure.
        titles: {value of a setting: what the table writes}.
    """

    def value(row: Row, key: str) -> Any:
        if key in row.cell:
            return titles.get(row.cell[key], setting(key, row.cell[key]))
        return {"seeds": len(row.runs), "epochs": row.epochs}.get(key, row.get(key))

    def head(key: str) -> str:
        known = known_measure(key)
        return heads.get(key) or (known.label if known else SYMBOLS.get(key, key))

    return lambda rows: [{head(key): value(row, key) for key in keys} for row in rows]


def shown_rows(study: Study, results: Path, budget: Budget | None = None) -> list[Row]:
    """The rows of a study under a budget, by default its own, from the results in a folder."""
    budget = budget or study.budget
    known = studies()
    own = [known[name] for name in study.beside] + [study]
    return [*study.rows([row for one in own for row in _current_rows(one, results, budget)])]


def _current_rows(study: Study, results: Path, budget: Budget) -> list[Row]:
    found = {result.key: result for result in read_lines(results / f"{study.name}.jsonl")}
    seeds = 1 + max((result.seed for result in found.values()), default=-1)
    keys = [job.key for job in study.jobs(budget, seeds)]
    return rows_of(study.name, [found[key] for key in keys if key in found])


def stale_lines(results: Path) -> list[str]:
    """A name for each line of the results that no study has any more."""
    names = []
    for study in studies().values():
        lines = read_lines(results / f"{study.name}.jsonl")
        seeds = 1 + max((result.seed for result in lines), default=-1)
        known = {job.key for budget in BUDGETS for job in study.jobs(budget, seeds)}
        names += [
            f"{study.name}: {described(line.cell)} seed={line.seed} (configuration {line.config})"
            for line in lines
            if line.key not in known
        ]
    return names


def all_claims(results: Path) -> list[targets.Claim]:
    """Every target of every study, with the reasons for those that are missed."""
    reasons = targets.read_reasons(results / TARGETS)
    return [
        claim
        for study in studies().values()
        for claim in targets.claims(study, shown_rows(study, results), reasons)
    ]


def all_tables(results: Path) -> dict[str, str]:
    """Every table by the name of its place, as Markdown."""
    lines: dict[str, Sequence[Line]] = {}
    for study in studies().values():
        for name, table in study.tables.items():
            lines[name] = table.lines(shown_rows(study, results, table.budget))
    claims = all_claims(results)
    for name in {claim.row.study for claim in claims}:
        own = [claim for claim in claims if claim.row.study == name]
        lines[f"{name}_targets"] = targets.reached_lines(own)
        lines[f"{name}_missed"] = targets.missed_lines(own)
    return {name: markdown_table(found) or "Not measured yet.\n" for name, found in lines.items()}


def all_figures(results: Path) -> dict[str, bytes]:
    """Every figure of a study that has rows, by its name, as a PNG file."""
    from motorspace.reports.figures import png

    return {
        name: png(draw(rows), dots_per_inch=80)
        for study in studies().values()
        if study.figures and (rows := shown_rows(study, results))
        for name, draw in study.figures.items()
    }


def changed_pages(
    pages: Iterable[Path], tables: Mapping[str, str]
) -> tuple[dict[Path, str], list[str]]:
    """The pages whose tables are not as in `tables`, filled; and places for no table."""
    changed, unknown = {}, []
    for page in pages:
        text = page.read_text()
        if (new := filled(text, tables)) != text:
            changed[page] = new
        unknown += [f"{page}: no table {name}" for name in places(text) if name not in tables]
    return changed, unknown


def write_pictures(results: Path, folder: Path) -> None:
    """Draw every figure of the studies into a folder."""
    for name, picture in all_figures(results).items():
        write_atomically(folder / f"{name}.png", picture)
