"""How each command moves the agent, in the encoder's own frame and the sensors' own unit."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.analysis.standard_form import body_point
from motorspace.models.model import Model
from motorspace.se2 import compose, exponential, relative
from motorspace.training.data import simulated
from motorspace.training.run import Run

Motors = Float[np.ndarray, "*batch M"]
Frames = Float[np.ndarray, "3 *batch"]
Features = Float[np.ndarray, "*batch F"]

NUM_COMMANDS = 4_000
VARYING = 0.05
"""Standard deviation above which the readout H depends on the command."""
RIDGE = 1e-4


class Odometry(NamedTuple):
    """Displacements of single commands: smooth functions of the commands, and their corrections.

    Args:
        step: [F, 4], from the features of a command to x, y, cos, sin of the body's displacement.
        gaze: [F, 4], the same for the sensors relative to the body after it.
        step_twist: [F, 3], corrections of `step`, as twists in the frame after the command.
        gaze_twist: [F, 3], corrections of `gaze`.
        has_gaze: Whether commands set the sensors relative to the body.
    """

    step: Float[np.ndarray, "F 4"]
    gaze: Float[np.ndarray, "F 4"]
    step_twist: Float[np.ndarray, "F 3"]
    gaze_twist: Float[np.ndarray, "F 3"]
    has_gaze: bool

    def steps(self, motors: Motors) -> Frames:
        """The body's displacement by each command."""
        known = features(motors)
        return compose(_frames(known @ self.step), exponential(known @ self.step_twist))

    def gazes(self, motors: Motors) -> Frames:
        """The frame of the sensors relative to the body after each command."""
        if not self.has_gaze:
            return np.zeros((3, *motors.shape[:-1]))
        known = features(motors)
        return compose(_frames(known @ self.gaze), exponential(known @ self.gaze_twist))

    def bodies(self, motors: Float[np.ndarray, "T n M"]) -> Float[np.ndarray, "3 S n"]:
        """The body's frames along walks, from the first of them."""
        here = np.zeros((3, motors.shape[1]))
        frames = [here]
        for then in np.moveaxis(self.steps(motors), 1, 0):
            here = compose(here, then)
            frames.append(here)
        return np.stack(frames, axis=1)

    def displacements(self, motors: Float[np.ndarray, "T n M"]) -> Float[np.ndarray, "3 n"]:
        """The sensors' displacement by whole sequences, from how they are mounted at rest."""
        frames = compose(self.bodies(motors)[:, -1], self.gazes(motors[-1]))
        return relative(self.gazes(np.zeros_like(motors[-1])), frames)

    def mirrored(self) -> "Odometry":
        """The same as seen in a mirror: left is right."""
        frame, twist = np.array([1.0, -1.0, 1.0, -1.0]), np.array([1.0, -1.0, -1.0])
        return self._replace(
            step=self.step * frame,
            gaze=self.gaze * frame,
            step_twist=self.step_twist * twist,
            gaze_twist=self.gaze_twist * twist,
        )

    def in_unit(self, unit: float) -> "Odometry":
        """The same in another unit of length: `unit` of it are one of before."""
        scale = np.array([unit, unit, 1.0, 1.0])
        return self._replace(step=self.step * scale, gaze=self.gaze * scale)


def features(motors: Motors) -> Features:
    """What displacements are linear in: sines and cosines of each channel, times every other.

    Rigid motions by angles and lengths that the channels set are among their combinations,
    whichever channel sets which; the wiggles of a network are not.
    """
    size = motors.shape[-1]
    waves = [wave(times * motors) for times in (1, 2) for wave in (np.sin, np.cos)]
    pairs = [
        wave[..., first] * motors[..., other]
        for wave in waves[:2]
        for first in range(size)
        for other in range(size)
        if first != other
    ]
    crossed = np.stack(pairs, axis=-1) if pairs else np.zeros((*motors.shape[:-1], 0))
    return np.concatenate([*waves, motors, crossed, np.ones((*motors.shape[:-1], 1))], axis=-1)


class Learned(NamedTuple):
    """What an encoder has learned of its commands.

    Args:
        odometry: In the encoder's own unit of length.
        point: Where in its frame the point of the body lies that it turns about, [2].
    """

    odometry: Odometry
    point: Float[np.ndarray, "2"]


def random_commands(run: Run, *, key: Key) -> Float[np.ndarray, "N M"]:
    """Commands of the simulated agent that a run has learned from, raw units."""
    commands = simulated(run.config.data).scenario().commands
    drawn = jax.vmap(lambda k: commands.sample(key=k))(jax.random.split(key, NUM_COMMANDS))
    return np.asarray(drawn, np.float64)


def distilled(run: Run, motors: Float[np.ndarray, "N M"]) -> Learned:
    """The odometry that a run's encoder has learned, whose codes are products of matrices.

    Args:
        run: The run.
        motors: Commands such as the encoder has learned from, raw units.

    Raises:
        UserError: For an encoder whose codes are no products of 3 x 3 matrices.
    """
    matrices = _matrices(run.model, jnp.asarray(motors, jnp.float32))
    if matrices is None or matrices[0].shape[-1] != 3:
        raise UserError(
            f"codes of the encoder {run.config.model.encoder!r} are no motions of the plane",
            remedy="train a run with the preset best, or on a log with the preset log",
        )
    transitions, readouts = (np.asarray(part, np.float64) for part in matrices)
    has_gaze = bool(readouts[:, :2, :2].std(axis=0).max() > VARYING)
    end = _constant(readouts, has_gaze)
    known = features(motors)
    normal = known.T @ known + RIDGE * np.eye(known.shape[1])
    step, gaze = (
        np.linalg.solve(normal, known.T @ _targets(rigid(product)))
        for product in (transitions, readouts @ np.linalg.inv(end))
    )
    nothing = np.zeros((known.shape[1], 3))
    return Learned(Odometry(step, gaze, nothing, nothing, has_gaze), -body_point(transitions))


@eqx.filter_jit
def _matrices(model: Model, motors: jax.Array) -> tuple[jax.Array, jax.Array] | None:
    return jax.vmap(model.encoder.matrices)(motors / jnp.array(model.scaling.motors)[None])


def _constant(readouts: Float[np.ndarray, "N 3 3"], has_gaze: bool) -> Float[np.ndarray, "3 3"]:
    """H of a command that leaves the sensors aligned with the body, as they are on average.

    Codes are products A(m_1) ... A(m_T) H(m_T) in which H ends in a constant of its own.
    """
    linear, shift = readouts[:, :2, :2], readouts[:, :2, 2]
    mean = linear.mean(axis=0)
    # The mean of rotations is shorter than a rotation.
    area = np.linalg.det(linear).mean() / np.linalg.det(mean)
    end = np.eye(3)
    end[:2, :2] = mean * np.sqrt(abs(area))
    pivot = np.zeros(2)
    if has_gaze:
        turns, shifts = linear - mean, shift - shift.mean(axis=0)
        pivot = np.linalg.lstsq(turns.reshape(-1, 2), shifts.reshape(-1), rcond=None)[0]
    end[:2, 2] = end[:2, :2] @ pivot + shift.mean(axis=0) - mean @ pivot
    return end


def rigid(matrices: Float[np.ndarray, "*batch 3 3"]) -> Frames:
    """The rigid motions nearest to affine ones: x, y, angle."""
    sin = matrices[..., 1, 0] - matrices[..., 0, 1]
    cos = matrices[..., 0, 0] + matrices[..., 1, 1]
    return np.stack([matrices[..., 0, 2], matrices[..., 1, 2], np.arctan2(sin, cos)])


def _targets(frames: Frames) -> Float[np.ndarray, "*batch 4"]:
    x, y, angle = frames
    return np.stack([x, y, np.cos(angle), np.sin(angle)], axis=-1)


def _frames(targets: Float[np.ndarray, "*batch 4"]) -> Frames:
    return np.stack(
        [targets[..., 0], targets[..., 1], np.arctan2(targets[..., 3], targets[..., 2])]
    )
