"""Reach a displacement, and a place that is far, with a controller that comes with the package."""

import math

import jax
import jax.numpy as jnp
import numpy as np

import motorspace as ms

run, controller, *_ = ms.load_pretrained("forward-0.4pi")
goal = ms.DisplacementGoal(longitudinal=1.0, lateral=-1.5, turn=math.pi / 2)
plan = ms.plan(controller, np.full(9, 5.0), goal)  # nine distances of 5 units
print("turns (radians) and moves (units):", plan.motors.round(2), sep="\n")

scenario = ms.Scenario("empty", run.config.data.scenario().agent)
start = ms.Pose(*jnp.array([20.0, 20.0, 0.0, 0.0]))
far = controller.probe(jnp.array([6.0, 4.0, 0.0]))  # the code of a displacement
way = ms.follow(controller, scenario, start, far, rounds=5, key=jax.random.key(0))
print(f"wanted (26, 24), reached ({way.poses.x[-1]:.2f}, {way.poses.y[-1]:.2f})")
