"""A new body, or a new sensor, in the space of codes that another agent has learned."""

from collections.abc import Sequence
from typing import Literal

import equinox as eqx

from motorspace._errors import UserError
from motorspace._types import Record
from motorspace.models.model import Scaling, with_parts
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Simulated
from motorspace.training.fit import fit, horizon_of, init
from motorspace.training.program import TrainState
from motorspace.training.run import Run
from motorspace.training.sources import source_of
from motorspace.worlds.checks import one_of

Learned = Literal["encoder", "predictor"]


def adapt(
    run: Run, data: Simulated, *, learn: Learned | str, training: TrainingConfig | None = None
) -> Run:
    """Return a run whose codes mean what those of another run mean.

    A predictor that stays says what a code does to the sensors. So the encoder of a new body that
    learns with it must give the commands of that body the codes of the same displacements. An
    encoder that stays gives a new sensor a predictor for the codes there are.

    Args:
        run: The run whose space of codes it is.
        data: What the new body and sensor undergo, without any labels.
        learn: `"encoder"`: that of a new body with the sensor of `run`, whose predictor stays.
            `"predictor"`: that of a new sensor on the body of `run`, whose encoder stays.
        training: How it learns; by default as `run` did.

    Returns:
        The run. Its configuration names its data and how it learned, not where the part comes
        from that it did not learn.

    Raises:
        UserError: For another sensor where the predictor stays, another body where the encoder
            stays, and where the loss stops being finite.

    Example:
        >>> from dataclasses import replace
        >>> from motorspace.training.run import initial_run
        >>> forward = initial_run(RunConfig(Simulated("forward", layout="empty"), preset="best"))
        >>> few = replace(forward.config.training, epochs=1, restarts=1)
        >>> data = Simulated("holonomic", layout="empty")
        >>> adapt(forward, data, learn="encoder", training=few).model.scaling.motors
        (1.0, 1.0, 1.0, 1.0)
    """
    one_of("learn", learn, ("encoder", "predictor"))
    config = RunConfig(data, run.config.model, training or run.config.training)
    source = source_of(config)
    _check(run.model.scaling, source.scaling, learn)
    frozen = ("predictor",) if learn == "encoder" else ("encoder",)
    first = init(config, source.scaling, horizon=horizon_of(source.experience))
    start = eqx.tree_at(lambda s: s.model, first, with_parts(first.model, run.model, frozen))
    log: list[Record] = []

    def note(_: TrainState, records: Sequence[Record]) -> None:
        log.extend(records)

    state = fit(config, start, source.experience, frozen=frozen, callback=note)
    return Run(config, state.selected, tuple(log))


def _check(own: Scaling, new: Scaling, learn: str) -> None:
    same = own.sensors == new.sensors if learn == "encoder" else own.motors == new.motors
    if not same:
        what, other = ("sensors", "predictor") if learn == "encoder" else ("commands", "encoder")
        raise UserError(
            f"the {what} are not those of the run, whose {other} is to stay as it is",
            remedy=f"give data of the same {what}, or learn the {other} first",
        )
