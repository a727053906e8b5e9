"""What an agent is to do, what it is given for it, and what it is rewarded for."""

import abc
from typing import Any, ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from motorspace._errors import UserError
from motorspace._types import Flags, Pose
from motorspace.navigation.problems import Problem
from motorspace.se2 import relative
from motorspace.worlds.scenario import Scenario

Hint = Float[Array, "G N"]
"""What each agent is given about its goal."""

Seen = Bool[Array, "C N"]
"""The cells of the world that each agent has been in, where a task asks for them."""

CELLS = 20
"""Cells along each side of a world whose coverage is rewarded."""

Bounds = tuple[tuple[float, ...], tuple[float, ...]]


def body(pose: Pose) -> tuple[Float[Array, " N"], Float[Array, " N"], Float[Array, " N"]]:
    """The frame (x, y, heading) in which the body moves, wherever the head looks."""
    return pose.x, pose.y, pose.heading


class AbstractNavigation(eqx.Module):
    """What a task must answer, for N agents (last axis)."""

    wanders: ClassVar[bool] = False
    """Whether random commands lead the agent away from its goal before it acts."""
    has_goal: ClassVar[bool] = True
    """Whether there is a place to reach."""
    gives_displacement: ClassVar[bool] = False
    """Whether the hint is the displacement of the goal from the start."""

    radius: float = eqx.field(static=True, default=1.0)
    """How near to its goal an agent must come, world units."""

    def hint(self, problem: Problem) -> Hint:
        """What the agents are given about their goals; nothing by default."""
        return jnp.zeros((0, problem.distance.shape[-1]))

    def hint_bounds(self, scenario: Scenario) -> Bounds:
        """The smallest and the largest value of each number of the hint."""
        del scenario
        return (), ()

    def begin(self, problem: Problem) -> Seen:
        """The cells that have been seen before the first command."""
        return jnp.zeros((0, problem.distance.shape[-1]), bool)

    @abc.abstractmethod
    def score(
        self, scenario: Scenario, seen: Seen, pose: Pose, problem: Problem
    ) -> tuple[Seen, Float[Array, " N"], Flags]:
        """The cells seen, the reward, and whether the goal is reached, after a command."""


class GoalTask(AbstractNavigation):
    """A place must be reached; reward 1 for that."""

    def score(
        self, scenario: Scenario, seen: Seen, pose: Pose, problem: Problem
    ) -> tuple[Seen, Float[Array, " N"], Flags]:
        del scenario
        away = jnp.hypot(pose.x - problem.goal.x, pose.y - problem.goal.y)
        reached = away < self.radius
        return seen, reached.astype(jnp.float32), reached


class Home(GoalTask):
    """To come back to where the episode began, after some random commands; no place is sensed."""

    wanders: ClassVar[bool] = True


class DisplacementGoal(GoalTask):
    """To reach a place that is given as (longitudinal, lateral) in the frame of the start."""

    gives_displacement: ClassVar[bool] = True

    def hint(self, problem: Problem) -> Hint:
        return relative(body(problem.start), body(problem.goal))[:2]

    def hint_bounds(self, scenario: Scenario) -> Bounds:
        del scenario
        return (-1000.0,) * 2, (1000.0,) * 2


class SensorGoal(GoalTask):
    """To reach the place at which some readings were taken; others that look alike do not count."""

    def hint(self, problem: Problem) -> Hint:
        return problem.wanted

    def hint_bounds(self, scenario: Scenario) -> Bounds:
        return scenario.space.low, scenario.space.high


class Explore(AbstractNavigation):
    """To see much of the world: reward 0.1 for each of 20 x 20 cells when it is first entered."""

    has_goal: ClassVar[bool] = False

    def begin(self, problem: Problem) -> Seen:
        return jnp.zeros((CELLS**2, problem.distance.shape[-1]), bool)

    def score(
        self, scenario: Scenario, seen: Seen, pose: Pose, problem: Problem
    ) -> tuple[Seen, Float[Array, " N"], Flags]:
        del problem
        world: Any = scenario.world
        x_low, y_low, x_high, y_high = world.bounds
        column = (CELLS * (pose.x - x_low) / (x_high - x_low)).astype(jnp.int32)
        row = (CELLS * (pose.y - y_low) / (y_high - y_low)).astype(jnp.int32)
        here = jax.nn.one_hot(row * CELLS + column, CELLS**2, axis=0, dtype=bool)
        new = (here & ~seen).any(axis=0)
        return seen | here, 0.1 * new.astype(jnp.float32), jnp.zeros_like(new)


def cell_centres(scenario: Scenario) -> tuple[Float[Array, "C N"], Float[Array, "C N"]]:
    """x and y of the middle of each cell, row by row as they are counted, in each agent's world."""
    world: Any = scenario.world
    x_low, y_low, x_high, y_high = world.bounds
    share = (jnp.arange(CELLS, dtype=jnp.float32) + 0.5)[:, None] / CELLS
    x, y = (
        low[None] + share * (high - low)[None] for low, high in ((x_low, x_high), (y_low, y_high))
    )
    return jnp.tile(x, (CELLS, 1)), jnp.repeat(y, CELLS, axis=0)


TASKS: dict[str, type[AbstractNavigation]] = {
    "home": Home,
    "displacement_goal": DisplacementGoal,
    "sensor_goal": SensorGoal,
    "explore": Explore,
}


def task_named(name: str) -> AbstractNavigation:
    """The task of a name. Raises `UserError` for one that there is not."""
    if name not in TASKS:
        raise UserError(f"there is no task {name!r}", remedy=f"choose one of {', '.join(TASKS)}")
    return TASKS[name]()
