"""Occupancy grids as ROS's map_server writes them: a few keys in YAML, and an image."""

import math
import re
import warnings
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from motorspace._errors import UserError
from motorspace._files import write_atomically
from motorspace.worlds.layouts import Layout
from motorspace.worlds.maps.files import map_text
from motorspace.worlds.maps.occupancy import Grid, traced

MOST_CELLS = 64_000_000

KEYS = ("image", "resolution", "origin", "negate", "mode", "occupied_thresh", "free_thresh")
NEEDED = KEYS[:3]
MODES = ("trinary", "scale", "raw")

LINE = re.compile(r"([A-Za-z_]\w*)\s*:(?:\s+(.*))?$")
ITEM = re.compile(r"\s*-\s+(\S+)\s*$")

UNKNOWN = -1.0

SAVED_AS_UNKNOWN = 205
"""The pixel that ROS's map savers write for unknown cells. Those of ROS 2 write a `free_thresh`
beside it by which it would be free."""

SAVED_AS_FREE, SAVED_AS_OCCUPIED = 254, 0


class Description(NamedTuple):
    """What the YAML file says."""

    image: str
    resolution: float
    origin: tuple[float, float, float]
    negate: bool = False
    mode: str = "trinary"
    occupied: float = 0.65
    free: float = 0.196


def read_map(path: Path) -> tuple[Layout, list[str]]:
    """The layout of a map, metres, and notes on what was left out.

    A cell is free below `free_thresh` (in the mode `scale` below the middle of both thresholds).
    All other cells are solid, the unknown ones too, which in the mode `trinary` are also those of
    the grey 205 that map savers write.

    Raises:
        UserError: Names the line or the image at fault.
    """
    described = read_description(map_text(path), where=path)
    image = Path(described.image)
    image = image if image.is_absolute() else path.parent / image
    pixels = _pixels(image)
    free, occupied = _cells(pixels, described)
    unknown = _saved_as_unknown(pixels, described)
    sure = (free & ~unknown)[::-1]
    grid = Grid(sure, occupied[::-1], described.resolution, described.origin)
    layout, notes = traced(grid, path.stem, where=path)
    if claimed := int((free & unknown).sum()):
        notes.append(
            f"{claimed} pixels of the grey {SAVED_AS_UNKNOWN} are unknown, although free_thresh "
            f"{described.free:g} would make them free"
        )
    return layout, notes


def write_map(
    path: Path,
    free: Bool[np.ndarray, "H W"],
    occupied: Bool[np.ndarray, "H W"],
    *,
    resolution: float,
    corner: tuple[float, float],
) -> None:
    """Write a grid as ROS's map savers do, for `read_map` and other programs.

    Args:
        path: The YAML file; its image, of the same name, ends in `.pgm`.
        free: Which cells are free, the first row at the bottom.
        occupied: Which hold something; all others are unknown.
        resolution: Side of a cell, metres.
        corner: The lower left corner of the first cell.

    Raises:
        UserError: Where the files cannot be written.
    """
    shades = np.where(occupied, SAVED_AS_OCCUPIED, np.where(free, SAVED_AS_FREE, SAVED_AS_UNKNOWN))
    height, width = shades.shape
    pixels = shades[::-1].astype(np.uint8).tobytes()
    image = path.with_suffix(".pgm")
    write_atomically(image, f"P5\n{width} {height}\n255\n".encode() + pixels)
    x, y = corner
    described = Description(image.name, resolution, (float(x), float(y), 0.0))
    lines = (
        f"image: {described.image}",
        f"resolution: {described.resolution!r}",
        f"origin: [{', '.join(map(repr, described.origin))}]",
        f"negate: {int(described.negate)}",
        f"mode: {described.mode}",
        f"occupied_thresh: {described.occupied}",
        f"free_thresh: {described.free}",
    )
    write_atomically(path, ("\n".join(lines) + "\n").encode())


def read_description(text: str, *, where: object) -> Description:
    """The keys of a map's YAML file: scalars, and a list of numbers on one line or on three.

    Raises `UserError` naming the line at fault.
    """
    found: dict[str, tuple[int, str]] = {}
    last = ""
    for number, line in enumerate(text.splitlines(), start=1):
        line = re.sub(r"(^|\s)#.*$", "", line).rstrip()
        if not line.strip() or line in ("---", "..."):
            continue
        item, match = ITEM.match(line), LINE.match(line)
        if item and last:
            start, value = found[last]
            found[last] = start, f"{value}, {item[1]}".removeprefix(", ")
        elif match is None:
            raise UserError(
                f"the line {line[:40]!r} is no `key: value`",
                where=f"{where}, line {number}",
                remedy="write the map's keys one a line",
            )
        else:
            last = match[1]
            if last in found:
                raise UserError(
                    f"a second {last}", where=f"{where}, line {number}", remedy="leave one out"
                )
            found[last] = number, (match[2] or "").strip()
    if lacking := [key for key in NEEDED if key not in found]:
        raise UserError(
            f"the map lacks {', '.join(lacking)}",
            where=where,
            remedy=f"a map_server file has the keys {', '.join(KEYS)}",
        )
    return _described({key: found[key] for key in KEYS if key in found}, where)


def _described(found: dict[str, tuple[int, str]], where: object) -> Description:
    def number(key: str, low: float, high: float, default: float) -> float:
        line, word = found.get(key, (0, str(default)))
        return _number(word, key, low, high, f"{where}, line {line}")

    line, listed = found["origin"]
    words = [word.strip() for word in listed.strip("[]").split(",")]
    if len(words) != 3:
        raise UserError(
            f"origin is {listed[:40]!r}",
            where=f"{where}, line {line}",
            remedy="write [x, y, yaw]: metres, metres, radians",
        )
    place = f"{where}, line {line}"
    x, y, yaw = (_number(word, "origin", -1e9, 1e9, place) for word in words)
    mode = found.get("mode", (0, "trinary"))[1].strip("'\"").lower()
    if mode not in MODES:
        raise UserError(
            f"mode is {mode[:40]!r}",
            where=f"{where}, line {found['mode'][0]}",
            remedy=f"choose one of {', '.join(MODES)}",
        )
    image = found["image"][1].strip("'\"")
    if not image:
        raise UserError(
            "image names no file", where=f"{where}, line {found['image'][0]}", remedy="name one"
        )
    negate = found.get("negate", (0, "0"))[1].lower() in ("1", "true", "yes")
    occupied = number("occupied_thresh", 0.0, 1.0, 0.65)
    free = number("free_thresh", 0.0, 1.0, 0.196)
    if free > occupied:
        raise UserError(
            f"free_thresh {free:g} is above occupied_thresh {occupied:g}",
            where=where,
            remedy="give a smaller free_thresh",
        )
    resolution = number("resolution", 1e-6, 1e6, math.nan)
    return Description(image, resolution, (x, y, yaw), negate, mode, occupied, free)


def _number(word: str, key: str, low: float, high: float, place: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise UserError(
            f"{key} is {word[:40]!r}", where=place, remedy=f"give a number from {low:g} to {high:g}"
        )
    return value


def _pixels(path: Path) -> Float[np.ndarray, "H W"]:
    """Brightness from 0 to 1, the first row at the top; negative where the image is transparent.

    Raises `UserError` for an image that is missing, damaged or too large, before it takes memory.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(path, formats=("PPM", "PNG", "BMP", "JPEG", "TIFF", "GIF")) as image:
                if image.width * image.height > MOST_CELLS:
                    raise UserError(
                        f"the image has {image.width} x {image.height} pixels, more than "
                        f"{MOST_CELLS:,}",
                        where=path,
                        remedy="cut out a part, or make its cells larger",
                    )
                return _brightness(image)
    except FileNotFoundError:
        raise UserError(
            "the map's image is missing", where=path, remedy="copy it beside the YAML file"
        ) from None
    except (OSError, ValueError, SyntaxError, MemoryError, Image.DecompressionBombError) as error:
        raise UserError(
            f"the map's image cannot be read ({str(error).partition(chr(10))[0]})",
            where=path,
            remedy="copy it again",
        ) from None


def _brightness(image: Any) -> Float[np.ndarray, "H W"]:
    if image.mode.startswith("I") or image.mode == "F":
        values = np.asarray(image, np.float32)
        return values / (65535 if values.max() > 255 else 255)
    if image.mode in ("L", "1"):
        return np.asarray(image.convert("L"), np.float32) / 255
    pixels = np.asarray(image.convert("RGBA"))
    grey = pixels[..., :3].mean(axis=-1, dtype=np.float32) / 255
    return np.where(pixels[..., 3] == 0, np.float32(UNKNOWN), grey)


def _cells(
    pixels: Float[np.ndarray, "H W"], described: Description
) -> tuple[Bool[np.ndarray, "H W"], Bool[np.ndarray, "H W"]]:
    """Which cells are free and which occupied; the page of map_server says what its modes mean."""
    known = pixels >= 0
    occupancy = pixels if described.negate else 1 - pixels
    if described.mode == "raw":
        # The pixel is the occupancy itself, from 0 to 100; what is above is unknown.
        occupancy = np.round(pixels * 255) / 100
        known &= occupancy <= 1
    free, occupied = described.free, described.occupied
    if described.mode == "scale":
        free = occupied = (free + occupied) / 2
    return known & (occupancy < free), known & (occupancy > occupied)


def _saved_as_unknown(
    pixels: Float[np.ndarray, "H W"], described: Description
) -> Bool[np.ndarray, "H W"]:
    """Cells that a map saver has written as unknown."""
    trinary = described.mode == "trinary" and not described.negate
    return trinary & (np.abs(pixels - SAVED_AS_UNKNOWN / 255) < 1e-4)
