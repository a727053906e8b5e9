"""`motorspace train`."""

import argparse
import shlex
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from motorspace._errors import UserError
from motorspace.cli.executors import add_executor_flags, executor_of
from motorspace.cli.parsing import CommandParser, Usage, count, existing, note
from motorspace.training import folder as run_folder
from motorspace.training.config import RunConfig
from motorspace.training.data import Logged
from motorspace.training.presets import PRESETS
from motorspace.training.settings import (
    configured,
    configured_on_log,
    logged_groups,
    simulated_groups,
)
from motorspace.worlds.catalog import AGENTS, SENSORS

RecordCallback = Callable[[dict[str, Any]], None]

OWN = (
    "agent",
    "sensor",
    "preset",
    "data",
    "reader",
    "out",
    "resume",
    "seeds",
    "jobs",
    "address",
    "gpus",
    "tensorboard",
    "imports",
)
"""Options of the command itself; all others are settings of the run."""


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command. Which there are depends on agent, sensor and log."""
    _own_flags(parser)
    first = _first_look(words)
    if first.data is not None:
        groups = logged_groups(_reader(first))
    else:
        groups = simulated_groups(first.agent or "forward", first.sensor)
    for group in groups:
        parser.add_parameters(group.title, group.parameters)


def run(options: argparse.Namespace) -> None:
    """Train."""
    settings = {name: value for name, value in vars(options).items() if name not in OWN}
    config, name = _config(options, settings)
    folder = options.out or Path("runs") / f"{name}-{config.training.seed}"
    if options.seeds > 1 and options.tensorboard:
        raise Usage("--tensorboard takes one seed at a time", remedy="leave out --seeds")
    if options.seeds > 1:
        _train_seeds(config, folder, options)
        return
    started = (folder / run_folder.CONFIG).exists()
    if started and not options.resume:
        raise UserError(
            "the folder already holds a run",
            where=folder,
            remedy="continue it with --resume, or choose another folder",
        )
    if options.resume and not started:
        note(f"{folder}: there is no run to resume; a new one begins")
    _train(config, folder, options)


def _own_flags(parser: CommandParser) -> None:
    parser.add_argument(
        "agent",
        nargs="?",
        default=None,
        metavar="AGENT",
        help=f"The agent to simulate: {', '.join(AGENTS.names)} (default: forward).",
    )
    add = parser.add_argument_group("run").add_argument
    add("--sensor", default=None, metavar="SENSOR", help=f"Its sensor: {', '.join(SENSORS.names)}.")
    add(
        "--preset",
        default="paper",
        choices=tuple(PRESETS),
        help="paper: the paper's network; best: the one whose codes are structured best; log: one "
        "that learns from a robot's log. What is given as a flag wins (default: paper).",
    )
    add(
        "--data",
        default=None,
        type=existing,
        metavar="LOG",
        help="A robot's log to learn from, instead of a simulation.",
    )
    add(
        "--reader",
        default=None,
        metavar="READER",
        help="The reader of the log; by default the one that recognises its content.",
    )
    add(
        "--out",
        default=None,
        type=Path,
        metavar="FOLDER",
        help="Folder of the run (default: runs/AGENT-SEED).",
    )
    add("--resume", action="store_true", default=False, help="Continue the run in this folder.")
    add(
        "--seeds",
        type=count,
        default=1,
        metavar="N",
        help="Networks to train, one per seed, in folders seedN (default: 1).",
    )
    add(
        "--tensorboard",
        action="store_true",
        default=False,
        help="Also write scalars for TensorBoard.",
    )
    add_executor_flags(parser)


def _first_look(words: Sequence[str]) -> argparse.Namespace:
    """Agent, sensor and log, which decide on all other flags."""
    parser = CommandParser(prog="motorspace train", add_help=False)
    _own_flags(parser)
    parser.add_argument("--import", dest="imports", action="append", default=[])
    options, others = parser.parse_known_args(list(words))
    # The value of a flag that is not known yet may stand where an agent may.
    found = [options.agent, *others]
    options.agent = next((word for word in found if word in AGENTS.names), None)
    if options.agent is None and words and not words[0].startswith("-"):
        options.agent = words[0]
    if options.data is not None and options.agent is not None:
        raise Usage(
            f"a log is not simulated, so no agent applies: {options.agent!r}",
            remedy=f"leave out {options.agent!r}, or --data",
        )
    return options


def _reader(options: argparse.Namespace) -> str:
    from motorspace.recordings.catalog import reader_for

    reader: str = options.reader or reader_for(options.data)
    return reader


def _config(options: argparse.Namespace, settings: dict[str, Any]) -> tuple[RunConfig, str]:
    """The configuration of the run, and what its folder is named after."""
    if options.data is not None:
        config = configured_on_log(
            options.data, settings, reader=options.reader, preset=options.preset
        )
        assert isinstance(config.data, Logged), "as its name says"
        config.data.recording()  # what cannot be read is known before anything heavy is loaded
        return config, options.data.name.partition(".")[0]
    if options.reader is not None:
        raise Usage("--reader applies to logs only", remedy="give a log with --data")
    agent = options.agent or "forward"
    config = configured(agent, settings, sensor=options.sensor, preset=options.preset)
    return config, agent


def _train(config: RunConfig, folder: Path, options: argparse.Namespace) -> None:
    from motorspace.cli.runtime import prepare_jax
    from motorspace.cli.show import progress

    prepare_jax()
    from motorspace.training.run import train

    training = config.training
    if training.restarts > 1 and not options.resume:
        print(
            f"trying {training.restarts} initial networks for {training.trial_epochs} epochs each",
            flush=True,
        )
    with progress("training", training.epochs) as bar:
        callback = _with_tensorboard(bar, folder) if options.tensorboard else bar
        run = train(config, folder=folder, resume=options.resume, callback=callback)
    if run.collapsed:
        note("the codes have collapsed: they no longer vary with the commands")
    quoted = shlex.quote(str(folder))
    print(f"finished: {folder}; measure it with: motorspace evaluate {quoted}")


def _with_tensorboard(callback: RecordCallback, folder: Path) -> RecordCallback:
    from motorspace.export.tensorboard import TensorBoardLog

    log = TensorBoardLog(folder / "tensorboard")

    def both(record: dict[str, Any]) -> None:
        callback(record)
        log(record)

    return both


def _train_seeds(config: RunConfig, folder: Path, options: argparse.Namespace) -> None:
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    from motorspace.running.seeds import train_seeds

    train_seeds(
        config,
        folder,
        seeds=options.seeds,
        executor=executor_of(options),
        resume=options.resume,
        report=lambda line: print(line, flush=True),
    )
