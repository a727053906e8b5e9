"""Places: where an agent may be, and which moves a wall forbids."""

import abc

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Flag, Key, Pose, Scalar, Walls
from motorspace.worlds import geometry

START_ATTEMPTS = 256


class AbstractWorld(eqx.Module):
    """What a place must answer."""

    @abc.abstractmethod
    def place(self, *, key: Key) -> Pose:
        """A free position and a heading, drawn uniformly; the head looks ahead."""

    @abc.abstractmethod
    def blocked(self, start: Pose, end: Pose) -> Flag:
        """Whether the straight move from `start` to `end` is forbidden."""


class WalledWorld(AbstractWorld):
    """A rectangle with walls: the paper's continuous world.

    `walls` holds every segment, the outer ones included; `solids` those that bound closed
    obstacles, in whose inside nothing may stand; `bounds` is (x low, y low, x high, y high).
    World units.
    """

    walls: Walls
    solids: Float[Array, "E 2 2"]
    bounds: tuple[float, float, float, float] = eqx.field(static=True)

    def free(self, x: Scalar, y: Scalar) -> Flag:
        """Whether an agent may stand at a point."""
        x_low, y_low, x_high, y_high = self.bounds
        in_bounds = (x > x_low) & (x < x_high) & (y > y_low) & (y < y_high)
        in_the_open = ~geometry.touches(self.walls, x, y) & ~geometry.inside(self.solids, x, y)
        return in_bounds & in_the_open

    def place(self, *, key: Key) -> Pose:
        x_low, y_low, x_high, y_high = self.bounds
        low, high = jnp.array([x_low, y_low]), jnp.array([x_high, y_high])
        attempts_key, heading_key = jax.random.split(key)

        def draw(attempt: Array) -> Float[Array, "2"]:
            return jax.random.uniform(
                jax.random.fold_in(attempts_key, attempt), (2,), minval=low, maxval=high
            )

        def again(carry: tuple[Array, Array]) -> Flag:
            attempt, point = carry
            return ~self.free(point[0], point[1]) & (attempt < START_ATTEMPTS)

        def redraw(carry: tuple[Array, Array]) -> tuple[Array, Array]:
            attempt, _ = carry
            return attempt + 1, draw(attempt + 1)

        first = jnp.zeros((), jnp.int32)
        _, (x, y) = jax.lax.while_loop(again, redraw, (first, draw(first)))
        heading = jax.random.uniform(heading_key, minval=-jnp.pi, maxval=jnp.pi)
        return Pose(x, y, heading, jnp.zeros_like(x))

    def blocked(self, start: Pose, end: Pose) -> Flag:
        return geometry.crosses(self.walls, start, end) | geometry.touches(self.walls, end.x, end.y)


class LatticeWorld(AbstractWorld):
    """A grid of nodes one unit apart, with four orientations: the paper's discrete world.

    Node (0, 0) is at the origin; a move that leaves the grid is forbidden.
    """

    width: int = eqx.field(static=True, default=6)
    height: int = eqx.field(static=True, default=6)

    @property
    def num_nodes(self) -> int:
        return self.width * self.height

    def place(self, *, key: Key) -> Pose:
        x_key, y_key, heading_key = jax.random.split(key, 3)
        x = jax.random.randint(x_key, (), 0, self.width).astype(float)
        y = jax.random.randint(y_key, (), 0, self.height).astype(float)
        quarters = jax.random.randint(heading_key, (), -1, 3).astype(float)
        return Pose(x, y, quarters * jnp.pi / 2, jnp.zeros_like(x))

    def blocked(self, start: Pose, end: Pose) -> Flag:
        del start
        # Half a unit of slack: positions are whole numbers up to rounding.
        outside_x = (end.x < -0.5) | (end.x > self.width - 0.5)
        outside_y = (end.y < -0.5) | (end.y > self.height - 0.5)
        return outside_x | outside_y
