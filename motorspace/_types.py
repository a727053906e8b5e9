"""The vocabulary of the package: every array type once, with its shape and unit.

`*batch` is one agent (no axis) or many: the simulator keeps agents in the last axes, so that
one operation runs over all of them side by side.
"""

from collections.abc import Callable
from typing import Literal

import equinox as eqx
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray
from jaxtyping import Key as KeyArray

Key = PRNGKeyArray
"""An explicit source of randomness."""

Keys = KeyArray[Array, "*batch"]
"""One source of randomness each for many of a kind."""

Scalar = Float[Array, ""]
Flag = Bool[Array, ""]
Count = Int[Array, ""]

Flags = Bool[Array, "*batch"]
Counts = Int[Array, "*batch"]

Motor = Float[Array, "M *batch"]
"""Motor command m of one time step, in the agent's own units."""

Motors = Float[Array, "T M *batch"]
"""Motor sequence: T commands in a row; T is the horizon."""

Sensors = Float[Array, "K *batch"]
"""What the agent senses at one time, in raw units (the paper's s_t)."""

Code = Float[Array, " C"]
"""Representation of a motor sequence (the paper's h^m)."""

Displacement = Float[Array, "3 *batch"]
"""(longitudinal, lateral, orientation change) in the frame of the part that carries the
sensors, at the start; world units, world units, radians in (-pi, pi]."""

Walls = Float[Array, "S 2 2 *worlds"]
"""S wall segments: two end points each, in world units; of one world, or of one for each agent."""

Record = dict[str, float | int]
"""What is logged of one epoch: its number, and means over its updates."""

RecordCallback = Callable[[Record], None]
"""Called after every epoch with its record."""

Collision = Literal["resample", "block"]
"""What happens to a command whose movement crosses a wall: another is drawn, or it is
logged and the translation does not happen."""


class Pose(eqx.Module):
    """Where the body is, which way it faces, and where the head points relative to it.

    ```
          y ^      / gaze = heading + head
            |     /
            |    o--- heading      angles counter-clockwise from the x axis
            +---------> x
    ```

    Args:
        x: World units. All fields share any batch shape.
        y: World units.
        heading: Radians, not wrapped.
        head: Radians; 0 for agents without one.
    """

    x: Float[Array, "*batch"]
    y: Float[Array, "*batch"]
    heading: Float[Array, "*batch"]
    head: Float[Array, "*batch"]

    @property
    def gaze(self) -> Float[Array, "*batch"]:
        """Orientation of the part that carries the sensors, radians."""
        return self.heading + self.head

    @property
    def frame(
        self,
    ) -> tuple[Float[Array, "*batch"], Float[Array, "*batch"], Float[Array, "*batch"]]:
        """The frame (x, y, gaze) of the part that carries the sensors; see `motorspace.se2`."""
        return self.x, self.y, self.gaze
