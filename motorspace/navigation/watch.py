"""Episodes as moving pictures: walls, rays, the goal and the way so far."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle

from motorspace._errors import UserError
from motorspace._types import Key, Pose
from motorspace.navigation.actors import AbstractActor
from motorspace.navigation.arena import Arena
from motorspace.navigation.arenas import Size, arena_of
from motorspace.navigation.copies import of_layouts
from motorspace.navigation.evaluation import run_episode
from motorspace.navigation.given import given_problem
from motorspace.navigation.learning import TrainedPolicy
from motorspace.navigation.measuring import actor_of
from motorspace.reports.figures.style import SERIES, ink, new_figure, styled
from motorspace.reports.figures.worlds import draw_world
from motorspace.worlds.scenario import Scenario

FRAMES_PER_SECOND = 8
RESTING = 6
"""Frames for which the end of an episode stays."""


class Watched(NamedTuple):
    """An episode of one agent."""

    scenario: Scenario
    goal: Float[np.ndarray, "2"] | None
    poses: Pose
    """Fields [T + 1]."""
    num_wander: int
    reached: bool
    radius: float
    """How near to the goal is near enough, world units."""


def episodes_of(
    trained: TrainedPolicy,
    *,
    num: int,
    split: str = "test",
    goal: Any = None,
    sampled: bool = True,
    seed: int = 0,
) -> list[Watched]:
    """`num` episodes of a policy, each in another layout; to `goal` if one is given.

    Raises:
        UserError: As `given_problem`.
    """
    config = replace(trained.config, num_layouts=num)
    key, actor = jax.random.key(seed), actor_of(trained, sampled=sampled)
    arena = arena_of(config, trained.codes, split, Size(num, 1), key=key)
    each = [of_layouts(arena, jnp.array([number])) for number in range(num)]
    return [_episode(one, actor, goal, jax.random.fold_in(key, n)) for n, one in enumerate(each)]


def _episode(arena: Arena, actor: AbstractActor, goal: Any, key: Key) -> Watched:
    start_key, key = jax.random.split(key)
    state = arena.begin(key=start_key)
    if goal is not None:
        state = arena.begin_with(given_problem(arena, state.problem, goal=goal))
    done, poses = run_episode(arena, actor, state, key=key)
    num_wander = int(state.problem.num_wander[0])
    last = num_wander + int(done.steps[0]) + 1
    world: Any = jax.tree.map(lambda leaf: leaf[..., 0], arena.scenario.world)
    place = state.problem.goal
    return Watched(
        Scenario(world, arena.scenario.agent, arena.scenario.sensor),
        np.array([float(place.x[0]), float(place.y[0])]) if arena.task.has_goal else None,
        jax.tree.map(lambda field: np.asarray(field[:last, 0]), poses),
        num_wander,
        bool(done.reached[0]),
        arena.task.radius,
    )


@styled
def write_animation(episodes: list[Watched], path: Path) -> None:
    """Write episodes one after the other as a GIF.

    Raises:
        UserError: Where it cannot be written.
    """
    figure = new_figure(4.2, 4.4)
    axes = figure.add_subplot()

    def draw(frame: tuple[Watched, int]) -> None:
        axes.clear()
        _draw(axes, *frame)

    animation = FuncAnimation(figure, draw, list(_frames(episodes)), init_func=lambda: None)
    try:
        animation.save(path, writer=PillowWriter(fps=FRAMES_PER_SECOND), dpi=90)
    except OSError as error:
        raise UserError(
            f"the file cannot be written ({error.strerror})",
            where=path,
            remedy="give a place in a folder that exists",
        ) from None


def _frames(episodes: list[Watched]) -> Iterator[tuple[Watched, int]]:
    for episode in episodes:
        last = len(episode.poses.x) - 1
        yield from ((episode, min(moment, last)) for moment in range(last + RESTING))


def _draw(axes: Axes, episode: Watched, moment: int) -> None:
    scenario, poses = episode.scenario, episode.poses
    draw_world(axes, scenario.world)
    if episode.goal is not None:
        axes.add_patch(Circle(tuple(episode.goal), episode.radius, color=SERIES[2], alpha=0.6))
    pose = jax.tree.map(lambda field: jnp.asarray(field[moment]), poses)
    rays = scenario.sensor.rays(scenario.world, pose)
    axes.add_collection(LineCollection(list(rays), colors=SERIES[1], linewidths=0.6))
    away = min(moment, episode.num_wander)
    axes.plot(poses.x[: away + 1], poses.y[: away + 1], color=ink("muted"), lw=1)
    axes.plot(poses.x[away : moment + 1], poses.y[away : moment + 1], color=SERIES[0], lw=1.6)
    x, y, gaze = float(pose.x), float(pose.y), float(pose.gaze)
    axes.scatter([x], [y], s=40, color=SERIES[0], zorder=4, linewidths=0)
    axes.plot([x, x + np.cos(gaze)], [y, y + np.sin(gaze)], color=ink("text"), zorder=5)
    axes.set(xticks=[], yticks=[], title=_title(episode, moment))


def _title(episode: Watched, moment: int) -> str:
    acted = moment - episode.num_wander
    if acted < 0:
        return f"wandering: {moment} of {episode.num_wander}"
    ended = moment == len(episode.poses.x) - 1 and episode.goal is not None
    end = ("; reached" if episode.reached else "; time is up") * ended
    return f"{acted} commands{end}"
