# %% [markdown]
# # Eyes instead of rulers
#
# So far the agent sensed distances, which are about space already. Here it sees colours, and
# nothing else. Does prediction still find out how the agent moves? Three minutes.

# %%
import math

import jax
import numpy as np

import motorspace as ms

EPOCHS = 200  # 1,000 for the numbers in the results
NUM = 4000

# %% [markdown]
# ## A painted room
#
# Every wall of the room has a colour. The retina has 32 pixels over half a circle. Below the room
# is what each agent sees, from left to right: no strip says how far away a wall is.

# %%
agent = ms.ForwardAgent(max_rotation=0.4 * math.pi)
data = ms.Simulated(agent, ms.Retina(num_rays=32), paint="flat:3")
scenario = data.scenario()
poses = [scenario.start(key=jax.random.key(seed)) for seed in (1, 2, 4)]
print(
    "readings:", scenario.space.shape, "from", scenario.space.low[0], "to", scenario.space.high[0]
)
ms.view_figure(scenario.world, poses, scenario.sensor)

# %% [markdown]
# ## Learning to predict colours
#
# `vision` is the preset `best` with another schedule, and predicts blurred views beside sharp ones:
# what is coarse in a view can be predicted from farther away.

# %%
config = ms.changed(ms.RunConfig(data, preset="vision"), {"epochs": EPOCHS})
run = ms.train(config)
measured = ms.evaluate(run, num=NUM)
for name in ("error", "persistence", "mean"):
    print(f"{name:12} {measured[f'prediction.{name}']:.3f}")

# %% [markdown]
# More than half of the variance of views is beyond prediction: an agent cannot know what is around
# a corner. Is it enough to learn from?
#
# ## Where do the codes say that the agent went?
#
# The agent has not been told a single displacement. Codes of new motor sequences, coloured by the
# true ones:

# %%
walk = ms.sample(scenario, num=NUM, horizon=6, key=jax.random.key(1))
codes = np.asarray(run.encode(walk.experience.motors))
report = ms.topology(codes, walk.displacements.nominal)
print("R² of a linear probe:", {part: round(r2, 3) for part, r2 in report.linear_r2.items()})
ms.codes_figure([("", ms.pca(codes, 3).coordinates, np.asarray(walk.displacements.nominal))])

# %% [markdown]
# ## Textures
#
# A texture is harder: it looks different from every place. With wavelengths of 4 to 8 units hardly
# anything can be predicted over six commands.

# %%
textured = ms.Simulated(agent, ms.Retina(num_rays=32), paint="texture:4:1:3")
fine = ms.train(ms.changed(ms.RunConfig(textured, preset="vision"), {"epochs": EPOCHS}))
measured = ms.evaluate(fine, num=NUM)
report = ms.topology(fine.encode(walk.experience.motors), walk.displacements.nominal)
print(f"error / mean {measured['prediction.error'] / measured['prediction.mean']:.2f}")
print(f"R² of the worst component {report['linear_r2.worst']:.3f}")
ms.view_figure(textured.scenario().world, poses, textured.scenario().sensor)

# %% [markdown]
# Codes are structured all the same: training begins with short sequences, of which more can be
# predicted, and their matrices compose to longer ones. [Does it work with
# eyes?](../results/vision.md) measures from where on it does not.
