# %% [markdown]
# # Find the way home
#
# An agent wanders at random through rooms that it has never seen, and must then come back to its
# start. It senses nine distances and bumps, no position. What it has learned before about its own
# commands says where home is: every command is a matrix, and their product is the way back.

# %%
import motorspace as ms

STEPS = 300_000  # commands to learn from; with fewer, fewer goals are reached
NUM = 512  # problems to measure with

# %% [markdown]
# ## Codes that come with the package
#
# The network learned by predicting what it would sense, and never knew where it was. It brings a
# policy as well, but first we learn one ourselves.

# %%
found = ms.load_pretrained("forward-0.4pi")
data = found.run.config.data
common = {"agent": data.agent, "sensor": data.sensor, "steps": STEPS}

# %% [markdown]
# ## Two policies
#
# One observes distances, bumps and its last command; the other one the chained code as well. Both
# learn by proximal policy optimisation, rewarded for nothing but coming home.

# %%
sensed = ("ranges", "bump", "command")
blind = ms.learn_policy(ms.NavigationConfig("home", observe=sensed, **common))
coded = ms.learn_policy(ms.NavigationConfig("home", observe=(*sensed, "code"), **common), found.run)
for name, policy in (("what it senses", blind), ("and the chained code", coded)):
    share = policy.log[-1]["success"]
    print(f"{name:>20}: {share:.0%} of the last episodes came home")

# %% [markdown]
# ## In rooms that neither has seen
#
# Chance moves at random. The planner knows the map and where it is.

# %%
first, second = (ms.evaluate_policy(policy, num=NUM) for policy in (blind, coded))
rows = {
    "chance": first["chance.success"],
    "what it senses": first["unseen.success"],
    "and the chained code": second["unseen.success"],
    "the planner": first["planner.success"],
}
for name, share in rows.items():
    print(f"{name:>20}: {share:6.1%}")

# %% [markdown]
# ## To look at
#
# Grey: the random commands. Blue: what the policy does then. The circle is home.

# %%
ms.policy_film(coded, num=2, seed=4)

# %% [markdown]
# Distances do not say which room this is, so the first policy can only search. The second one turns
# round and walks. It does not know the walls between, though: where the way home leads around one,
# it has to find the door by touch. `found.policy` learned for longer. On the command line:
# `motorspace navigate watch FOLDER`. How all of this compares: [navigation](../navigation.md).
