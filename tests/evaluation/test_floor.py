"""The floor where it is known: nothing left to guess, one direction left to guess, a wall."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace._kinds import register
from motorspace._types import Pose
from motorspace.evaluation import floor
from motorspace.training.data import Simulated
from motorspace.trajectories.transitions import Displacements, Experience, Trajectories
from motorspace.worlds.agents import ForwardAgent, HolonomicAgent
from motorspace.worlds.sensors.base import AbstractSensor
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.spaces import SensorSpace

SIDE = 200.0
SQUARE = f"title square\nbounds 0 0 {SIDE:g} {SIDE:g}\n"
NUM_TEST = 300


@pytest.fixture(autouse=True)
def few_neighbours(monkeypatch):
    """Every number of neighbours is compiled anew."""
    monkeypatch.setattr(floor, "NEIGHBOURS", (40,))


@register("height of the tests")
class Height(AbstractSensor):
    """The agent's y, and if it has a compass, cosine and sine of its gaze."""

    compass: bool = False

    def space(self, world):
        high = (SIDE,) + (1.0, 1.0) * self.compass
        return SensorSpace(
            (0.0,) + (-1.0, -1.0) * self.compass, high, ("y", "cos", "sin")[: len(high)]
        )

    def sense(self, world, pose):
        gaze = [jnp.cos(pose.gaze), jnp.sin(pose.gaze)] * self.compass
        return jnp.stack([pose.y, *gaze])


def in_square(compass=False):
    """One step ahead in a wide square, with a sense of height."""
    return Simulated(ForwardAgent(math.pi), Height(compass), SQUARE, horizon=1)


def remembered(data, num, *, key):
    scenario = data.scenario()
    return floor.remember(scenario.world, scenario.sensor, num, key=key)


def height_floor(*, compass, key):
    memory = remembered(in_square(compass), 20_000, key=key)
    return floor.prediction_floor(in_square(compass), memory, num_test=NUM_TEST, key=key)


@pytest.mark.slow
def test_an_unknown_heading_leaves_half_of_the_squared_distance(getkey):
    # y' - y = l sin(a) with l uniform in [0, 1] and a uniform: its variance is 1/2 times 1/3.
    found = height_floor(compass=False, key=getkey())
    assert np.mean(found.errors) == pytest.approx(1 / 6, abs=4 * found.standard_error)
    assert found.disagreement == pytest.approx(1 / 6, rel=0.1)
    assert len(found.errors) == floor.NUM_SETS and found.neighbours in floor.NEIGHBOURS


@pytest.mark.slow
def test_nothing_is_left_to_guess_with_a_compass(getkey):
    assert np.mean(height_floor(compass=True, key=getkey()).errors) < 1e-5


def test_poses_are_left_out_from_which_the_trajectory_was_impossible(getkey):
    # At a height of 0.3 a move by 1 ahead stays above 0 for sin(a) > -0.3 only.
    memory = remembered(in_square(), 200_000, key=getkey())
    height, least = 0.3, math.asin(0.3)
    here, there = jnp.array([[height]]), jnp.array([[0.0]])
    ahead = jnp.array([[1.0, 0.0, 0.0]])
    experience = Experience(here, jnp.zeros((1, 1, 2)), jnp.ones(1, jnp.int32), there)
    trajectory = Trajectories(experience, Displacements(ahead, ahead))
    mean_sine = 2 * math.cos(least) / (math.pi + 2 * least)
    found = floor.predict(memory, trajectory, 1500)
    assert found.mean[0, 0] == pytest.approx(height + mean_sine, abs=0.05)


@pytest.mark.slow
def test_a_room_seen_to_all_its_ends_leaves_nothing_to_guess(getkey, tmp_path):
    # Its four quarter turns look alike, and so does what lies ahead in each of them.
    room = tmp_path / "room.layout"
    room.write_text("title room\nbounds 0 0 8 8\n")
    data = Simulated(sensor=RangeFan(max_range=20.0), layout=room, horizon=2)
    memory = remembered(data, 2000, key=getkey())
    found = floor.prediction_floor(data, memory, num_test=100, key=getkey())
    assert max(found.errors) < 1e-5


def test_every_case_of_the_lattice_is_told_from_memory(getkey):
    data = Simulated("lattice", horizon=3)
    memory = remembered(data, 5000, key=getkey())
    found = floor.prediction_floor(data, memory, num_test=100, key=getkey())
    assert max(found.errors) < 1e-10 and found.disagreement < 1e-10


def test_corrected_poses_sense_what_they_should_and_stay_in_the_free(getkey):
    scenario = Simulated().scenario()
    world, sensor = scenario.world, scenario.sensor
    place_key, noise_key = jax.random.split(getkey())
    true = jax.vmap(lambda key: world.place(key=key))(jax.random.split(place_key, 20))
    noise = 0.03 * jax.random.normal(noise_key, (3, 20, 10))
    moved = (f[:, None] + n for f, n in zip((true.x, true.y, true.heading), noise, strict=True))
    near = Pose(*moved, jnp.zeros((20, 10)))
    sensed = sensor.sense(world, true)
    correct = jax.jit(jax.vmap(lambda pose, s: floor.corrected(world, sensor, pose, s), (0, 1)))
    found = correct(near, sensed)

    def usually_off(pose):
        return float(jnp.median(jnp.abs(sensor.sense(world, pose) - sensed[..., None])))

    assert usually_off(found) < 1e-4 < 1e-2 < usually_off(near)
    assert world.free(found)[world.free(near)].all()


@pytest.mark.slow
def test_the_floor_comes_down_with_the_number_of_poses():
    agent = HolonomicAgent(0.4 * math.pi)
    found = floor.measure_floor(Simulated(agent), num_poses=(200, 5000), num_test=60)
    assert found["floor.error"] == found["floor.error.5000"] > 0
    assert found["floor.error.200"] > 1.5 * found["floor.error"]
    assert found["floor.lowest"] <= found["floor.error"] <= found["floor.highest"]
    assert found["floor.standard_error"] > 0 and found["floor.disagreement"] > 0
    assert found["floor.num"] == 60 * floor.NUM_SETS
