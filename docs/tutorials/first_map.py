# %% [markdown]
# # A first map of codes
#
# In about two minutes: an agent explores a world, a network learns to predict its sensors, and the
# network's codes turn out to be a map of where the agent went.

# %%
import math

import jax
import matplotlib.pyplot as plt
import numpy as np

import motorspace as ms

EPOCHS = 200  # 1,000 for the numbers in the results
NUM = 4000

# %% [markdown]
# ## What the agent knows
#
# The holonomic agent turns, slides ahead and aside, and moves its head. It senses nine distances
# over half a circle. It is not told where it is, nor what its commands do.

# %%
agent = ms.HolonomicAgent(max_rotation=0.8 * math.pi)
config = ms.RunConfig(ms.Simulated(agent=agent), preset="best")
scenario = config.data.scenario()
walk = ms.sample(scenario, num=NUM, horizon=6, key=jax.random.key(0))
print("sensors now  ", walk.experience.sensors.shape)
print("commands     ", walk.experience.motors.shape, scenario.commands.names)
print("sensors later", walk.experience.later_sensors.shape)

# %% [markdown]
# ## Learning to predict
#
# `config` says everything: what the run learns from, the network, and how it is trained. The preset
# `best` encodes every command as a matrix; without it you get the paper's LSTM.

# %%
run = ms.train(ms.changed(config, {"epochs": EPOCHS}))
errors = np.array([record["prediction_loss"] for record in run.log])

figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
axes.plot(np.arange(1, len(errors) + 1), errors, color="#3867b0")
axes.set(xlabel="epoch", ylabel="prediction loss", yscale="log")
axes.spines[["top", "right"]].set_visible(False)

# %% [markdown]
# In the first tenth of the epochs the sequences grow from one command to six, so the task becomes
# harder while the network learns: that is the small step up. From then on the loss falls.

# %% [markdown]
# ## Looking at the codes
#
# The code of a sequence has six units. We rotate them into four independent components, without
# telling them anything about displacements, and only then colour them: two components form a plane
# of translations, and the other two a ring of orientations.

# %%
codes = np.asarray(run.encode(walk.experience.motors))
ahead, aside, turn = np.asarray(walk.displacements.nominal).T
components = ms.ica(codes, 4)
components = components[:, np.argsort((components**4).mean(axis=0))]  # the ring is least peaked

figure, panels = plt.subplots(1, 3, figsize=(10, 3.5), layout="constrained")
shown = [
    (components[:, 2:], ahead, "viridis", "moved ahead, units"),
    (components[:, 2:], aside, "viridis", "moved aside, units"),
    (components[:, :2], turn, "twilight", "turned, radians"),
]
for axes, (points, value, colours, title) in zip(panels, shown, strict=True):
    drawn = axes.scatter(*points.T, c=value, cmap=colours, s=4, linewidths=0)
    figure.colorbar(drawn, ax=axes, shrink=0.8)
    axes.set(title=title, aspect="equal", xticks=[], yticks=[])

# %% [markdown]
# ## Two ways to one place
#
# Turn left by a quarter and slide right, or slide ahead and turn afterwards: other commands, one
# displacement. A third sequence leads elsewhere.

# %%
quarter = math.pi / 2
sequences = np.zeros((3, 6, 4), np.float32)
sequences[0, :2] = (quarter, 0, 0, 0), (0, 0, -1, 0)  # turn left, then slide to the right
sequences[1, :2] = (0, 1, 0, 0), (quarter, 0, 0, 0)  # slide ahead, then turn left
sequences[2, :2] = (0, 1, 0, 0), (-quarter, 0, 0, 0)  # slide ahead, then turn right
first, second, third = np.asarray(run.encode(sequences)) / codes.std(axis=0)
print(f"first and second: {np.linalg.norm(first - second):.2f}")
print(f"second and third: {np.linalg.norm(second - third):.2f}")

# %% [markdown]
# ## In numbers
#
# `topology` measures the codes beside displacement, with the perfect value and the value by chance.
# [Measures](../concepts/measures.md) says what each row means.

# %%
print(ms.topology(codes, walk.displacements.nominal))

# %% [markdown]
# From here: [your own layout and sensor](own_layout_and_sensor.md), or
# [what came out when this was done carefully](../results/index.md).
