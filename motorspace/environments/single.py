"""One agent behind Gymnasium's single interface."""

import math
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from jaxtyping import Float, UInt8

from motorspace.environments import MAX_EPISODE_STEPS, core
from motorspace.environments.scenarios import AgentLike, SensorLike, chosen_scenario
from motorspace.environments.tasks import AbstractTask, Explore
from motorspace.worlds.scenario import Scenario, WorldLike

Observation = Float[np.ndarray, "..."]


class ExplorationEnv(core.Compiled, gymnasium.Env[Observation, Any]):
    """An agent in a world: observations are its sensors, actions its commands.

    Observations are in raw units. An action is the number of a command, or every motor channel in
    [-1, 1]. A move through a wall turns the agent and does not move it. `info` holds the true
    `pose` (x, y, heading, head; world units, radians) and whether the last move was `blocked`.

    Args:
        agent: The kind of agent, or one made before; forward by default.
        sensor: The kind of sensor, or one made before; by default what suits the agent.
        layout: The world, its layout, a layout file, or a name such as `paper`, `rooms:7` or
            `lattice:6`; by default what suits the agent.
        scenario: World, agent and sensor, instead of the three above.
        run: The folder of a run, instead of them: the environment that it learned in.
        task: Reward and end of an episode; by default none.
        max_steps: Steps until an episode is truncated, by default 200. With `gymnasium.make`, give
            its own `max_episode_steps`.
        render_mode: `"rgb_array"` for pictures.
        **options: Options of the agent and of the sensor, as their classes have them, for instance
            `max_rotation` (radians) or `num_rays`.

    Raises:
        UserError: For options that do not fit, and for actions that are no commands.
    """

    metadata = {"render_modes": list(core.RENDER_MODES), "render_fps": 10}

    def __init__(
        self,
        agent: AgentLike | None = None,
        *,
        sensor: SensorLike | None = None,
        layout: WorldLike | None = None,
        scenario: Scenario | None = None,
        run: str | Path | None = None,
        task: AbstractTask | None = None,
        max_steps: int | None = None,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        self.render_mode = core.checked_mode(render_mode)
        self.max_steps = core.episode_length(max_steps, None)
        chosen = chosen_scenario(
            agent, sensor=sensor, layout=layout, scenario=scenario, run=run, options=options
        )
        self._set_episode(core.Episode(chosen, Explore() if task is None else task))
        self.action_space = core.action_space(chosen.commands)
        self.observation_space = core.observation_space(chosen.space)
        self._result: core.StepResult | None = None
        self._steps, self._length = 0, math.inf

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self._length = self._episode_length()
        self._result, self._steps = self._compiled.begin(core.jax_key(self.np_random)), 0
        observation, pose, blocked, *_ = core.unpack(self._result, self._space)
        return observation, {"pose": pose, "blocked": blocked}

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        if self._result is None:
            raise gymnasium.error.ResetNeeded("call reset before step")
        checked = core.checked_action(self._commands, action)
        self._result = self._compiled.advance(self._result, checked)
        self._steps += 1
        observation, pose, blocked, reward, done = core.unpack(self._result, self._space)
        info = {"pose": pose, "blocked": blocked}
        return observation, reward, done, self._steps >= self._length, info

    def render(self) -> UInt8[np.ndarray, "H W 3"] | None:
        if self.render_mode is None or self._result is None:
            return None
        return core.picture(self.episode, self._result)

    def _episode_length(self) -> float:
        """After how many steps an episode is truncated here, and not by Gymnasium."""
        if self.spec is None:
            return float(self.max_steps or MAX_EPISODE_STEPS)
        core.episode_length(self.max_steps, MAX_EPISODE_STEPS)
        return float(self.max_steps or math.inf)
