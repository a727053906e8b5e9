"""Flags: from the declared options of classes and configurations, parsed by argparse."""

import argparse
import math
import sys
from collections.abc import Callable, Iterable, Sequence
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
                type=converter(_type_of(parameter)),
                choices=parameter.choices or None,
                metavar=None if parameter.choices else _metavar(parameter),
                help=_help(parameter),
            )

    def parse(self, words: Sequence[str]) -> argparse.Namespace:
        """What the words say. Raises `Usage` for flags that there are not."""
        options, unknown = self.parse_known_args([_hyphens(word) for word in words])
        if unknown:
            self._refuse(unknown[0])
        return options

    def error(self, message: str) -> NoReturn:
        """Raise `Usage`."""
        if message.startswith("argument "):
            where, _, what = message.removeprefix("argument ").partition(": ")
            raise Usage(what.replace("argument: ", ""), where=where, remedy=self._see_help())
        raise Usage(message, remedy=self._see_help())

    def _refuse(self, word: str) -> NoReturn:
        if not word.startswith("-"):
            raise Usage(f"nothing is expected here: {word!r}", remedy=self._see_help())
        name = word.partition("=")[0]
        near = get_close_matches(name, self._option_string_actions, 1)
        elsewhere = _who_has(name)
        raise Usage(
            f"the flag {name} {'applies to ' + elsewhere if elsewhere else 'does not exist'}"
            + (" only" if elsewhere else ""),
            remedy=f"perhaps {near[0]}" if near and not elsewhere else self._see_help(),
        )

    def _see_help(self) -> str:
        return f"see {self.prog} --help"


def flag(name: str) -> str:
    """An option's name as a flag."""
    return f"--{name.replace('_', '-')}"


def converter(kind: type) -> Callable[[str], Any]:
    """From a word to a value, with a sentence where it is none."""

    def whole(word: str) -> int:
        try:
            return int(word)
        except ValueError:
            raise argparse.ArgumentTypeError(f"must be a whole number, got {word!r}") from None

    def number(word: str) -> float:
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise argparse.ArgumentTypeError(f"must be a number, got {word!r}")
        return value

    return {int: whole, float: number}.get(kind, kind)


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
    if parameter.in_pi:
        value = round(value / math.pi, 6)
    unit = " In units of pi." if parameter.in_pi else ""
    default = (
        ""
        if value is None
        else f" (default: {str(value).lower() if isinstance(value, bool) else value})"
    )
    return f"{parameter.help}{unit}{default}".replace("%", "%%")


def _who_has(name: str) -> str:
    """Whose flag it is, where it does not apply here."""
    from motorspace.recordings.catalog import READERS
    from motorspace.worlds.catalog import AGENTS, SENSORS

    owners = [
        f"the {registry.family} {kind}"
        for registry in (AGENTS, SENSORS, READERS)
        for kind in registry.names
        if name.removeprefix("--no-").removeprefix("--").replace("-", "_")
        in {p.name for p in registry.parameters(kind)}
    ]
    return " and ".join(owners)
