"""Search for a motor sequence of least cost: random shooting, the cross-entropy method, descent."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float

from motorspace._types import Key, Motors, Scalar
from motorspace.control.codes import random_sequences
from motorspace.control.decoder import Logits, squash
from motorspace.worlds.spaces import CommandSpace, ContinuousCommands

Cost = Callable[[Motors], Scalar]
"""What one motor sequence [T, M] costs."""

ELITE_SHARE = 0.125
"""The part of each generation that the next one is drawn around."""
LEAST_SPREAD = 0.01
"""The spread that is left at least, as a share of the bounds."""


def shooting(cost: Cost, commands: CommandSpace, size: tuple[int, int], *, key: Key) -> Motors:
    """The best of random sequences; `size` is (how many, T)."""
    motors = random_sequences(commands, size, key=key)
    return motors[jnp.argmin(jax.vmap(cost)(motors))]


def cross_entropy(
    cost: Cost, commands: ContinuousCommands, size: tuple[int, int, int], *, key: Key
) -> Motors:
    """The best sequence of the cross-entropy method (Rubinstein, 1999).

    Each generation is drawn from a normal distribution, clipped to the bounds, whose mean and
    spread are those of the best of the one before. `size` is (generations, sequences in each, T).
    """
    generations, num, horizon = size
    elite = max(2, round(ELITE_SHARE * num))
    shape = (horizon, commands.size)

    def generation(
        carry: tuple[Array, Array, Array, Scalar], key: Key
    ) -> tuple[tuple[Array, Array, Array, Scalar], None]:
        mean, spread, best, least = carry
        noise = jax.random.normal(key, (num, *shape))
        shares = (mean[None] + spread[None] * noise).clip(0.0, 1.0)
        costs = jax.vmap(lambda s: cost(commands.spread(s.T).T))(shares)
        order = jnp.argsort(costs)[:elite]
        chosen = shares[order]
        better = costs[order[0]] < least
        best = jnp.where(better, chosen[0], best)
        spread = jnp.maximum(chosen.std(axis=0), LEAST_SPREAD)
        return (chosen.mean(axis=0), spread, best, jnp.minimum(least, costs[order[0]])), None

    half = jnp.full(shape, 0.5, jnp.float32)
    first = (half, half, half, jnp.array(jnp.inf, jnp.float32))
    (_, _, best, _), _ = jax.lax.scan(generation, first, jax.random.split(key, generations))
    return commands.spread(best.T).T


def descent(
    cost: Cost,
    commands: ContinuousCommands,
    start: Float[Array, "S T M"],
    steps: int,
    *,
    learning_rate: float = 0.3,
) -> Motors:
    """The best end of gradient descent (Adam) from several starts, given as logits."""

    def of_logits(logits: Logits) -> Scalar:
        return cost(squash(commands, logits))

    optimiser = optax.adam(learning_rate)

    def one(logits: Logits) -> tuple[Logits, Scalar]:
        def step(
            carry: tuple[Logits, optax.OptState], _: None
        ) -> tuple[tuple[Logits, optax.OptState], None]:
            logits, state = carry
            gradient = jax.grad(of_logits)(logits)
            with jax.numpy_dtype_promotion("standard"):  # optax counts in whole numbers
                updates, state = optimiser.update(gradient, state)
            return (logits + updates, state), None

        (logits, _), _ = jax.lax.scan(step, (logits, optimiser.init(logits)), None, steps)
        return logits, of_logits(logits)

    ends, costs = jax.vmap(one)(start)
    return squash(commands, ends[jnp.argmin(costs)])
