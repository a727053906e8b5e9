"""Tables in Markdown, and the places in a page where they stand.

A table stands between `<!-- table: NAME -->` and `<!-- end -->`.
"""

import re
from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import Any

PLACE = re.compile(r"(<!-- table: ([a-z0-9_]+) -->\n).*?(<!-- end -->)", re.DOTALL)


def markdown_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Returns rows as a Markdown table; the first row's keys are the columns.

    Args:
        rows: {head of a column: value}; values are written by `shown`. No rows, no table.

    Example:
        >>> print(markdown_table([{"r": 0.2, "error": 3.6539}]), end="")
        | r | error |
        |---|---|
        | 0.2 | 3.65 |
    """
    if not rows:
        return ""
    columns = list(rows[0])
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    lines += [
        "| " + " | ".join(shown(row.get(c)).replace("|", "\\|") for c in columns) + " |"
        for row in rows
    ]
    return "\n".join(lines) + "\n"


def shown(value: Any, *, digits: int = 3) -> str:
    """Returns a value as a table shows it.

    Args:
        value: A number is rounded, but none of its digits before the point; nothing is a dash.
        digits: Significant digits of a number that is not whole.

    Example:
        >>> shown(None), shown(True), shown(0.12345), shown(123456.7), shown(6)
        ('–', 'yes', '0.123', '123,457', '6')
    """
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, Real):
        return str(value)
    rounded = f"{float(value):.{digits}g}"
    whole = isinstance(value, Integral) or abs(float(rounded)) >= 10**digits
    return f"{float(value):,.0f}" if whole else rounded


def places(page: str) -> list[str]:
    """Returns the names of the tables that stand in a page."""
    return [found[2] for found in PLACE.finditer(page)]


def filled(page: str, tables: Mapping[str, str]) -> str:
    """Returns the page with these tables in their places; others stay as they are.

    Args:
        page: Markdown.
        tables: {name: Markdown}.
    """
    return PLACE.sub(lambda found: found[1] + tables.get(found[2], _rest(found)) + found[3], page)


def _rest(found: "re.Match[str]") -> str:
    return found[0][len(found[1]) : -len(found[3])]
