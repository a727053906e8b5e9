"""What determines a policy: task, body, observation, learner. Importing it loads nothing heavy."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from motorspace._errors import UserError
from motorspace._kinds import Part
from motorspace.navigation.levels import level_of
from motorspace.worlds.catalog import AGENTS, SENSORS
from motorspace.worlds.checks import flag, one_of, positive, whole, within

TASKS = ("home", "displacement_goal", "sensor_goal", "explore")
REWARDS = ("sparse", "shaped")
ACTS = ("commands", "codes")
PARTS = ("ranges", "bump", "command", "stack", "code", "untrained_code", "displacement")
"""What can be observed."""

CODES = ("code", "untrained_code")
"""Parts of an observation that need a run."""


@dataclass(frozen=True)
class PPOConfig:
    """Proximal policy optimisation (Schulman et al., 2017), for environments in one program."""

    num_agents: int = 256
    """Agents side by side."""
    num_steps: int = 32
    """Commands of each agent between two updates."""
    num_epochs: int = 4
    """How often an update goes over what the agents did."""
    num_minibatches: int = 8
    """Groups of agents in each epoch."""
    learning_rate: float = 1e-3
    """Adam's step size at the beginning; it falls to 0 along a line."""
    discount: float = 0.99
    """What a reward one command later is worth."""
    trace: float = 0.95
    """Lambda of generalised advantage estimation (Schulman et al., 2016)."""
    clip: float = 0.2
    """How far the probability of a command may move in an update, as a share."""
    entropy_weight: float = 0.0
    """The weight of the entropy of the commands."""
    value_weight: float = 0.5
    """The weight of the value's squared error."""
    max_gradient: float = 0.5
    """The largest norm of a gradient."""

    def __post_init__(self) -> None:
        for name in ("num_agents", "num_steps", "num_epochs", "num_minibatches"):
            whole(name, getattr(self, name))
        for name in ("learning_rate", "clip", "max_gradient"):
            positive(name, getattr(self, name))
        for name in ("discount", "trace"):
            within(name, getattr(self, name), 0.0, 1.0)
        if self.num_agents % self.num_minibatches:
            raise UserError(
                f"{self.num_agents} agents do not make {self.num_minibatches} equal groups",
                remedy="let num_minibatches divide num_agents",
            )

    @property
    def steps_per_update(self) -> int:
        """Actions between two updates."""
        return self.num_agents * self.num_steps


@dataclass(frozen=True)
class PolicyConfig:
    """The networks of a policy."""

    width_size: int = 64
    """Units of each of the two tanh layers of actor and critic."""
    memory_size: int = 0
    """Units of a GRU before them; without one the policy remembers nothing."""
    log_std: float = -0.5
    """Logarithm of the commands' standard deviation at the beginning, as a share of their range."""

    def __post_init__(self) -> None:
        whole("width_size", self.width_size)
        whole("memory_size", self.memory_size, at_least=0)


@dataclass(frozen=True)
class NavigationConfig:
    """A task, and how a policy for it is learned."""

    task: str = "home"
    """What is to be done."""
    agent: Part = field(default=Part("forward"))
    """The body."""
    sensor: Part = field(default=Part("range_fan"))
    """What it senses with."""
    observe: tuple[str, ...] = ("ranges", "bump", "command")
    """What it observes: ranges, bump, command (the last one), stack (the four moments before),
    code (the goal seen from here, by a run's chained codes), untrained_code, displacement (where
    the goal truly is)."""
    act: str = "commands"
    """commands: each action is a command; codes: it is a code, which a run's controller turns into
    a sequence of commands."""
    level: int = 2
    """How far goals are, and how many walls there are: 1 to 3."""
    reward: str = "sparse"
    """sparse: 1 at the goal; shaped: also for each step that leads nearer to it."""
    sense_blocked: bool = True
    """Whether the agent senses that a wall took a translation away."""
    max_steps: int | None = None
    """Commands until an episode is truncated; by default those of the level."""
    num_layouts: int = 64
    """Random layouts to learn in."""
    steps: int = 300_000
    """Environment steps to learn for."""
    seed: int = 0
    """The seed of all randomness but that of the layouts."""
    policy: PolicyConfig = field(default_factory=PolicyConfig)
    """The networks."""
    ppo: PPOConfig = field(default_factory=PPOConfig)
    """The learner."""

    def __post_init__(self) -> None:
        for name, registry in (("agent", AGENTS), ("sensor", SENSORS)):
            part = getattr(self, name)
            object.__setattr__(self, name, registry.part(part.kind, dict(part.options)))
        one_of("task", self.task, TASKS)
        one_of("reward", self.reward, REWARDS)
        one_of("act", self.act, ACTS)
        level_of(self.level)
        flag("sense_blocked", self.sense_blocked)
        whole("max_steps", self.episode_steps)
        for name in ("num_layouts", "steps"):
            whole(name, getattr(self, name))
        if not self.observe:
            raise UserError("nothing is observed", remedy=f"name some of {', '.join(PARTS)}")
        for part in self.observe:
            if part not in PARTS:
                raise UserError(
                    f"nothing is called {part!r} that could be observed",
                    remedy=f"choose from {', '.join(PARTS)}",
                )
        if "bump" in self.observe and not self.sense_blocked:
            raise UserError(
                "a bump that is not sensed cannot be observed", remedy="leave one of them out"
            )

    @property
    def episode_steps(self) -> int:
        """Commands until an episode is truncated."""
        return level_of(self.level).max_steps if self.max_steps is None else self.max_steps

    @property
    def needs_run(self) -> bool:
        """Whether codes of a trained run are observed, or acted in."""
        return self.act == "codes" or any(part in CODES for part in self.observe)

    def as_json(self) -> dict[str, Any]:
        """The same as JSON-able data."""
        written = asdict(self) | {"observe": list(self.observe)}
        return written | {"agent": self.agent.as_json(), "sensor": self.sensor.as_json()}


def navigation_from_json(value: Mapping[str, Any], *, where: object) -> NavigationConfig:
    """The configuration that `as_json` described. Raises `UserError` where it is broken."""
    try:
        fields = dict(value)
        parts = {
            name: registry.part(
                value[name]["kind"],
                {n: v for n, v in value[name].items() if n != "kind"},
                where=where,
            )
            for name, registry in (("agent", AGENTS), ("sensor", SENSORS))
        }
        fields |= parts | {"observe": tuple(value["observe"])}
        fields |= {"policy": PolicyConfig(**value["policy"]), "ppo": PPOConfig(**value["ppo"])}
        return NavigationConfig(**fields)
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise UserError(
            f"the configuration is broken, or of another version ({error})",
            where=where,
            remedy="train the policy anew",
        ) from None
