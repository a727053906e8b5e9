"""Paint: which colours the walls of a layout have. Reading its name needs no JAX.

A paint is written in one word, in a layout file and on the command line: `flat`, one colour for
each wall, or `texture:4`, colours that vary along a wall with wavelengths from 4 to 8 world units.
After these may follow the share of the texture in the colour and the seed: `texture:4:0.5:7`,
`flat:7`.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.worlds.checks import one_of, positive, whole, within

if TYPE_CHECKING:
    from motorspace.worlds.coat import Coat

Kind = Literal["flat", "texture"]

TEXELS = 16
"""Colours that are kept for each wavelength; between them colours are interpolated."""

NUM_WAVES = 12
"""Sinusoids that make a texture."""

DEVIATION = 0.22
"""Standard deviation of a texture, where black is 0 and full light is 1."""


@dataclass(frozen=True)
class Paint:
    """The colours of all walls of a layout; they are the same for the same seed.

    Args:
        kind: "flat", or "texture": band-limited noise along each wall.
        wavelength: The shortest wavelength of the texture; the longest is twice that. World units.
        share: How much of the colour is texture; the rest is the wall's flat colour.
        seed: Of the colours.

    Raises:
        UserError: For a kind that does not exist, a wavelength that is not above 0, a share that
            is not from 0 to 1, and a seed below 0.

    >>> parse_paint("texture:4:0.5").share
    0.5
    """

    kind: Kind = "flat"
    wavelength: float = 4.0
    share: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        one_of("paint", self.kind, get_args(Kind))
        object.__setattr__(self, "wavelength", positive("wavelength", self.wavelength))
        object.__setattr__(self, "share", within("share", self.share, 0.0, 1.0))
        whole("seed", self.seed, at_least=0)

    @property
    def name(self) -> str:
        """The word that `parse_paint` gives this paint for.

        >>> Paint("texture", 4.0, seed=7).name
        'texture:4:1:7'
        """
        if self.kind == "flat":
            return f"flat:{self.seed}" if self.seed else "flat"
        return f"texture:{_number(self.wavelength)}:{_number(self.share)}:{self.seed}"

    def coat(self, walls: Float[np.ndarray, "S 2 2"]) -> "Coat":
        """The colours of these walls, two end points each, as a sensor looks them up."""
        from motorspace.worlds.coat import coat_of

        textured = self.kind == "texture"
        step = self.wavelength / TEXELS if textured else math.inf
        return coat_of(walls, [self._colours(*wall) for wall in enumerate(walls)], step)

    def _colours(self, number: int, wall: Float[np.ndarray, "2 2"]) -> Float[np.ndarray, "P 3"]:
        """The colours along a wall, a step apart, each channel from 0 to 1; one if it is flat."""
        random = np.random.default_rng([self.seed, number])
        flat = random.uniform(size=3)
        if self.kind == "flat":
            return flat[None]
        step = self.wavelength / TEXELS
        places = step * np.arange(math.ceil(math.dist(*wall) / step) + 2)
        frequencies = random.uniform(0.5, 1.0, (NUM_WAVES, 3)) / self.wavelength
        phases = random.uniform(size=(NUM_WAVES, 3))
        waves = np.sin(2 * np.pi * (places[:, None, None] * frequencies + phases))
        texture = 0.5 + DEVIATION * math.sqrt(2 / NUM_WAVES) * waves.sum(axis=1)
        return (1 - self.share) * flat + self.share * texture.clip(0.0, 1.0)


PLAIN = Paint()
"""What walls have of which nothing is said: a colour each."""


def parse_paint(word: str, *, where: object = None) -> Paint:
    """The paint that a word stands for.

    Args:
        word: `flat`, `flat:SEED`, `texture:WAVELENGTH`, `texture:WAVELENGTH:SHARE` or
            `texture:WAVELENGTH:SHARE:SEED`.
        where: What to name in messages.

    Raises:
        UserError: For any other word.
    """
    kind, *numbers = word.strip().split(":")
    try:
        if kind == "flat" and len(numbers) <= 1:
            return Paint(seed=int(numbers[0])) if numbers else Paint()
        if kind == "texture" and 1 <= len(numbers) <= 3:
            wavelength, share = (float(number) for number in (*numbers[:2], "1")[:2])
            return Paint("texture", wavelength, share, int("".join(numbers[2:]) or "0"))
    except UserError as error:
        raise UserError(error.what, where=where, remedy=error.remedy) from None
    except ValueError:
        pass
    raise UserError(
        f"{word!r} is no paint",
        where=where,
        remedy="write flat, flat:SEED, or texture:WAVELENGTH:SHARE:SEED, for instance texture:4",
    )


def _number(value: float) -> str:
    return repr(value).removesuffix(".0")
