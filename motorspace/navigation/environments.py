"""Navigation behind Gymnasium's single and vector interfaces."""

from pathlib import Path
from typing import Any

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
from gymnasium.vector import VectorEnv
from gymnasium.vector.utils import batch_space
from jaxtyping import Float, UInt8

from motorspace._errors import UserError
from motorspace.environments import core
from motorspace.environments.render import render
from motorspace.environments.vector import METADATA, with_presence
from motorspace.navigation import copies
from motorspace.navigation.arenas import codes_of
from motorspace.navigation.given import given_problem
from motorspace.training.run import load_run
from motorspace.worlds.checks import whole
from motorspace.worlds.scenario import Scenario

Observation = Float[np.ndarray, " O"]
Observations = Float[np.ndarray, "N O"]


class _Navigation:
    """N agents in some of many layouts, whose compiled step is made anew after unpickling."""

    def _set_up(
        self,
        num: int,
        task: str,
        agent: Any,
        *,
        run: str | Path | None,
        split: str,
        options: dict[str, Any],
    ) -> None:
        config = copies.navigation_config(task, agent, run=run, **options)
        if config.needs_run and run is None:
            raise UserError("codes are computed by a trained network", remedy="give the run of one")
        codes = codes_of(load_run(run)) if config.needs_run and run is not None else None
        self.bank = copies.bank_of(config, codes, split)
        self._num, self._now = num, None
        self._box = copies.observation_box(self.bank)
        self._compiled = copies.compiled(self.bank, num)

    _now: copies.Now | None

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_compiled"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._compiled = copies.compiled(self.bank, self._num)

    def _picture(self, number: int) -> UInt8[np.ndarray, "H W 3"]:
        assert self._now is not None, "there is an episode"
        here, scenario = self._now.layouts[number], self.bank.scenario
        world: Any = jax.tree.map(lambda leaf: leaf[..., here], scenario.world)
        state = jax.tree.map(lambda leaf: leaf[..., number], self._now.state)
        goal = state.problem.goal if self.bank.task.has_goal else None
        return render(Scenario(world, scenario.agent, scenario.sensor), state.pose, goal=goal)


class NavigationEnv(_Navigation, gymnasium.Env[Observation, Any]):
    """An agent with a task in one of many random layouts.

    An action is every motor channel in [-1, 1]. An observation is the parts in `observe`, one after
    the other, then what the task gives: a hint at the goal, and for *home* whether the agent acts.
    Before that it wanders, and its actions are ignored. `info` holds what is true: the `pose` and
    the `goal` (x, y, heading, head; world units, radians), whether the agent is `acting`, and
    whether the last move was `blocked`. An episode is terminated at the goal and truncated after
    `max_steps` actions of the agent's own.

    `reset(options={"goal": ..., "start": ...})` poses a problem; see `given_problem`.

    Args:
        task: home, displacement_goal, sensor_goal or explore.
        agent: The kind of agent, or one made before; forward by default, or the run's.
        run: The folder of a run: its agent and sensor, and its network for chained codes.
        split: `"train"`, or `"test"` for layouts that no policy is trained in; or one layout.
        render_mode: `"rgb_array"` for pictures.
        **options: `sensor`, options of agent and sensor, and fields of `NavigationConfig` such as
            `observe`, `level`, `reward`, `sense_blocked`, `max_steps`, `num_layouts` and `seed`.

    Raises:
        UserError: For options that do not fit, and for actions that are no commands.
    """

    metadata = {"render_modes": list(core.RENDER_MODES), "render_fps": 10}

    def __init__(
        self,
        task: str = "home",
        agent: Any = None,
        *,
        run: str | Path | None = None,
        split: str = "train",
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        self.render_mode = core.checked_mode(render_mode)
        self._set_up(1, task, agent, run=run, split=split, options=options)
        self.action_space = core.action_space(self.bank.scenario.commands)
        self.observation_space = self._box

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self._now = self._compiled.begin(core.jax_key(self.np_random))
        if options:
            self._now = self._posed(self._now, **options)
        seen = copies.seen(self._now, self._box)
        return seen.observation[0], _of_one(seen)

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        if self._now is None:
            raise gymnasium.error.ResetNeeded("call reset before step")
        checked = core.checked_action(self.bank.scenario.commands, action)
        self._now, outcome = self._compiled.advance(self._now, checked[None])
        seen = copies.seen(self._now, self._box, outcome)
        ends = bool(seen.terminated[0]), bool(seen.truncated[0])
        return seen.observation[0], float(seen.reward[0]), *ends, _of_one(seen)

    def render(self) -> UInt8[np.ndarray, "H W 3"] | None:
        if self.render_mode is None or self._now is None:
            return None
        return self._picture(0)

    def _posed(self, now: copies.Now, *, start: Any = None, goal: Any = None) -> copies.Now:
        arena = copies.of_layouts(self.bank, now.layouts)
        problem = given_problem(arena, now.state.problem, start=start, goal=goal)
        return self._compiled.begin_with(now.layouts, problem)


class NavigationVectorEnv(_Navigation, VectorEnv[Observations, Any, Any]):
    """`num_envs` copies of `NavigationEnv`, with its options, in one compiled step.

    A copy whose episode has ended is reset by the step after (`AutoresetMode.NEXT_STEP`), which
    ignores its action; it may begin anew in another layout.
    """

    metadata = dict(METADATA)

    def __init__(
        self,
        task: str = "home",
        num_envs: int = 1,
        agent: Any = None,
        *,
        run: str | Path | None = None,
        split: str = "train",
        max_steps: int | None = None,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        self.render_mode = core.checked_mode(render_mode)
        self.num_envs = whole("num_envs", num_envs)
        length = core.episode_length(max_steps, max_episode_steps)
        options |= {} if length is None else {"max_steps": length}
        self._set_up(num_envs, task, agent, run=run, split=split, options=options)
        self.single_action_space = core.action_space(self.bank.scenario.commands)
        self.single_observation_space = self._box
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._ended = np.zeros(num_envs, bool)

    def reset(
        self, *, seed: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        super().reset(seed=seed)
        self._now = self._compiled.begin(core.jax_key(self.np_random))
        self._ended = np.zeros(self.num_envs, bool)
        seen = copies.seen(self._now, self._box)
        return seen.observation, self._info(seen)

    def step(self, actions: Any) -> tuple[Observations, Any, Any, Any, dict[str, Any]]:
        if self._now is None:
            raise gymnasium.error.ResetNeeded("call reset before step")
        checked = core.checked_action(self.bank.scenario.commands, actions, self.num_envs)
        self._now, outcome = self._compiled.advance(self._now, checked)
        if self._ended.any():
            fresh = self._compiled.begin(core.jax_key(self.np_random))
            ended = jnp.asarray(self._ended)
            self._now = self._compiled.replace(ended, fresh, self._now)
            nothing = jax.tree.map(jnp.zeros_like, outcome)
            outcome = self._compiled.replace(ended, nothing, outcome)
        seen = copies.seen(self._now, self._box, outcome)
        self._ended = seen.terminated | seen.truncated
        return seen.observation, seen.reward, seen.terminated, seen.truncated, self._info(seen)

    def render(self) -> tuple[UInt8[np.ndarray, "H W 3"], ...] | None:
        if self.render_mode is None or self._now is None:
            return None
        return tuple(self._picture(number) for number in range(self.num_envs))

    def _info(self, seen: copies.Seen) -> dict[str, Any]:
        return with_presence(seen.info, self.num_envs)


def _of_one(seen: copies.Seen) -> dict[str, Any]:
    """The info of a single agent, its flags as plain truth values."""
    first = {name: value[0] for name, value in seen.info.items()}
    return first | {name: bool(first[name]) for name in ("acting", "blocked")}
