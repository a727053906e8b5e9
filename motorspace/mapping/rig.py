"""What a robot learns of itself from one walk: how commands move it, where its rays point."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from motorspace._errors import UserError
from motorspace.mapping.bearings import find_bearings
from motorspace.mapping.frame import FrameMap, find_frame, in_frame
from motorspace.mapping.motion import Motion
from motorspace.mapping.mounting import Mounting
from motorspace.mapping.odometry import Odometry, distilled, features
from motorspace.mapping.rig_file import Sections, read_sections, write_sections
from motorspace.mapping.survey import Scans, corrected_odometry
from motorspace.recordings.recording import Recording, chained_per_interval
from motorspace.se2 import compose, relative
from motorspace.training.data import Logged, base_of
from motorspace.training.run import Run


@dataclass(frozen=True)
class Rig:
    """Odometry of codes, and rays.

    Attributes:
        odometry: How each command moves the sensors, in the codes' own frame and unit.
        frame: From twists in that frame to those of the rays' origin, in the readings' unit.
        mounting: Where the rays point.
        per_scan: Whether the commands between two scans count as one.
    """

    odometry: Odometry
    frame: FrameMap
    mounting: Mounting
    per_scan: bool

    def scans(self, recording: Recording) -> Scans:
        """The readings of a walk, and the displacements between them by chained codes.

        Raises `UserError` for commands of another size, and for other rays.
        """
        self._check(recording)
        steps = coded_steps(self.odometry, recording, per_scan=self.per_scan)
        return Scans(recording.sensors, in_frame(steps, self.frame), self.mounting)

    def _check(self, recording: Recording) -> None:
        num, rays = recording.increments.shape[1], recording.sensors.shape[1]
        reach = max(recording.sensor_scale)
        if features(np.zeros(num)).size != len(self.odometry.step):
            what, remedy = f"commands of {num} values", "calibrate on a walk of this robot"
        elif rays != len(self.mounting.angles):
            what = f"{rays} rays instead of {len(self.mounting.angles)}"
            remedy = "read as many rays as the calibration was made with"
        elif not np.isclose(reach, self.mounting.reach, rtol=1e-4):
            what = f"readings up to {reach:g} instead of {self.mounting.reach:g}"
            remedy = "read with the maximum range that the calibration was made with"
        else:
            return
        raise UserError(
            f"the calibration is of another robot: the walk has {what}",
            where=recording.name,
            remedy=remedy,
        )


@dataclass(frozen=True)
class CalibratedRig:
    """All that has to be known of a robot for its odometry, wherever it goes; kept in a file.

    Attributes:
        rig: Odometry of codes, and rays.
        motion: What that odometry gets wrong, and how uncertain it is then.
    """

    rig: Rig
    motion: Motion

    def save(self, path: str | Path) -> None:
        """Write everything into one JSON file. Raises `UserError` where that is not possible."""
        angles, origin, reach = self.rig.mounting
        motion = self.motion._asdict()
        del motion["reach"]  # that of the rays
        sections = {
            "rig": {"frame": self.rig.frame, "per_scan": self.rig.per_scan},
            "odometry": self.rig.odometry._asdict(),
            "mounting": {"angles": angles, "origin": origin, "reach": reach},
            "motion": motion,
        }
        write_sections(Path(path), sections)

    @classmethod
    def load(cls, path: str | Path) -> "CalibratedRig":
        """What `save` has written. Raises `UserError` for a file that is missing or broken."""
        return cls.of(read_sections(path))

    @classmethod
    def of(cls, sections: Sections) -> "CalibratedRig":
        """From the sections of a file."""
        angles, origin, reach = (sections["mounting"][name] for name in Mounting._fields)
        mounting = Mounting(angles, origin, float(reach))
        odometry, frame = Odometry(**sections["odometry"]), sections["rig"]["frame"]
        rig = Rig(odometry, frame, mounting, sections["rig"]["per_scan"])
        return cls(rig, Motion(**sections["motion"], reach=mounting.reach))


def calibrate_rig(run: Run, recording: Recording) -> CalibratedRig:
    """Learn what `learn_rig` does, and what its odometry gets wrong.

    Args:
        run: A run whose codes are products of 3 x 3 matrices.
        recording: A walk of the same robot with walls in sight.

    Raises:
        UserError: As `learn_rig` does.
    """
    rig = learn_rig(run, recording)
    return CalibratedRig(rig, corrected_odometry(rig.scans(recording)))


def learn_rig(run: Run, recording: Recording) -> Rig:
    """Learn a robot's odometry and rays from a run's codes and one walk, without a pose.

    Args:
        run: A run whose codes are products of 3 x 3 matrices (preset best or log).
        recording: A walk of the same robot, with readings that are distances along rays.

    Returns:
        What holds wherever the robot goes.

    Raises:
        UserError: For another encoder, for commands of another size, and for readings that show
            no straight walls or cannot be matched.
    """
    per_scan = commands_per_scan(run)
    odometry = distilled(run, _commands(recording, per_scan)).odometry
    reach = max(recording.sensor_scale)
    bearings = find_bearings(recording.sensors, reach=reach)
    mounting = Mounting(bearings, np.zeros(2), reach)
    steps = coded_steps(odometry, recording, per_scan=per_scan)
    views = Scans(recording.sensors, steps, mounting).views()
    return Rig(odometry, find_frame(views, steps, reach=reach), mounting, per_scan)


def commands_per_scan(run: Run) -> bool:
    """Whether the run has learned from one command between two scans."""
    base = base_of(run.config.data)
    return not isinstance(base, Logged) or base.per_scan


def coded_frames(
    odometry: Odometry, recording: Recording, *, per_scan: bool
) -> Float[np.ndarray, "3 N"]:
    """Frames of the sensors along a walk, by chained codes of its commands.

    Args:
        odometry: How each command moves the sensors.
        recording: The walk.
        per_scan: Whether the commands between two scans count as one.
    """
    motors = _commands(recording, per_scan)
    interval = np.arange(len(motors)) if per_scan else recording.interval
    bodies = odometry.bodies(motors[:, None])[:, :, 0]
    done = np.searchsorted(interval, np.arange(len(recording)))
    rest = np.zeros((1, motors.shape[1]))
    gazes = odometry.gazes(np.concatenate([rest, motors]))
    return np.asarray(compose(bodies, gazes))[:, done]


def coded_steps(
    odometry: Odometry, recording: Recording, *, per_scan: bool
) -> Float[np.ndarray, "3 S"]:
    """Displacements of the sensors between scans, in the codes' own frame and unit."""
    frames = coded_frames(odometry, recording, per_scan=per_scan)
    return np.asarray(relative(frames[:, :-1], frames[:, 1:]))


def _commands(recording: Recording, per_scan: bool) -> Float[np.ndarray, "L M"]:
    if not len(recording.increments):
        raise UserError("the walk holds no commands", where=recording.name)
    return chained_per_interval(recording) if per_scan else recording.increments
