"""Problems that a person poses: a start, a goal, and whether one leads to the other."""

import math
from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np

from motorspace._errors import UserError
from motorspace._types import Pose
from motorspace.navigation.arena import Arena
from motorspace.navigation.problems import Problem, posed
from motorspace.se2 import compose

POSE = ("x", "y", "heading")
DISPLACEMENT = ("longitudinal", "lateral")


def given_problem(
    arena: Arena, problem: Problem, *, start: Any = None, goal: Any = None
) -> Problem:
    """Return the problem that somebody poses, for the one agent of an arena.

    Args:
        arena: The task, with a single agent.
        problem: The one that it takes the place of.
        start: x, y and heading (world units, radians); by default those of `problem`.
        goal: For a displacement goal (longitudinal, lateral) in the frame of the start, world
            units; for a sensor goal the x, y and heading at which the readings are taken.

    Raises:
        UserError: For a wrong number of values, values that are not finite, a place outside the
            world or in a wall, a goal that no way leads to, and a task whose goals cannot be given.
    """
    task = arena.task
    begin = _place(problem.start) if start is None else numbers(start, POSE, "the start")
    pose = _checked(arena, begin, "the start")
    if task.wanders or not task.has_goal:
        if goal is not None:
            raise UserError(f"a {type(task).__name__} task takes no goal", remedy="leave it out")
        found = posed(arena.setting, pose, pose)
        return found._replace(wander=problem.wander, num_wander=problem.num_wander)
    if goal is None:
        raise UserError("a start needs a goal", remedy="give both, or the goal alone")
    aim = _checked(arena, _goal(arena, begin, goal), "the goal")
    found = posed(arena.setting, pose, aim)
    if not np.isfinite(np.asarray(found.distance)).all():
        raise UserError(
            "no way leads from the start to the goal", remedy="choose a goal on this side of walls"
        )
    return found


def numbers(values: Any, names: Sequence[str], what: str) -> list[float]:
    """Finite numbers, as many as there are names. Raises `UserError` otherwise."""
    try:
        found = [float(value) for value in np.asarray(values, float).reshape(-1)]
    except (TypeError, ValueError):
        raise UserError(f"{what} must be numbers, got {values!r}") from None
    if len(found) != len(names):
        raise UserError(
            f"{what} must be {len(names)} numbers ({', '.join(names)}), got {len(found)}"
        )
    if not all(map(math.isfinite, found)):
        raise UserError(f"{what} must be finite, got {found}")
    return found


def _goal(arena: Arena, start: Sequence[float], goal: Any) -> list[float]:
    """The x, y and heading of a goal."""
    if arena.task.gives_displacement:
        ahead, left = numbers(goal, DISPLACEMENT, "the goal")
        end = compose(np.asarray(start), np.asarray([ahead, left, 0.0]))
        return [float(value) for value in end]
    return numbers(goal, POSE, "the goal")


def _checked(arena: Arena, pose: Sequence[float], what: str) -> Pose:
    world: Any = arena.scenario.world
    x_low, y_low, x_high, y_high = (float(np.asarray(bound)[0]) for bound in world.bounds)
    x, y, heading = pose
    if not (x_low < x < x_high and y_low < y < y_high):
        raise UserError(
            f"{what} ({x:g}, {y:g}) is outside the world",
            remedy=f"keep x from {x_low:g} to {x_high:g} and y from {y_low:g} to {y_high:g}",
        )
    found = Pose(*(jnp.full(1, value, jnp.float32) for value in (x, y, heading, 0.0)))
    if not bool(world.free(found).all()):
        raise UserError(f"{what} ({x:g}, {y:g}) is in a wall", remedy="choose a place beside it")
    return found


def _place(pose: Pose) -> list[float]:
    return [float(np.asarray(field).ravel()[0]) for field in (pose.x, pose.y, pose.heading)]
