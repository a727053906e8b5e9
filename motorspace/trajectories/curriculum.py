"""How long sequences are while learning begins."""

import jax.numpy as jnp

from motorspace._types import Count


def sequence_lengths(
    epoch: Count, growing: Count, *, shortest: int, horizon: int
) -> tuple[Count, Count]:
    """The shortest and the longest sequence of an epoch.

    With large rotations the outcome of T commands says almost nothing about any one of them, much
    as a parity of T bits, and learning sits still. So the first epochs draw shorter sequences, of 1
    command and then of up to 2, 3 ... T, which show what each one does.

    Args:
        epoch: The epoch, from 0.
        growing: Epochs over which the longest sequence grows from 1 to `horizon`.
        shortest: Commands of the shortest sequence afterwards.
        horizon: Commands of the longest sequence (T).
    """
    grown = 1 + epoch * horizon // jnp.maximum(growing, 1)
    first = jnp.where(epoch < growing, 1, shortest)
    return first, jnp.where(epoch < growing, grown, horizon)
