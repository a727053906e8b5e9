"""Codes that are matrices, in standard form: what prediction leaves open, set by convention."""

import numpy as np
from jaxtyping import Float

Codes = Float[np.ndarray, "N _"]
Matrices = Float[np.ndarray, "K n n"]


def standard_form(codes: Codes, transitions: Matrices, readouts: Matrices) -> Codes:
    """Returns the codes of a `MatrixProductEncoder` with unit, body point and readout standardised.

    Codes are products A(m_1) ... A(m_T) H(m_T). With constant matrices S and K in them,
    S A S^-1 and S H K, they hold the same for a predictor: which S and K a network has is chance.
    In standard form

    - H is the identity in the mean over commands,
    - translation is that of the point of the body whose shift by a command, seen from where it
      ends (that is, in A^-1), is uncorrelated with how the command turns,
    - the unit of length is the one in which translation varies as much as the linear part.

    Args:
        codes: [N, n (n - 1)], the first n - 1 rows of each product.
        transitions: [K, n, n], A of K random commands.
        readouts: [K, n, n], H of the same commands.
    """
    num, size = len(codes), transitions.shape[-1]
    product = np.broadcast_to(np.eye(size), (num, size, size)).copy()
    product[:, :-1] = codes.reshape(num, size - 1, size)
    linear, translation = _parts(product @ np.linalg.inv(readouts.mean(axis=0)))
    translation = translation - linear @ body_point(transitions)
    spread = translation.var(axis=0).sum()
    unit = np.sqrt(linear.var(axis=0).sum() / spread) if spread > 0 else 1.0
    return np.concatenate([linear, unit * translation[:, :, None]], axis=2).reshape(num, -1)


def body_point(transitions: Matrices) -> Float[np.ndarray, " _"]:
    """The q for which t - L q varies least, (L, t) the parts of the inverse commands."""
    linear, translation = _parts(np.linalg.inv(transitions))
    turns, shifts = linear - linear.mean(axis=0), translation - translation.mean(axis=0)
    return np.linalg.lstsq(turns.reshape(-1, turns.shape[-1]), shifts.reshape(-1), rcond=None)[0]


def _parts(
    matrices: Matrices,
) -> tuple[Float[np.ndarray, "K _ _"], Float[np.ndarray, "K _"]]:
    return matrices[:, :-1, :-1], matrices[:, :-1, -1]
