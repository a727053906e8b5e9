"""Flags: from the declared options of classes and configurations, parsed by argparse."""

import argparse
import math
import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import fields
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NoReturn

from motorspace._errors import UserError
from motorspace._kinds import Parameter


class Usage(UserError):
    """Words that make no command."""


class CommandParser(argparse.ArgumentParser):
    """An argument parser whose errors are one sentence, with the nearest flag there is."""

    def __init__(self, **described: Any) -> None:
        super().__init__(
            allow_abbrev=False,
            argument_default=argparse.SUPPRESS,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            **described,
        )
        self.register("type", int, whole)
        self.register("type", float, number)

    def add_parameters(self, title: str, parameters: Iterable[Parameter]) -> None:
        """A flag for each option. One that is not written leaves no trace in the result."""
        group = self.add_argument_group(title)
        for parameter in parameters:
            name = flag(parameter.name)
            if _type_of(parameter) is bool:
                group.add_argument(
                    name, action=argparse.BooleanOptionalAction, help=_help(parameter)
                )
                continue
            group.add_argument(
                name,
                type=_type_of(parameter),
                choices=parameter.choices or None,
                metavar=None if parameter.choices else _metavar(parameter),
                help=_help(parameter),
            )

    def parse(self, words: Sequence[str]) -> argparse.Namespace:
        """What the words say, flags between the others or not. Raises `Usage` for unknown flags."""
        options, unknown = self.parse_known_intermixed_args([_hyphens(word) for word in words])
        if unknown:
            self._refuse(unknown[0])
        return options

    def error(self, message: str) -> NoReturn:
        """Raise `Usage`."""
        where, what = None, message
        if message.startswith("argument "):
            names, _, what = message.removeprefix("argument ").partition(": ")
            where = names.partition("/")[0]
        raise Usage(_plain(what), where=where, remedy=self._see_help())

    def _refuse(self, word: str) -> NoReturn:
        if not word.startswith("-"):
            if word in SWITCHES:
                raise Usage(
                    f"nothing is expected here: {word!r}",
                    remedy="flags that switch take no value: write --FLAG or --no-FLAG",
                )
            raise Usage(f"nothing is expected here: {word!r}", remedy=self._see_help())
        name = word.partition("=")[0]
        if name[2:].upper() in {action.metavar for action in self._get_positional_actions()}:
            raise Usage(
                f"{name[2:].upper()} is given without a flag",
                where=name,
                remedy=f"write: {self.prog} {name[2:].upper()}",
            )
        if owners := owners_of(name):
            raise Usage(f"the flag {name} applies to {owners} only", remedy=self._see_help())
        bare = {known.lstrip("-"): known for known in self._option_string_actions}
        near = get_close_matches(name.lstrip("-"), bare, 1)
        raise Usage(
            f"the flag {name} does not exist",
            remedy=f"perhaps {bare[near[0]]}" if near else self._see_help(),
        )

    def _see_help(self) -> str:
        return f"see {self.prog} --help"


SWITCHES = ("true", "false", "yes", "no", "on", "off")


def _plain(message: str) -> str:
    """What argparse says, as a sentence about what the person wrote."""
    message = message.replace("argument: ", "")
    if found := re.fullmatch(r"invalid choice: (.*) \(choose from (.*)\)", message):
        return f"{found[1]} is not one of {found[2].replace(chr(39), '')}"
    if message.startswith("ignored explicit argument"):
        return "the flag takes no value"
    if message.startswith("the following arguments are required: "):
        return f"{message.partition(': ')[2]} is missing"
    return {
        "expected one argument": "its value is missing",
        "expected at least one argument": "its values are missing",
    }.get(message, message)


def flag(name: str) -> str:
    """An option's name as a flag."""
    return f"--{name.replace('_', '-')}"


def whole(word: str) -> int:
    """A whole number, as an argument's type."""
    try:
        return int(word)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a whole number, got {word!r}") from None


def count(word: str) -> int:
    """A whole number above zero, as an argument's type."""
    value = whole(word)
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1, got {word}")
    return value


def seed(word: str) -> int:
    """The seed of a random number generator, as an argument's type."""
    value = whole(word)
    if not 0 <= value < 2**31:
        raise argparse.ArgumentTypeError(f"must be from 0 to {2**31 - 1}, got {word}")
    return value


def number(word: str) -> float:
    """A finite number, as an argument's type."""
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"must be a number, got {word!r}")
    return value


def existing(word: str) -> Path:
    """A path that exists, as an argument's type."""
    if not Path(word).exists():
        raise UserError("there is no such file", where=word, remedy="check the path")
    return Path(word)


def note(sentence: str) -> None:
    """Tell a person something beside the results."""
    print(f"motorspace: {sentence}", file=sys.stderr)


def _hyphens(word: str) -> str:
    """--max_rotation is --max-rotation."""
    name, equals, value = word.partition("=")
    return name.replace("_", "-") + equals + value if word.startswith("--") else word


def _type_of(parameter: Parameter) -> type:
    if parameter.type is not None:
        kind: type = parameter.type
        return kind
    return str if parameter.default is None else type(parameter.default)


def _metavar(parameter: Parameter) -> str:
    return {int: "N", float: "X"}.get(
        _type_of(parameter), parameter.name.rpartition("_")[2].upper()
    )


def _help(parameter: Parameter) -> str:
    value = parameter.default
    if parameter.in_pi and value is not None:
        value = round(value / math.pi, 6)
    unit = " In units of pi." if parameter.in_pi else ""
    default = (
        ""
        if value is None
        else f" (default: {str(value).lower() if isinstance(value, bool) else value})"
    )
    return f"{parameter.help}{unit}{default}".replace("%", "%%")


def owners_of(flag: str) -> str:
    """Whose flag of `motorspace train` it is: agents, sensors, readers, simulations, logs."""
    from motorspace.models.config import ModelConfig
    from motorspace.recordings.catalog import READERS
    from motorspace.training.config import TrainingConfig
    from motorspace.training.settings import LOGGED, SIMULATED
    from motorspace.worlds.catalog import AGENTS, SENSORS

    name = flag.removeprefix("--no-").removeprefix("--").replace("-", "_")
    owners = []
    for registry in (AGENTS, SENSORS, READERS):
        kinds = [
            kind for kind in registry.names if name in {p.name for p in registry.parameters(kind)}
        ]
        if kinds:
            plural = "s" * (len(kinds) > 1)
            owners.append(f"the {registry.family}{plural} {' and '.join(kinds)}")
    settings = {p.name for p in SIMULATED}, {p.name for p in LOGGED}
    owners += ["simulations"] * (name in settings[0]) + ["logs (--data)"] * (name in settings[1])
    if name in {field.name for part in (ModelConfig, TrainingConfig) for field in fields(part)}:
        owners.append("motorspace train")
    return " and ".join(owners)
