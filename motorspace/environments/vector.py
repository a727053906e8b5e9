"""Many agents behind Gymnasium's vector interface, as one compiled step."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from jaxtyping import Bool, Float

from motorspace._errors import UserError
from motorspace._types import Pose
from motorspace.environments.setting import (
    AgentName,
    advance,
    begin_all,
    build_setting,
    jax_key,
)

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
        self.num_envs = num_envs
        self.max_steps = max_steps
        self.single_action_space = self.setting.action_space
        self.single_observation_space = self.setting.observation_space
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._poses: Pose | None = None
        self._steps = np.zeros(num_envs, int)

    def reset(
        self, *, seed: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        super().reset(seed=seed)
        self._poses, outcome = self._begin()
        self._steps = np.zeros(self.num_envs, int)
        return self._told(outcome)

    def step(self, actions: Any) -> Step:
        assert self._poses is not None, "call reset before step"
        again = self._steps >= self.max_steps
        poses, outcome = advance(self.setting, self._poses, np.asarray(actions))
        if again.any():
            fresh, fresh_outcome = self._begin()
            mask = jnp.asarray(again)
            poses = jax.tree.map(lambda a, b: jnp.where(mask, a, b), fresh, poses)
            outcome = jnp.where(mask[:, None], fresh_outcome, outcome)
        self._poses = poses
        self._steps = np.where(again, 0, self._steps + 1)
        observations, info = self._told(outcome)
        never, nothing = np.zeros(self.num_envs, bool), np.zeros(self.num_envs)
        return observations, nothing, never, self._steps >= self.max_steps, info

    def _begin(self) -> tuple[Pose, Any]:
        return begin_all(self.setting, jax.random.split(jax_key(self.np_random), self.num_envs))

    def _told(self, outcome: Any) -> tuple[Observations, dict[str, Any]]:
        observations, info = self.setting.told(outcome)
        present = np.ones(self.num_envs, bool)
        return observations, info | {"_pose": present, "_blocked": present.copy()}
