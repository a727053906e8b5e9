"""What training draws from: what the configuration names, and what baselines are given."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace.models.config import ModelConfig
from motorspace.models.model import Scaling
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Derived, Given, Logged, Simulated
from motorspace.training.fit import horizon_of
from motorspace.training.sources import given_source, logged_data, source_of
from motorspace.trajectories.commands import nominal
from motorspace.trajectories.transitions import Experience
from motorspace.worlds.agents import ForwardAgent
from tests.tables import write_table

BASE = Simulated(ForwardAgent(0.4 * np.pi), horizon=6)
FEW = TrainingConfig(trajectories_per_epoch=50, batch_size=50)
KEY, LATE = jax.random.key(0), jnp.array(5000, jnp.int32)


def drawn(data):
    return source_of(RunConfig(data, training=FEW)).experience(KEY, LATE)


@pytest.fixture(scope="module")
def plain():
    return drawn(BASE)


def test_shuffled_targets_are_those_of_other_sequences(plain):
    mixed = drawn(Derived(BASE, "shuffled"))
    np.testing.assert_array_equal(plain.motors, mixed.motors)
    np.testing.assert_array_equal(plain.sensors, mixed.sensors)
    assert (plain.later_sensors != mixed.later_sensors).any()
    rows = [set(map(tuple, np.asarray(e.later_sensors).tolist())) for e in (plain, mixed)]
    assert rows[0] == rows[1]


def test_supervision_predicts_the_displacement_from_the_motors_alone(plain):
    told = drawn(Derived(BASE, "supervised"))
    assert told.later_sensors.shape == (50, 4) and not told.sensors.any()
    np.testing.assert_array_equal(told.motors, plain.motors)
    cos, sin = told.later_sensors[:, 2:].T
    np.testing.assert_allclose(cos**2 + sin**2, 1.0, atol=1e-5)


def test_the_oracle_is_given_the_displacement_for_a_command(plain):
    told = drawn(Derived(BASE, "oracle"))
    assert told.motors.shape == (50, 1, 4) and (told.num_steps == 1).all()
    np.testing.assert_array_equal(told.later_sensors, plain.later_sensors)
    x, y, turn = nominal(ForwardAgent(0.4 * np.pi), np.asarray(plain.motors)).T
    expected = np.stack([x / 6, y / 6, np.cos(turn), np.sin(turn)], axis=1)
    np.testing.assert_allclose(told.motors[:, 0], expected, atol=1e-4)


def test_scaled_rotations_change_what_displacement_the_predictor_is_given(plain):
    right = drawn(Derived(BASE, "scaled_rotations", 1.0))
    np.testing.assert_allclose(right.motors, drawn(Derived(BASE, "oracle")).motors, atol=1e-4)
    double = drawn(Derived(BASE, "scaled_rotations", 2.0))
    turned = np.asarray(plain.motors) * [2.0, 1.0]
    x, y, turn = nominal(ForwardAgent(), turned.astype(np.float32)).T
    expected = np.stack([x / 6, y / 6, np.cos(turn), np.sin(turn)], axis=1)
    np.testing.assert_allclose(double.motors[:, 0], expected, atol=1e-5)
    np.testing.assert_array_equal(double.later_sensors, plain.later_sensors)


@pytest.mark.parametrize(
    ("data", "sensors", "motors"),
    [
        (BASE, (10.0,) * 9, (1.0, 1.0)),
        (Derived(BASE, "oracle"), (10.0,) * 9, (1.0,) * 4),
        (Derived(BASE, "supervised"), (6.0, 6.0, 1.0, 1.0), (1.0, 1.0)),
        (Simulated("lattice"), (1.0,) * 40, (1.0,) * 6),
    ],
)
def test_every_source_says_what_its_numbers_are_divided_by(data, sensors, motors):
    assert source_of(RunConfig(data)).scaling == Scaling(sensors, motors)


def test_commands_are_divided_by_their_largest_magnitude_if_asked_for():
    config = RunConfig(BASE, ModelConfig(motor_scaling="maximum"))
    np.testing.assert_allclose(source_of(config).scaling.motors, (0.4 * np.pi, 1.0))


def test_data_of_ones_own_are_scaled_by_what_they_vary():
    motors = np.zeros((4, 3, 2), np.float32)
    motors[:, 0, 0] = [1, -1, 1, -1]
    motors[:, 1] = 99.0
    sensors = np.array([[3.0, 0.0], [-5.0, 0.0], [1.0, 0.0], [2.0, 0.0]], np.float32)
    arrays = map(jnp.asarray, (sensors, motors, np.full(4, 1, np.int32), sensors))
    experience = Experience(*arrays)
    found = given_source(RunConfig(Given()), experience, None).scaling
    # Rows beyond the steps are no commands; what does not vary is not scaled.
    assert found == Scaling((5.0, 1.0), (1.0, 1.0))
    again = given_source(RunConfig(Given()), lambda key, epoch: experience, None)
    assert again.scaling == found and horizon_of(again.experience) == 3
    own = Scaling((2.0, 2.0), (3.0, 3.0))
    assert given_source(RunConfig(Given()), experience, own).scaling is own


def test_a_command_that_never_varies_is_not_divided_by_its_rounding(log):
    turning, constant = source_of(RunConfig(log)).scaling.motors
    assert 0.3 < turning < 0.4 and constant == 1.0


def test_data_of_ones_own_have_to_be_passed():
    with pytest.raises(UserError, match=r"names no data \(mine\); pass them: train\(config, exp"):
        source_of(RunConfig(Given("mine")))


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return Logged(write_table(tmp_path_factory.mktemp("log") / "t.csv"), horizon=3, num_blocks=10)


def test_a_log_is_split_into_parts_that_share_no_scan(log):
    data = logged_data(log)
    num = [len(part) for part in (data.train, data.validation, data.test)]
    assert num == [6 * 77, 2 * 77, 2 * 77]
    seen = [np.asarray(p.experience.sensors) for p in (data.train, data.validation, data.test)]
    rows = [set(map(tuple, part.tolist())) for part in seen]
    assert not rows[0] & rows[1] and not rows[0] & rows[2] and not rows[1] & rows[2]
    source = source_of(RunConfig(log))
    assert source.validation is data.validation.experience
    spread = np.asarray(data.train.experience.motors)[..., 0].std()
    np.testing.assert_allclose(source.scaling.motors[0], spread, rtol=1e-4)


def test_shorter_transitions_of_a_log_are_added_to_training_alone(log):
    whole, mixed = logged_data(log), logged_data(replace(log, min_horizon=1))
    assert len(mixed.test) == len(whole.test)
    steps = np.asarray(mixed.train.experience.num_steps)
    assert set(steps) == {1, 2, 3} and (steps == 3).sum() == len(whole.train)
    assert not np.asarray(mixed.train.experience.motors)[steps == 1, 1:].any()


def test_the_oracle_of_a_log_is_given_its_true_displacements(log):
    plain, told = logged_data(log), logged_data(Derived(log, "oracle"))
    reach = np.abs(np.asarray(plain.train.displacements.achieved)[:, :2]).max()
    x, y, turn = np.asarray(plain.test.displacements.achieved).T
    expected = np.stack([x / reach, y / reach, np.cos(turn), np.sin(turn)], axis=1)
    np.testing.assert_allclose(told.test.experience.motors[:, 0], expected, atol=1e-5)
    np.testing.assert_array_equal(told.test.experience.sensors, plain.test.experience.sensors)
    assert told.scaling.motors == (1.0,) * 4
