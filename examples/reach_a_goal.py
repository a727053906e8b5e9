"""Learn to act with the codes of a run, and reach a displacement and a far goal."""

import math

import jax
import numpy as np

import motorspace as ms

config = ms.RunConfig(ms.Simulated(ms.ForwardAgent(max_rotation=0.4 * math.pi)), preset="best")
run = ms.train(ms.changed(config, dict(epochs=400)))
controller = ms.learn_controller(run, ms.ControlConfig(updates=2000))

goal = ms.DisplacementGoal(longitudinal=1.0, lateral=-1.5, turn=math.pi / 2)
plan = ms.plan(controller, np.full(9, 5.0), goal)  # nine distances of 5 units
print("six commands (radians, units):", plan.motors.round(2).tolist())

scenario = ms.Scenario("empty", ms.ForwardAgent(max_rotation=0.4 * math.pi))
start = ms.Pose(*np.array([20.0, 20.0, 0.0, 0.0], np.float32))
far = controller.probe(np.array([6.0, 4.0, 0.0], np.float32))
way = ms.follow(controller, scenario, start, far, rounds=5, key=jax.random.key(0))
print(f"wanted (26, 24), reached ({way.poses.x[-1]:.2f}, {way.poses.y[-1]:.2f})")
