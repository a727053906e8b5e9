"""Policies: from what is observed to commands, and what is expected to come of it."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from motorspace._types import Key
from motorspace.navigation.config import PolicyConfig

Hidden = Float[Array, " H"]
"""What a policy remembers; H is 0 without a memory."""

Hiddens = Float[Array, "N H"]


class Answer(NamedTuple):
    """What a policy answers to an observation."""

    hidden: Hidden
    mean: Float[Array, " A"]
    """The middle of a normal distribution of actions; each channel is then cut to [-1, 1]."""
    value: Float[Array, ""]
    """The expected sum of discounted rewards."""


class Answers(NamedTuple):
    """The answers to T observations of N agents."""

    mean: Float[Array, "T N A"]
    value: Float[Array, "T N"]


class Policy(eqx.Module):
    """Actor and critic, two networks of two tanh layers, behind one memory if there is any.

    Methods take one agent; use `jax.vmap`.
    """

    offset: Float[Array, " O"]
    """What is taken from an observation first; not learned by gradients."""
    scale: Float[Array, " O"]
    """What it is then divided by."""
    memory: eqx.nn.GRUCell | None
    actor: eqx.nn.MLP
    critic: eqx.nn.MLP
    log_std: Float[Array, " A"]
    memory_size: int = eqx.field(static=True)

    def __init__(
        self, config: PolicyConfig, observation_size: int, action_size: int, *, key: Key
    ) -> None:
        memory_key, actor_key, critic_key, weights_key = jax.random.split(key, 4)
        self.memory_size = config.memory_size
        self.offset = jnp.zeros(observation_size)
        self.scale = jnp.ones(observation_size)
        self.memory = None
        if config.memory_size > 0:
            self.memory = eqx.nn.GRUCell(observation_size, config.memory_size, key=memory_key)
        size, width = observation_size + config.memory_size, config.width_size
        actor = eqx.nn.MLP(size, action_size, width, 2, jnp.tanh, key=actor_key)
        critic = eqx.nn.MLP(size, "scalar", width, 2, jnp.tanh, key=critic_key)
        first_key, second_key = jax.random.split(weights_key)
        self.actor = orthogonal(actor, last=0.01, key=first_key)
        self.critic = orthogonal(critic, last=1.0, key=second_key)
        self.log_std = jnp.full(action_size, config.log_std, jnp.float32)

    def __call__(self, hidden: Hidden, observation: Float[Array, " O"]) -> Answer:
        """The answer to what is observed now."""
        hidden, features = self._features(hidden, observation)
        return Answer(hidden, self.actor(features), self.critic(features))

    def _features(
        self, hidden: Hidden, observation: Float[Array, " O"]
    ) -> tuple[Hidden, Float[Array, " F"]]:
        """What is remembered from here on, and what actor and critic see."""
        offset, scale = jax.lax.stop_gradient((self.offset, self.scale))
        seen = jnp.clip((observation - offset) / scale, -10.0, 10.0)
        if self.memory is None:
            return hidden, seen
        hidden = self.memory(seen, hidden)
        return hidden, jnp.concatenate([seen, hidden])

    def initial(self, num_agents: int) -> Hiddens:
        """What agents remember before their first observation."""
        return jnp.zeros((num_agents, self.memory_size), jnp.float32)

    def answers(
        self, hidden: Hiddens, observations: Float[Array, "T N O"], begins: Bool[Array, "T N"]
    ) -> Answers:
        """The answers to observations in a row; `begins` says where an episode begins."""
        each = jax.vmap(self._features)

        def advance(
            hidden: Hiddens, given: tuple[Float[Array, "N O"], Bool[Array, " N"]]
        ) -> tuple[Hiddens, Float[Array, "N F"]]:
            observation, begin = given
            return each(jnp.where(begin[:, None], 0.0, hidden), observation)

        if self.memory is None:
            features = jax.vmap(each, in_axes=(None, 0))(hidden, observations)[1]
        else:
            features = jax.lax.scan(advance, hidden, (observations, begins))[1]
        actor, critic = (jax.vmap(jax.vmap(net)) for net in (self.actor, self.critic))
        return Answers(actor(features), critic(features))

    def log_probability(
        self, mean: Float[Array, "*batch A"], action: Float[Array, "*batch A"]
    ) -> Float[Array, "*batch"]:
        """The log-density of actions, before they are cut."""
        away = (action - mean) * jnp.exp(-self._log_std(mean))
        each = -0.5 * away**2 - self._log_std(mean) - 0.5 * np.log(2 * np.pi).astype(np.float32)
        return each.sum(axis=-1)

    def sampled(self, mean: Float[Array, "*batch A"], *, key: Key) -> Float[Array, "*batch A"]:
        """Random actions around their means."""
        noise = jax.random.normal(key, mean.shape, jnp.float32)
        return mean + jnp.exp(self._log_std(mean)) * noise

    @property
    def entropy(self) -> Float[Array, ""]:
        """That of the commands."""
        return jnp.sum(self.log_std + 0.5 * np.log(2 * np.pi * np.e).astype(np.float32))

    def _log_std(self, like: Float[Array, "*batch A"]) -> Float[Array, "*batch A"]:
        return jnp.broadcast_to(self.log_std, like.shape)

    def normalised(self, observations: Float[Array, "N O"]) -> "Policy":
        """The policy for observations distributed like these.

        Channels that hardly vary are divided by no less than a hundredth of the largest spread.
        """
        offset, scale = observations.mean(axis=0), observations.std(axis=0)
        floor = jnp.maximum(0.01 * scale.max(), 1e-6)
        return eqx.tree_at(
            lambda policy: (policy.offset, policy.scale), self, (offset, jnp.maximum(scale, floor))
        )


def orthogonal(mlp: eqx.nn.MLP, *, last: float, key: Key) -> eqx.nn.MLP:
    """The network with orthogonal weights of gain sqrt(2), `last` in its last layer, no biases."""
    gains = [2**0.5] * (len(mlp.layers) - 1) + [last]
    keys = jax.random.split(key, len(gains))
    weights = [
        jax.nn.initializers.orthogonal(gain)(key, layer.weight.shape, jnp.float32)
        for layer, gain, key in zip(mlp.layers, gains, keys, strict=True)
    ]
    biases = [jnp.zeros(len(weight), jnp.float32) for weight in weights]
    return eqx.tree_at(
        lambda net: [leaf for layer in net.layers for leaf in (layer.weight, layer.bias)],
        mlp,
        [leaf for pair in zip(weights, biases, strict=True) for leaf in pair],
    )
