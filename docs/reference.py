"""Write the pages of the API reference: `python -m docs.reference`.

One page for the public names, and one for each room of the package, whose text comes from the
docstrings when the site is built. The list of the rooms in `mkdocs.yml` is written as well.
"""

import ast
import re
from pathlib import Path

import motorspace as ms
from motorspace._files import write_atomically

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "motorspace"
REFERENCE = ROOT / "docs" / "reference"
SITE = ROOT / "mkdocs.yml"

ROOMS = (
    "worlds",
    "trajectories",
    "recordings",
    "models",
    "analysis",
    "reports",
    "training",
    "evaluation",
    "judge",
    "mapping",
    "control",
    "environments",
    "export",
    "navigation",
    "running",
    "studies",
    "testing",
)
"""In the order of the data; those that the package has are shown."""


def main() -> None:
    """Write every page that has changed."""
    for path, text in pages().items():
        if not path.exists() or path.read_text() != text:
            write_atomically(path, text.encode())


def pages() -> dict[Path, str]:
    """Every file that is made, with what it must hold."""
    rooms = [room for room in ROOMS if (PACKAGE / room).is_dir()]
    made = {REFERENCE / f"{room}.md": _room(room) for room in rooms}
    made[REFERENCE / "index.md"] = _public(rooms)
    entries = "".join(f"      - reference/{room}.md\n" for room in rooms)
    made[SITE] = re.sub(
        r"(# rooms\n).*?(      # end\n)",
        lambda found: found[1] + entries + found[2],
        SITE.read_text(),
        flags=re.DOTALL,
    )
    return made


def _room(room: str) -> str:
    """The page of a room: every module that says something in public."""
    parts = [f"# motorspace.{room}", _first_line(PACKAGE / room / "__init__.py")]
    for path in sorted((PACKAGE / room).rglob("*.py")):
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        if path.name != "__init__.py" and not path.name.startswith("_"):
            parts.append(f"::: {name}")
    return "\n\n".join(parts) + "\n"


def _public(rooms: list[str]) -> str:
    """The page of the public surface: each name with its first line, linked to its place."""
    text = [
        "# Reference",
        "`import motorspace as ms` gives these names. Everything else is imported from the module "
        "that defines it.",
        "| name | what it is |\n|---|---|",
    ]
    places = set()
    for name in sorted(_names(), key=str.lower):
        value = getattr(ms, name)
        place = f"{value.__module__}.{value.__qualname__}"
        places.add(place)
        summary = (value.__doc__ or "").strip().split("\n\n")[0]
        text[-1] += f"\n| [`{name}`][{place}] | {' '.join(summary.split())} |"
    text.append("## By room")
    text.append("\n".join(f"- [motorspace.{room}]({room}.md)" for room in rooms))
    text.append("## In no room")
    text += [f"::: {place}" for place in sorted(places) if place.split(".")[1] not in rooms]
    return "\n\n".join(text) + "\n"


def _names() -> list[str]:
    names = getattr(ms, "__all__", dir(ms))
    return [n for n in names if not n.startswith("_") and hasattr(getattr(ms, n), "__qualname__")]


def _first_line(module: Path) -> str:
    docstring = ast.get_docstring(ast.parse(module.read_text()))
    return " ".join((docstring or "").split("\n\n")[0].split())


if __name__ == "__main__":
    main()
