"""Many agents behind Gymnasium's vector interface, as one compiled step."""

from pathlib import Path
from typing import Any

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from jaxtyping import Bool, Float, UInt8

from motorspace.environments import MAX_EPISODE_STEPS, core
from motorspace.environments.scenarios import AgentLike, SensorLike, chosen_scenario
from motorspace.environments.tasks import AbstractTask, Explore
from motorspace.worlds.checks import whole
from motorspace.worlds.scenario import Scenario, WorldLike

Observations = Float[np.ndarray, "N ..."]
Flags = Bool[np.ndarray, " N"]
Step = tuple[Observations, Float[np.ndarray, " N"], Flags, Flags, dict[str, Any]]


METADATA = {
    "autoreset_mode": AutoresetMode.NEXT_STEP,
    "render_modes": list(core.RENDER_MODES),
    "render_fps": 10,
}
"""What Gymnasium asks of a class of vector environments."""


def with_presence(info: dict[str, Any], num_envs: int) -> dict[str, Any]:
    """What is known of each copy, marked as Gymnasium asks: every copy has said it."""
    present = np.ones(num_envs, bool)
    return info | {f"_{name}": present.copy() for name in info}


class ExplorationVectorEnv(core.Compiled, VectorEnv[Observations, Any, Any]):
    """`num_envs` copies of `ExplorationEnv`, with its options, in one compiled step.

    A copy whose episode has ended is reset by the step after (`AutoresetMode.NEXT_STEP`), which
    ignores its action.
    """

    metadata = dict(METADATA)

    def __init__(
        self,
        agent: AgentLike | None = None,
        num_envs: int = 1,
        *,
        sensor: SensorLike | None = None,
        layout: WorldLike | None = None,
        scenario: Scenario | None = None,
        run: str | Path | None = None,
        task: AbstractTask | None = None,
        max_steps: int | None = None,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        self.render_mode = core.checked_mode(render_mode)
        self.num_envs = whole("num_envs", num_envs)
        length = core.episode_length(max_steps, max_episode_steps)
        self.max_steps = MAX_EPISODE_STEPS if length is None else length
        chosen = chosen_scenario(
            agent, sensor=sensor, layout=layout, scenario=scenario, run=run, options=options
        )
        self._set_episode(core.Episode(chosen, Explore() if task is None else task))
        self.single_action_space = core.action_space(chosen.commands)
        self.single_observation_space = core.observation_space(chosen.space)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._results: core.StepResult | None = None
        self._steps = np.zeros(num_envs, int)
        self._ended = np.zeros(num_envs, bool)

    def reset(
        self, *, seed: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        super().reset(seed=seed)
        self._results, self._steps = self._begin(), np.zeros(self.num_envs, int)
        self._ended = np.zeros(self.num_envs, bool)
        unpacked = core.unpack(self._results, self._space)
        return unpacked.observation, self._info(unpacked)

    def step(self, actions: Any) -> Step:
        if self._results is None:
            raise gymnasium.error.ResetNeeded("call reset before step")
        checked = core.checked_action(self._commands, actions, self.num_envs)
        results, again = self._compiled.advance(self._results, checked), self._ended
        if again.any():
            results = jnp.where(again[:, None], self._begin(), results)
        self._results, self._steps = results, np.where(again, 0, self._steps + 1)
        unpacked = core.unpack(results, self._space)
        truncated = self._steps >= self.max_steps
        self._ended = truncated | unpacked.terminated
        outcome = unpacked.observation, unpacked.reward, unpacked.terminated
        return *outcome, truncated, self._info(unpacked)

    def render(self) -> tuple[UInt8[np.ndarray, "H W 3"], ...] | None:
        if self.render_mode is None or self._results is None:
            return None
        return tuple(core.picture(self.episode, result) for result in self._results)

    def _begin(self) -> core.StepResult:
        keys = jax.random.split(core.jax_key(self.np_random), self.num_envs)
        return self._compiled.begin_all(keys)

    def _info(self, unpacked: core.Unpacked) -> dict[str, Any]:
        known = {"pose": unpacked.pose, "blocked": unpacked.blocked}
        return with_presence(known, self.num_envs)
