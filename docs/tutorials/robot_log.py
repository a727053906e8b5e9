# %% [markdown]
# # Your robot's log
#
# A log becomes a recording, a recording becomes transitions, and from there on learning does not
# know that no simulator was involved. This tutorial first writes a log as a robot might, faults
# included, so that you can put your own in its place.

# %%
import csv
import math
from pathlib import Path

import jax
import matplotlib.pyplot as plt
import numpy as np

import motorspace as ms
from motorspace.recordings.recording import describe

STEPS = 8000
EPOCHS = 100

# %% [markdown]
# ## A log
#
# A plain table has one row per time step: `time` in seconds, `motor_*` columns that hold what is
# executed between this row and the next, `sensor_*` columns, and, if you know it, the true pose
# `x, y, theta`, which the evaluation alone may use.
#
# Ours is of a robot that drives through four rooms, slows down, speeds up, and turns away from
# walls. It has three faults of real logs: beams without a return, a missing reading, and a minute
# in which nothing was written.

# %%
scenario = ms.Scenario("four_rooms", ms.ForwardAgent(max_rotation=0.1 * math.pi))
step = jax.jit(lambda pose, motor: scenario.step(pose, motor))
sense = jax.jit(lambda pose: scenario.sense(pose))
random = np.random.default_rng(0)
pose, speed, turn, rows = scenario.start(key=jax.random.key(1)), 0.5, 0.0, []
for number in range(STEPS):
    ranges = np.asarray(sense(pose)).round(3)
    speed = np.clip(speed + random.normal(scale=0.15), 0, 1)
    turn = np.clip(0.8 * turn + random.normal(scale=0.15), -0.3, 0.3)
    if ranges[3:6].min() < 1.5:  # a wall ahead
        speed, turn = 0.0, 0.3
    after, blocked = step(pose, np.float32([turn, speed]))
    time = number / 2 + (60 if number > STEPS // 2 else 0)
    motors = [round(turn, 4), round(0 if blocked else speed, 4)]
    place = [round(float(value), 3) for value in (pose.x, pose.y, pose.heading)]
    rows.append([time, *motors, *["inf" if r == 10 else r for r in ranges], *place])
    pose = after
rows[100][7] = ""

names = ["time", "motor_turn", "motor_ahead", *[f"sensor_{i}" for i in range(9)]]
with open("robot.csv", "w", newline="") as file:
    csv.writer(file).writerows([[*names, "x", "y", "theta"], *rows])
print(Path("robot.csv").read_text()[:230])

# %% [markdown]
# ## What is in it?
#
# Look before you train; `motorspace inspect robot.csv` prints the same. The notes say what was
# found and by which rule it was handled. The reader's options change the rules.

# %%
recording = ms.read_log("robot.csv", max_range=10.0)
for name, value in describe(recording).items():
    lines = value if name == "notes" else [value]
    print(f"{name:34} " + f"\n{'':35}".join(map(str, lines)))

# %% [markdown]
# ## Learning
#
# `Logged` keeps the log's path, a hash of its content, and the reader with its options, so that the
# run knows what it learned from. The log is cut into blocks of time, dealt out to training,
# validation and test, because neighbouring scans look alike. Training also sees transitions over
# fewer scans than six (`min_horizon`). A log is short, so the weights are averaged (`ema_decay`).

# %%
data = ms.Logged("robot.csv", horizon=6, min_horizon=1, max_range=10.0)
training = ms.TrainingConfig(epochs=EPOCHS, learning_rate=4e-3, ema_decay=0.99)
run = ms.train(ms.RunConfig(data, ms.ModelConfig(initial_weights="scaled"), training))

# %% [markdown]
# ## What came of it?
#
# On the blocks that training never saw: the error beside predicting no change (persistence) and the
# mean, and how well a linear probe reads each component of the displacement from the code.

# %%
print(ms.evaluate(run))

# %% [markdown]
# The codes on their two main components: how far the robot drove, and how far it turned.

# %%
test = ms.windows(recording, horizon=6, per_scan=True)
codes = np.asarray(run.encode(test.experience.motors))
moved = np.asarray(test.displacements.achieved)
centred = codes - codes.mean(axis=0)
components = centred @ np.linalg.svd(centred, full_matrices=False)[2][:2].T

figure, panels = plt.subplots(1, 2, figsize=(8, 3.6), layout="constrained")
for axes, column, title in zip(panels, (0, 2), ("ahead, units", "turned, radians"), strict=True):
    drawn = axes.scatter(*components.T, c=moved[:, column], cmap="viridis", s=4, linewidths=0)
    figure.colorbar(drawn, ax=axes)
    axes.set(title=title, xticks=[], yticks=[])

# %% [markdown]
# From the command line:
#
# ```
# motorspace inspect robot.csv --max-range 10
# motorspace train --data robot.csv --max-range 10 --min-horizon 1 --ema-decay 0.99 --out runs/robot
# motorspace evaluate runs/robot
# ```
#
# Formats, rules, and what to do about a log of another kind: [robots](../robots.md),
# [add a reader](../how-to/reader.md).
