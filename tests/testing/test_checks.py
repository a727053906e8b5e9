"""Our own agents, sensors and encoders pass the checks for those of others; broken ones do not."""

import math

import equinox as eqx
import jax
import jax.numpy as jnp
import pytest

from motorspace._types import Pose
from motorspace.models.config import ENCODERS
from motorspace.models.encoders.base import AbstractMotorEncoder, EncoderSize, executed
from motorspace.testing import check_agent, check_encoder, check_sensor
from motorspace.worlds.agents import AbstractAgent, ForwardAgent, HolonomicAgent, LatticeAgent
from motorspace.worlds.catalog import AGENTS, SENSORS
from motorspace.worlds.sensors.base import AbstractSensor
from motorspace.worlds.sensors.node_index import NodeIndex
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.spaces import ContinuousCommands, SensorSpace


@pytest.mark.parametrize(
    ("agent", "world"),
    [
        (ForwardAgent(), "empty"),
        (ForwardAgent(0.3), "four_rooms"),
        (HolonomicAgent(), "empty"),
        (HolonomicAgent(head_rule="turn", head_start="random"), "empty"),
        (LatticeAgent(), "lattice:4"),
    ],
    ids=str,
)
def test_our_agents_pass(agent, world):
    check_agent(agent, world)


@pytest.mark.parametrize(
    ("sensor", "world"),
    [
        (RangeFan(), "paper"),
        (RangeFan(1, 4.0), "empty"),
        (RangeFan(5, 3.0, 2 * math.pi, sense_head=True), "empty"),
        (NodeIndex(), "lattice:4"),
    ],
    ids=str,
)
def test_our_sensors_pass(sensor, world):
    check_sensor(sensor, world)


@pytest.mark.parametrize("kind", ENCODERS.names)
def test_our_encoders_pass(kind):
    check_encoder(ENCODERS.class_of(kind))


def test_encoders_of_one_unit_and_one_command_pass():
    check_encoder(ENCODERS.class_of("lstm"), EncoderSize(1, 1, 1, 1))


@pytest.fixture(autouse=True)
def nothing_stays_registered(monkeypatch):
    for registry in (AGENTS, SENSORS):
        monkeypatch.setattr(registry, "_added", dict(registry._added))


class Body(AbstractAgent):
    """A body that stays where it is. Tests change one thing about it."""

    @property
    def commands(self):
        return ContinuousCommands((-1.0,), (1.0,), ("turn",))

    def start(self, place, *, key):
        return place

    def turn(self, pose, motor):
        return Pose(pose.x, pose.y, pose.heading + motor[0], pose.head)

    def move(self, pose, motor):
        return (self.turn(pose, motor),)


class Drifting(Body):
    """Its turns translate it."""

    def turn(self, pose, motor):
        return Pose(pose.x + 0.1, pose.y, pose.heading, pose.head)


class Herd(Body):
    """It turns as all of them do in the mean."""

    def move(self, pose, motor):
        heading = pose.heading + jnp.mean(motor[0])
        return (Pose(pose.x, pose.y, heading, pose.head),)


class Lost(Body):
    """It leaves the numbers."""

    def move(self, pose, motor):
        return (Pose(pose.x * jnp.inf, pose.y, pose.heading, pose.head),)


class Greedy(ContinuousCommands):
    """Commands outside of their own bounds."""

    def sample(self, *, key):
        return jnp.array([3.0])


class Outside(Body):
    """Its commands leave their space."""

    @property
    def commands(self):
        return Greedy((-1.0,), (1.0,), ("turn",))


class Stuck(Body):
    """It has no legs."""

    def move(self, pose, motor):
        return ()


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (Body, None),
        (Drifting, "`turn` must not translate the body"),
        (Herd, "one and many differ in `heading`"),
        (Lost, "`x` must be finite"),
        (Outside, "random commands must lie within the bounds of their space"),
        (Stuck, "`move` must give at least one leg"),
    ],
)
def test_a_broken_agent_is_told_what_is_wrong(body, message):
    AGENTS.add(body.__name__, body)
    if message is None:
        check_agent(body())
        return
    with pytest.raises(AssertionError, match=message):
        check_agent(body())


class Nose(AbstractSensor):
    """Smells where it is along the x axis. Tests change one thing about it."""

    reach: float = eqx.field(static=True, default=100.0)

    def space(self, world):
        return SensorSpace((0.0,), (self.reach,), ("smell",))

    def sense(self, world, pose):
        return pose.x[None]


class Long(Nose):
    """It gives more readings than it says."""

    def sense(self, world, pose):
        return jnp.stack([pose.x, pose.y])


class Blind(Nose):
    """It gives no numbers."""

    def sense(self, world, pose):
        return pose.x[None] * jnp.nan


class Short(Nose):
    """It smells more than it says it can."""

    reach: float = eqx.field(static=True, default=0.1)


@pytest.mark.parametrize(
    ("nose", "message"),
    [
        (Nose, None),
        (Long, r"have the shape \(2, 32\), their space says \(1, 32\)"),
        (Blind, "readings must be finite"),
        (Short, "channel 'smell' leaves the bounds of its space"),
    ],
)
def test_a_broken_sensor_is_told_what_is_wrong(nose, message):
    SENSORS.add(nose.__name__, nose)
    if message is None:
        check_sensor(nose())
        return
    with pytest.raises(AssertionError, match=message):
        check_sensor(nose())


class Plain(AbstractMotorEncoder):
    """A linear map of the sum. Tests change one thing about it."""

    layer: eqx.nn.Linear

    def __init__(self, motor_size, hidden_size, code_size, *, key):
        self.layer = eqx.nn.Linear(motor_size, code_size, key=key)

    def __call__(self, motors, num_steps):
        return self.layer(jnp.sum(executed(motors, num_steps), axis=0))


class Nosy(Plain):
    """It counts rows that are no part of the sequence."""

    def __call__(self, motors, num_steps):
        return super().__call__(motors, num_steps) + float(len(motors))


class Random(Plain):
    """Its weights are not those of its key."""

    @classmethod
    def create(cls, size, *, key):
        del key
        key = jax.random.key(next(COUNTER))
        return cls(size.motor_size, size.hidden_size, size.code_size, key=key)


COUNTER = iter(range(1000))


class Steep(Plain):
    """Its gradient is not finite."""

    def __call__(self, motors, num_steps):
        return jnp.sqrt(0.0 * super().__call__(motors, num_steps))


class Negative(Plain):
    """Its penalty rewards."""

    def penalty(self, motors):
        return -jnp.mean(motors**2)


@pytest.mark.parametrize(
    ("encoder", "message"),
    [
        (Plain, None),
        (Nosy, "rows beyond `num_steps` change the code"),
        (Random, "the same key must give the same initial weights"),
        (Steep, "the gradient of the codes must be finite"),
        (Negative, "the penalty must be a scalar of at least 0"),
    ],
)
def test_a_broken_encoder_is_told_what_is_wrong(encoder, message):
    if message is None:
        check_encoder(encoder)
        return
    with pytest.raises(AssertionError, match=message):
        check_encoder(encoder)
