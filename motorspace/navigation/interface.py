"""What a learner asks of environments."""

from typing import Any, NamedTuple, Protocol, runtime_checkable

from jaxtyping import Array, Bool, Float

from motorspace._types import Key

Environments = Any
"""The state of N environments."""

Observations = Float[Array, "N O"]


class Step(NamedTuple):
    """What comes of one action in each of N environments."""

    final: Observations
    """What is observed after the action."""
    observation: Observations
    """The same, but the first observation of the next episode where one has ended."""
    reward: Float[Array, " N"]
    terminated: Bool[Array, " N"]
    """Whether an end is reached, after which nothing comes."""
    truncated: Bool[Array, " N"]
    """Whether the episode was cut off, though more would come."""
    acted: Bool[Array, " N"]
    """Whether the action was carried out; others are not learned from."""


@runtime_checkable
class Environment(Protocol):
    """N environments that begin anew by themselves."""

    @property
    def num_agents(self) -> int:
        """How many there are (N)."""

    @property
    def action_size(self) -> int:
        """Channels of an action in [-1, 1] (A)."""

    @property
    def commands_per_action(self) -> int:
        """Environment steps that an action takes at most."""

    def begin(self, *, key: Key) -> Environments:
        """All at the start of an episode."""

    def observed(self, state: Environments) -> Observations:
        """What is observed now."""

    def step(
        self, state: Environments, action: Float[Array, "N A"], *, key: Key
    ) -> tuple[Environments, Step]:
        """What comes of an action of each."""
