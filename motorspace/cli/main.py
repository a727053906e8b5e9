"""From words to a command: the table of commands, what all of them share, and how errors end."""

import importlib
import itertools
import os
import sys
import traceback
import warnings
from collections.abc import Sequence
from difflib import get_close_matches
from typing import NamedTuple

from motorspace._errors import UserError
from motorspace.cli.parsing import CommandParser, Usage, note


class Command(NamedTuple):
    """A command: where its `configure(parser, words)` and `run(options)` are, and what it does."""

    module: str
    help: str
    goes_on: str = ""
    """How a person goes on with what was interrupted."""


AGAIN = "the same command"

COMMANDS = {
    "demo": Command("demo", "train a forward agent in a few minutes and write a page about it"),
    "train": Command("train", "train a network, in simulation or on a robot's log", "--resume"),
    "evaluate": Command("evaluate", "measure a run on data that training never saw"),
    "topology": Command("topology", "measure how codes are structured by displacement"),
    "control": Command("control", "plan motor commands that reach a goal"),
    "compare": Command("compare", "show what two or more runs differ in"),
    "navigate": Command("navigate", "train, measure and watch policies that get to goals"),
    "export": Command("export", "write a run's codes, and its network for other programs"),
    "inspect": Command("inspect", "describe a robot's log, or a map"),
    "import": Command("import_data", "write a robot's log as a table, or a map as a layout"),
    "reproduce": Command(
        "reproduce", "run the paper's experiments and the studies beyond them", AGAIN
    ),
    "sweep": Command("sweep", "run a grid or a random search over any setting", AGAIN),
    "completion": Command("completion", "print a completion script for a shell"),
}


def main(argv: Sequence[str] | None = None) -> None:
    """Run the command line. Wrong input ends with one sentence and exit code 2."""
    words = list(sys.argv[1:] if argv is None else argv)
    try:
        run(words)
    except UserError as error:
        _end(f"motorspace: {error}", 2)
    except KeyboardInterrupt:
        how = COMMANDS[words[0]].goes_on
        _end("motorspace: stopped" + (f"; {how} continues" if how else ""), 130)
    except BrokenPipeError:  # as of `| head`; what is still buffered goes nowhere
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def run(words: Sequence[str]) -> None:
    """Do what the words say. Raises `UserError` for wrong ones."""
    if not words or words[0] in ("-h", "--help"):
        print(general_help())
        return
    if words[0] == "--version":
        from importlib.metadata import version

        print(f"motorspace {version('motorspace')}")
        return
    name, *rest = words
    if name.startswith("-"):
        raise Usage(
            f"the flag {name} does not exist, or belongs to a command",
            remedy="begin with a command: motorspace COMMAND [options]",
        )
    if name not in COMMANDS:
        near = get_close_matches(name, COMMANDS, 1)
        raise Usage(
            f"there is no command {name!r}",
            remedy=f"perhaps {near[0]!r}" if near else f"choose one of {', '.join(COMMANDS)}",
        )
    module = importlib.import_module(f"motorspace.cli.{COMMANDS[name].module}")
    _import_modules(rest)
    parser = command_parser(name)
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_, **__: note(str(message))
        module.configure(parser, rest)
        module.run(parser.parse(rest))


def command_parser(name: str) -> CommandParser:
    """The empty parser of a command, with what all commands share."""
    parser = CommandParser(prog=f"motorspace {name}", description=_sentence(COMMANDS[name].help))
    parser.add_argument(
        "--import",
        dest="imports",
        action="append",
        default=[],
        metavar="MODULE",
        help="Import a Python module first, which registers classes of your own; may be repeated.",
    )
    return parser


def _import_modules(words: Sequence[str]) -> None:
    """Import what `--import` names. Only the person at the command line can ask for that."""
    names = [
        after
        for word, after in itertools.pairwise(words)
        if word == "--import" and not after.startswith("-")
    ]
    names += [word.partition("=")[2] for word in words if word.startswith("--import=")]
    if names and os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    for name in names:
        _import_module(name)


def _import_module(name: str) -> None:
    try:
        importlib.import_module(name)
    except UserError:
        raise
    except ModuleNotFoundError as error:
        missing = error.name or name
        remedy = f"install {missing!r}, which it imports"
        if name == missing or name.startswith(f"{missing}."):
            remedy = (
                "give the name of a module in this folder, without .py, or of one that is installed"
            )
        raise UserError(
            f"there is no module {missing!r}", where=f"--import {name}", remedy=remedy
        ) from None
    except Exception as error:  # the module is the person's own, and may fail in any way
        raise UserError(
            f"the module cannot be imported ({_place(error)}{type(error).__name__}: {error})",
            where=f"--import {name}",
            remedy="mend it",
        ) from None


def _place(error: Exception) -> str:
    """Where the last frame of an error is, as FILE:LINE."""
    if isinstance(error, SyntaxError):
        return ""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{last.filename}:{last.lineno}: "


def general_help() -> str:
    """The help for `motorspace` alone."""
    lines = [f"  {name:<12} {command.help}" for name, command in COMMANDS.items()]
    return "\n".join(
        [
            "usage: motorspace COMMAND [options]",
            "",
            "Learn the space of displacements of an agent from its motor commands and its sensors.",
            "",
            "commands:",
            *lines,
            "",
            "`motorspace COMMAND --help` lists the options of a command; `--version` the version.",
        ]
    )


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."


def _end(message: str, code: int) -> None:
    print(message, file=sys.stderr)
    sys.exit(code)
