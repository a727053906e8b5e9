"""A run as data: what it learns from, the network, and how that is fitted."""

import dataclasses
import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeVar, get_args

from motorspace._errors import UserError
from motorspace._kinds import Part, Registry
from motorspace.models.config import ENCODERS, ModelConfig
from motorspace.training.data import Data, Derived, Given, Logged, Simulated
from motorspace.training.presets import PresetName, Settings, preset_settings
from motorspace.worlds.catalog import AGENTS, SENSORS
from motorspace.worlds.checks import flag, one_of, positive, whole, within

Schedule = Literal["cosine", "constant"]
Precision = Literal["float32", "tf32", "bf16"]
LATER: Mapping[str, Any] = {"precision": "float32", "blur_weight": 0.0, "latent_weight": 0.0}
"""Settings that came later, and what they stand at in runs from before: those keep their hash."""

MOST_DECAY = 1 - 1e-6
"""Of the moving average: with one of 1 the initial weights would stay."""


@dataclass(frozen=True)
class TrainingConfig:
    """How a network is fitted; the defaults are the paper's budget for continuous worlds."""

    epochs: int = 5000
    """Passes, each over fresh trajectories."""
    trajectories_per_epoch: int = 2000
    """Trajectories sampled for each epoch."""
    resample_each_epoch: bool = True
    """Sample new trajectories for every epoch; otherwise those of the first are repeated."""
    batch_size: int = 100
    """Trajectories per update."""
    learning_rate: float = 6e-3
    """Adam's (peak) learning rate."""
    schedule: Schedule = "cosine"
    """cosine: warm-up over 1% of the updates, then decay to zero; constant: the plain recipe."""
    curriculum: float = 0.3
    """Share of the epochs, from the first, over which the longest trajectory grows from 1 to T."""
    code_noise: float = 0.0
    """Noise on the codes that the predictor sees, relative to each unit's standard deviation; it
    decays to zero over the epochs of the curriculum."""
    inverse_weight: float = 0.0
    """Weight of the inverse model's loss; 0 leaves it out."""
    slowness_weight: float = 0.0
    """Weight of the slowness of the code (not in the paper; 0 = off)."""
    composition_weight: float = 0.0
    """Weight of the composition loss: predict a sequence's code from the codes of its halves (not
    in the paper; 0 = off)."""
    isometry_weight: float = 0.0
    """Weight of the penalty on commands that are not isometries, of the encoder matrix_product; it
    grows from 0 once the curriculum is over (not in the paper; 0 = off)."""
    blur_weight: float = 0.0
    """Weight of the errors of blurred views beside those of the views, for eyes (not in the paper;
    0 = off)."""
    latent_weight: float = 0.0
    """Weight of the prediction of learned features instead of sensors, which codes then learn from
    alone (not in the paper; 0 = off)."""
    train_encoder: bool = True
    """Train the encoder; otherwise it keeps its initial weights, as a baseline."""
    ema_decay: float = 0.0
    """Decay of an exponential moving average of the weights, which is what is saved; 0 saves the
    last weights."""
    restarts: int = 1
    """Initial networks that are tried for a tenth of the epochs; the one that predicts best by
    then is trained."""
    precision: Precision = "float32"
    """Products of matrices on an accelerator: exact to float32, or with factors rounded to tf32 or
    bf16; weights and sums are float32 always. A CPU knows float32 alone."""
    seed: int = 0
    """Seed of the initial weights and of every trajectory."""

    def __post_init__(self) -> None:
        for name in ("epochs", "trajectories_per_epoch", "batch_size", "restarts"):
            whole(name, getattr(self, name))
        if self.batch_size > self.trajectories_per_epoch:
            raise UserError(
                f"batch_size {self.batch_size} is above trajectories_per_epoch "
                f"{self.trajectories_per_epoch}",
                remedy="lower the one, or raise the other",
            )
        bounds = dict.fromkeys(("code_noise", *(f"{n}_weight" for n in self.weights)), math.inf)
        for name, most in (bounds | {"curriculum": 1.0, "ema_decay": MOST_DECAY}).items():
            object.__setattr__(self, name, within(name, getattr(self, name), 0.0, most))
        object.__setattr__(self, "learning_rate", positive("learning_rate", self.learning_rate))
        if not whole("seed", self.seed, at_least=0) < 2**31:
            raise UserError(f"seed must be from 0 to {2**31 - 1}, got {self.seed}")
        one_of("schedule", self.schedule, get_args(Schedule))
        one_of("precision", self.precision, get_args(Precision))
        for name in ("resample_each_epoch", "train_encoder"):
            flag(name, getattr(self, name))

    @property
    def weights(self) -> dict[str, float]:
        """The weight of every loss beside the prediction loss, by its name."""
        suffix = "_weight"
        return {n.removesuffix(suffix): w for n, w in vars(self).items() if n.endswith(suffix)}

    @property
    def trial_epochs(self) -> int:
        """Epochs for which every restart is tried where there are several."""
        return max(1, self.epochs // 10)

    @property
    def curriculum_epochs(self) -> int:
        """Epochs in which the longest trajectory still grows."""
        return round(self.curriculum * self.epochs)

    @property
    def num_updates(self) -> int:
        """Updates of an epoch."""
        return self.trajectories_per_epoch // self.batch_size


@dataclass(frozen=True, init=False)
class RunConfig:
    """Everything that determines a run.

    Args:
        data: What the run learns from.
        model: The network; by default that of the preset.
        training: How it is fitted; by default as the preset does it.
        preset: `"paper"`; `"best"`: the network whose codes are structured best; `"log"`: one that
            learns from some hundred scans of a robot's log; `"vision"` and `"vision_paper"`: the
            first two for eyes.

    Example:
        >>> config = RunConfig(Simulated("holonomic"), preset="best")
        >>> config.model.encoder, config.training.epochs
        ('matrix_product', 5000)
    """

    data: Data
    model: ModelConfig
    training: TrainingConfig

    def __init__(
        self,
        data: Data | None = None,
        model: ModelConfig | None = None,
        training: TrainingConfig | None = None,
        *,
        preset: PresetName = "paper",
    ) -> None:
        data = Simulated() if data is None else data
        agent = data.agent.kind if isinstance(data, Simulated) else None
        settings = preset_settings(preset, agent)
        object.__setattr__(self, "data", data)
        object.__setattr__(self, "model", model or _made(ModelConfig, settings))
        object.__setattr__(self, "training", training or _made(TrainingConfig, settings))

    def as_json(self) -> dict[str, Any]:
        """The configuration as JSON-able data."""
        return {
            "data": self.data.as_json(),
            "model": dataclasses.asdict(self.model),
            "training": dataclasses.asdict(self.training),
        }

    def hash(self) -> str:
        """Twelve hexadecimal digits that differ for configurations that differ.

        Where a log lies makes no difference, its content does.
        """
        described = self.as_json()
        for data in (described["data"], described["data"].get("base", {})):
            data.pop("path", None)
        for name, before in LATER.items():
            if described["training"][name] == before:
                del described["training"][name]
        text = json.dumps(described, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:12]

    def program(self) -> str:
        """The same for runs that one compiled program may train: seeds and numbers aside."""
        described = self.as_json()
        del described["training"]["seed"]
        return json.dumps(_without_numbers(described), sort_keys=True)


def _without_numbers(value: Any) -> Any:
    """JSON-able data in which a number only says whether it is 0: what is 0 is left out."""
    if isinstance(value, Mapping):
        return {name: _without_numbers(entry) for name, entry in value.items()}
    return value != 0.0 if isinstance(value, float) else value


Network = TypeVar("Network", ModelConfig, TrainingConfig)


def _made(kind: type[Network], settings: Settings) -> Network:
    """The part of a configuration that some settings belong to, among others that do not."""
    names = {field.name for field in dataclasses.fields(kind)}
    return kind(**{name: value for name, value in settings.items() if name in names})


def config_from_json(value: Any, *, where: object) -> RunConfig:
    """The configuration that `RunConfig.as_json` gave. Raises `UserError` if it is broken."""
    try:
        ENCODERS.check(value["model"]["encoder"], where=where)
        return RunConfig(
            _data_from_json(value["data"], where=where),
            ModelConfig(**value["model"]),
            TrainingConfig(**value["training"]),
        )
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise UserError(
            f"the configuration is broken, or of another version ({error})",
            where=where,
            remedy="train the run anew",
        ) from None


def _data_from_json(value: Mapping[str, Any], *, where: object) -> Data:
    """The data that `as_json` described. Raises `UserError` where that is broken."""
    kind, fields = value["kind"], {k: v for k, v in value.items() if k != "kind"}
    match kind:
        case "simulated":
            agent = _part_from_json(AGENTS, fields.pop("agent"), where=where)
            sensor = _part_from_json(SENSORS, fields.pop("sensor"), where=where)
            return Simulated(agent, sensor, **fields)
        case "logged":
            from motorspace.recordings.catalog import READERS

            return Logged(
                reader=_part_from_json(READERS, fields.pop("reader"), where=where), **fields
            )
        case "derived":
            base: Any = _data_from_json(fields.pop("base"), where=where)
            return Derived(base, **fields)
        case "given":
            return Given(fields["description"], tuple(fields.get("shape", ())))
    raise ValueError(f"data of the kind {kind!r}")


def _part_from_json(registry: Registry[Any], value: Mapping[str, Any], *, where: object) -> Part:
    options = {name: option for name, option in value.items() if name != "kind"}
    return registry.part(value["kind"], options, where=where)
