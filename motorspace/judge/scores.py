"""How well a judge predicts, beside the network and what stands still."""

import time

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._types import Key
from motorspace.evaluation.floor import FLOOR_SEED, predict, remember
from motorspace.evaluation.prediction import Metrics
from motorspace.judge.judge import NUM_EXPLORED, Calibration, Judge, calibrate
from motorspace.judge.walks import walk
from motorspace.training.data import simulated
from motorspace.training.run import Run
from motorspace.trajectories.sampling import sample
from motorspace.worlds.scenario import Scenario

SCORE_SEED = 3_000_003
EXPLORED = (2_000, 5_000, NUM_EXPLORED)
"""Steps of the walks that the layout is learned from."""
UNSEEN, UNSEEN_STEPS = "rooms:7", 2_000
"""A layout that the encoder has never seen, and the steps of looking around in it."""
CHUNK_SIZE = 100
FLOOR_POSES, FLOOR_NEIGHBOURS = 300_000, 200


def measure_judge(run: Run, *, num: int) -> Metrics:
    """What `num` fresh transitions say of judges that explored for longer and longer.

    Returns:
        Mean squared errors, raw units squared: `judge.error.N` after N steps in the layout that
        the run was trained in, `judge.error` after the most; `.motors`, where displacements come
        from the commands instead of their codes; `.network`, of the run's own predictor;
        `.persistence`; `.floor`, of 300,000 true poses on the same transitions; `.unseen` and
        `.unseen_network` in another layout after 2,000 steps. `.calibration_seconds` and
        `.seconds.N` of one core's time, `.standard_error` and `.num`.
    """
    keys = jax.random.split(jax.random.key(SCORE_SEED + run.config.training.seed), 5)
    scenario = simulated(run.config.data).scenario()
    began = time.process_time()
    calibration = calibrate(run, key=keys[0])
    metrics: Metrics = {"judge.calibration_seconds": time.process_time() - began}
    test = _Test(run, calibration, scenario, num, key=keys[1])
    for steps in EXPLORED:
        began = time.process_time()
        judge = Judge(calibration, walk(scenario, num_steps=steps, key=keys[2]))
        metrics[f"judge.seconds.{steps}"] = time.process_time() - began
        errors = test.errors(judge, test.of_codes)
        metrics[f"judge.error.{steps}"] = float(errors.mean())
    metrics |= {
        "judge.error": float(errors.mean()),
        "judge.standard_error": float(errors.std() / num**0.5),
        "judge.motors": float(test.errors(judge, test.of_motors).mean()),
        "judge.network": test.network,
        "judge.persistence": test.persistence,
        "judge.floor": test.floor(scenario),
        "judge.num": num,
    }
    elsewhere = Scenario(UNSEEN, scenario.agent, scenario.sensor)
    unseen = _Test(run, calibration, elsewhere, num, key=keys[3])
    judge = Judge(calibration, walk(elsewhere, num_steps=UNSEEN_STEPS, key=keys[4]))
    metrics["judge.unseen"] = float(unseen.errors(judge, unseen.of_codes).mean())
    return metrics | {"judge.unseen_network": unseen.network}


class _Test:
    """Fresh transitions, and how each is displaced as a judge reads it."""

    def __init__(
        self, run: Run, calibration: Calibration, scenario: Scenario, num: int, *, key: Key
    ) -> None:
        data = simulated(run.config.data)
        self.trajectories = sample(scenario, num=num, horizon=data.horizon, key=key)
        drawn = self.trajectories.experience
        self.before = np.asarray(drawn.sensors, np.float64)
        self.after = np.asarray(drawn.later_sensors, np.float64)
        motors = np.moveaxis(np.asarray(drawn.motors, np.float64), 0, 1)
        self.of_motors = calibration.body.odometry.displacements(motors)
        self.of_codes = calibration.codes.read(run.encode(drawn.motors, drawn.num_steps))
        self.network = _mean_square(run.predict(drawn) - drawn.later_sensors)
        self.persistence = _mean_square(drawn.sensors - drawn.later_sensors)

    def floor(self, scenario: Scenario) -> float:
        """What whoever knows the true displacement and remembers the true world predicts."""
        memory = remember(
            scenario.world, scenario.sensor, FLOOR_POSES, key=jax.random.key(FLOOR_SEED)
        )
        mean = np.asarray(predict(memory, self.trajectories, FLOOR_NEIGHBOURS).mean)
        return float(((mean - self.after) ** 2).mean())

    def errors(
        self, judge: Judge, displacements: Float[np.ndarray, "3 N"]
    ) -> Float[np.ndarray, " N"]:
        """Mean squared error of each transition."""
        rows = np.split(self.before, range(CHUNK_SIZE, len(self.before), CHUNK_SIZE))
        places = [found for part in rows for found in judge.places.where(part)]
        predicted = np.concatenate(
            [
                judge.predict_displaced(found, displacements[:, row : row + 1])
                for row, found in enumerate(places)
            ]
        )
        return np.asarray(((predicted - self.after) ** 2).mean(axis=1))


def _mean_square(off: Float[Array, "N K"]) -> float:
    return float(jnp.mean(off**2))
