"""A run as data: every parameter of the paper, every point it leaves open."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import jax
import jax.numpy as jnp

from motorspace._errors import UserError
from motorspace._types import Collision, Count, Key
from motorspace.models.config import ModelConfig
from motorspace.models.model import Scaling
from motorspace.trajectories.sampling import SamplingPlan, simulate
from motorspace.trajectories.transitions import ExperienceSource, Trajectories
from motorspace.worlds.agents import AbstractAgent, ForwardAgent, HolonomicAgent, LatticeAgent
from motorspace.worlds.layouts import layout
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.sensors.base import AbstractSensor
from motorspace.worlds.sensors.node_index import NodeIndex
from motorspace.worlds.sensors.range_fan import RangeFan
from motorspace.worlds.world import AbstractWorld, LatticeWorld

AgentName = Literal["lattice", "forward", "holonomic"]


@dataclass(frozen=True)
class SimulationConfig:
    """Where the experience comes from when it is simulated."""

    agent: AgentName = "forward"
    """Which agent explores."""
    layout: str = "paper"
    """Walls of the continuous world: a bundled layout, a layout file, or rooms:SEED."""
    max_rotation: float = 0.8
    """Largest body rotation per step, in units of pi."""
    horizon: int = 6
    """Motor commands per trajectory (T)."""
    min_horizon: int | None = None
    """Shortest trajectory, when lengths are drawn from min_horizon to horizon."""
    num_rays: int = 9
    """Distance sensors."""
    max_range: float = 10.0
    """Range of the distance sensors, world units."""
    field_of_view: float = 1.0
    """Field of view of the distance sensors, in units of pi."""
    collision: Collision = "resample"
    """A command that a wall forbids: resample draws another, block discards its translation."""
    head_rule: Literal["set", "turn"] = "set"
    """The head command: set the head's angle, or turn the head by it."""
    head_start: Literal["aligned", "random"] = "aligned"
    """The head's angle when a trajectory begins."""
    sense_head: bool = False
    """Whether the head's angle is one more sensor."""
    lattice_size: int = 6
    """Nodes along each side of the lattice."""

    def __post_init__(self) -> None:
        for name in ("horizon", "min_horizon", "num_rays", "lattice_size"):
            value = getattr(self, name)
            if value is not None and value < 1:
                raise UserError(f"{name} must be at least 1, not {value}")
        for name in ("max_rotation", "max_range", "field_of_view"):
            value = getattr(self, name)
            if not 0 < value < math.inf:
                raise UserError(f"{name} must be above 0, not {value}")
        if self.min_horizon is not None and self.min_horizon > self.horizon:
            raise UserError(f"min_horizon {self.min_horizon} is above horizon {self.horizon}")

    def build(self) -> tuple[AbstractWorld, AbstractAgent, AbstractSensor[Any]]:
        """The world, the agent and its sensors."""
        if self.agent == "lattice":
            side = self.lattice_size
            return LatticeWorld(side, side), LatticeAgent(), NodeIndex()
        rotation = self.max_rotation * math.pi
        agent = (
            ForwardAgent(rotation)
            if self.agent == "forward"
            else HolonomicAgent(rotation, self.head_rule, self.head_start)
        )
        fan = RangeFan(self.num_rays, self.max_range, self.field_of_view * math.pi, self.sense_head)
        return layout(self.layout), agent, fan


@dataclass(frozen=True)
class TrainingConfig:
    """How a network is fitted; the defaults are the paper's budget for continuous worlds."""

    epochs: int = 5000
    """Passes, each over fresh trajectories."""
    trajectories_per_epoch: int = 2000
    """Trajectories drawn for each epoch."""
    fresh: bool = True
    """New trajectories for every epoch; False repeats those of the first."""
    batch_size: int = 100
    """Trajectories per update."""
    learning_rate: float = 6e-3
    """Adam's (peak) learning rate."""
    schedule: Literal["cosine", "constant"] = "cosine"
    """cosine: warm-up over 1% of the updates, then decay to zero; constant: the plain recipe."""
    curriculum: float = 0.3
    """Share of the epochs, from the first, over which the longest trajectory grows from 1 to T."""
    code_noise: float = 0.0
    """Noise on the codes that the predictor sees, relative to each unit's standard deviation; it
    fades to none over the epochs of the curriculum."""
    average: float = 0.0
    """Decay of a moving average of the weights, which is what is kept; 0 keeps the last ones."""
    starts: int = 1
    """Initial networks that are tried for a tenth of the epochs; the one that predicts best by
    then is trained."""
    seed: int = 0
    """Seed of the initial weights and of every trajectory."""

    @property
    def trial_epochs(self) -> int:
        """Epochs for which every start is tried where there are several."""
        return max(1, self.epochs // 10)

    @property
    def curriculum_epochs(self) -> int:
        """Epochs in which the longest trajectory still grows."""
        return round(self.curriculum * self.epochs)


@dataclass(frozen=True)
class RunConfig:
    """Everything that determines a run."""

    simulation: SimulationConfig = field(default_factory=SimulationConfig)
    model: ModelConfig = field(default_factory=ModelConfig)
    training: TrainingConfig = field(default_factory=TrainingConfig)


def simulator(config: RunConfig) -> Callable[[Key, Count], Trajectories]:
    """A function from a key and the epoch to one epoch's new trajectories.

    With large rotations the outcome of T commands says almost nothing about any one of them,
    much as a parity of T bits, and learning sits still. So the first epochs (`curriculum`) draw
    shorter sequences, of 1 command and then of up to 2, 3 ... T, which show what each one does.
    """
    scenario = Scenario(*config.simulation.build())
    simulation, training = config.simulation, config.training
    shortest = simulation.min_horizon or simulation.horizon

    def draw(key: Key, epoch: Count) -> Trajectories:
        young = epoch < training.curriculum_epochs
        grown = 1 + epoch * simulation.horizon // max(training.curriculum_epochs, 1)
        lengths = (jnp.where(young, 1, shortest), jnp.where(young, grown, simulation.horizon))
        if not training.fresh:
            key = jax.random.key(training.seed)
        plan = SamplingPlan(
            training.trajectories_per_epoch, simulation.horizon, simulation.collision
        )
        return simulate(scenario, plan, lengths, key=key)

    return draw


def fresh_experience(config: RunConfig) -> ExperienceSource:
    """The source that simulates new transitions for every epoch."""
    draw = simulator(config)
    return lambda key, epoch: draw(key, epoch).experience


def simulation_scaling(config: RunConfig) -> Scaling:
    """What simulated sensors and commands are divided by."""
    world, agent, sensor = config.simulation.build()
    raw = config.model.motor_scaling == "raw"
    commands = agent.commands
    return Scaling(sensor.space(world).scale, (1.0,) * commands.size if raw else commands.scale)


def config_from_json(value: Any, *, where: object) -> RunConfig:
    """The configuration that `dataclasses.asdict` wrote. Raises `UserError` if it is broken."""
    try:
        return RunConfig(
            SimulationConfig(**value["simulation"]),
            ModelConfig(**value["model"]),
            TrainingConfig(**value["training"]),
        )
    except (KeyError, TypeError) as error:
        raise UserError(
            f"the configuration is not one of this version ({error})",
            where=where,
            remedy="train the run anew",
        ) from None
