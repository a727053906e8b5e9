"""Which kind of map a file is, by its content, and its layout."""

import importlib
import re
from pathlib import Path

from motorspace._errors import UserError
from motorspace.worlds.layouts import Layout

HEAD = 4096

IMAGES = (b"P2", b"P3", b"P5", b"P6", b"\x89PNG", b"BM", b"\xff\xd8\xff", b"GIF8")

KINDS = {
    "map_server": re.compile(r"^(image|resolution|occupied_thresh)\s*:", re.MULTILINE),
    "moving_ai": re.compile(r"\Atype\s+\w+\s+height\s"),
    "geojson": re.compile(
        r'\A\s*\{.*"type"\s*:\s*"(Feature|\w*Polygon|\w*LineString|Geometry)', re.S
    ),
    "svg": re.compile(r"\A\s*(<\?xml[^>]*>\s*)?(<!--.*?-->\s*)*<(!DOCTYPE svg|svg)", re.S),
}
"""The module that reads a map, and how one begins."""

ENDINGS = {
    ".yaml": "map_server",
    ".yml": "map_server",
    ".map": "moving_ai",
    ".geojson": "geojson",
    ".svg": "svg",
}
"""What a name says, where the content does not."""


def kind_of_map(path: Path) -> str | None:
    """The kind of a map; None for a file that is no map.

    Raises:
        UserError: For an image alone, which does not say how large its pixels are.
    """
    try:
        with path.open("rb") as file:
            head = file.read(HEAD)
    except (OSError, ValueError):
        return None
    if head.startswith(IMAGES) and path.suffix.lower() != ".layout":
        raise UserError(
            "an image alone does not say how large its pixels are",
            where=path,
            remedy="give the YAML file of the map, with image, resolution and origin",
        )
    text = head.decode("utf-8", "replace").removeprefix("\ufeff")
    for kind, begins in KINDS.items():
        if begins.search(text):
            return kind
    return ENDINGS.get(path.suffix.lower())


def read_map(path: Path, kind: str) -> tuple[Layout, list[str]]:
    """The layout of a map, and notes on what was left out.

    Args:
        path: The file.
        kind: As `kind_of_map` says.

    Raises:
        UserError: The file, or one that it names, is missing or broken.
    """
    module = importlib.import_module(f"motorspace.worlds.maps.{kind}")
    found: tuple[Layout, list[str]] = module.read_map(path)
    return found
