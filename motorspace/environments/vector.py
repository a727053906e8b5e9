"""Many agents behind Gymnasium's vector interface, as one compiled step."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from jaxtyping import Bool, Float

from motorspace._errors import UserError
from motorspace.environments.core import AgentName, Outcome, build_setting, compiled, jax_key

Observations = Float[np.ndarray, "N K"]
Flags = Bool[np.ndarray, " N"]
Step = tuple[Observations, Float[np.ndarray, " N"], Flags, Flags, dict[str, Any]]


class ExplorationVectorEnv(VectorEnv[Observations, Any, Any]):
    """`num_envs` copies of `ExplorationEnv`.

    A truncated copy is reset by the step after (`AutoresetMode.NEXT_STEP`), which ignores its
    action.
    """

    metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        agent: AgentName,
        num_envs: int = 1,
        max_steps: int = 200,
        layout: str = "paper",
        max_rotation: float = 0.8,
        lattice_size: int = 6,
    ) -> None:
        if num_envs < 1 or max_steps < 1:
            raise UserError(
                f"{num_envs} environments of {max_steps} steps are none", remedy="give at least 1"
            )
        self.setting = build_setting(
            agent, layout_name=layout, max_rotation=max_rotation, lattice_size=lattice_size
        )
        self._rules = compiled(self.setting)
        self.num_envs = num_envs
        self.max_steps = max_steps
        self.single_action_space = self.setting.action_space
        self.single_observation_space = self.setting.observation_space
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._outcome: Outcome | None = None
        self._steps = np.zeros(num_envs, int)

    def reset(
        self, *, seed: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        super().reset(seed=seed)
        self._outcome, self._steps = self._begin(), np.zeros(self.num_envs, int)
        return self._told()

    def step(self, actions: Any) -> Step:
        assert self._outcome is not None, "call reset before step"
        again = self._steps >= self.max_steps
        self._outcome = self._rules.advance(self._outcome, np.asarray(actions))
        if again.any():
            self._outcome = jnp.where(again[:, None], self._begin(), self._outcome)
        self._steps = np.where(again, 0, self._steps + 1)
        observations, info = self._told()
        never, nothing = np.zeros(self.num_envs, bool), np.zeros(self.num_envs)
        return observations, nothing, never, self._steps >= self.max_steps, info

    def _begin(self) -> Outcome:
        return self._rules.begin_all(jax.random.split(jax_key(self.np_random), self.num_envs))

    def _told(self) -> tuple[Observations, dict[str, Any]]:
        assert self._outcome is not None
        observations, info = self.setting.told(self._outcome)
        present = np.ones(self.num_envs, bool)
        return observations, info | {"_pose": present, "_blocked": present.copy()}
