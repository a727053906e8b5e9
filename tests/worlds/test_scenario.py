"""A world, an agent and a sensor that fit together, from whatever names them."""

import math

import jax
import numpy as np
import pytest

from motorspace import (
    ForwardAgent,
    HolonomicAgent,
    LatticeAgent,
    LatticeWorld,
    NodeIndex,
    RangeFan,
    Scenario,
    UserError,
)
from motorspace._kinds import parameters_of
from motorspace.worlds.catalog import AGENTS, SENSORS, home_of
from motorspace.worlds.layouts import load_layout
from motorspace.worlds.scenario import world_of


@pytest.mark.parametrize("registry", [AGENTS, SENSORS], ids=["agents", "sensors"])
def test_the_catalog_says_what_the_classes_say(registry):
    for kind in registry.names:
        assert registry.parameters(kind) == parameters_of(registry.class_of(kind)), kind
        assert registry.class_of(kind).registry is registry
        made = registry.build(registry.part(kind))
        assert registry.part_of(made) == registry.part(kind)


@pytest.mark.parametrize("kind", AGENTS.names)
def test_every_agent_has_a_usual_sensor_and_world(kind):
    sensor, layout, *_ = home_of(kind)
    scenario = Scenario.of(AGENTS.part(kind), SENSORS.part(sensor), layout)
    pose = scenario.start(key=jax.random.key(0))
    assert scenario.sense(pose).shape == (scenario.space.size,)
    after, blocked = scenario.step(pose, scenario.commands.sample(key=jax.random.key(1)))
    assert blocked.shape == after.x.shape == ()


def test_a_configuration_names_every_option():
    made = Scenario.of(
        AGENTS.part("holonomic", {"max_rotation": 0.5, "head_rule": "turn"}),
        SENSORS.part("range_fan", {"num_rays": 30, "sense_head": True}),
        "rooms:2",
    )
    assert made.agent == HolonomicAgent(0.5, "turn")
    assert made.space.size == 31 and made.commands.scale[0] == 0.5


def test_a_world_is_built_once(tmp_path):
    path = tmp_path / "own.layout"
    path.write_text(load_layout("four_rooms").text())
    for name in ("paper", "rooms:3", path, str(path), load_layout("pillars")):
        assert world_of(name) is world_of(name)
    before = world_of(path)
    path.write_text(load_layout("empty").text())
    assert len(world_of(path).walls) != len(before.walls), "a file that changed is read again"


def test_the_lattice_has_a_name():
    assert world_of("lattice:4") == LatticeWorld(4, 4)
    scenario = Scenario("lattice:4", LatticeAgent(), NodeIndex())
    assert scenario.space.size == 20


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Scenario("nowhere"), "there is no layout 'nowhere'"),
        (lambda: Scenario("lattice:0"), "side of a lattice must be a whole number above 0"),
        (lambda: Scenario("lattice:six"), "side of a lattice .* got 'six'; write for instance"),
        (lambda: Scenario("lattice:3"), "a RangeFan cannot sense a LatticeWorld"),
        (lambda: Scenario("paper", LatticeAgent()), "from node to node"),
        (lambda: LatticeWorld(0, 3), "width must be at least 1, got 0"),
        (lambda: Scenario("title a\nwal 3"), "layout, line 2: unknown statement 'wal'"),
    ],
)
def test_what_does_not_fit_is_refused(make, message):
    with pytest.raises(UserError, match=message):
        make()


def test_the_default_is_the_papers_forward_agent():
    scenario = Scenario()
    assert (scenario.agent, scenario.sensor) == (ForwardAgent(0.8 * math.pi), RangeFan())


def test_worlds_say_what_to_draw():
    drawing = world_of("paper").drawing()
    np.testing.assert_array_equal(drawing.lines, world_of("paper").walls)
    assert drawing.bounds == (0.0, 0.0, 40.0, 40.0) and len(drawing.points) == 0
    drawing = LatticeWorld(3, 2).drawing()
    assert drawing.bounds == (-1.0, -1.0, 3.0, 2.0)
    assert drawing.points.shape == (6, 2) and drawing.lines.shape == (0, 2, 2)
