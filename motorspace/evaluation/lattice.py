"""The lattice: exact predictions over every case there is, and how its codes are structured."""

import itertools
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from motorspace._types import Count, Flag, Pose
from motorspace.analysis.equivalence import within_to_total_variance
from motorspace.analysis.probes import displacement_targets
from motorspace.analysis.projections import pca
from motorspace.evaluation.prediction import Metrics
from motorspace.evaluation.sampling import TEST_SEED, draw_test, probe_halves
from motorspace.models.model import Model
from motorspace.training.data import simulated
from motorspace.training.run import Run
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.simulation import step
from motorspace.worlds.world import LatticeWorld

NUM_CODES = 20_000
NUM_COMMANDS = 6

MOST_SEQUENCES = 6**6
"""Of longer lengths, which have more, so many random sequences are tried from every start."""


def measure_lattice(run: Run, *, num_codes: int = NUM_CODES) -> Metrics:
    """Exact predictions over every case there is, and how the codes are structured.

    Structured means: sequences of equal displacement share a code (`within_to_total`, of equal
    translation, and of equal translation and turn: 0 is perfect), and few principal components
    tell the displacement (`r2.COMPONENTS.NAME`).
    """
    key = jax.random.key(TEST_SEED - 1)
    trajectories = draw_test(run.config.data, num_codes, key=key)
    experience = trajectories.experience
    codes = run.encode(experience.motors, experience.num_steps)
    targets = displacement_targets(trajectories.displacements.achieved)
    counts = lattice_counts(run)
    metrics: Metrics = {
        "lattice.accuracy": sum(c.correct for c in counts) / sum(c.valid for c in counts),
        "lattice.within_to_total": within_to_total_variance(codes, targets[:, :2]),
        "lattice.within_to_total_pose": within_to_total_variance(codes, targets),
    }
    for count in counts:
        metrics[f"lattice.correct.{count.num_steps}"] = float(count.correct)
        metrics[f"lattice.valid.{count.num_steps}"] = float(count.valid)
    for size in (2, 3):
        probed = probe_halves(pca(codes, size).coordinates, targets)
        metrics |= {f"lattice.r2.{size}.{name}": r2 for name, r2 in probed.items()}
    return metrics


@dataclass(frozen=True)
class LatticeCount:
    """Predictions over every start, orientation and valid sequence of one length."""

    num_steps: int
    correct: int
    """Cases whose node and orientation are both predicted exactly (largest output)."""
    valid: int
    """Cases in which no command would leave the lattice."""


def lattice_counts(run: Run) -> list[LatticeCount]:
    """`run` on every case there is, for each length that it was trained for.

    A lattice of 36 nodes and sequences of five commands make 144 x 7,776 cases before those
    that leave the lattice are struck out; encoding is done once per sequence. Lengths that have
    more than `MOST_SEQUENCES` are sampled.
    """
    data = simulated(run.config.data)
    scenario = data.scenario()
    world = scenario.world
    assert isinstance(world, LatticeWorld), "the caller has made sure"
    starts = every_pose(world)
    counts = []
    for num_steps in range(data.min_horizon or data.horizon, data.horizon + 1):
        commands = sequences(num_steps)
        motors = jnp.zeros((len(commands), data.horizon, NUM_COMMANDS))
        motors = motors.at[:, :num_steps].set(jax.nn.one_hot(commands, NUM_COMMANDS))
        correct, valid = _count(run.model, scenario, starts, motors, num_steps)
        counts.append(LatticeCount(num_steps, int(correct), int(valid)))
    return counts


def sequences(num_steps: int) -> Int[np.ndarray, "S T"]:
    """Every sequence of so many commands, or a random selection where there are too many."""
    if NUM_COMMANDS**num_steps <= MOST_SEQUENCES:
        return np.array(list(itertools.product(range(NUM_COMMANDS), repeat=num_steps)))
    rng = np.random.default_rng(TEST_SEED)
    return rng.integers(NUM_COMMANDS, size=(MOST_SEQUENCES, num_steps))


def every_pose(world: LatticeWorld) -> Pose:
    """Each node in each of the four orientations: fields of shape [4 x nodes]."""
    x, y, quarters = np.meshgrid(
        np.arange(world.width), np.arange(world.height), np.arange(4) - 1, indexing="ij"
    )
    heading = quarters.ravel() * np.pi / 2
    return Pose(
        jnp.asarray(x.ravel(), jnp.float32),
        jnp.asarray(y.ravel(), jnp.float32),
        jnp.asarray(heading, jnp.float32),
        jnp.zeros(heading.shape),
    )


@eqx.filter_jit
def _count(
    model: Model, scenario: Scenario, starts: Pose, motors: Float[Array, "N T 6"], num_steps: int
) -> tuple[Count, Count]:
    """Over all starts and sequences: exact predictions, and cases that stay on the lattice."""
    world, agent, sensor = scenario.world, scenario.agent, scenario.sensor
    codes = jax.vmap(model.encode, in_axes=(0, None))(motors, jnp.asarray(num_steps))

    def walk(start: Pose, sequence: Float[Array, "T 6"]) -> tuple[Pose, Flag]:
        def advance(pose: Pose, motor: Float[Array, "6"]) -> tuple[Pose, Flag]:
            return step(world, agent, pose, motor)

        end, blocked = jax.lax.scan(advance, start, sequence[:num_steps])
        return end, ~blocked.any()

    def from_start(start: Pose) -> tuple[Count, Count]:
        ends, valid = jax.vmap(walk, in_axes=(None, 0))(start, motors)
        later = jax.vmap(sensor.sense, in_axes=(None, 0))(world, ends)
        now = sensor.sense(world, start)
        predicted = jax.vmap(model.predict, in_axes=(None, 0))(now, codes)
        return jnp.sum(_exact(predicted, later) & valid), jnp.sum(valid)

    correct, valid = jax.lax.map(from_start, starts)
    return correct.sum(), valid.sum()


def _exact(predicted: Float[Array, "N K"], later: Float[Array, "N K"]) -> Bool[Array, " N"]:
    """Whether node and orientation, each the largest of its outputs, are both right."""
    node = predicted[:, :-4].argmax(1) == later[:, :-4].argmax(1)
    return node & (predicted[:, -4:].argmax(1) == later[:, -4:].argmax(1))
