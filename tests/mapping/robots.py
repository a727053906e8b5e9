"""A robot that is calibrated, with numbers of no meaning."""

import numpy as np

from motorspace.mapping.motion import Motion
from motorspace.mapping.mounting import Mounting
from motorspace.mapping.odometry import Odometry
from motorspace.mapping.rig import CalibratedRig, Rig
from tests.mapping.rooms import REACH, mounting

NUM_FEATURES = 15
"""Of commands of two values."""


def robot(num_rays: int = 61, seed: int = 0) -> CalibratedRig:
    random = np.random.default_rng(seed)
    step, gaze = 0.1 * random.normal(size=(2, NUM_FEATURES, 4))
    step_twist, gaze_twist = 0.01 * random.normal(size=(2, NUM_FEATURES, 3))
    odometry = Odometry(step, gaze, step_twist, gaze_twist, has_gaze=False)
    rays: Mounting = mounting(num_rays)
    rig = Rig(odometry, np.eye(3) + 0.1 * random.normal(size=(3, 3)), rays, per_scan=True)
    twist, strength = 0.01 * random.normal(size=(6, 3)), random.uniform(0, 1e-3, 12)
    return CalibratedRig(rig, Motion(twist, strength, REACH))
