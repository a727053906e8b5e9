"""A run's folder: what determines it, what it has learned, and what it was measured at.

```
RUN/config.json             everything that determines the run
RUN/log.jsonl               one record per epoch
RUN/checkpoint.safetensors  the whole training state, replaced as one file
RUN/weights.safetensors     the network, once training is finished
RUN/results.json            what `evaluate` measured
```
"""

import dataclasses
import json
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int
from safetensors import SafetensorError
from safetensors.numpy import load, save

from motorspace._errors import UserError
from motorspace._files import locked, write_atomically, write_json
from motorspace._types import Record, Watch
from motorspace.models.losses import encode_all
from motorspace.models.model import Model, Scaling
from motorspace.training.config import RunConfig, config_from_json, simulation_scaling
from motorspace.training.fit import COLLAPSED_BELOW, TrainState, fit, fit_together, horizon_of, init
from motorspace.trajectories.transitions import Experience, ExperienceSource

FORMAT_VERSION = 1
CHECKPOINT_SECONDS = 30.0


@dataclasses.dataclass(frozen=True)
class Run:
    """A trained network and what determined it."""

    config: RunConfig
    model: Model
    log: tuple[Record, ...] = ()

    @property
    def collapsed(self) -> bool:
        """Whether the codes stopped varying with the commands by the end of training."""
        last = self.log[-1]["code_variance"] if self.log else float("inf")
        encodes = self.config.model.encoder not in ("none", "identity")
        return encodes and last < COLLAPSED_BELOW

    def encode(
        self,
        motors: Float[Array | np.ndarray, "N T M"],
        num_steps: Int[Array | np.ndarray, " N"] | None = None,
    ) -> Float[Array, "N C"]:
        """Codes h^m of N motor sequences in raw units, of `num_steps` commands each (T)."""
        if num_steps is None:
            num_steps = jnp.full(motors.shape[0], motors.shape[1])
        return _encode(self.model, jnp.asarray(motors), jnp.asarray(num_steps))

    def predict(self, experience: Experience) -> Float[Array, "N K"]:
        """Expected sensors after each transition's motor sequence, raw units."""
        return _predict(self.model, experience)


@eqx.filter_jit
def _encode(model: Model, motors: Array, num_steps: Array) -> Array:
    return jax.vmap(model.encode)(motors, num_steps)


@eqx.filter_jit
def _predict(model: Model, experience: Experience) -> Array:
    return jax.vmap(model.predict)(experience.sensors, encode_all(model, experience))


def train(
    config: RunConfig,
    source: ExperienceSource,
    scaling: Scaling,
    folder: Path | None = None,
    *,
    validation: Experience | None = None,
    resume: bool = False,
    watch: Watch = lambda record: None,
) -> Run:
    """Fit a network to `source` and, given a `folder`, keep the run there.

    With `validation` data the network that predicted them best after any epoch is kept.
    A checkpoint is written every half a minute. With `resume` a stopped run continues from
    its last one, to the same weights as if it had never stopped; a finished run is returned
    as it is.

    Raises `UserError` when the folder holds another run, another process trains in it, or the
    loss stops being finite (the last good checkpoint stays).
    """
    horizon = horizon_of(source)
    validated = validation is not None
    state = init(config.training, config.model, scaling, horizon=horizon, validated=validated)
    if folder is None:
        log: list[Record] = []

        def keep(_: TrainState, record: Record) -> None:
            log.append(record)
            watch(record)

        state = fit(config.training, config.model, state, source, validation=validation, watch=keep)
        return Run(config, state.kept, tuple(log))

    described = _description(config, scaling, horizon)
    with _kept(folder, described, state, resume=resume, watch=watch) as keeper:
        fit(
            config.training,
            config.model,
            keeper.state,
            source,
            validation=validation,
            watch=keeper.record,
        )
    return Run(config, keeper.state.kept, tuple(keeper.log))


def train_together(
    configs: Sequence[RunConfig],
    source: ExperienceSource,
    scaling: Scaling,
    folders: Sequence[Path],
    *,
    resume: bool = False,
) -> list[Run]:
    """`train` runs that differ by their seed alone as one program: for devices of many cores."""
    horizon, (first, *_) = horizon_of(source), configs
    with ExitStack() as stack:
        keepers = []
        for config, folder in zip(configs, folders, strict=True):
            state = init(config.training, config.model, scaling, horizon=horizon)
            described = _description(config, scaling, horizon)
            keepers.append(stack.enter_context(_kept(folder, described, state, resume=resume)))
        fit_together(
            first.training,
            first.model,
            [keeper.state for keeper in keepers],
            source,
            seeds=[config.training.seed for config in configs],
            watches=[keeper.record for keeper in keepers],
        )
    return [
        Run(config, keeper.state.kept, tuple(keeper.log))
        for config, keeper in zip(configs, keepers, strict=True)
    ]


def initial_run(config: RunConfig) -> Run:
    """A simulated run before its first epoch: a reference for what training adds."""
    scaling, horizon = simulation_scaling(config), config.simulation.horizon
    return Run(config, init(config.training, config.model, scaling, horizon=horizon).model)


def load_run(folder: Path) -> Run:
    """The finished run in a folder. Raises `UserError` when there is none, or it is broken."""
    described = _read_description(folder)
    config = config_from_json(described["config"], where=folder / "config.json")
    scaling = Scaling(*(tuple(described["scaling"][part]) for part in ("sensors", "motors")))
    weights = folder / "weights.safetensors"
    if not weights.exists():
        raise UserError(
            "this run is not finished", where=folder, remedy="continue it with --resume"
        )
    state = init(config.training, config.model, scaling, horizon=described["horizon"])
    model = _unpacked(state.model, weights)
    return Run(config, model, tuple(_read_log(folder)))


class _Keeper:
    """Writes log and checkpoint as training goes on."""

    def __init__(
        self,
        folder: Path,
        state: TrainState,
        log: list[Record],
        watch: Watch,
    ) -> None:
        self.folder, self.state, self.log, self.watch = folder, state, log, watch
        self.written = time.monotonic()

    def record(self, state: TrainState, record: Record) -> None:
        self.state = state
        self.log.append(record)
        self.watch(record)
        if time.monotonic() - self.written > CHECKPOINT_SECONDS:
            self.write()

    def write(self) -> None:
        # The log first: one that is ahead of its checkpoint is cut back on resuming.
        lines = "".join(json.dumps(record) + "\n" for record in self.log)
        write_atomically(self.folder / "log.jsonl", lines.encode())
        write_atomically(self.folder / "checkpoint.safetensors", _packed(self.state))
        self.written = time.monotonic()


@contextmanager
def _kept(
    folder: Path,
    described: dict[str, Any],
    state: TrainState,
    *,
    resume: bool,
    watch: Watch = lambda record: None,
) -> Iterator[_Keeper]:
    """Training that is kept in a folder: from its checkpoint, if any, to its weights."""
    with locked(folder):
        _claim(folder, described, resume=resume)
        keeper = _Keeper(folder, *_restore(folder, state), watch)
        try:
            yield keeper
        finally:
            keeper.write()
        write_atomically(folder / "weights.safetensors", _packed(keeper.state.kept))


def _description(config: RunConfig, scaling: Scaling, horizon: int) -> dict[str, Any]:
    return {
        "format_version": FORMAT_VERSION,
        "config": dataclasses.asdict(config),
        "scaling": dataclasses.asdict(scaling),
        "horizon": horizon,
    }


def _claim(folder: Path, described: dict[str, Any], *, resume: bool) -> None:
    """Make the folder this run's own, or make sure that it already is."""
    path = folder / "config.json"
    if not path.exists():
        write_json(path, described)
        return
    if not resume:
        raise UserError(
            "the folder already holds a run",
            where=folder,
            remedy="continue it with --resume, or choose another folder",
        )
    found = _read_description(folder)
    # A run of an earlier version is told without the fields that were added since.
    config = config_from_json(found["config"], where=path)
    found["config"] = dataclasses.asdict(config)
    found, wanted = (json.loads(json.dumps(told)) for told in (found, described))
    if found != wanted:
        names = ", ".join(_differences(found, wanted))
        raise UserError(
            f"the folder belongs to another configuration (different: {names})",
            where=folder,
            remedy="choose another folder, or the flags it was started with",
        )


def _restore(folder: Path, state: TrainState) -> tuple[TrainState, list[Record]]:
    path = folder / "checkpoint.safetensors"
    if not path.exists():
        return state, []
    restored = _unpacked(state, path)
    return restored, _read_log(folder)[: int(restored.epoch)]


def _read_description(folder: Path) -> dict[str, Any]:
    path = folder / "config.json"
    try:
        described = json.loads(path.read_bytes())
        if described["format_version"] != FORMAT_VERSION:
            raise ValueError
    except FileNotFoundError:
        raise UserError(
            "there is no run here",
            where=folder,
            remedy="give a folder made by motorspace train",
        ) from None
    except (OSError, ValueError, KeyError, TypeError):
        raise UserError(
            "the run's configuration cannot be read", where=path, remedy="train the run anew"
        ) from None
    return dict(described)


def _read_log(folder: Path) -> list[Record]:
    path = folder / "log.jsonl"
    try:
        return [json.loads(line) for line in path.read_text().splitlines()]
    except FileNotFoundError:
        return []
    except (OSError, ValueError):
        raise UserError(
            "the run's log cannot be read", where=path, remedy="train the run anew"
        ) from None


def _differences(found: Any, wanted: Any, name: str = "") -> list[str]:
    if isinstance(found, dict) and isinstance(wanted, dict):
        keys = sorted(found.keys() | wanted.keys())
        return [d for k in keys for d in _differences(found.get(k), wanted.get(k), k)]
    return [] if found == wanted else [name]


def _named_arrays(tree: Any) -> dict[str, Array]:
    leaves = jax.tree_util.tree_leaves_with_path(eqx.filter(tree, eqx.is_array))
    return {jax.tree_util.keystr(path): leaf for path, leaf in leaves}


def _packed(tree: Any) -> bytes:
    return save({name: np.asarray(leaf) for name, leaf in _named_arrays(tree).items()})


Tree = TypeVar("Tree")


def _unpacked(template: Tree, path: Path) -> Tree:
    """`template` with the arrays of a file. Raises `UserError` unless all of them fit."""
    try:
        stored = load(path.read_bytes())
    except (OSError, SafetensorError):
        raise UserError(
            "the file is cut off or damaged", where=path, remedy="train the run anew"
        ) from None
    expected = {name: (a.shape, a.dtype) for name, a in _named_arrays(template).items()}
    if {name: (a.shape, a.dtype) for name, a in stored.items()} != expected:
        raise UserError(
            "the weights do not fit the run's configuration",
            where=path,
            remedy="train the run anew",
        )
    arrays, rest = eqx.partition(template, eqx.is_array)
    leaves, structure = jax.tree_util.tree_flatten_with_path(arrays)
    loaded = [jnp.asarray(stored[jax.tree_util.keystr(path)]) for path, _ in leaves]
    return eqx.combine(jax.tree.unflatten(structure, loaded), rest)
