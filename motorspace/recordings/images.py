"""What a camera sees along a walk, drawn by MiniWorld; needs the extra `vision`.

Only the picture is MiniWorld's. Where the agent is, and what a wall does to its commands, stays as
the recording says: two recordings of one walk differ by their sensor alone.
"""

import colorsys
import io
import math
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float, UInt8

from motorspace._errors import UserError
from motorspace.recordings.recording import Recording, sensor_frames
from motorspace.worlds.checks import positive, whole
from motorspace.worlds.scenario import WorldLike, world_of
from motorspace.worlds.world import Drawing, WalledWorld

SYSTEM = "libegl1 libfreetype6 libgl1 libgl1-mesa-dri libglu1-mesa"
"""What MiniWorld needs from Debian or Ubuntu; `make vision-system` installs it."""

WIDEST = 0.9 * math.pi
"""An image on a plane grows without limit as its field of view approaches half a circle."""

TEXTURES = ("marble", "metal_grill", "stucco", "ceiling_tiles", "rock", "concrete_tiles", "drywall")
"""Textures of walls, grey enough to be tinted; as many as share no factor with the hues."""
FLOOR, CEILING = "asphalt", "ceiling_tile_noborder"

NEXT_HUE = (math.sqrt(5) - 1) / 2
"""From the hue of one face to that of the next, in full circles: the golden section, which never
comes back close to where it was."""
ALONG = 0.25
"""From the hue at one end of a face to that at its other end, in full circles."""

DIAGONAL = 30.0
"""A layout's diagonal in MiniWorld's own units: all of it is within the 100 that MiniWorld draws,
and its depths of 16 bits tell walls apart."""


@dataclass(frozen=True)
class Camera:
    """A camera that looks straight ahead, level, from where the sensors are.

    Example:
        >>> Camera(height=12, width=16).shape
        (12, 16, 3)

    Raises:
        UserError: For a size below 1, a field of view that is not above 0 and at most 0.9 pi, or
            an eye that is not above the floor.
    """

    height: int = 24
    """Rows of the image, pixels."""
    width: int = 32
    """Columns of the image, pixels."""
    field_of_view: float = 2 * math.pi / 3
    """Angle from the left edge of the image to the right one, radians."""
    eye_level: float = 3.0
    """How high the camera is above the floor, world units; walls are twice as high."""

    def __post_init__(self) -> None:
        whole("height", self.height)
        whole("width", self.width)
        positive("field_of_view", self.field_of_view, at_most=WIDEST, unit="radians")
        positive("eye_level", self.eye_level, unit="world units")

    @property
    def shape(self) -> tuple[int, int, int]:
        """(rows, columns, colours) of an image; the colours are red, green and blue."""
        return self.height, self.width, 3


def with_images(recording: Recording, layout: WorldLike, camera: Camera | None = None) -> Recording:
    """The same walk with what a camera sees in place of the readings.

    Every face of a wall has a texture, and colours that change from one end to the other, of its
    own. The same walk gives the same images. An environment of MiniWorld that is open in this
    process has to be reset afterwards: all of them keep their scene under one number.

    Args:
        recording: A walk whose true poses are known.
        layout: Where it went: a world with walls, a `Layout`, a layout file, or a name.
        camera: The camera, at the pose of the sensors; 24 x 32 pixels by default.

    Returns:
        The recording with an image per scan, rows from top to bottom, columns from left to right,
        as one line of channels in [-1, 1] (black -1, white 1); its `shape` says how they are
        arranged. Single precision: 9 kB per image of 24 x 32 pixels.

    Raises:
        UserError: A pose that is unknown or outside the layout, a world without walls, no
            MiniWorld, or nothing that it can draw with.
    """
    camera = Camera() if camera is None else camera
    world = world_of(layout)
    if not isinstance(world, WalledWorld):
        raise UserError(
            f"a {type(world).__name__} has no walls that a camera could see",
            remedy="choose a layout such as paper",
        )
    drawing = world.drawing()
    frames = sensor_frames(recording)
    _check(recording, frames, drawing)
    images = np.empty((len(recording), *camera.shape), np.float32)
    with _miniworld(drawing, camera) as scene:
        for index, frame in enumerate(frames.T):
            images[index] = scene.seen(*frame.tolist())
    images *= 2 / 255
    images -= 1
    return replace(
        recording,
        sensors=images.reshape(len(images), -1),
        sensor_scale=(1.0,) * math.prod(camera.shape),
        shape=camera.shape,
    )


def _check(recording: Recording, frames: Float[np.ndarray, "3 N"], drawing: Drawing) -> None:
    """Raise `UserError` unless every pose is known and in the layout."""
    unknown = ~np.isfinite(frames).all(axis=0)
    if unknown.any():
        raise UserError(
            f"the true pose of scan {int(np.argmax(unknown))} is unknown",
            where=recording.name,
            remedy="images need a walk whose poses are all known, such as those of record",
        )
    low, high = np.reshape(drawing.bounds, (2, 2))
    slack = 1e-3 * np.linalg.norm(high - low)
    places = frames[:2].T
    outside = ((places < low - slack) | (places > high + slack)).any(axis=1)
    if outside.any():
        first = int(np.argmax(outside))
        x, y = places[first]
        raise UserError(
            f"scan {first} is at ({x:g}, {y:g}), outside the layout",
            where=recording.name,
            remedy="give the layout that the walk was recorded in",
        )


@contextmanager
def _miniworld(drawing: Drawing, camera: Camera) -> Iterator[Any]:
    """A scene of MiniWorld with these walls, closed at the end."""
    try:
        import pyglet

        # It counts when pyglet's window system is first imported; Linux alone draws without one.
        if sys.platform == "linux" and "pyglet.gl" not in sys.modules:
            pyglet.options["headless"] = True
        # Said are how many samples a pixel has, and where no device is before that is an error.
        with redirect_stdout(io.StringIO()), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = _scene(drawing, camera)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("miniworld", "pyglet"):
            raise
        raise UserError(
            "images of a walk need MiniWorld", remedy="pip install 'motorspace[vision]'"
        ) from None
    except Exception as error:  # any of pyglet's, of OpenGL's, and plain assertions
        raise UserError(
            f"MiniWorld cannot draw here ({' '.join(str(error).split()) or type(error).__name__})",
            remedy=f"on Debian or Ubuntu: apt-get install {SYSTEM}",
        ) from error
    try:
        yield scene
    finally:
        scene.close()


def _scene(drawing: Drawing, camera: Camera) -> Any:
    """An environment of MiniWorld, whose x is ours and whose z points against our y."""
    from miniworld.entity import Entity
    from miniworld.miniworld import MiniWorldEnv
    from miniworld.opengl import Texture
    from miniworld.params import DEFAULT_PARAMS
    from pyglet import gl

    x_low, y_low, x_high, y_high = drawing.bounds
    scale = DIAGONAL / math.hypot(x_high - x_low, y_high - y_low)
    top = 2 * camera.eye_level

    class Walls(Entity):
        is_static = True

        def __init__(self) -> None:
            super().__init__()
            self.textures = [Texture.get(name) for name in TEXTURES]

        def render(self) -> None:
            # Colours between corners would run beyond them where a wall is seen from its edge.
            gl.glShadeModel(gl.GL_FLAT)
            for index, face in enumerate(_faces(drawing)):
                self.textures[index % len(TEXTURES)].bind()
                gl.glBegin(gl.GL_QUADS)
                gl.glNormal3f(*_normal(face))
                for start, end, hue in _pieces(face, index * NEXT_HUE, top / 4):
                    gl.glColor3f(*colorsys.hsv_to_rgb(hue, 0.75, 1.0))
                    # Up at the start, down at the end: counter-clockwise, seen from the front.
                    for along, v in ((start, 0.0), (start, 1.0), (end, 1.0), (end, 0.0)):
                        x, y = face[0] + along * (face[1] - face[0])
                        gl.glTexCoord2f(along * math.dist(*face) / top, v)
                        gl.glVertex3f(x * scale, v * top * scale, -y * scale)
                gl.glEnd()
            gl.glShadeModel(gl.GL_SMOOTH)

    class Scene(MiniWorldEnv):
        def _gen_world(self) -> None:
            beyond = 0.05 * DIAGONAL  # its own walls are hidden behind ours
            self.add_rect_room(
                x_low * scale - beyond,
                x_high * scale + beyond,
                -y_high * scale - beyond,
                -y_low * scale + beyond,
                wall_height=top * scale,
                floor_tex=FLOOR,
                ceil_tex=CEILING,
            )
            self.entities.append(Walls())
            half = math.tan(camera.field_of_view / 2) * camera.height / camera.width
            self.agent.cam_fov_y = math.degrees(2 * math.atan(half))
            self.agent.cam_height = camera.eye_level * scale
            self.agent.cam_fwd_disp = 0.0
            self.agent.pos, self.agent.dir = np.zeros(3), 0.0

        def seen(self, x: float, y: float, angle: float) -> UInt8[np.ndarray, "H W 3"]:
            self.agent.pos, self.agent.dir = np.array([x * scale, 0.0, -y * scale]), angle
            return self.render_obs()

        def close(self) -> None:
            super().close()
            self.shadow_window.close()

    middle = [(x_low + x_high) / 2 * scale, camera.eye_level * scale, -(y_low + y_high) / 2 * scale]
    params = DEFAULT_PARAMS.copy()
    for name, value in (
        ("light_pos", middle),
        ("light_color", [0.4] * 3),
        ("light_ambient", [0.4] * 3),
    ):
        params.set(name, value, value, value)
    size = {"obs_width": camera.width, "obs_height": camera.height}
    scene = Scene(**size, window_width=1, window_height=1, params=params)
    gl.glEnable(gl.GL_DEPTH_CLAMP)  # a wall is seen however near it is
    return scene


def _faces(drawing: Drawing) -> Float[np.ndarray, "F 2 2"]:
    """Both sides of every wall: end points, in the order in which its front has them."""
    lines = np.asarray(drawing.lines, np.float64)
    lines = lines[(lines[:, 0] != lines[:, 1]).any(axis=1)]
    return np.stack([lines, lines[:, ::-1]], axis=1).reshape(-1, 2, 2)


def _normal(face: Float[np.ndarray, "2 2"]) -> tuple[float, float, float]:
    """Away from the front of a face, in MiniWorld's axes."""
    x, y = (face[1] - face[0]) / math.dist(*face)
    return -y, 0.0, -x


def _pieces(
    face: Float[np.ndarray, "2 2"], hue: float, longest: float
) -> Iterator[tuple[float, float, float]]:
    """Where each piece of a face begins and ends, as shares of the face, and its hue."""
    num = max(math.ceil(math.dist(*face) / longest), 1)
    for index in range(num):
        yield index / num, (index + 1) / num, (hue + ALONG * (index + 0.5) / num) % 1.0
