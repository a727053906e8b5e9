"""Training as a user calls it: a configuration in, a run out, and its folder on the way."""

import dataclasses
import json
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from motorspace._errors import UserError
from motorspace._files import locked, write_atomically
from motorspace._types import Record, RecordCallback
from motorspace.models.losses import encode_all
from motorspace.models.model import Model, Scaling
from motorspace.training import folder as run_folder
from motorspace.training.checkpoint import packed, unpacked
from motorspace.training.config import RunConfig
from motorspace.training.data import Given
from motorspace.training.fit import COLLAPSED_BELOW, fit, fit_together, horizon_of, init, task_of
from motorspace.training.program import TrainState
from motorspace.training.sources import DataSource, given_source, source_of
from motorspace.trajectories.transitions import Experience, ExperienceSource

CHECKPOINT_SECONDS = 30.0


@dataclasses.dataclass(frozen=True)
class Run:
    """A trained network and what determined it.

    Attributes:
        config: The configuration.
        model: The network.
        log: One record per epoch: its number, and means over its updates.
    """

    config: RunConfig
    model: Model
    log: tuple[Record, ...] = ()

    @property
    def collapsed(self) -> bool:
        """Whether the codes stopped varying with the commands by the end of training."""
        last = self.log[-1]["code_variance"] if self.log else float("inf")
        return self.model.encoder.learned and last < COLLAPSED_BELOW

    def encode(
        self,
        motors: Float[Array | np.ndarray, "N T M"],
        num_steps: Int[Array | np.ndarray, " N"] | None = None,
    ) -> Float[Array, "N C"]:
        """The codes h^m of N motor sequences.

        Args:
            motors: Commands in raw units (radians, world units), [N, T, M].
            num_steps: How many commands of each sequence count; by default all T.

        Returns:
            Codes, [N, C].
        """
        if num_steps is None:
            num_steps = jnp.full(motors.shape[0], motors.shape[1])
        return _encode(self.model, jnp.asarray(motors), jnp.asarray(num_steps))

    def predict(self, experience: Experience) -> Float[Array, "N K"]:
        """The sensors expected after each transition's motor sequence, raw units, [N, K]."""
        return _predict(self.model, experience)


@eqx.filter_jit
def _encode(model: Model, motors: Array, num_steps: Array) -> Array:
    return jax.vmap(model.encode)(motors, num_steps)


@eqx.filter_jit
def _predict(model: Model, experience: Experience) -> Array:
    return jax.vmap(model.predict)(experience.sensors, encode_all(model, experience))


def train(
    config: RunConfig,
    experience: ExperienceSource | None = None,
    *,
    folder: str | Path | None = None,
    validation: Experience | None = None,
    scaling: Scaling | None = None,
    resume: bool = False,
    callback: RecordCallback = lambda record: None,
) -> Run:
    """Train a network on what the configuration says, or on data of one's own.

    Args:
        config: Everything that determines the run.
        experience: Data of one's own, instead of those that `config.data` names: a fixed
            `Experience`, or a function from a key and the epoch to fresh transitions.
        folder: Where the run is kept. A checkpoint is written there every half a minute.
        validation: With these the network is kept that predicted them best after any epoch. A
            log brings its own.
        scaling: What sensors and commands of `experience` are divided by; by default the largest
            magnitude of each sensor, the standard deviation of each command channel.
        resume: Continue a run that was stopped from its last checkpoint, to the same weights as
            if it had never stopped. A finished run is returned as it is, or lengthened if the
            configuration asks for more epochs.
        callback: Called after every epoch with its record.

    Returns:
        The run.

    Raises:
        UserError: When the folder holds another run, another process trains in it, the data
            cannot be read, or the loss stops being finite (the last good checkpoint stays).

    Example:
        >>> from motorspace.training.config import RunConfig, TrainingConfig
        >>> from motorspace.training.data import Simulated
        >>> config = RunConfig(Simulated(layout="empty"), training=TrainingConfig(epochs=1))
        >>> train(config).log[-1]["epoch"]  # doctest: +SKIP
        1
    """
    config, data = _config_and_source(config, experience, scaling)
    validation = data.validation if validation is None else validation
    horizon = horizon_of(data.experience)
    state = init(config, data.scaling, horizon=horizon, validated=validation is not None)
    if folder is None:
        log: list[Record] = []

        def record_only(_: TrainState, records: Sequence[Record]) -> None:
            log.extend(records)
            for record in records:
                callback(record)

        state = fit(config, state, data.experience, validation=validation, callback=record_only)
        return Run(config, state.selected, tuple(log))
    described = _described(config, data.scaling, horizon)
    with _checkpointed(Path(folder), described, state, resume=resume, callback=callback) as keeper:
        fit(config, keeper.state, data.experience, validation=validation, callback=keeper.record)
    return Run(config, keeper.state.selected, tuple(keeper.log))


def _config_and_source(
    config: RunConfig, experience: ExperienceSource | None, scaling: Scaling | None
) -> tuple[RunConfig, DataSource]:
    if experience is None:
        return config, source_of(config)
    if not isinstance(config.data, Given):
        config = dataclasses.replace(config, data=Given())
    return config, given_source(config, experience, scaling)


def train_together(
    configs: Sequence[RunConfig], folders: Sequence[Path], *, resume: bool = False
) -> list[Run]:
    """`train` several runs at once; those that differ by seeds and numbers are one program.

    For devices of many cores.
    """
    with ExitStack() as stack:
        keepers, tasks = [], []
        for config, folder in zip(configs, folders, strict=True):
            data = source_of(config)
            horizon, validated = horizon_of(data.experience), data.validation is not None
            state = init(config, data.scaling, horizon=horizon, validated=validated)
            described = _described(config, data.scaling, horizon)
            kept = _checkpointed(folder, described, state, resume=resume)
            keepers.append(stack.enter_context(kept))
            tasks.append(task_of(config, data.scaling, data.experience, validation=data.validation))
        fit_together(
            configs,
            [keeper.state for keeper in keepers],
            tasks,
            callbacks=[keeper.record for keeper in keepers],
        )
    return [
        Run(config, keeper.state.selected, tuple(keeper.log))
        for config, keeper in zip(configs, keepers, strict=True)
    ]


def initial_run(config: RunConfig) -> Run:
    """A run before its first epoch: a baseline for what training adds."""
    data = source_of(config)
    state = init(config, data.scaling, horizon=horizon_of(data.experience))
    return Run(config, state.model)


def load_run(folder: str | Path) -> Run:
    """Return the finished run in a folder.

    Args:
        folder: A folder that `train` or `motorspace train` has filled.

    Raises:
        UserError: When there is no finished run, it is broken, or it names a class that is not
            imported: nothing that the folder names is ever imported.
    """
    folder = Path(folder)
    described = run_folder.read_description(folder)
    config = described.config
    if not run_folder.finished(folder):
        raise UserError(
            "this run is not finished", where=folder, remedy="continue it with --resume"
        )
    scaling = Scaling(described.sensor_scale, described.motor_scale)
    state = init(config, scaling, horizon=described.horizon)
    model = unpacked(state.model, folder / run_folder.WEIGHTS)
    return Run(config, model, tuple(run_folder.read_log(folder)))


def _described(config: RunConfig, scaling: Scaling, horizon: int) -> run_folder.Description:
    """What a run's folder says of it."""
    return run_folder.Description(
        config, tuple(map(float, scaling.sensors)), tuple(map(float, scaling.motors)), horizon
    )


class _Checkpointer:
    """Writes log and checkpoint as training goes on."""

    def __init__(
        self, folder: Path, state: TrainState, log: list[Record], callback: RecordCallback
    ) -> None:
        self.folder, self.state, self.log, self.callback = folder, state, log, callback
        self.written = time.monotonic()

    def record(self, state: TrainState, records: Sequence[Record]) -> None:
        self.state = state
        self.log.extend(records)
        for record in records:
            self.callback(record)
        if time.monotonic() - self.written > CHECKPOINT_SECONDS:
            self.write()

    def write(self) -> None:
        # The log first: one that is ahead of its checkpoint is cut back on resuming.
        lines = "".join(json.dumps(record) + "\n" for record in self.log)
        write_atomically(self.folder / run_folder.LOG, lines.encode())
        write_atomically(self.folder / run_folder.CHECKPOINT, packed(self.state))
        self.written = time.monotonic()


@contextmanager
def _checkpointed(
    folder: Path,
    described: run_folder.Description,
    state: TrainState,
    *,
    resume: bool,
    callback: RecordCallback = lambda record: None,
) -> Iterator[_Checkpointer]:
    """Training that is kept in a folder: from its checkpoint, if any, to its weights."""
    with locked(folder):
        run_folder.claim(folder, described, resume=resume)
        keeper = _Checkpointer(folder, *_restore(folder, state), callback)
        try:
            yield keeper
        finally:
            keeper.write()
        write_atomically(folder / run_folder.WEIGHTS, packed(keeper.state.selected))


def _restore(folder: Path, state: TrainState) -> tuple[TrainState, list[Record]]:
    path = folder / run_folder.CHECKPOINT
    if not path.exists():
        return state, []
    restored = unpacked(state, path)
    return restored, run_folder.read_log(folder)[: int(restored.epoch)]
