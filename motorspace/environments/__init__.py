"""The three agents as Gymnasium environments, without a task: reward 0, never terminated.

Importing this package registers `motorspace/Lattice-v0`, `motorspace/Forward-v0` and
`motorspace/Holonomic-v0`; or let Gymnasium do it:
`gymnasium.make("motorspace.environments:motorspace/Forward-v0")`.
"""

import gymnasium

IDS = {
    "motorspace/Lattice-v0": "lattice",
    "motorspace/Forward-v0": "forward",
    "motorspace/Holonomic-v0": "holonomic",
}


def register() -> None:
    """Register the environments; once is enough, twice does no harm."""
    for name, agent in IDS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                id=name,
                entry_point="motorspace.environments.single:ExplorationEnv",
                vector_entry_point="motorspace.environments.vector:ExplorationVectorEnv",
                kwargs={"agent": agent},
            )


register()
