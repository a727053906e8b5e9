"""Classes are known by name, described as data, and never imported because a file names them."""

import dataclasses
import math
import sys
from typing import Any, ClassVar, Literal

import pytest

import motorspace as ms
from motorspace._errors import UserError
from motorspace._kinds import Builtin, Parameter, Part, Registry, parameters_of, to_radians


@dataclasses.dataclass(frozen=True)
class Tool:
    """What the registry of these tests holds."""

    registry: ClassVar[Registry[Any]] = Registry("tool", {})

    size: int = 3
    """How large it is,
    in steps."""
    angle: float = dataclasses.field(default=0.5 * math.pi, metadata={"in_pi": True})
    """How far it turns."""
    mode: Literal["slow", "fast"] = "slow"
    limit: float | None = None
    weight: float = dataclasses.field(default=1.0, metadata={"positive": True})


@pytest.fixture
def tools():
    registry = Registry("tool", {"json": Builtin("antigravity", "Tool", (Parameter("size", 1),))})
    registry.add("saw", Tool)
    return registry


def test_the_fields_of_a_class_are_its_options():
    size, angle, mode, limit, weight = parameters_of(Tool)
    assert (size.name, size.default, size.help) == ("size", 3, "How large it is, in steps.")
    assert angle.in_pi and to_radians(angle, 0.25) == 0.25 * math.pi
    assert to_radians(size, 2) == 2
    assert mode.choices == ("slow", "fast")
    assert (limit.default, limit.type) == (None, float)
    assert weight.positive


def test_a_part_and_its_object_describe_each_other(tools):
    part = tools.part("saw", {"size": 5})
    assert part.as_json() == {"kind": "saw", "size": 5, "angle": 0.5 * math.pi, "mode": "slow"} | {
        "limit": None,
        "weight": 1.0,
    }
    assert tools.build(part) == Tool(5)
    assert tools.part_of(Tool(5)) == part


def test_whole_numbers_for_floats_describe_the_same_part(tools):
    assert tools.part("saw", {"weight": 2}) == tools.part("saw", {"weight": 2.0})
    assert type(dict(tools.part("saw", {"weight": 2}).options)["weight"]) is float


@pytest.mark.parametrize(
    ("kind", "options", "message"),
    [
        ("swa", {}, r"no tool named 'swa' \(perhaps 'saw'\); choose one of json, saw, or import"),
        ("saw", {"sise": 1}, "the tool 'saw' has no option sise; its options are size, angle"),
        ("saw", {"mode": "idle"}, "mode is 'idle'; choose one of slow, fast"),
        ("saw", {"weight": 0.0}, "weight must be above 0"),
        ("saw", {"weight": math.nan}, "weight must be above 0"),
    ],
)
def test_wrong_parts_are_one_sentence(tools, kind, options, message):
    with pytest.raises(UserError, match=message):
        tools.part(kind, options)


def test_options_that_a_class_refuses_are_one_sentence(tools):
    with pytest.raises(UserError, match="the tool 'saw' cannot be made"):
        tools.build(Part("saw", (("unknown", 1),)))


def test_describing_a_class_of_ours_does_not_import_it(tools):
    assert tools.part("json").as_json() == {"kind": "json", "size": 1}
    assert "antigravity" not in sys.modules


def test_a_name_belongs_to_one_class_and_a_notebook_may_run_its_cell_again(tools):
    again = dataclasses.make_dataclass("Tool", [], namespace={"__module__": __name__})
    tools.add("saw", again)
    assert tools.class_of("saw") is again
    for taken in ("saw", "json"):
        with pytest.raises(UserError, match=f"there already is a tool named {taken!r}"):
            tools.add(taken, Builtin)


def test_a_class_outside_every_family_cannot_be_registered():
    with pytest.raises(UserError, match="no agent, sensor, encoder or reader; derive it from"):
        ms.register("thing")(Builtin)


def test_an_object_of_a_class_without_a_name_says_how_to_give_it_one(tools):
    with pytest.raises(UserError, match=r"put @motorspace\.register"):
        tools.part_of(Parameter("x", 1))


def test_an_option_without_a_default_is_refused():
    with pytest.raises(UserError, match="the option 'x' has no default"):
        parameters_of(dataclasses.make_dataclass("Bare", [("x", int)]))
