"""`motorspace odometry`."""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from motorspace.cli.located import data_of
from motorspace.cli.parsing import CommandParser
from motorspace.cli.show import show
from motorspace.cli.walks import add_walk_flags, truth_of, walk_of


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command."""
    parser.add_argument("run", type=Path, metavar="RUN", help="The run whose codes are chained.")
    add_walk_flags(parser, words)
    parser.add_argument(
        "--out",
        type=Path,
        default=None,
        metavar="FILE",
        help="Write the path as CSV: time, x, y, theta, and standard deviations of each step.",
    )
    parser.add_argument(
        "--save-calibration",
        type=Path,
        default=None,
        metavar="FILE",
        help="Write what was learned as JSON, for --calibration where no walls are in sight.",
    )
    parser.add_argument("--json", action="store_true", default=False, help="Print JSON.")


def run(options: argparse.Namespace) -> None:
    """Chain codes along a walk, and score where they lead."""
    data_of(options.run, None, command="odometry")
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    from motorspace.analysis.paths import standing_still
    from motorspace.mapping.motion import chained
    from motorspace.mapping.rig import CalibratedRig, calibrate_rig
    from motorspace.mapping.scores import measure_path
    from motorspace.training.run import load_run

    learned = load_run(options.run)
    walk = walk_of(options, learned)
    given = options.calibration
    robot = calibrate_rig(learned, walk) if given is None else CalibratedRig.of(given)
    scans, motion = robot.rig.scans(walk), robot.motion
    steps = motion.corrected(scans.steps)
    paths = {"chained codes": chained(scans.steps), "corrected": chained(steps)}
    truth = truth_of(walk)
    if truth is not None:
        paths["standing still"] = standing_still(truth)
        show(
            {name: measure_path(path, truth) for name, path in paths.items()},
            as_json=options.json,
        )
    else:
        show({"scans": len(walk), "end": paths["corrected"][:, -1].tolist()}, as_json=options.json)
    if options.out is not None:
        from motorspace._files import write_atomically

        spread = np.sqrt(np.diagonal(motion.covariance(steps), axis1=1, axis2=2))
        text = _csv(walk.time, paths["corrected"], np.concatenate([np.zeros((1, 3)), spread]))
        write_atomically(options.out, text.encode())
    if options.save_calibration is not None:
        robot.save(options.save_calibration)


def _csv(time: np.ndarray, path: np.ndarray, spread: np.ndarray) -> str:
    rows = ["time,x,y,theta,sd_x,sd_y,sd_theta"]
    table = np.column_stack([time, path.T, spread])
    rows += [",".join(f"{value:.6f}" for value in row) for row in table]
    return "\n".join(rows) + "\n"
