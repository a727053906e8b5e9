"""How well a judge predicts, beside the network and what stands still."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._types import Key
from motorspace.evaluation.floor import FLOOR_SEED, predict, remember
from motorspace.evaluation.prediction import Metrics
from motorspace.evaluation.sampling import test_trajectories
from motorspace.judge.judge import NUM_EXPLORED, Calibration, Judge, calibrate
from motorspace.judge.places import Hypotheses
from motorspace.mapping.walks import walk
from motorspace.training.config import RunConfig
from motorspace.training.data import simulated
from motorspace.training.run import Run, train
from motorspace.training.settings import changed
from motorspace.trajectories.sampling import sample
from motorspace.worlds.scenario import Scenario

SCORE_SEED = 3_000_003
EXPLORED = (2_000, 5_000, NUM_EXPLORED)
"""Steps of the walks that the layout is learned from."""
UNSEEN, UNSEEN_STEPS = 20, 2_000
"""Seeds of the layouts that the encoder has never seen begin here; steps of looking around."""
CHUNK_SIZE = 100
FLOOR_POSES, FLOOR_NEIGHBOURS = 300_000, 200
TIMED, WARM = 20, 5
"""Epochs that are timed, after so many that are not."""


@dataclass(frozen=True)
class Explored:
    """What judges of one run have come to know.

    Attributes:
        calibration: Of the run's body.
        seen: The judge of the layout that the run was trained in, after each number of steps.
        elsewhere: A layout that the run was not trained in.
        unseen: Its judge, after looking around.
        seconds: Of one core: `judge.calibration_seconds`, `judge.seconds.N` after N steps.
    """

    calibration: Calibration
    seen: Mapping[int, Judge]
    elsewhere: Scenario
    unseen: Judge
    seconds: Metrics

    @property
    def most(self) -> Judge:
        """The judge that has explored for longest."""
        return self.seen[max(self.seen)]


def explore(run: Run) -> Explored:
    """Judges that walk through the run's layout for longer and longer, and through another one."""
    body_key, walk_key, _, unseen_key = _keys(run.config)
    scenario, seed = simulated(run.config.data).scenario(), run.config.training.seed
    began = time.process_time()
    calibration = calibrate(run, key=body_key)
    seconds: Metrics = {"judge.calibration_seconds": time.process_time() - began}
    seen = {}
    for steps in EXPLORED:
        began = time.process_time()
        seen[steps] = Judge(calibration, walk(scenario, num_steps=steps, key=walk_key))
        seconds[f"judge.seconds.{steps}"] = time.process_time() - began
    elsewhere = Scenario(f"rooms:{UNSEEN + seed}", scenario.agent, scenario.sensor)
    unseen = Judge(calibration, walk(elsewhere, num_steps=UNSEEN_STEPS, key=unseen_key))
    return Explored(calibration, seen, elsewhere, unseen, seconds)


def measure_judge(run: Run, explored: Explored, *, num: int) -> Metrics:
    """What `num` fresh transitions say of judges that explored for longer and longer.

    Returns:
        Mean squared errors, raw units squared: `judge.error.N` after N steps in the layout that
        the run was trained in, `judge.error` after the most; `.motors`, where displacements come
        from the commands instead of their codes; `.network`, of the run's own predictor;
        `.persistence`; `.floor`, of 300,000 true poses on the same transitions; `.unseen` and
        `.unseen_network` in another layout. `.standard_error`, `.num` and seconds of one core.
    """
    scenario, key = simulated(run.config.data).scenario(), _keys(run.config)[2]
    test = _Test(run, explored.calibration, scenario, num, key=key)
    metrics = dict(explored.seconds)
    for steps, judge in explored.seen.items():
        places = test.located(judge)
        errors = test.errors(judge, places, test.of_codes)
        metrics[f"judge.error.{steps}"] = float(errors.mean())
    unseen = _Test(run, explored.calibration, explored.elsewhere, num, key=key)
    around = unseen.located(explored.unseen)
    return metrics | {
        "judge.error": float(errors.mean()),
        "judge.standard_error": float(errors.std() / num**0.5),
        "judge.motors": float(test.errors(judge, places, test.of_motors).mean()),
        "judge.network": test.network,
        "judge.network_seconds": training_seconds(run.config),
        "judge.persistence": test.persistence,
        "judge.floor": test.floor(scenario),
        "judge.unseen": float(unseen.errors(explored.unseen, around, unseen.of_codes).mean()),
        "judge.unseen_network": unseen.network,
        "judge.num": num,
    }


def measure_networks(run: Run, *, num: int, members: int = 1) -> Metrics:
    """`judge.network` of a run on the transitions that judges of its seed are tested on.

    Args:
        run: The run; its transitions may be derived, as those of its oracle.
        num: Transitions.
        members: Runs whose mean prediction is tested; all but the first are trained here.
    """
    tested = test_trajectories(run.config.data, num, key=_keys(run.config)[2]).experience
    seeds = [run.config.training.seed + SCORE_SEED * more for more in range(1, members)]
    others = [train(changed(run.config, {"seed": seed})) for seed in seeds]
    mean = sum(member.predict(tested) for member in (run, *others)) / members
    return {
        "judge.network": _mean_square(mean - tested.later_sensors),
        "judge.network_seconds": members * training_seconds(run.config),
        "judge.num": num,
    }


def training_seconds(config: RunConfig) -> float:
    """Seconds of one core that a training takes, by some of its epochs."""
    ends: list[float] = []
    short = replace(config, training=replace(config.training, epochs=WARM + TIMED))
    train(short, callback=lambda record: ends.append(time.process_time()))
    return (ends[-1] - ends[WARM - 1]) / TIMED * config.training.epochs


def _keys(config: RunConfig) -> list[Key]:
    """Of the calibration, the walks, the transitions, and the walk elsewhere."""
    return list(jax.random.split(jax.random.key(SCORE_SEED + config.training.seed), 4))


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

    def located(self, judge: Judge) -> list[Hypotheses]:
        """Where each transition may have begun."""
        rows = np.split(self.before, range(CHUNK_SIZE, len(self.before), CHUNK_SIZE))
        return [found for part in rows for found in judge.places.where(part)]

    def errors(
        self, judge: Judge, places: list[Hypotheses], displacements: Float[np.ndarray, "3 N"]
    ) -> Float[np.ndarray, " N"]:
        """Mean squared error of each transition."""
        predicted = np.concatenate(
            [
                judge.predict_displaced(found, displacements[:, row : row + 1])
                for row, found in enumerate(places)
            ]
        )
        return np.asarray(((predicted - self.after) ** 2).mean(axis=1))


def _mean_square(off: Float[Array, "N K"]) -> float:
    return float(jnp.mean(off**2))
