"""Agents in their worlds as Gymnasium environments: without a task, and with one.

`import motorspace` registers the ids below with Gymnasium, and so does
`gymnasium.make("motorspace:motorspace/Forward-v0")`, which imports it. Nothing heavy is imported
before an environment is made.
"""

import importlib.abc
import importlib.util
import sys
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

IDS: dict[str, dict[str, Any]] = {
    "motorspace/Exploration-v0": {},
    "motorspace/Lattice-v0": {"agent": "lattice"},
    "motorspace/Forward-v0": {"agent": "forward"},
    "motorspace/Holonomic-v0": {"agent": "holonomic"},
}
"""What each id adds to the options of an environment."""

NAVIGATION: dict[str, dict[str, Any]] = {
    "motorspace/Home-v0": {"task": "home"},
    "motorspace/DisplacementGoal-v0": {"task": "displacement_goal"},
    "motorspace/SensorGoal-v0": {"task": "sensor_goal"},
    "motorspace/Explore-v0": {"task": "explore"},
}
"""The same for environments with a task, which say themselves when an episode ends."""

MAX_EPISODE_STEPS = 200
"""Steps of an episode where nothing else is asked for."""


def register() -> None:
    """Register the environments with Gymnasium; once is enough, twice does no harm."""
    from gymnasium.envs import registration

    for name, options in IDS.items():
        if name not in registration.registry:
            registration.register(
                id=name,
                entry_point="motorspace.environments.single:ExplorationEnv",
                vector_entry_point="motorspace.environments.vector:ExplorationVectorEnv",
                max_episode_steps=MAX_EPISODE_STEPS,
                kwargs=dict(options),
            )
    for name, options in NAVIGATION.items():
        if name not in registration.registry:
            registration.register(
                id=name,
                entry_point="motorspace.navigation.environments:NavigationEnv",
                vector_entry_point="motorspace.navigation.environments:NavigationVectorEnv",
                kwargs=dict(options),
            )


def register_with_gymnasium() -> None:
    """Register the environments now if Gymnasium is imported, else as soon as it is."""
    if "gymnasium" in sys.modules:
        register()
    elif not any(isinstance(finder, _Registration) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Registration())


class _Registration(importlib.abc.MetaPathFinder):
    """Registers the environments when Gymnasium is imported, which costs too much before."""

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> ModuleSpec | None:
        if fullname != "gymnasium":
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(fullname)
        if spec is not None and spec.loader is not None:
            execute = spec.loader.exec_module

            def execute_and_register(module: ModuleType) -> None:
                execute(module)
                register()

            spec.loader.exec_module = execute_and_register  # type: ignore[method-assign]
        return spec
