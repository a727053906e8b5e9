# %% [markdown]
# # Measure anybody's codes
#
# The report on structure takes arrays: codes, displacements, and the motor sequences if you have
# them. Where the codes come from does not matter. Here three encoders that nobody trained are
# measured, and one that knows the answer.

# %%
import math
import subprocess
import sys

import jax
import matplotlib.pyplot as plt
import numpy as np

import motorspace as ms

NUM = 4000

# %% [markdown]
# ## The data
#
# Displacements are [N, 3]: longitudinal, lateral, and the change of orientation in radians. These
# are of a forward agent that executes six commands, with no walls in the way.

# %%
agent = ms.ForwardAgent(max_rotation=0.4 * math.pi)
walk = ms.sample(ms.Scenario("empty", agent), num=NUM, horizon=6, key=jax.random.key(0))
motors = np.asarray(walk.experience.motors)  # [N, 6, 2]: rotation, move
displacements = np.asarray(walk.displacements.nominal)  # [N, 3]

# %% [markdown]
# ## The codes
#
# - **sum**: all commands added up, which ignores their order;
# - **random network**: an untrained recurrent network of fifty units;
# - **noisy odometry**: the true displacement with noise on every component, through a random linear
#   map to twelve units;
# - **dead reckoning**: the displacement itself, with its angle as a point on the circle.

# %%
random = np.random.default_rng(0)


def random_network(motors, size=50):
    """The last state of h = tanh(W m + U h) with random weights."""
    into = random.normal(size=(2, size))
    within = random.normal(size=(size, size)) / math.sqrt(size)
    state = np.zeros((len(motors), size))
    for step in range(motors.shape[1]):
        state = np.tanh(motors[:, step] @ into + state @ within)
    return state


x, y, angle = displacements.T
point = np.stack([x, y, 2 * np.cos(angle), 2 * np.sin(angle)], axis=-1)
noisy = point + random.normal(scale=0.3, size=point.shape)
codes = {
    "sum": motors.sum(axis=1),
    "random network": random_network(motors),
    "noisy odometry": noisy @ random.normal(size=(4, 12)),
    "dead reckoning": point,
}

# %% [markdown]
# ## The reports
#
# A report maps the key of each measure to an estimate: a number with its standard error.
# `print(report)` shows all of them; here are four.

# %%
reports = {name: ms.topology(code, displacements, motors) for name, code in codes.items()}
keys = ("linear_r2.worst", "rank_correlation", "partial_motors", "trustworthiness.20")
print(f"{'':16}" + "".join(f"{key:>20}" for key in keys))
for name, report in reports.items():
    print(f"{name:16}" + "".join(f"{report[key]:>20.3f}" for key in keys))

# %% [markdown]
# The sum knows how far and how much, but since it ignores the order it is blind to one component of
# the displacement. The random network has a trace of everything and a map of nothing. Noise lowers
# every row a little, which is what a measure should do.

# %% [markdown]
# ## A picture
#
# Distances between codes over distances between displacements, for random pairs: a map of
# displacement has a line, or at least a curve.

# %%
first, second = random.integers(NUM, size=(2, 3000))
apart = np.linalg.norm(point[first] - point[second], axis=1)
figure, panels = plt.subplots(1, len(codes), figsize=(11, 2.9), layout="constrained")
for axes, (name, code) in zip(panels, codes.items(), strict=True):
    distance = np.linalg.norm(code[first] - code[second], axis=1)
    axes.scatter(apart, distance / distance.mean(), s=2, alpha=0.4, color="#3867b0")
    axes.set(title=name, xlabel="distance of displacements", ylim=(0, 3))
    axes.spines[["top", "right"]].set_visible(False)
panels[0].set_ylabel("distance of codes")

# %% [markdown]
# ## From files
#
# The command line reads `.npy`, `.npz`, CSV, Parquet and Zarr, and refuses what cannot be codes and
# displacements with one sentence.

# %%
np.save("codes.npy", codes["noisy odometry"])
np.save("displacements.npy", displacements)
command = ["motorspace", "topology", "codes.npy", "displacements.npy", "--json"]
done = subprocess.run([sys.executable, "-m", *command], capture_output=True, text=True, check=True)
print(" ".join(command))
print(done.stdout[:300], "...")

# %% [markdown]
# What each measure means, and what it does not: [measures](../concepts/measures.md).
