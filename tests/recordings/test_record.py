"""Simulated walks: the same kind of recording as a robot's log."""

import jax
import numpy as np
import pytest

from motorspace import UserError
from motorspace.recordings.record import record
from motorspace.recordings.recording import describe
from motorspace.recordings.windows import windows
from motorspace.testing.reader import check_recording
from motorspace.worlds.agents import ForwardAgent, HolonomicAgent, LatticeAgent
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.sensors.node_index import NodeIndex
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.simulation import rollout

KEY = jax.random.key(3)
SCENARIOS = {
    "forward": Scenario("paper", ForwardAgent(), RangeFan(3)),
    "holonomic": Scenario("paper", HolonomicAgent(head_start="random"), RangeFan(3)),
    "lattice": Scenario("lattice:4", LatticeAgent(), NodeIndex()),
}


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_walk_is_a_sound_recording(name):
    scenario = SCENARIOS[name]
    walk = record(scenario, num_steps=40, key=KEY)
    check_recording(walk)
    assert len(walk) == 41
    assert walk.increments.shape == (40, scenario.commands.size)
    assert describe(walk)["scans"] == 41
    again = record(scenario, num_steps=40, key=KEY)
    np.testing.assert_array_equal(walk.sensors, again.sensors)
    assert not np.array_equal(
        walk.poses, record(scenario, num_steps=40, key=jax.random.key(4)).poses
    )


@pytest.mark.parametrize("name", SCENARIOS)
def test_poses_and_readings_follow_from_the_commands(name):
    scenario = SCENARIOS[name]
    walk = record(scenario, num_steps=40, key=KEY)
    start = scenario.start(key=jax.random.split(KEY)[0])
    poses = rollout(
        scenario.world, scenario.agent, start, jax.numpy.asarray(walk.increments, "float32")
    )
    fields = [poses.x, poses.y, poses.heading, poses.head]
    np.testing.assert_allclose(walk.poses.T, fields, atol=1e-5)
    np.testing.assert_allclose(walk.sensors.T, scenario.sense(poses), atol=1e-4)


def test_windows_give_the_displacement_of_the_part_that_carries_the_sensors():
    walk = record(SCENARIOS["holonomic"], num_steps=30, key=KEY)
    moved = windows(walk, horizon=2, per_scan=True)
    assert moved.experience.motors.shape == (29, 2, 4)
    x, y, heading, head = walk.poses.T
    turned = np.angle(np.exp(1j * np.diff((heading + head)[::2])))
    np.testing.assert_allclose(moved.displacements.achieved[::2, 2], turned, atol=1e-5)
    length = np.hypot(np.diff(x[::2]), np.diff(y[::2]))
    np.testing.assert_allclose(
        np.hypot(*moved.displacements.achieved[::2, :2].T), length, atol=1e-5
    )


def test_a_wall_blocks_or_makes_the_agent_choose_again():
    cell = "bounds 0 0 1.2 1.2\n"
    scenario = Scenario(cell, ForwardAgent(), RangeFan(3))
    walk = record(scenario, num_steps=60, key=KEY)
    blocked = record(scenario, num_steps=60, collision="block", key=KEY)
    assert blocked.usable.all()

    def moved(walk):
        return np.hypot(*np.diff(walk.poses[:, :2], axis=0).T)

    np.testing.assert_allclose(moved(walk)[walk.usable], walk.increments[walk.usable, 1], atol=1e-5)
    assert (moved(blocked) == 0).any()
    assert (~walk.usable).any() == any("stuck" in note for note in walk.notes)


def test_commands_come_from_a_policy():
    def straight_on(*, key):
        return jax.numpy.array([0.0, 0.5]) + 0.0 * jax.random.uniform(key, (2,))

    walk = record(SCENARIOS["forward"], num_steps=5, policy=straight_on, key=KEY)
    assert (walk.increments == [0.0, 0.5]).all()


def test_fewer_than_one_step_is_refused():
    with pytest.raises(UserError, match="num_steps must be at least 1, got 0"):
        record(SCENARIOS["forward"], num_steps=0, key=KEY)
