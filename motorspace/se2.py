"""Rigid motions of the plane, SE(2), on NumPy and on JAX arrays.

A frame, or a displacement, is (x, y, angle): three arrays of any one batch shape, stacked in the
first axis where a function returns them. World units and radians. Each function computes with the
arrays that it is given: NumPy's in their own precision, JAX's also under `jit`.
"""

import dataclasses
import math
from typing import Any, TypeVar

import numpy as np
from jaxtyping import Float

Batch = Float[Any, "*batch"]
Frame = Float[Any, "3 *batch"] | tuple[Batch, Batch, Batch]
Posed = TypeVar("Posed")

FULL_TURN = 2 * math.pi


def wrap(angle: Batch) -> Batch:
    """The same angle in (-pi, pi], radians.

    >>> float(wrap(np.array(-math.pi)))
    3.141592653589793
    """
    xp = _namespace(angle)
    if xp is np:
        return np.pi - np.mod(np.pi - angle, FULL_TURN)
    return angle - FULL_TURN * xp.ceil((angle - math.pi) / FULL_TURN)


def cos_sin(angle: Batch) -> tuple[Batch, Batch]:
    """Cosine and sine of angles, radians; of JAX arrays with errors below 2e-7.

    JAX's compiler evaluates its own one number after the other and, where they are used for many
    rays, once for each. For its arrays these are the polynomials of Cephes (Moshier, 1992) on
    [-pi/4, pi/4], after whole quarters of a turn are taken off in three parts that float32 can
    subtract exactly.
    """
    xp = _namespace(angle)
    if xp is np:
        return np.cos(angle), np.sin(angle)
    quarters = xp.round(angle * (2 / math.pi))
    rest = angle - quarters * 1.5703125 - quarters * 4.837512969970703e-4
    rest = rest - quarters * 7.549789948768648e-8
    square = rest * rest
    sin = ((-1.9515295891e-4 * square + 8.3321608736e-3) * square - 1.6666654611e-1) * square
    sin = sin * rest + rest
    cos = (2.443315711809948e-5 * square - 1.388731625493765e-3) * square + 4.166664568298827e-2
    cos = (cos * square - 0.5) * square + 1.0
    quadrant = quarters.astype(xp.int32)
    odd = quadrant & 1 == 1
    cos, sin = xp.where(odd, sin, cos), xp.where(odd, cos, sin)
    return xp.where((quadrant + 1) & 2 == 2, -cos, cos), xp.where(quadrant & 2 == 2, -sin, sin)


def advance(pose: Posed, longitudinal: Batch, lateral: Batch) -> Posed:
    """The pose (x, y, heading, head) after a translation in the body's own frame, world units."""
    body: Any = pose
    cos, sin = cos_sin(body.heading)
    x = body.x + cos * longitudinal - sin * lateral
    y = body.y + sin * longitudinal + cos * lateral
    moved: Posed = dataclasses.replace(body, x=x, y=y)
    return moved


def relative(start: Frame, end: Frame) -> Float[Any, "3 *batch"]:
    """The displacement from `start` to `end` in the frame of `start`: start^-1 o end.

    >>> relative(np.array([1.0, 2.0, math.pi / 2]), np.array([1.0, 5.0, math.pi])).round(3) + 0.0
    array([3.   , 0.   , 1.571])
    """
    (x, y, angle), (end_x, end_y, end_angle) = start, end
    cos, sin = cos_sin(angle)
    dx, dy = end_x - x, end_y - y
    return _stack(cos * dx + sin * dy, cos * dy - sin * dx, wrap(end_angle - angle))


def compose(first: Frame, then: Frame) -> Float[Any, "3 *batch"]:
    """The displacement that undergoes `first` and after it `then`: first o then."""
    (x, y, angle), (dx, dy, turn) = first, then
    cos, sin = cos_sin(angle)
    return _stack(x + cos * dx - sin * dy, y + sin * dx + cos * dy, wrap(angle + turn))


def inverse(displacement: Frame) -> Float[Any, "3 *batch"]:
    """The displacement that undoes another: displacement^-1."""
    dx, dy, turn = displacement
    cos, sin = cos_sin(turn)
    return _stack(-cos * dx - sin * dy, sin * dx - cos * dy, wrap(-turn))


def chain(displacements: Float[Any, "*batch T 3"]) -> Float[Any, "*batch 3"]:
    """The displacement after T displacements in a row, in order of the next to last axis."""
    xp = _namespace(displacements)
    dx, dy, turn = (displacements[..., axis] for axis in range(3))
    before = xp.cumsum(turn, axis=-1) - turn
    cos, sin = cos_sin(before)
    x, y = (cos * dx - sin * dy).sum(-1), (sin * dx + cos * dy).sum(-1)
    return xp.stack([x, y, wrap(turn.sum(-1))], axis=-1)


def exponential(twist: Float[Any, "*batch 3"]) -> Float[Any, "3 *batch"]:
    """The displacement after moving with a constant twist (x, y, angle) for a unit of time.

    >>> exponential(np.array([math.pi / 2, 0.0, math.pi / 2])).round(3)
    array([1.   , 1.   , 1.571])
    """
    xp = _namespace(twist)
    x, y, angle = (twist[..., axis] for axis in range(3))
    small = xp.abs(angle) < 1e-6
    along = xp.sinc(angle / math.pi)
    across = xp.where(small, angle / 2, (1 - xp.cos(angle)) / xp.where(small, 1.0, angle))
    return _stack(along * x - across * y, across * x + along * y, angle)


def logarithm(displacement: Frame) -> Float[Any, "*batch 3"]:
    """The constant twist that leads to a displacement in a unit of time.

    >>> logarithm(np.array([1.0, 1.0, math.pi / 2])).round(3)
    array([1.571, 0.   , 1.571])
    """
    x, y, angle = displacement
    xp = _namespace(angle)
    half = angle / 2
    small = xp.abs(half) < 1e-6
    along = xp.where(small, 1.0, half / xp.tan(xp.where(small, 1.0, half)))
    return xp.stack([along * x + half * y, along * y - half * x, angle], axis=-1)


def adjoint(frame: Frame) -> Float[Any, "*batch 3 3"]:
    """From twists in a frame to the same twists about the origin.

    >>> adjoint(np.array([0.0, 2.0, 0.0])) @ np.array([0.0, 0.0, 1.0])
    array([2., 0., 1.])
    """
    x, y, angle = frame
    xp = _namespace(angle)
    cos, sin, zero = xp.cos(angle), xp.sin(angle), xp.zeros_like(x)
    rows = [[cos, -sin, y], [sin, cos, -x], [zero, zero, zero + 1]]
    return xp.stack([xp.stack(row, axis=-1) for row in rows], axis=-2)


def _stack(*components: Batch) -> Float[Any, "3 *batch"]:
    return _namespace(components[0]).stack(components)


def _namespace(array: Any) -> Any:
    """The module whose functions take this array: `numpy` or `jax.numpy`."""
    found = getattr(array, "__array_namespace__", None)
    return np if found is None else found()
