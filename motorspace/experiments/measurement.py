"""What a finished run is measured at, on trajectories that training never saw."""

import dataclasses
import itertools
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from motorspace._types import Count, Flag, Key, Pose
from motorspace.analysis.collapse import within_to_total_variance
from motorspace.analysis.coordinates import COMPONENTS
from motorspace.analysis.errors import CHUNK_SIZE, prediction_errors
from motorspace.analysis.probes import displacement_targets, linear_probe
from motorspace.analysis.projections import pca
from motorspace.models.model import Model
from motorspace.training.config import RunConfig
from motorspace.training.runs import Run
from motorspace.trajectories.derived import displacement_as_motors
from motorspace.trajectories.sampling import sample
from motorspace.trajectories.transitions import Experience, Trajectories
from motorspace.worlds.agents import LatticeAgent
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.sensors.node_index import NodeIndex
from motorspace.worlds.simulation import step
from motorspace.worlds.world import LatticeWorld

TEST_SEED = 1_000_003
"""Evaluation draws from its own stream: training seeds stay far below it."""

NUM_LATTICE_CODES = 20_000


def draw_test(config: RunConfig, num: int, *, key: Key) -> Trajectories:
    """Fresh trajectories of the run's own kind, at its full horizons."""
    simulation = config.simulation
    return sample(
        Scenario(*simulation.build()),
        num=num,
        horizon=simulation.horizon,
        min_horizon=simulation.min_horizon,
        collision=simulation.collision,
        key=key,
    )


def as_seen_by(config: RunConfig, trajectories: Trajectories) -> Experience:
    """What the run's network is given: the oracle sees displacements for commands."""
    if config.model.encoder == "identity":
        return displacement_as_motors(trajectories, float(config.simulation.horizon))
    return trajectories.experience


def measure(run: Run, num: int) -> dict[str, Any]:
    """Errors on `num` fresh trajectories, the codes' variance, and linear probes of them."""
    config = run.config
    errors_key, probe_key = jax.random.split(jax.random.key(TEST_SEED + config.training.seed))

    def draw(key: Key, count: int) -> Experience:
        return as_seen_by(config, draw_test(config, count, key=key))

    errors = prediction_errors(run.predict, draw, num=num, key=errors_key)
    probed = draw_test(config, CHUNK_SIZE, key=probe_key)
    seen = as_seen_by(config, probed)
    codes = run.encode(seen.motors, seen.num_steps)
    measured = {
        "seed": config.training.seed,
        "epochs": config.training.epochs,
        "recipe": f"{config.model.initial_weights}, {config.training.learning_rate:g}",
        "errors": dataclasses.asdict(errors),
        "code_variance": float(jnp.mean(jnp.var(codes, axis=0))),
        "probe_r2": _probe_halves(codes, displacement_targets(probed.displacements.achieved)),
    }
    return measured | (measure_lattice(run) if config.simulation.agent == "lattice" else {})


def measure_lattice(run: Run) -> dict[str, Any]:
    """Exact predictions over every case there is, and how the codes are organised.

    Organised means: sequences of equal displacement share a code (`within_to_total`, of equal
    translation, and of equal translation and turn: 0 is perfect), and few principal components
    tell the displacement (`r2_from_components`).
    """
    trajectories = draw_test(run.config, NUM_LATTICE_CODES, key=jax.random.key(TEST_SEED - 1))
    experience = trajectories.experience
    codes = run.encode(experience.motors, experience.num_steps)
    targets = displacement_targets(trajectories.displacements.achieved)
    counts = lattice_counts(run)
    return {
        "cases": {str(c.num_steps): [c.correct, c.valid] for c in counts},
        "accuracy": sum(c.correct for c in counts) / sum(c.valid for c in counts),
        "within_to_total": within_to_total_variance(codes, targets[:, :2]),
        "within_to_total_pose": within_to_total_variance(codes, targets),
        "r2_from_components": {
            str(count): _probe_halves(pca(codes, count).coordinates, targets) for count in (2, 3)
        },
    }


def _probe_halves(
    codes: Float[Array | np.ndarray, "N C"], targets: Float[Array | np.ndarray, "N 4"]
) -> dict[str, float]:
    """R2 on one half of the codes of a linear probe fitted on the other."""
    half = len(codes) // 2
    r2 = linear_probe(codes[:half], targets[:half], codes[half:], targets[half:])
    return dict(zip(COMPONENTS, (round(float(v), 4) for v in r2), strict=True))


@dataclasses.dataclass(frozen=True)
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
    that leave the lattice are struck out; encoding is done once per sequence.
    """
    simulation = run.config.simulation
    world, agent, sensor = simulation.build()
    assert isinstance(world, LatticeWorld) and isinstance(agent, LatticeAgent)
    assert isinstance(sensor, NodeIndex)
    starts = every_pose(world)
    counts = []
    for num_steps in range(simulation.min_horizon or simulation.horizon, simulation.horizon + 1):
        commands = np.array(list(itertools.product(range(6), repeat=num_steps)))
        motors = jnp.zeros((len(commands), simulation.horizon, 6))
        motors = motors.at[:, :num_steps].set(jax.nn.one_hot(commands, 6))
        correct, valid = _count(run.model, (world, agent, sensor), starts, motors, num_steps)
        counts.append(LatticeCount(num_steps, int(correct), int(valid)))
    return counts


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
    model: Model,
    system: tuple[LatticeWorld, LatticeAgent, NodeIndex],
    starts: Pose,
    motors: Float[Array, "N T 6"],
    num_steps: int,
) -> tuple[Count, Count]:
    """Over all starts and sequences: exact predictions, and cases that stay on the lattice."""
    world, agent, sensor = system
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
