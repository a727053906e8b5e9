"""`motorspace map`."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from motorspace.cli.inspect import made_folder
from motorspace.cli.located import data_of
from motorspace.cli.parsing import CommandParser, note, number
from motorspace.cli.show import show
from motorspace.cli.walks import add_walk_flags, truth_of, walk_of

if TYPE_CHECKING:
    from motorspace.mapping.survey import Scans, Survey
    from motorspace.recordings.recording import Recording
    from motorspace.reports.figures.maps import MapPanel

PAGE, DESCRIPTION, PATH = "map.html", "map.json", "path.csv"
CALIBRATION, GRID = "calibration.json", "map.yaml"
CELL = 0.01
"""Side of the cells of the picture, share of the sensors' reach."""


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command."""
    parser.add_argument("run", type=Path, metavar="RUN", help="The run whose codes are used.")
    add_walk_flags(parser, words)
    parser.add_argument(
        "--out",
        type=Path,
        default=None,
        metavar="FOLDER",
        help="Where the page, the path and the numbers are written (default: map in the run).",
    )
    parser.add_argument(
        "--cell", type=number, default=None, metavar="X", help="Side of the picture's cells."
    )
    parser.add_argument("--json", action="store_true", default=False, help="Print JSON.")


def run(options: argparse.Namespace) -> None:
    """Put a walk together, and write a page about it."""
    data_of(options.run, None, command="map")
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    from motorspace.mapping.rig import CalibratedRig, learn_rig
    from motorspace.mapping.survey import survey
    from motorspace.training.run import load_run

    learned = load_run(options.run)
    walk = walk_of(options, learned)
    note(f"mapping {walk.name}: {len(walk)} scans; some seconds for each thousand")
    given = None if options.calibration is None else CalibratedRig.of(options.calibration)
    rig = learn_rig(learned, walk) if given is None else given.rig
    scans = rig.scans(walk)
    found = survey(scans, None if given is None else given.motion)
    folder = options.out or options.run / "map"
    scores = write_map(folder, walk, scans, found, cell=options.cell)
    CalibratedRig(rig, found.motion).save(folder / CALIBRATION)
    show(scores or {"scans": len(walk), "loops": len(found.loops.first)}, as_json=options.json)
    note(f"open {folder / PAGE}")


def write_map(
    folder: Path, walk: "Recording", scans: "Scans", found: "Survey", *, cell: float | None = None
) -> dict[str, Any]:
    """Write the page, the path as CSV, the map for ROS, and the numbers; returns the numbers."""
    from motorspace._files import write_atomically, write_json
    from motorspace.analysis.paths import aligned
    from motorspace.mapping.motion import chained
    from motorspace.mapping.scores import measure_survey
    from motorspace.reports.map_page import map_page
    from motorspace.worlds.maps.map_server import write_map as write_grid

    made_folder(folder)
    truth = truth_of(walk)
    paths = {"chained codes": chained(scans.steps), "corrected": found.local}
    paths["with loops"] = found.poses
    scores: dict[str, Any] = {}
    if truth is not None:
        scores = measure_survey(scans, found, paths, truth)
        paths = {name: aligned(path, truth) for name, path in paths.items()} | {"truth": truth}
    panels = panels_of(scans, found, paths, cell=cell)
    flat = {name: path[:2] for name, path in paths.items()}
    drawn = panels[0]
    free, corner = drawn.seen & ~drawn.occupied, (drawn.low[0], drawn.low[1])
    write_grid(folder / GRID, free.T, drawn.occupied.T, resolution=float(drawn.cell), corner=corner)
    write_json(folder / DESCRIPTION, scores)
    write_atomically(folder / PATH, _csv(walk, paths["with loops"]).encode())
    write_atomically(folder / PAGE, map_page(walk.name, panels, flat, scores).encode())
    return scores


def panels_of(
    scans: "Scans", found: "Survey", paths: dict[str, np.ndarray], *, cell: float | None
) -> list["MapPanel"]:
    """Drawings of the readings along the path with loops and, where it is known, the true one."""
    from motorspace.mapping.occupancy import occupancy
    from motorspace.reports.figures.maps import MapPanel

    side = CELL * scans.mounting.reach if cell is None else cell
    panels = []
    for name, title in (("with loops", "by codes and readings"), ("truth", "at the true poses")):
        if name not in paths:
            continue
        path = paths[name]
        drawn = occupancy(path, scans.sensors, scans.mounting, cell=side)
        ends = path[:2, np.stack([found.loops.first, found.loops.second])]
        loops = np.moveaxis(ends, (0, 1), (2, 1)) if name == "with loops" else None
        panels.append(MapPanel(title, drawn.occupied, drawn.seen, drawn.low, side, path[:2], loops))
    return panels


def _csv(walk: "Recording", path: np.ndarray) -> str:
    rows = ["time,x,y,theta"]
    rows += [
        f"{time:.6f},{x:.6f},{y:.6f},{angle:.6f}"
        for time, (x, y, angle) in zip(walk.time, path.T, strict=True)
    ]
    return "\n".join(rows) + "\n"
