"""What policies observe and how they act, in the tasks of the study of navigation."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from motorspace.navigation.config import PolicyConfig, PPOConfig

STEPS = {
    "home": 300_000,
    "displacement_goal": 1_000_000,
    "sensor_goal": 300_000,
    "explore": 300_000,
}
"""Commands from which the policies of a task learn."""

SENSED = ("ranges", "bump", "command")
CODED = (*SENSED, "code")
MEMORY = PolicyConfig(memory_size=64)
IN_CODES = PPOConfig(num_steps=4, num_epochs=8, learning_rate=2e-3, discount=0.94)
"""An action takes six commands, so there are fewer of them, and each is worth six."""


@dataclass(frozen=True)
class Observed:
    """A row: what a policy observes, how it acts, and for which tasks."""

    options: Mapping[str, Any]
    tasks: tuple[str, ...] = ("home",)
    codes: str = "learned"
    """The network whose codes they are."""
    times: int = 1
    """How often the usual number of commands it learns from."""
    networks: int | None = None
    """With how many of the networks it is learned, by one policy each; by default with all."""


GOALS = ("home", "displacement_goal")

OBSERVATIONS: Mapping[str, Observed] = {
    "ranges": Observed({"observe": SENSED}, (*GOALS, "sensor_goal", "explore")),
    "ranges + four frames": Observed({"observe": (*SENSED, "stack")}),
    "ranges + GRU": Observed({"observe": SENSED, "policy": MEMORY}, (*GOALS, "explore")),
    "ranges + GRU, 20 times the steps": Observed(
        {"observe": SENSED, "policy": MEMORY}, times=20, networks=3
    ),
    "chained code": Observed({"observe": CODED}, (*GOALS, "sensor_goal", "explore")),
    "chained code, shaped reward": Observed(
        {"observe": CODED, "reward": "shaped"}, ("displacement_goal",), networks=1
    ),
    "chained code + GRU": Observed({"observe": CODED, "policy": MEMORY}, GOALS),
    "chained code, bumps not sensed": Observed(
        {"observe": ("ranges", "command", "code"), "sense_blocked": False}
    ),
    "codes as actions": Observed({"observe": CODED, "act": "codes", "ppo": IN_CODES}, GOALS),
    "untrained code": Observed({"observe": (*SENSED, "untrained_code")}, GOALS),
    "supervised code": Observed({"observe": CODED}, GOALS, codes="supervised"),
    "paper's code, learned composition": Observed({"observe": CODED}, codes="paper"),
    "true displacement": Observed({"observe": (*SENSED, "displacement")}, (*GOALS, "sensor_goal")),
}

BESIDE = ("chance", "planner")
"""Rows that learn nothing."""

CODES = ("learned", "supervised", "paper")
