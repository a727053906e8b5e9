"""One self-contained HTML page: text, tables and pictures in one file."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any

import numpy as np

STYLE = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem;
       margin: 2rem auto; padding: 0 1rem; }
img { max-width: 100%; height: auto; background: white; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { padding: .3rem .8rem; border-bottom: 1px solid #8888; text-align: left; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
"""


@dataclass(frozen=True)
class Section:
    """A heading with a paragraph, a table (rows of equal keys) and PNG pictures."""

    heading: str
    text: str = ""
    rows: Sequence[Mapping[str, Any]] = ()
    pictures: Sequence[tuple[str, bytes]] = field(default=())
    """(What the picture shows, PNG file)."""


def report_page(title: str, sections: Sequence[Section]) -> str:
    """The page as HTML; it loads nothing from anywhere."""
    body = "\n".join(_section(section) for section in sections)
    return (
        f'<!doctype html>\n<html lang="en">\n<head><meta charset="utf-8"><title>{escape(title)}'
        f"</title><style>{STYLE}</style></head>\n<body>\n<h1>{escape(title)}</h1>\n{body}\n"
        "</body>\n</html>\n"
    )


def markdown_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows as a Markdown table; the first row's keys are the columns. No rows, no table."""
    if not rows:
        return ""
    columns = list(rows[0])
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    lines += [
        "| " + " | ".join(shown(row.get(c)).replace("|", "\\|") for c in columns) + " |"
        for row in rows
    ]
    return "\n".join(lines) + "\n"


def shown(value: Any) -> str:
    """A value as a table shows it: three digits, a dash for nothing, mean and range."""
    if value is None:
        return "–"
    if isinstance(value, Mapping) and "mean" in value:
        mean, low, high = (f"{value[k]:.3g}" for k in ("mean", "low", "high"))
        return mean if low == high else f"{mean} ({low} to {high})"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.3g}" if isinstance(value, float | np.floating) else str(value)


def _section(section: Section) -> str:
    parts = [f"<h2>{escape(section.heading)}</h2>"]
    if section.text:
        parts.append(f"<p>{escape(section.text)}</p>")
    if section.rows:
        parts.append(_table(section.rows))
    for caption, picture in section.pictures:
        data = base64.b64encode(picture).decode()
        parts.append(f'<img alt="{escape(caption)}" src="data:image/png;base64,{data}">')
    return "\n".join(parts)


def _table(rows: Sequence[Mapping[str, Any]]) -> str:
    columns = list(rows[0])
    head = "".join(f"<th>{escape(c)}</th>" for c in columns)
    lines = []
    for row in rows:
        cells = []
        for column in columns:
            value = row.get(column)
            kind = "" if isinstance(value, str) else ' class="number"'
            cells.append(f"<td{kind}>{escape(shown(value))}</td>")
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return f"<table><tr>{head}</tr>\n{chr(10).join(lines)}</table>"
