"""Classes by name: agents, sensors, encoders and readers, ours and those of others.

A configuration is plain data, so it names a class (its *kind*) and the options that it is made
with: a `Part`. A registry turns parts into objects and back. Only classes that are already
imported, or that come with motorspace, can be found: nothing that a file names is ever imported.
"""

import ast
import dataclasses
import functools
import importlib
import inspect
import itertools
import math
import textwrap
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from typing import Any, Generic, TypeVar, get_args, get_type_hints

from motorspace._errors import UserError

Class = TypeVar("Class", bound=type)
T = TypeVar("T")


@dataclasses.dataclass(frozen=True)
class Parameter:
    """One option of a class: a key in JSON, a flag on the command line."""

    name: str
    default: Any
    help: str = ""
    choices: tuple[Any, ...] = ()
    in_pi: bool = False
    """Whether people write it in units of pi. In objects and in JSON it is in radians."""
    positive: bool = False
    """Whether it must be a finite number above zero."""
    type: Any = None
    """What a flag is converted to; the type of the default where that is None."""

    def check(self, value: Any) -> None:
        """Raise `UserError` for a value that the option cannot have."""
        shown = value / math.pi if self.in_pi and isinstance(value, float) else value
        unit = " (in units of pi)" if self.in_pi else ""
        if self.choices and value not in self.choices:
            raise UserError(
                f"{self.name} is {value!r}", remedy=f"choose one of {', '.join(self.choices)}"
            )
        if self.positive and not 0 < value < math.inf:
            raise UserError(f"{self.name} must be above 0{unit}, got {shown}")

    def exact(self, value: Any) -> Any:
        """The value, a whole number for a float as that float: equal parts have equal JSON."""
        whole = isinstance(value, int) and not isinstance(value, bool)
        return float(value) if whole and isinstance(self.default, float) else value


@dataclasses.dataclass(frozen=True)
class Part:
    """A component of a system as data: the kind of its class, and the options it is made with.

    Args:
        kind: The name under which the class is registered.
        options: (name, value) of options; those left out have their defaults.

    Example:
        >>> Part("forward", (("max_rotation", 0.5),)).as_json()
        {'kind': 'forward', 'max_rotation': 0.5}
    """

    kind: str
    options: tuple[tuple[str, Any], ...] = ()

    def as_json(self) -> dict[str, Any]:
        """{"kind": ..., every option by its name}."""
        return {"kind": self.kind, **dict(self.options)}


@dataclasses.dataclass(frozen=True)
class Builtin:
    """Where a class of motorspace is, and its options, known without importing it."""

    module: str
    name: str
    parameters: tuple[Parameter, ...] = ()
    light: bool = False
    """Whether its module imports nothing heavy, so that the class itself may be asked."""


class Registry(Generic[T]):
    """The classes of one family by their kind."""

    def __init__(self, family: str, builtins: Mapping[str, Builtin]) -> None:
        self.family = family
        self._builtins = dict(builtins)
        self._added: dict[str, type[T]] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """Every kind that is known by now."""
        return (*self._builtins, *self._added)

    def add(self, kind: str, added: type[T]) -> None:
        """Make a class known. Raises `UserError` when the name belongs to another class."""
        known = self._added.get(kind)
        # A module that is run again, as in a notebook, defines its classes anew.
        same = known is not None and (known.__module__, known.__qualname__) == (
            added.__module__,
            added.__qualname__,
        )
        if kind in self._builtins or (known is not None and not same):
            raise UserError(
                f"there already is a {self.family} named {kind!r}", remedy="choose another name"
            )
        self._added[kind] = added

    def class_of(self, kind: str) -> type[T]:
        """The class of a kind. Raises `UserError` naming those there are."""
        self.check(kind)
        if kind in self._added:
            return self._added[kind]
        builtin = self._builtins[kind]
        found: type[T] = getattr(importlib.import_module(builtin.module), builtin.name)
        return found

    def check(self, kind: str, *, where: object = None) -> None:
        """Raise `UserError` unless there is such a kind."""
        if kind in self.names:
            return
        near = get_close_matches(str(kind), self.names, 1)
        raise UserError(
            f"there is no {self.family} named {kind!r}"
            + "".join(f" (perhaps {name!r})" for name in near),
            where=where,
            remedy=f"choose one of {', '.join(self.names)}, or import the module that registers it"
            " (on the command line: --import MODULE)",
        )

    def parameters(self, kind: str) -> tuple[Parameter, ...]:
        """The options of a kind; those of motorspace's own classes without importing them."""
        self.check(kind)
        if kind in self._builtins and not self._builtins[kind].light:
            return self._builtins[kind].parameters
        return parameters_of(self.class_of(kind))

    def part(self, kind: str, options: Mapping[str, Any] = {}, *, where: object = None) -> Part:
        """The part with these options, and the defaults of all others.

        Raises `UserError` for an unknown kind or option.
        """
        self.check(kind, where=where)
        known = {p.name: p.default for p in self.parameters(kind)}
        if unknown := options.keys() - known.keys():
            raise UserError(
                f"the {self.family} {kind!r} has no option {', '.join(sorted(unknown))}",
                where=where,
                remedy=f"its options are {', '.join(known) or 'none'}",
            )
        for parameter in self.parameters(kind):
            if parameter.name in options:
                parameter.check(options[parameter.name])
        made = known | dict(options)
        return Part(kind, tuple((p.name, p.exact(made[p.name])) for p in self.parameters(kind)))

    def part_of(self, value: T) -> Part:
        """The part that describes an object. Raises `UserError` for an unregistered class."""
        kind = self._kind_of(type(value))
        options = ((p.name, p.exact(getattr(value, p.name))) for p in self.parameters(kind))
        return Part(kind, tuple(options))

    def build(self, part: Part) -> T:
        """The object that a part describes. Raises `UserError` for options that do not fit."""
        made = self.class_of(part.kind)
        try:
            return made(**dict(part.options))
        except (TypeError, ValueError) as error:
            raise UserError(
                f"the {self.family} {part.kind!r} cannot be made ({error})",
                remedy="check its options",
            ) from None

    def _kind_of(self, wanted: type) -> str:
        for kind, known in self._added.items():
            if known is wanted:
                return kind
        for kind, builtin in self._builtins.items():
            if (wanted.__module__, wanted.__qualname__) == (builtin.module, builtin.name):
                return kind
        raise UserError(
            f"the class {wanted.__qualname__} is not registered",
            remedy=f'put @motorspace.register("NAME") above it, so that a run can name its '
            f"{self.family}",
        )


def parameters_of(described: type) -> tuple[Parameter, ...]:
    """The options of a dataclass (an Equinox module is one): its fields, with their docstrings.

    A field whose metadata hold {"in_pi": True} is written in units of pi on the command line, one
    with {"positive": True} must be above zero.
    """
    docs: dict[str, str] = {}
    for ancestor in filter(dataclasses.is_dataclass, reversed(described.__mro__)):
        docs |= field_docstrings(ancestor)
    hints = get_type_hints(described)
    return tuple(
        Parameter(
            name=field.name,
            default=_default(field),
            help=docs.get(field.name, ""),
            choices=_choices(hints.get(field.name)),
            in_pi=bool(field.metadata.get("in_pi", False)),
            positive=bool(field.metadata.get("positive", False)),
            type=_type(hints.get(field.name)) if _default(field) is None else None,
        )
        for field in dataclasses.fields(described)
        if field.init
    )


@functools.cache
def field_docstrings(described: type) -> dict[str, str]:
    """The string below each field in a class's source, on one line; empty where no source is."""
    try:
        source = textwrap.dedent(inspect.getsource(described))
    except (OSError, TypeError):
        return {}
    (body,) = (node.body for node in ast.parse(source).body if isinstance(node, ast.ClassDef))
    docs = {}
    for node, after in itertools.pairwise(body):
        if (
            isinstance(node, ast.AnnAssign)
            and isinstance(node.target, ast.Name)
            and isinstance(after, ast.Expr)
            and isinstance(after.value, ast.Constant)
            and isinstance(after.value.value, str)
        ):
            docs[node.target.id] = " ".join(after.value.value.split())
    return docs


def to_radians(parameter: Parameter, value: Any) -> Any:
    """A value as a person writes it, in the unit of the object."""
    return value * math.pi if parameter.in_pi else value


def _default(field: "dataclasses.Field[Any]") -> Any:
    if field.default is not dataclasses.MISSING:
        return field.default
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    raise UserError(
        f"the option {field.name!r} has no default",
        remedy="give every field of a registered class a default value",
    )


def _type(hint: Any) -> Any:
    """The one type of a hint such as `int | None`; None where there is no one."""
    found = [kind for kind in get_args(hint) or (hint,) if kind is not type(None)]
    return found[0] if len(found) == 1 and found[0] in (int, float, str, bool) else None


def _choices(hint: Any) -> tuple[Any, ...]:
    """The values of a `Literal`, else none."""
    found = get_args(hint)
    return found if found and all(isinstance(value, str) for value in found) else ()


def register(kind: str) -> Callable[[Class], Class]:
    """Return a decorator that makes an agent, sensor, encoder or reader known by a name.

    Its fields become options: keys in a run's folder, flags on the command line.

    Args:
        kind: The name, for configurations and the command line.

    Raises:
        UserError: When the class belongs to none of these families, or the name is taken.
    """

    def added(cls: Class) -> Class:
        registry: Registry[Any] | None = getattr(cls, "registry", None)
        if registry is None:
            raise UserError(
                f"the class {cls.__qualname__} is no agent, sensor, encoder or reader",
                remedy="derive it from AbstractAgent, AbstractSensor, AbstractMotorEncoder or "
                "AbstractReader",
            )
        registry.add(kind, cls)
        return cls

    return added
