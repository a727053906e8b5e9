# %% [markdown]
# # Reach a goal
#
# In about five minutes: an agent that has learned codes learns to act with them. It is asked for a
# displacement and answers with motor commands, with as many different ones as you like.

# %%
import math

import jax
import jax.numpy as jnp
import numpy as np

import motorspace as ms
from motorspace.se2 import relative

EPOCHS = 400  # 1,000 for the numbers in the results
UPDATES = 3000  # 6,000 for the numbers in the results

# %% [markdown]
# ## Codes first
#
# The forward agent turns by at most 72 degrees and moves ahead by at most one unit. Its network
# encodes six such commands.

# %%
agent = ms.ForwardAgent(max_rotation=0.4 * math.pi)
config = ms.RunConfig(ms.Simulated(agent), preset="best")
run = ms.train(ms.changed(config, {"epochs": EPOCHS}))

# %% [markdown]
# ## Learning to decode
#
# The controller turns a code into motor commands. Nobody shows it which: it proposes commands, and
# the agent's own encoder says what their code is. Only the map from displacements to codes needs
# labels, 50 sequences whose displacement is known.

# %%
controller = ms.learn_controller(run, ms.ControlConfig(updates=UPDATES))

# %% [markdown]
# ## One goal, many answers
#
# Go one unit ahead and a unit and a half to the right, and face to the left.

# %%
goal = ms.DisplacementGoal(longitudinal=1.0, lateral=-1.5, turn=math.pi / 2)
sensors = np.full(9, 5.0)  # what the agent senses; a displacement does not depend on it
plans = [ms.plan(controller, sensors, goal, seed=seed) for seed in range(12)]
print("commands of the first answer: turn (radians), move (units)")
print(plans[0].motors.round(2))


def path(motors):
    middle = ms.Pose(*jnp.array([20.0, 20.0, 0.0, 0.0]))
    poses = ms.rollout(ms.layout("empty"), agent, middle, motors)
    return np.stack([poses.x - 20, poses.y - 20, poses.heading], axis=-1)


paths = np.stack([path(plan.motors) for plan in plans])
ms.answers_figure(paths, np.array([1.0, -1.5, math.pi / 2]))

# %% [markdown]
# Twelve seeds, twelve ways. The agent can only move ahead, so all of them pass the goal and come
# back to it. They end near the circle and face along its arrow.

# %%
off = paths[:, -1, :2] - np.array([1.0, -1.5])
print(f"mean distance from the goal: {np.hypot(*off.T).mean():.3f} units")

# %% [markdown]
# ## Farther than six commands
#
# Codes of `best` are matrices that multiply, so what is left of a goal is known after every
# sequence: the inverse of what was done, times the goal. Four agents come together from four
# corners; each knows only which displacement leads it there.

# %%
scenario = ms.Scenario("empty", agent)
meeting = np.array([20.0, 20.0, math.pi / 2])
corners = [(12.0, 12.0, 0.0), (28.0, 13.0, 2.0), (27.0, 28.0, 4.0), (13.0, 27.0, 5.5)]
ways = []
for seed, corner in enumerate(corners):
    goal = controller.probe(jnp.array(relative(np.array(corner), meeting), jnp.float32))
    start = ms.Pose(*jnp.array([*corner, 0.0]))
    ways.append(ms.follow(controller, scenario, start, goal, rounds=8, key=jax.random.key(seed)))
    end = ways[-1].poses
    print(f"wanted (20, 20), reached ({end.x[-1]:.2f}, {end.y[-1]:.2f})")
ms.ways_film(scenario.world, [way.poses for way in ways], meeting)

# %% [markdown]
# On the command line: `motorspace control RUN --displacement 1 -1.5 90`. How often goals are
# reached: [acting in the space of codes](../results/control.md).
