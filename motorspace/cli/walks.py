"""A walk for the commands that follow one: a robot's log, or one that is simulated."""

import argparse
import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from motorspace._errors import UserError
from motorspace.cli.inspect import add_reader_flags, recording_of
from motorspace.cli.parsing import CommandParser, count, existing, number, seed

if TYPE_CHECKING:
    from motorspace.mapping.rig_file import Sections
    from motorspace.recordings.recording import Recording
    from motorspace.training.run import Run


def add_walk_flags(parser: CommandParser, words: Sequence[str]) -> None:
    """A log with its reader's flags, or how a walk is simulated."""
    add = parser.add_argument
    add(
        "file",
        nargs="?",
        type=existing,
        default=None,
        metavar="LOG",
        help="A robot's log; without, a walk of the run's agent is simulated.",
    )
    add("--reader", default=None, metavar="READER", help="The reader of the log.")
    add(
        "--calibration",
        type=_sections,
        default=None,
        metavar="FILE",
        help="What was learned on another walk (the map's calibration.json, or --save-calibration"
        " of odometry); this one then needs no walls.",
    )
    group = parser.add_argument_group("a simulated walk")
    group.add_argument(
        "--layout", default=None, metavar="WORLD", help="Where (default: the run's own layout)."
    )
    group.add_argument(
        "--steps", type=count, default=1000, metavar="N", help="Commands (default: 1000)."
    )
    group.add_argument(
        "--num-beams", type=count, default=61, metavar="N", help="Distances (default: 61)."
    )
    group.add_argument(
        "--motor-noise",
        type=number,
        default=0.0,
        metavar="X",
        help="Relative error of each command, a standard deviation (default: 0).",
    )
    group.add_argument(
        "--motor-bias",
        type=number,
        default=0.0,
        metavar="X",
        help="What the body adds to each command (default: 0).",
    )
    group.add_argument("--seed", type=seed, default=0, metavar="N", help="Seed of the walk.")
    # Values of flags are no logs; one that does not exist is refused once all flags are known.
    before = ["", *words]
    places = [w for flag, w in zip(before, words, strict=False) if not flag.startswith("--")]
    logs = [word for word in places if not word.startswith("-")][1:]
    if logs and Path(logs[0]).exists():
        reader = [pair for pair in zip(before, words, strict=False) if pair[0] == "--reader"]
        add_reader_flags(parser, [logs[0], *itertools.chain(*reader)])


def _sections(word: str) -> "Sections":
    """A robot's calibration, as an argument's type."""
    from motorspace.mapping.rig_file import read_sections

    return read_sections(existing(word))


def walk_of(options: argparse.Namespace, run: "Run") -> "Recording":
    """The walk that a command names. Raises `UserError` where there is none."""
    if options.file is not None:
        return recording_of(options)
    import jax

    from motorspace.recordings.record import record, with_motor_errors
    from motorspace.training.data import simulated
    from motorspace.worlds.scenario import Scenario
    from motorspace.worlds.sensors.range_fan import RangeFan

    try:
        own = simulated(run.config.data).scenario()
    except UserError as error:
        raise UserError(error.what, remedy="name a log after the run") from None
    world = own.world if options.layout is None else options.layout
    scenario = Scenario(world, own.agent, RangeFan(num_rays=options.num_beams))
    walk_key, noise_key = jax.random.split(jax.random.key(options.seed))
    walk = record(scenario, num_steps=options.steps, key=walk_key)
    return with_motor_errors(
        walk, noise=options.motor_noise, bias=options.motor_bias, key=noise_key
    )


def truth_of(walk: "Recording") -> np.ndarray | None:
    """The true frames of the sensors along a walk, [3, N]; None where one is unknown."""
    from motorspace.recordings.recording import sensor_frames

    if walk.odometry_poses or not np.isfinite(walk.poses).all():
        return None
    return sensor_frames(walk)
