"""One self-contained HTML page: text, numbers, tables, pictures and views in one file.

It loads nothing from anywhere, and forbids the browser to.
"""

import base64
import re
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from typing import Any

from matplotlib.figure import Figure

from motorspace.reports.codes_view import View, view_scripts
from motorspace.reports.figures.style import png, theme
from motorspace.reports.tables import shown

POLICY = (
    "default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; "
    "script-src 'unsafe-inline'; font-src data:"
)
"""What the browser may load: nothing that is not in the page."""
DOTS_PER_INCH = 150
NUMERIC = re.compile(r"(yes|no|nan)?[-+\d.,e ±–%]*")
"""What cells of numbers look like."""
SENTENCE = 50
"""Cells with more characters are prose."""
WIDE = 3.0
"""Pictures that are wider for their height are scrolled on narrow screens."""


@dataclass(frozen=True)
class Picture:
    """A PNG file for light pages, and where there is one another for dark pages."""

    caption: str
    light: bytes
    dark: bytes = b""


def picture(caption: str, draw: Callable[[], Figure]) -> Picture:
    """Returns a picture in both themes.

    Args:
        caption: What it shows; stands below it.
        draw: Makes the figure; called once for each theme.
    """
    drawn = []
    for name in ("light", "dark"):
        with theme(name):
            drawn.append(png(draw(), dots_per_inch=DOTS_PER_INCH))
    return Picture(caption, *drawn)


@dataclass(frozen=True)
class Section:
    """A card of the page, with all it holds in this order."""

    heading: str
    text: str = ""
    """Paragraphs, separated by empty lines; `code` stands between backticks."""
    facts: Sequence[tuple[str, Any]] = ()
    """The few numbers that matter, large: (what it is, value)."""
    rows: Sequence[Mapping[str, Any]] = ()
    """A table; the first row's keys are the columns, and cells may hold `code` as well."""
    views: Sequence[View] = ()
    pictures: Sequence[Picture] = ()


def report_page(title: str, sections: Sequence[Section], *, lead: str = "") -> str:
    """Returns the page as HTML.

    Args:
        title: Its title.
        sections: Its cards, from top to bottom; the table of contents names them.
        lead: A sentence or two below the title.
    """
    names = [f"{i}-{_slug(section.heading)}" for i, section in enumerate(sections, 1)]
    links = "".join(
        f'<a href="#{name}">{escape(section.heading)}</a>'
        for name, section in zip(names, sections, strict=True)
    )
    cards = "\n".join(map(_section, sections, names))
    scripts = f"<script>{_resource('page.js')}</script>"
    if any(section.views for section in sections):
        scripts = f"{view_scripts()}\n{scripts}"
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">\n'
        f"<title>{escape(title)}</title>\n<style>{_resource('page.css')}</style>\n</head>\n<body>\n"
        f"<header><h1>{escape(title)}</h1>{_text(lead)}</header>\n"
        f'<nav aria-label="Contents">{links}</nav>\n<main>\n{cards}\n</main>\n{scripts}\n'
        "</body>\n</html>\n"
    )


def _resource(name: str) -> str:
    return files(__package__).joinpath(name).read_text("utf-8")


def _slug(heading: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", heading.lower()).strip("-")


def _section(section: Section, name: str) -> str:
    parts = [f"<h2>{escape(section.heading)}</h2>", _text(section.text)]
    if section.facts:
        facts = "".join(
            f"<div><dt>{escape(what)}</dt><dd>{escape(shown(value))}</dd></div>"
            for what, value in section.facts
        )
        parts.append(f'<dl class="facts">{facts}</dl>')
    if section.rows:
        parts.append(_table(section.rows))
    shows = [view.html for view in section.views] + [_picture(one) for one in section.pictures]
    if shows:
        parts.append(f'<div class="figures">{"".join(shows)}</div>')
    return f'<section id="{name}">{"".join(parts)}</section>'


def _text(text: str) -> str:
    return "".join(f"<p>{_marked(part)}</p>" for part in text.split("\n\n") if part.strip())


def _marked(text: str) -> str:
    """The text for a page, with `code` between backticks."""
    return re.sub("`([^`]+)`", r"<code>\1</code>", escape(text))


def _picture(one: Picture) -> str:
    caption, light = escape(one.caption), _data(one.light)
    width, height = struct.unpack(">II", one.light[16:24])  # where every PNG file holds them
    kinds = ["plain"] * (not one.dark) + ["wide"] * (width > WIDE * height)
    dark = f'<source media="(prefers-color-scheme: dark)" srcset="{_data(one.dark)}">'
    return (
        f'<figure class="{" ".join(kinds)}"><picture>{dark if one.dark else ""}'
        f'<img alt="{caption}" src="{light}"></picture><figcaption>{caption}</figcaption></figure>'
    )


def _data(content: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(content).decode()}"


def _kind(cells: Sequence[str]) -> str:
    """The class of a column: numbers stand to the right, sentences need their width."""
    if all(map(NUMERIC.fullmatch, cells)):
        return ' class="number"'
    return ' class="prose"' if max(map(len, cells)) > SENTENCE else ""


def _table(rows: Sequence[Mapping[str, Any]]) -> str:
    columns = list(rows[0])
    cells = {c: [shown(row.get(c)) for row in rows] for c in columns}
    align = {c: _kind(cells[c]) for c in columns}
    head = "".join(f"<th{align[c]}>{escape(c)}</th>" for c in columns)
    body = "".join(
        "<tr>" + "".join(f"<td{align[c]}>{_marked(cells[c][i])}</td>" for c in columns) + "</tr>"
        for i in range(len(rows))
    )
    table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    return f'<div class="table">{table}</div>'
