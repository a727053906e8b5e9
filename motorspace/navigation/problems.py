"""Problems: where an agent begins, where it is to go, and that there is a way of fitting length."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from motorspace._errors import UserError
from motorspace._types import Key, Keys, Motors, Pose, Walls
from motorspace.navigation.levels import Level
from motorspace.navigation.planner import Corners, in_sight, way_length, ways_to
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.simulation import select
from motorspace.worlds.spaces import ContinuousCommands
from motorspace.worlds.world import AbstractWorld

CANDIDATES, MORE = 4, 64
"""For each problem that is wanted four are proposed, and 64 besides, since some do not fit."""


class Problem(NamedTuple):
    """What an episode begins with, for N agents (last axis); with one more axis, many of them."""

    start: Pose
    goal: Pose
    distance: Float[Array, "*P N"]
    """The shortest way to the goal from where the agent begins to act, world units."""
    around: Bool[Array, "*P N"]
    """Whether that way leads around a wall."""
    to_goal: Float[Array, "*P V N"]
    """The shortest way to the goal from every corner of its world."""
    readings: Float[Array, "*P K N"]
    """What is sensed at the start."""
    wanted: Float[Array, "*P K N"]
    """What is sensed at the goal."""
    wander: Float[Array, "*P W M N"]
    """Commands that lead away from the start before the agent acts."""
    num_wander: Int[Array, "*P N"]
    """How many of them are executed."""


class Setting(NamedTuple):
    """What problems are posed in."""

    scenario: Scenario
    """Its world holds one world for each agent; see `deal_worlds`."""
    corners: Corners
    """Where ways bend in each agent's world."""

    @property
    def walls(self) -> Walls:
        """The walls of each agent's world."""
        world: Any = self.scenario.world
        return world.walls

    @property
    def commands(self) -> ContinuousCommands:
        """The commands of the agents. Raises `UserError` for those that are numbers."""
        commands = self.scenario.commands
        if not isinstance(commands, ContinuousCommands):
            raise UserError(
                f"a {type(self.scenario.agent).__name__} moves from node to node, and goals are"
                " places among walls",
                remedy="choose the agent forward or holonomic",
            )
        return commands


def sample_problems(
    setting: Setting, level: Level, *, num: int, wanders: bool, somewhere: bool, key: Key
) -> Problem:
    """`num` random problems of a level for each agent: fields [num, ..., N].

    Args:
        setting: Where they are posed.
        level: How far goals are, and for how long agents wander.
        num: Problems for each agent. Where a world offers fewer, they are repeated.
        wanders: Whether the goal is where the agent begins, and random commands lead away from it.
        somewhere: Whether there is no goal at all.
        key: The source of randomness.

    Raises:
        UserError: For a world in which no problem of this level was found.
    """
    num_agents = setting.corners.x.shape[-1]
    keys = jax.random.split(key, (MORE + CANDIDATES * num, num_agents))
    problems, count = _sampled(setting, keys, level, num, wanders, somewhere)
    if not bool((count > 0).all()):
        raise UserError(
            f"some layout has no two places whose way is {level.nearest:g} to {level.farthest:g}"
            " units long",
            remedy="choose another level or other layouts",
        )
    return problems


def _sample(
    setting: Setting, keys: Keys, level: Level, num: int, wanders: bool, somewhere: bool
) -> tuple[Problem, Int[Array, " N"]]:
    def propose(keys: Keys) -> tuple[Problem, Bool[Array, " N"]]:
        if somewhere:
            return _anywhere(setting, keys)
        return _home(setting, level, keys) if wanders else _two_places(setting, level, keys)

    proposed, fit = jax.lax.map(propose, keys)
    count = fit.sum(axis=0).astype(jnp.int32)
    nth = jnp.arange(num, dtype=jnp.int32)[:, None] % jnp.maximum(count, 1)[None]
    rows = jnp.take_along_axis(jnp.argsort(~fit, axis=0, stable=True), nth, axis=0)
    pick = jax.vmap(lambda of_agent, rows: of_agent[rows], in_axes=-1, out_axes=-1)
    return jax.tree.map(lambda leaf: pick(leaf, rows), proposed), count


_sampled = jax.jit(_sample, static_argnums=(2, 3, 4, 5))


def posed(setting: Setting, start: Pose, goal: Pose) -> Problem:
    """The problem to get from one pose to another, for each agent."""
    scenario, num = setting.scenario, len(start.x)
    to_goal = ways_to(setting.walls, setting.corners, (goal.x, goal.y))
    return Problem(
        start,
        goal,
        *_way(setting, start, goal, to_goal),
        to_goal,
        scenario.sense(start),
        scenario.sense(goal),
        jnp.zeros((0, setting.commands.size, num)),
        jnp.zeros(num, jnp.int32),
    )


def _way(
    setting: Setting, start: Pose, goal: Pose, to_goal: Float[Array, "V N"]
) -> tuple[Float[Array, " N"], Bool[Array, " N"]]:
    """The length of the shortest way, and whether it leads around a wall."""
    ends = (goal.x, goal.y), (start.x, start.y)
    length = way_length(setting.walls, setting.corners, to_goal, *ends)
    return length, ~in_sight(setting.walls, *ends)


def _anywhere(setting: Setting, keys: Keys) -> tuple[Problem, Bool[Array, " N"]]:
    start = _random_pose(setting.scenario, keys)
    return posed(setting, start, start), setting.scenario.world.free(start)


def _two_places(setting: Setting, level: Level, keys: Keys) -> tuple[Problem, Bool[Array, " N"]]:
    scenario = setting.scenario
    keys = jax.vmap(lambda key: jax.random.split(key, 3))(keys)
    goal, turned = (_random_pose(scenario, keys[:, n]) for n in range(2))
    polar = jax.vmap(lambda key: jax.random.uniform(key, (2,)))(keys[:, 2])
    far, angle = level.farthest * jnp.sqrt(polar[:, 0]), 2 * jnp.pi * polar[:, 1]
    x, y = goal.x + far * jnp.cos(angle), goal.y + far * jnp.sin(angle)
    start = Pose(x, y, turned.heading, turned.head)
    problem = posed(setting, start, goal)
    free = scenario.world.free(start) & scenario.world.free(goal)
    return problem, free & _fits(level, problem.distance)


def _home(setting: Setting, level: Level, keys: Keys) -> tuple[Problem, Bool[Array, " N"]]:
    scenario = setting.scenario
    keys = jax.vmap(lambda key: jax.random.split(key, 3))(keys)
    home = _random_pose(scenario, keys[:, 0])
    fewest, most = level.wander
    num_wander = jax.vmap(lambda key: jax.random.randint(key, (), fewest, most + 1))(keys[:, 1])
    wander_keys = jax.vmap(lambda key: jax.random.split(key, most))(keys[:, 2])
    sample = jax.vmap(jax.vmap(lambda key: scenario.commands.sample(key=key)))
    wander = jnp.moveaxis(sample(wander_keys), 0, -1)
    away = _wandered(scenario, home, wander, num_wander)
    here = posed(setting, home, home)
    distance, around = _way(setting, away, home, here.to_goal)
    problem = here._replace(distance=distance, around=around, wander=wander, num_wander=num_wander)
    return problem, scenario.world.free(home) & _fits(level, distance)


def _wandered(scenario: Scenario, pose: Pose, wander: Motors, num_wander: Int[Array, " N"]) -> Pose:
    def advance(pose: Pose, given: tuple[Array, Array]) -> tuple[Pose, None]:
        number, motor = given
        return select(number < num_wander, scenario.step(pose, motor)[0], pose), None

    numbers = jnp.arange(len(wander), dtype=jnp.int32)
    return jax.lax.scan(advance, pose, (numbers, wander))[0]


def _fits(level: Level, distance: Float[Array, " N"]) -> Bool[Array, " N"]:
    return (distance >= level.nearest) & (distance <= level.farthest)


def _random_pose(scenario: Scenario, keys: Keys) -> Pose:
    """A random pose for each agent in its own world, as an episode begins; it need not be free."""

    def one(world: AbstractWorld, key: Key) -> Pose:
        place_key, head_key = jax.random.split(key)
        return scenario.agent.start(world.random_pose(key=place_key), key=head_key)

    return jax.vmap(one, in_axes=(-1, 0), out_axes=-1)(scenario.world, keys)
