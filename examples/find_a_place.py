"""Go to where something is sensed, by a map that the agent has made without poses.

It is given its commands, its readings and its bumps; poses are for printing alone. Some goals are
missed: places look alike, and the walk has not been everywhere.
"""

import jax
import jax.numpy as jnp

import motorspace as ms

run, controller, *_ = ms.load_pretrained("forward-0.4pi")
scenario = run.config.data.scenario()
body_key, walk_key, *keys = jax.random.split(jax.random.key(1), 8)

calibration = ms.calibrate(run, key=body_key)  # of the body; half a minute, once for all layouts
judge = ms.Judge(calibration, ms.walk(scenario, num_steps=15_000, key=walk_key))
guide, roadmap = ms.Guide(controller, judge), ms.Roadmap(judge.walls, judge.eyes)

for key in keys:
    start_key, place_key, key = jax.random.split(key, 3)
    start, place = scenario.start(key=start_key), scenario.start(key=place_key)
    way = ms.seek(guide, roadmap, scenario, start, scenario.sense(place), rounds=40, key=key)
    left = jnp.hypot(way.poses.x - place.x, way.poses.y - place.y)
    print(f"{left[0]:.1f} units away, after {len(way.motors)} commands {left[-1]:.2f}")
