"""One agent behind Gymnasium's single interface."""

from typing import Any

import gymnasium
import numpy as np
from jaxtyping import Float, UInt8

from motorspace._errors import UserError
from motorspace._types import Pose
from motorspace.environments.core import AgentName, Outcome, build_setting, compiled, jax_key
from motorspace.environments.render import render

Observation = Float[np.ndarray, " K"]


class ExplorationEnv(gymnasium.Env[Observation, Any]):
    """An agent exploring a world: observations are its sensors, actions its commands.

    The reward is 0 and an episode never terminates; it is truncated after `max_steps`. `info`
    holds the true `pose` (x, y, heading, head) and whether the last move was `blocked`.
    `layout` and `max_rotation` (units of pi) are those of the continuous worlds.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(
        self,
        agent: AgentName,
        render_mode: str | None = None,
        max_steps: int = 200,
        layout: str = "paper",
        max_rotation: float = 0.8,
        lattice_size: int = 6,
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise UserError(f"there is no render mode {render_mode!r}", remedy="use rgb_array")
        if max_steps < 1:
            raise UserError(f"an episode of {max_steps} steps is none", remedy="give at least 1")
        self.setting = build_setting(
            agent, layout_name=layout, max_rotation=max_rotation, lattice_size=lattice_size
        )
        self._rules = compiled(self.setting)
        self.render_mode = render_mode
        self.max_steps = max_steps
        self.action_space = self.setting.action_space
        self.observation_space = self.setting.observation_space
        self._outcome: Outcome | None = None
        self._steps = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self._outcome, self._steps = self._rules.begin(jax_key(self.np_random)), 0
        return self._told()

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        if self._outcome is None:
            raise gymnasium.error.ResetNeeded("call reset before step")
        self._outcome = self._rules.advance(self._outcome, np.asarray(action))
        self._steps += 1
        observation, info = self._told()
        return observation, 0.0, False, self._steps >= self.max_steps, info

    def render(self) -> UInt8[np.ndarray, "H W 3"] | None:
        if self.render_mode is None or self._outcome is None:
            return None
        return render(self.setting.world, self.setting.sensor, Pose(*self._outcome[:4]))

    def _told(self) -> tuple[Observation, dict[str, Any]]:
        assert self._outcome is not None
        observation, info = self.setting.told(self._outcome)
        return observation, info | {"blocked": bool(info["blocked"])}
