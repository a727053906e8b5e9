"""Many agents on their way to goals in many worlds, as one compiled step."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from motorspace._types import Flags, Key, Motor, Pose
from motorspace.navigation.interface import Step
from motorspace.navigation.observations import Memory, Moment, Observer
from motorspace.navigation.planner import way_length
from motorspace.navigation.problems import Problem, Setting
from motorspace.navigation.tasks import AbstractNavigation, Seen
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.simulation import select, to_agents_last, to_rows

SHAPING = 0.1
"""The shaped reward for each unit that a command brings the agent nearer to its goal."""


class State(NamedTuple):
    """N agents on their way; agents in the last axis."""

    problem: Problem
    pose: Pose
    steps: Int[Array, " N"]
    """Commands so far, those of the wander included."""
    walked: Float[Array, " N"]
    """The length of the way since the agent acts itself, world units."""
    potential: Float[Array, " N"]
    """What the shaped reward is a difference of; 0 without it."""
    seen: Seen
    bumped: Flags
    """Whether the agent senses that a wall took its last translation away."""
    memory: Memory
    """What the observer remembers."""
    observation: Float[Array, "O N"]


class Outcome(NamedTuple):
    """What came of one command, for N agents."""

    reward: Float[Array, " N"]
    terminated: Flags
    """Whether the goal is reached."""
    truncated: Flags
    """Whether time is up."""
    acted: Flags
    """Whether the command was the agent's own."""
    blocked: Flags
    """Whether a wall took its translation away, sensed or not."""


class Rules(eqx.Module):
    """What does not depend on the world."""

    max_steps: int = eqx.field(static=True)
    """Commands of its own after which an agent's episode is truncated."""
    shaped: bool = eqx.field(static=True, default=False)
    """Whether each step is rewarded by how much nearer it leads."""
    sense_blocked: bool = eqx.field(static=True, default=True)
    """Whether the agent senses that a wall took a translation away."""
    discount: float = eqx.field(static=True, default=0.99)
    """The learner's discount, with which the shaped reward changes no best policy."""


class Arena(eqx.Module):
    """A task for N agents, each in a world of its own, with many problems to solve there."""

    setting: Setting
    task: AbstractNavigation
    observer: Observer
    problems: Problem
    """Fields [P, ..., N]: P problems for each agent."""
    rules: Rules

    @property
    def scenario(self) -> Scenario:
        """The worlds, the body and its sensor."""
        return self.setting.scenario

    @property
    def num_agents(self) -> int:
        """How many agents there are (N)."""
        return int(self.problems.distance.shape[-1])

    @property
    def commands_per_action(self) -> int:
        """Commands that an action makes."""
        return 1

    @property
    def num_problems(self) -> int:
        """How many problems there are for each agent (P)."""
        return len(self.problems.distance)

    @property
    def action_size(self) -> int:
        """Channels of an action in [-1, 1] (A)."""
        return self.scenario.commands.size

    def observed(self, state: State) -> Float[Array, "N O"]:
        """What each agent observes now, agents in rows."""
        return to_rows(state.observation)

    def motors(self, action: Float[Array, "A N"]) -> Motor:
        """The commands at actions in [-1, 1]."""
        return self.setting.commands.from_unit(action)

    def begin(self, *, key: Key) -> State:
        """Every agent at the start of a random one of its problems."""
        rows = jax.random.randint(key, (self.num_agents,), 0, self.num_problems, jnp.int32)
        return self.begin_at(rows)

    def begin_at(self, rows: Int[Array, " N"]) -> State:
        """Every agent at the start of its problem with this number."""
        pick = jax.vmap(lambda of_agent, row: of_agent[row], in_axes=(-1, 0), out_axes=-1)
        return self.begin_with(jax.tree.map(lambda leaf: pick(leaf, rows), self.problems))

    def begin_with(self, problem: Problem) -> State:
        """Every agent at the start of a problem."""
        zero = jnp.zeros_like(problem.distance)
        motor = jnp.zeros((self.scenario.commands.size, *zero.shape))
        acting = problem.num_wander == 0
        moment = Moment(problem.readings, motor, zero > 0, problem.start, acting, problem)
        memory = self.observer.begin(moment)
        potential = -SHAPING * problem.distance if self._shaped else zero
        return State(
            problem,
            problem.start,
            jnp.zeros_like(problem.num_wander),
            zero,
            potential,
            self.task.begin(problem),
            zero > 0,
            memory,
            self.observer.read(memory, moment),
        )

    def advance(self, state: State, motor: Motor) -> tuple[State, Outcome]:
        """What comes of a command of each agent; while it wanders, another takes its place."""
        problem, acted = state.problem, state.steps >= state.problem.num_wander
        motor = jnp.where(acted[None], motor, _nth(problem.wander, state.steps))
        pose, blocked = self.scenario.step(state.pose, motor)
        steps = state.steps + 1
        acting = steps >= problem.num_wander
        moment = Moment(
            self.scenario.sense(pose),
            motor,
            blocked & self.rules.sense_blocked,
            pose,
            acting,
            problem,
        )
        memory = self.observer.update(state.memory, moment)
        seen, reward, reached = self.task.score(self.scenario, state.seen, pose, problem)
        terminated = reached & acted
        reward = jnp.where(acted, reward, 0.0)
        truncated = ~terminated & (steps >= problem.num_wander + self.rules.max_steps)
        moved = jnp.hypot(pose.x - state.pose.x, pose.y - state.pose.y)
        potential = self._potential(state, pose, terminated, acting)
        if self._shaped:
            reward += jnp.where(acted, self.rules.discount * potential - state.potential, 0.0)
        after = State(
            problem,
            pose,
            steps,
            state.walked + jnp.where(acted, moved, 0.0),
            potential,
            jnp.where(acted[None], seen, state.seen),
            moment.blocked,
            memory,
            self.observer.read(memory, moment),
        )
        return after, Outcome(reward, terminated, truncated, acted, blocked)

    def step(self, state: State, action: Float[Array, "N A"], *, key: Key) -> tuple[State, Step]:
        """`advance` for a learner: agents in rows, who has ended begins anew."""
        after, outcome = self.advance(state, self.motors(to_agents_last(action)))
        then = self.anew(after, outcome.terminated | outcome.truncated, key=key)
        return then, Step(
            to_rows(after.observation),
            to_rows(then.observation),
            outcome.reward,
            outcome.terminated,
            outcome.truncated,
            outcome.acted,
        )

    def anew(self, state: State, ended: Flags, *, key: Key) -> State:
        """The same agents, those whose episode has ended at the start of another problem."""
        return select(ended, self.begin(key=key), state)

    @property
    def _shaped(self) -> bool:
        return self.rules.shaped and self.task.has_goal

    def _potential(self, state: State, pose: Pose, terminated: Flags, acting: Flags) -> Array:
        """Minus the way that is left; 0 at the goal. Before the agent acts it is the whole way."""
        if not self._shaped:
            return jnp.zeros_like(pose.x)
        problem, setting = state.problem, self.setting
        goal = problem.goal.x, problem.goal.y
        way = way_length(setting.walls, setting.corners, problem.to_goal, goal, (pose.x, pose.y))
        left = -SHAPING * jnp.where(acting, way, problem.distance)
        # Who touches a wall may be seen from no corner: then nothing is known to have changed.
        left = jnp.where(jnp.isfinite(left), left, state.potential)
        return jnp.where(terminated, 0.0, left)


def _nth(wander: Float[Array, "W M N"], steps: Int[Array, " N"]) -> Motor:
    """Command number `steps` of each agent's wander, zeros after the last."""
    if len(wander) == 0:
        return jnp.zeros(wander.shape[1:])
    rows = jnp.minimum(steps, len(wander) - 1)[None, None]
    return jnp.take_along_axis(wander, rows, axis=0)[0]
