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
import fcntl
import json
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from motorspace._errors import UserError
from motorspace.models import Model, Scaling
from motorspace.models.losses import encode_all
from motorspace.training.config import RunConfig, read_config
from motorspace.training.fit import TrainState, fit, init
from motorspace.trajectories import Experience, ExperienceSource

FORMAT_VERSION = 1
CHECKPOINT_SECONDS = 30.0


@dataclasses.dataclass(frozen=True)
class Run:
    """A trained network and what determined it."""

    config: RunConfig
    model: Model
    log: tuple[dict[str, float], ...] = ()

    def encode(
        self, motors: Float[Array, "N T M"], num_steps: Int[Array, " N"] | None = None
    ) -> Float[Array, "N C"]:
        """Codes h^m of N motor sequences in raw units, of `num_steps` commands each (T)."""
        if num_steps is None:
            num_steps = jnp.full(motors.shape[0], motors.shape[1])
        return _encode(self.model, motors, num_steps)

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
    resume: bool = False,
    watch: Callable[[dict[str, float]], None] = lambda record: None,
) -> Run:
    """Fit a network to `source` and, given a `folder`, keep the run there.

    A checkpoint is written every half a minute. With `resume` a stopped run continues from
    its last one, to the same weights as if it had never stopped; a finished run is returned
    as it is.

    Raises `UserError` when the folder holds another run, another process trains in it, or the
    loss stops being finite (the last good checkpoint stays).
    """
    horizon = config.simulation.horizon if isinstance(source, Callable) else 0  # type: ignore[arg-type]
    if isinstance(source, Experience):
        horizon = source.motors.shape[1]
    state = init(config.training, config.model, scaling, horizon=horizon)
    weight = config.model.inverse_weight
    log: list[dict[str, float]] = []
    if folder is None:
        state = fit(
            config.training,
            state,
            source,
            inverse_weight=weight,
            watch=lambda _, record: (log.append(record), watch(record))[0],
        )
        return Run(config, state.model, tuple(log))

    with locked(folder):
        _claim(folder, config, resume=resume)
        state, log = _restore(folder, state)
        keeper = _Keeper(folder, state, log, watch)
        try:
            state = fit(
                config.training, state, source, inverse_weight=weight, watch=keeper.record
            )
        finally:
            keeper.write()
        write_atomically(folder / "weights.safetensors", pack(state.model, {}))
    return Run(config, state.model, tuple(log))
