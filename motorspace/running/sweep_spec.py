"""How a sweep is written: a few lines of TOML, or flags.

name = "table1"
agent = ["forward", "holonomic"]
seeds = 3
samples = 10

[fixed]
epochs = 1000

[grid]
max-rotation = [0.2, 0.4, 0.6, 0.8, 1.0, 1.2]

[random]
learning-rate = { log-uniform = [1e-4, 1e-2] }
"""

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from motorspace._errors import UserError
from motorspace.running.jobs import Value
from motorspace.running.store import CONFIGS
from motorspace.running.sweep import SAVED, Distribution, Sweep, nearest

KEYS = {
    "name": "the name of its results",
    "agent": "an agent, or a list of them",
    "preset": "the preset that all runs start from",
    "seeds": "how many seeds, or a list of them",
    "measure": "what to measure",
    "metrics": "which measures tables show",
    "fixed": "flags that are the same for all runs",
    "grid": "lists of values by flag",
    "random": "distributions by flag",
    "samples": "how many random values",
    "random-seed": "the seed of the random values",
}

TABLES = ("fixed", "grid", "random")

DISTRIBUTIONS = ("uniform", "log-uniform", "choice")


def read_sweep(path: Path) -> Sweep:
    """The sweep that a TOML file describes, or that the runs in a folder belong to.

    Raises `UserError` naming file and key.
    """
    path = path / SAVED if path.is_dir() else path
    try:
        content = path.read_text()
        spec = json.loads(content) if path.name == SAVED else tomllib.loads(content)
    except OSError as error:
        raise UserError(
            f"the sweep cannot be read ({error.strerror})",
            where=path,
            remedy="give a TOML file, or the folder of a sweep's runs",
        ) from None
    except ValueError as error:
        raise UserError(
            f"this is no sweep ({error})",
            where=path,
            remedy="write it as docs/how-to/sweep.md says",
        ) from None
    return sweep_from(spec, name=path.stem, where=str(path))


def sweep_of_flags(
    name: str,
    *,
    grid: Sequence[str] = (),
    random: Sequence[str] = (),
    fixed: Sequence[str] = (),
    **keys: Any,
) -> Sweep:
    """The sweep that flags describe. Raises `UserError` naming the flag.

    Args:
        name: The sweep's name.
        grid: FLAG=VALUE,VALUE,... each.
        random: FLAG=KIND:VALUE,VALUE,... each.
        fixed: FLAG=VALUE each.
        **keys: The other keys of a sweep's file; None where they are not given.

    >>> sweep_of_flags("mine", grid=["max-rotation=0.2,0.4"], agent="forward").grid
    {'max_rotation': (0.2, 0.4)}
    """
    spec = {key.replace("_", "-"): value for key, value in keys.items() if value is not None}
    spec["grid"] = {flag: _words(values) for flag, values in _pairs("grid", grid)}
    spec["fixed"] = {flag: _word(value) for flag, value in _pairs("fixed", fixed)}
    spec["random"] = {}
    for flag, drawn in _pairs("random", random):
        kind, _, values = drawn.partition(":")
        spec["random"][flag] = {kind: _words(values)}
    return sweep_from(spec, name=name, where="sweep")


def sweep_from(spec: Mapping[str, Any], *, name: str, where: str) -> Sweep:
    """The sweep that the contents of a TOML file describe. Raises `UserError` naming the key.

    Args:
        spec: The contents of the file, or the same from flags.
        name: The sweep's name if the contents have none.
        where: The file, for messages.

    >>> spec = {"agent": "forward", "seeds": 2, "grid": {"max-rotation": [0.2, 0.4]}}
    >>> sweep_from(spec, name="mine", where="mine.toml").grid
    {'max_rotation': (0.2, 0.4)}
    """
    reader = _Reader(where, spec)
    reader.check_keys()
    sweep = Sweep(
        name=reader.name(name),
        agents=reader.list_of(str, "agent", spec.get("agent", "forward")),
        seeds=reader.seeds(),
        fixed=reader.fixed(),
        grid={flag: reader.list_of(Value, f"grid.{flag}", v) for flag, v in reader.table("grid")},
        random={flag: reader.distribution(flag, v) for flag, v in reader.table("random")},
        samples=reader.count("samples", default=1, least=1),
        random_seed=reader.count("random-seed", default=0, least=0),
        measure=reader.word("measure"),
        metrics=reader.list_of(str, "metrics", spec["metrics"]) if spec.get("metrics") else (),
        where=where,
    )
    return Sweep(**vars(sweep) | {part: _underscored(getattr(sweep, part)) for part in TABLES})


def _underscored(flags: Mapping[str, Any]) -> dict[str, Any]:
    return {flag.replace("-", "_"): value for flag, value in flags.items()}


@dataclass(frozen=True)
class _Reader:
    """Reads the keys of a sweep, and refuses what they cannot be."""

    where: str
    spec: Mapping[str, Any]

    def refuse(self, key: str, what: str, remedy: str = "") -> NoReturn:
        raise UserError(what, where=f"{self.where}, {key}", remedy=remedy)

    def check_keys(self) -> None:
        for key in self.spec:
            if key == "import":
                self.refuse(
                    key,
                    "a file cannot say which code to run",
                    "name the module on the command line: --import MODULE",
                )
            if key not in KEYS:
                remedy = f"the keys are {', '.join(KEYS)}; flags stand in [fixed], [grid], [random]"
                self.refuse(key, f"a sweep has no key {key!r}{nearest(key, [*KEYS])}", remedy)
        self.check_flags()
        if self.spec.get("random") and "samples" not in self.spec:
            self.refuse("samples", "nobody says how many random values", "write samples = N")
        if self.spec.get("samples", 1) != 1 and not self.spec.get("random"):
            self.refuse("samples", "nothing is random here", "say what is in a table [random]")

    def check_flags(self) -> None:
        """Refuse flags that stand twice, or have a key of their own."""
        places: dict[str, str] = {"agent": "agent", "seed": "seeds", "import": "--import"}
        if "preset" in self.spec:
            places["preset"] = "preset"
        for part in TABLES:
            for flag, _ in self.table(part):
                other = places.setdefault(flag.replace("-", "_"), part)
                if other != part:
                    self.refuse(f"{part}.{flag}", f"{flag!r} belongs to {other}, and to it alone")

    def table(self, part: str) -> list[tuple[str, Any]]:
        found = self.spec.get(part, {})
        if not isinstance(found, Mapping):
            self.refuse(part, "this is no table", f"write [{part}], and below it FLAG = ...")
        return [*found.items()]

    def name(self, default: str) -> str:
        name = self.spec.get("name", default)
        if not isinstance(name, str) or not re.fullmatch(r"\w[\w.-]*", name):
            self.refuse("name", f"{name!r} is no name of a file", "use letters, digits, - and _")
        if f"{name}.jsonl" == CONFIGS:
            self.refuse("name", f"{name!r} is the file of all configurations", "choose another")
        return name

    def word(self, key: str) -> str:
        found = self.spec.get(key, "")
        if not isinstance(found, str):
            self.refuse(key, f"this must be a name, not {found!r}")
        return found

    def count(self, key: str, *, default: int, least: int) -> int:
        found = self.spec.get(key, default)
        if not _is_count(found) or found < least:
            self.refuse(key, f"this must be a whole number from {least}, not {found!r}")
        return int(found)

    def seeds(self) -> tuple[int, ...]:
        found = self.spec.get("seeds", 3)
        if not isinstance(found, Sequence):
            return tuple(range(self.count("seeds", default=3, least=1)))
        if isinstance(found, str) or not found or not all(_is_count(s) and s >= 0 for s in found):
            self.refuse("seeds", f"{found!r} is neither a number nor a list of seeds from 0")
        return tuple(found)

    def fixed(self) -> dict[str, Value]:
        found = dict(self.table("fixed"))
        for flag, value in found.items():
            if not isinstance(value, Value):
                self.refuse(f"fixed.{flag}", f"this must be one value, not {value!r}")
        return found | ({"preset": self.word("preset")} if "preset" in self.spec else {})

    def list_of(self, kind: Any, key: str, found: Any) -> tuple[Any, ...]:
        values = (found,) if isinstance(found, str) and kind is str else found
        if not isinstance(values, Sequence) or isinstance(values, str) or not values:
            self.refuse(key, f"this must be a list of values, not {found!r}", "write [A, B, ...]")
        for value in values:
            if not isinstance(value, kind):
                self.refuse(key, f"{value!r} cannot stand here")
        return tuple(values)

    def distribution(self, flag: str, found: Any) -> Distribution:
        key = f"random.{flag}"
        if (
            not isinstance(found, Mapping)
            or len(found) != 1
            or not found.keys() <= {*DISTRIBUTIONS}
        ):
            self.refuse(
                key,
                f"{found!r} is no distribution",
                f"write {flag} = {{ uniform = [LOW, HIGH] }}, or log-uniform, or choice",
            )
        ((kind, values),) = found.items()
        numbers = self.list_of(Value if kind == "choice" else int | float, key, values)
        if kind != "choice" and not (len(numbers) == 2 and numbers[0] < numbers[1]):
            self.refuse(key, f"{values!r} are not a lower and a higher bound")
        if kind == "log-uniform" and numbers[0] <= 0:
            self.refuse(key, f"{numbers[0]!r} has no logarithm", "give bounds above 0")
        return Distribution(kind, numbers)


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _pairs(flag: str, words: Sequence[str]) -> list[tuple[str, str]]:
    found = []
    for word in words:
        name, equals, value = word.partition("=")
        if not (name and equals and value):
            raise UserError(
                f"{word!r} is not FLAG=VALUES", where=f"--{flag}", remedy=f"see {EXAMPLES[flag]}"
            )
        found.append((name, value))
    return found


EXAMPLES = {
    "grid": "--grid max-rotation=0.2,0.4",
    "fixed": "--fixed epochs=100",
    "random": "--random learning-rate=log-uniform:1e-4,1e-2",
}


def _words(values: str) -> list[Value]:
    return [_word(word) for word in values.split(",")]


def _word(word: str) -> Value:
    """A value as TOML would read it; what it cannot read is a string."""
    try:
        value = tomllib.loads(f"value = {word}")["value"]
    except ValueError:
        return word
    return value if isinstance(value, str | int | float) else word
