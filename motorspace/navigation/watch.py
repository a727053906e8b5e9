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
from matplotlib.patches import Circle, Polygon

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
from motorspace.reports.figures.films import MILLISECONDS, RESTING, film
from motorspace.reports.figures.style import SERIES, ink
from motorspace.reports.figures.worlds import draw_world
from motorspace.worlds.scenario import Scenario

LEAST_VIEW, MARGIN = 7.0, 3.0
"""Half the side of what is shown, at least, and what is shown around the way, world units."""

OWN, RAY, GOAL = SERIES[0], SERIES[1], SERIES[2]


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


def policy_film(
    trained: TrainedPolicy, *, num: int = 2, split: str = "test", seed: int = 0
) -> FuncAnimation:
    """Returns a moving picture of a policy's episodes, one after the other.

    Args:
        trained: The policy.
        num: Episodes, each in another layout.
        split: `"train"`, or `"test"` for layouts that it has not learned in.
        seed: The seed of the problems.

    Returns:
        The film; `film.save("film.gif", writer="pillow")` writes it.
    """
    return _film(episodes_of(trained, num=num, split=split, seed=seed))


def _film(episodes: list[Watched]) -> FuncAnimation:
    """Episodes as a moving picture, a command in every frame."""
    return film(lambda axes, frame: _draw(axes, *frame), list(_frames(episodes)), (6.0, 6.4))


def write_animation(episodes: list[Watched], path: Path) -> None:
    """Write episodes one after the other as a GIF.

    Raises:
        UserError: Where it cannot be written.
    """
    try:
        _film(episodes).save(path, writer=PillowWriter(fps=round(1000 / MILLISECONDS)), dpi=100)
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
        axes.add_patch(Circle(tuple(episode.goal), episode.radius, color=GOAL, alpha=0.35, lw=0))
        x, y = episode.goal
        axes.scatter([x], [y], marker="*", s=130, color=GOAL, zorder=3, label="goal")
    pose = jax.tree.map(lambda field: jnp.asarray(field[moment]), poses)
    rays = np.asarray(scenario.sensor.rays(scenario.world, pose))
    axes.add_collection(LineCollection(list(rays), colors=RAY, linewidths=0.9, alpha=0.75))
    axes.scatter(rays[:, 1, 0], rays[:, 1, 1], s=14, color=RAY, zorder=3, linewidths=0)
    _draw_way(axes, episode, moment)
    x, y, heading, gaze = (float(v) for v in (pose.x, pose.y, pose.heading, pose.gaze))
    axes.add_patch(Polygon(_body(x, y, heading), color=OWN, zorder=6, lw=0))
    nose = [x, x + np.cos(gaze)], [y, y + np.sin(gaze)]
    axes.plot(*nose, color=ink("text"), lw=1.6, zorder=7)
    middle, half = _view(episode)
    limits = {name: (m - half, m + half) for name, m in zip(("xlim", "ylim"), middle, strict=True)}
    axes.set(xticks=[], yticks=[], **limits)
    axes.set_title(_title(episode, moment), fontsize=14)
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=4, fontsize=11, handlelength=1.6
    )


def _draw_way(axes: Axes, episode: Watched, moment: int) -> None:
    """Where the agent has been: at random first, by itself from then on."""
    x, y, away = episode.poses.x, episode.poses.y, min(moment, episode.num_wander)
    axes.scatter(
        x[:1], y[:1], s=90, facecolors="none", edgecolors=ink("muted"), lw=1.8, label="start"
    )
    if episode.num_wander > 0:
        wander: dict[str, Any] = {
            "color": ink("muted"),
            "lw": 1.4,
            "ls": (0, (3, 2)),
            "label": "random commands",
        }
        axes.plot(x[: away + 1], y[: away + 1], **wander)
    own: dict[str, Any] = {"color": OWN, "lw": 2.4, "marker": "o", "ms": 4, "label": "its own"}
    axes.plot(x[away : moment + 1], y[away : moment + 1], **own)


def _body(x: float, y: float, heading: float) -> Float[np.ndarray, "3 2"]:
    """A triangle that points where the body heads."""
    angles = heading + np.array([0.0, 2.5, -2.5])
    return np.stack([x + 0.6 * np.cos(angles), y + 0.6 * np.sin(angles)], axis=-1)


def _view(episode: Watched) -> tuple[Float[np.ndarray, "2"], float]:
    """The middle and half the side of what is shown: all of the way, the goal, and around them."""
    places = np.stack([episode.poses.x, episode.poses.y], axis=-1)
    if episode.goal is not None:
        places = np.concatenate([places, episode.goal[None]])
    low, high = places.min(axis=0), places.max(axis=0)
    return (low + high) / 2, max(LEAST_VIEW, float((high - low).max()) / 2 + MARGIN)


def _title(episode: Watched, moment: int) -> str:
    acted = moment - episode.num_wander
    if acted < 0:
        return f"random commands: {moment} of {episode.num_wander}"
    ended = moment == len(episode.poses.x) - 1 and episode.goal is not None
    end = (": the goal is reached" if episode.reached else ": time is up") * ended
    return f"{acted} commands of its own{end}"
