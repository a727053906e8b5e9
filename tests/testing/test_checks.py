"""The checks pass for our own classes, and each is seen to fail for a class with one mistake."""

import dataclasses
import itertools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace._types import Pose
from motorspace.models.config import ENCODERS
from motorspace.models.encoders.base import AbstractMotorEncoder
from motorspace.recordings.readers.table import TableReader
from motorspace.testing import check_agent, check_encoder, check_reader, check_sensor
from motorspace.worlds.agents import ForwardAgent, HolonomicAgent, LatticeAgent
from motorspace.worlds.catalog import AGENTS, SENSORS
from motorspace.worlds.sensors.node_index import NodeIndex
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.spaces import ContinuousCommands, SensorSpace

count = itertools.count(1)


@pytest.mark.parametrize(
    ("agent", "world"),
    [
        (ForwardAgent(), "paper"),
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
        (RangeFan(num_rays=1, max_range=3.0, field_of_view=1.0, sense_head=True), "empty"),
        (NodeIndex(), "lattice:4"),
    ],
    ids=str,
)
def test_our_sensors_pass(sensor, world):
    check_sensor(sensor, world)


@pytest.mark.parametrize("kind", ENCODERS._builtins)
def test_our_encoders_pass(kind):
    check_encoder(ENCODERS.class_of(kind))


# --- agents, one mistake each


class Commands(ContinuousCommands):
    def __init__(self, sample):
        super().__init__((-1.0, 0.0), (1.0, 1.0), ("rotation", "move"))
        object.__setattr__(self, "change", sample)

    def sample(self, *, key):
        return self.change(super().sample(key=key))


def agent_that_samples(change):
    class Agent(ForwardAgent):
        @property
        def commands(self):
            return Commands(change)

    return Agent


def agent_that_ends_at(change):
    class Agent(ForwardAgent):
        def move(self, pose, motor):
            return change(super().move(pose, motor)[-1], motor)

    return Agent


class Doubled(ForwardAgent):
    speed: float = eqx.field(static=True, default=1.0, converter=lambda value: 2 * value)


class Sliding(ForwardAgent):
    def turn(self, pose, motor):
        return Pose(pose.x + 0.1, pose.y, pose.heading, pose.head)


def further(pose, metres):
    return (Pose(pose.x + metres, pose.y, pose.heading, pose.head),)


AGENT_MISTAKES = {
    "built from its own options differs": Doubled,
    "commands have the shape": agent_that_samples(lambda motor: motor[:1]),
    "random commands must be finite": agent_that_samples(lambda motor: motor / 0.0),
    "within the bounds": agent_that_samples(lambda motor: motor + 2.0),
    "the same key": agent_that_samples(lambda motor: motor / next(count)),
    "at least one leg": agent_that_ends_at(lambda pose, motor: ()),
    "loses the batch": agent_that_ends_at(
        lambda pose, motor: (jax.tree.map(lambda field: field[..., :1], pose),)
    ),
    "`x` must be finite": agent_that_ends_at(lambda pose, motor: further(pose, jnp.nan)),
    "`turn` must not translate": Sliding,
    "one and many differ in `x`": agent_that_ends_at(lambda pose, m: further(pose, 1.0 * m.ndim)),
    "jit changes `x`": agent_that_ends_at(
        lambda pose, motor: further(pose, float(isinstance(motor, jax.core.Tracer)))
    ),
}


@pytest.mark.parametrize("sentence", AGENT_MISTAKES)
def test_a_mistake_of_an_agent_is_named(sentence, monkeypatch):
    monkeypatch.setattr(AGENTS, "_added", {})
    AGENTS.add("mistaken", AGENT_MISTAKES[sentence])
    with pytest.raises(AssertionError, match=sentence):
        check_agent(AGENT_MISTAKES[sentence]())


# --- sensors


def sensor_that_reads(change):
    class Sensor(RangeFan):
        def sense(self, world, pose):
            return change(super().sense(world, pose))

    return Sensor


def sensor_that_draws(rays):
    class Sensor(RangeFan):
        def rays(self, world, pose):
            return rays

    return Sensor


class Wider(RangeFan):
    factor: float = eqx.field(static=True, default=1.0, converter=lambda value: 2 * value)


SENSOR_MISTAKES = {
    "built from its own options differs": Wider,
    "readings of 32 agents have the shape": sensor_that_reads(lambda ranges: ranges[:3]),
    "readings must be finite": sensor_that_reads(lambda ranges: ranges / 0.0),
    "'range_0' leaves the bounds": sensor_that_reads(lambda ranges: ranges + 10.0),
    "one and many differ": sensor_that_reads(lambda ranges: ranges / ranges.ndim),
    "jit changes the readings": sensor_that_reads(
        lambda ranges: ranges / (1.0 + isinstance(ranges, jax.core.Tracer))
    ),
    "`rays` must be segments": sensor_that_draws(np.zeros((9, 2))),
    "`rays` must be finite": sensor_that_draws(np.full((9, 2, 2), np.inf)),
}


@pytest.mark.parametrize("sentence", SENSOR_MISTAKES)
def test_a_mistake_of_a_sensor_is_named(sentence, monkeypatch):
    monkeypatch.setattr(SENSORS, "_added", {})
    SENSORS.add("mistaken", SENSOR_MISTAKES[sentence])
    with pytest.raises(AssertionError, match=sentence):
        check_sensor(SENSOR_MISTAKES[sentence](), "empty")


def test_a_space_that_a_sensor_does_not_fill_is_named(monkeypatch):
    class Narrow(RangeFan):
        def space(self, world):
            return SensorSpace((0.0,) * 9, (1.0,) * 9, tuple(map(str, range(9))))

    monkeypatch.setattr(SENSORS, "_added", {})
    SENSORS.add("narrow", Narrow)
    with pytest.raises(AssertionError, match="leaves the bounds of its space"):
        check_sensor(Narrow(), "empty")


# --- encoders


def encoder_that(change, penalty=lambda self: jnp.zeros(()), draw=jax.random.normal):
    class Encoder(AbstractMotorEncoder):
        weights: jax.Array

        def __init__(self, motor_size, hidden_size, code_size, *, key):
            self.weights = draw(key, (motor_size, code_size))

        def __call__(self, motors, num_steps):
            executed = jnp.where(jnp.arange(len(motors))[:, None] < num_steps, motors, 0.0)
            return change(executed @ self.weights, motors)

        def penalty(self, motors):
            return penalty(self)

    return Encoder


def total(codes, motors):
    return codes.sum(axis=0)


class Unlearned(AbstractMotorEncoder):
    def __init__(self, motor_size, hidden_size, code_size, *, key):
        pass

    def __call__(self, motors, num_steps):
        executed = jnp.arange(len(motors))[:, None] < num_steps
        return jnp.where(executed, motors, 0.0).sum(axis=0)


ENCODER_MISTAKES = {
    "the same initial weights": encoder_that(
        total, draw=lambda key, shape: jnp.full(shape, 1.0 * next(count))
    ),
    "a code must be one vector": encoder_that(lambda codes, motors: codes),
    "codes must be finite": encoder_that(lambda codes, motors: total(codes, motors) / 0.0),
    "one and many, or jit, differ": encoder_that(
        lambda codes, motors: total(codes, motors) + float(isinstance(motors, jax.core.Tracer))
    ),
    "rows beyond `num_steps`": encoder_that(
        lambda codes, motors: total(codes, motors) / len(motors)
    ),
    "must have weights": Unlearned,
    "gradient of the codes must be finite": encoder_that(
        lambda codes, motors: jnp.sqrt(jnp.maximum(total(codes, motors) - 100.0, 0.0))
    ),
    "the penalty must be": encoder_that(total, penalty=lambda self: -jnp.ones(())),
}


@pytest.mark.parametrize("sentence", ENCODER_MISTAKES)
def test_a_mistake_of_an_encoder_is_named(sentence):
    with pytest.raises(AssertionError, match=sentence):
        check_encoder(ENCODER_MISTAKES[sentence])


# --- readers; what may be wrong with a recording is tested beside them


class Shy(TableReader):
    @classmethod
    def recognises(cls, name, head):
        return False


class Fickle(TableReader):
    def parse(self, path):
        recording = super().parse(path)
        return dataclasses.replace(recording, increments=recording.increments * next(count))


class Careless(TableReader):
    def parse(self, path):
        if path.name == "missing":
            raise KeyError(path)
        return super().parse(path)


class Inventive(TableReader):
    known = []

    def parse(self, path):
        self.known.append(path)
        return super().parse(self.known[0])


class NoReader:
    pass


READER_MISTAKES = {
    "has to be derived from AbstractReader": NoReader,
    "does not recognise": Shy,
    "twice gives two different increments": Fickle,
    "KeyError for a missing file": Careless,
    "reads a file that does not exist": Inventive,
}


@pytest.mark.parametrize("sentence", READER_MISTAKES)
def test_a_mistake_of_a_reader_is_named(sentence, tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("time,motor_a,sensor_a\n0,1,2\n1,2,3\n2,3,4\n")
    Inventive.known.clear()
    with pytest.raises(AssertionError, match=sentence):
        # Without the types that tests execute, as for anybody else.
        check_reader.__wrapped__(READER_MISTAKES[sentence](), log)
