"""`motorspace completion`."""

import argparse
import importlib
from collections.abc import Sequence

from motorspace.cli.parsing import CommandParser

SHELLS = ("bash", "zsh", "tcsh")


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command."""
    del words
    parser.add_argument(
        "shell", choices=SHELLS, metavar="SHELL", help=f"The shell: {', '.join(SHELLS)}."
    )


def run(options: argparse.Namespace) -> None:
    """Print a script that completes commands and flags; for bash: `eval "$(...)"`."""
    import shtab

    from motorspace.cli.main import COMMANDS, command_parser

    whole = argparse.ArgumentParser(prog="motorspace")
    commands = whole.add_subparsers()
    for name, command in COMMANDS.items():
        parser = command_parser(name)
        importlib.import_module(f"motorspace.cli.{command.module}").configure(parser, [])
        commands.add_parser(name, parents=[parser], add_help=False, help=command.help)
    print(shtab.complete(whole, shell=options.shell))
