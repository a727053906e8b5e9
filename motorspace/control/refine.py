"""A few steps of Levenberg and Marquardt from a motor sequence towards a code."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Count, Scalar
from motorspace.control.decoder import Logits

FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-2, 1e-6, 1e6

Residual = Callable[[Logits], Float[Array, " R"]]
"""What should be zero, as a function of a motor sequence's logits."""


class _Now(NamedTuple):
    logits: Logits
    error: Scalar
    damping: Scalar


def levenberg_marquardt(residual: Residual, start: Logits, steps: int) -> Logits:
    """Logits of less residual, after so many steps; a step that does not help is not made.

    Levenberg (1944), Marquardt (1963), in the form for fewer residuals than unknowns.
    """
    shape = start.shape

    def flat(x: Float[Array, " D"]) -> Float[Array, " R"]:
        return residual(x.reshape(shape))

    def step(_: Count, now: _Now) -> _Now:
        x = now.logits.reshape(-1)
        value, pullback = jax.vjp(flat, x)
        slopes = jax.vmap(pullback)(jnp.eye(len(value)))[0]
        gram = slopes @ slopes.T
        damped = gram + now.damping * (jnp.trace(gram) / len(value) + 1e-9) * jnp.eye(len(value))
        there = x - slopes.T @ jnp.linalg.solve(damped, value)
        error = jnp.sum(flat(there) ** 2)
        better = error < now.error
        return _Now(
            jnp.where(better, there, x).reshape(shape),
            jnp.where(better, error, now.error),
            jnp.where(better, now.damping / 10, now.damping * 10).clip(LEAST_DAMPING, MOST_DAMPING),
        )

    first = _Now(start, jnp.sum(residual(start) ** 2), jnp.array(FIRST_DAMPING, jnp.float32))
    return jax.lax.fori_loop(0, steps, step, first).logits
