"""A controller: what an agent needs, beside its network, to act in the space of codes."""

import dataclasses
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool

from motorspace._errors import UserError
from motorspace._types import Code, Key, Motors
from motorspace.control.codes import (
    Examples,
    Probe,
    Whitening,
    blank_probe,
    encode,
    examples,
    fit_probe,
    whitening,
)
from motorspace.control.composing import Remainder, held, is_product, remaining
from motorspace.control.decoder import Decoder
from motorspace.control.learning import USUAL, ControlConfig, Task, learn_decoder, learn_remainder
from motorspace.models.model import Model
from motorspace.training.data import simulated
from motorspace.training.run import Run
from motorspace.trajectories.commands import nominal
from motorspace.worlds.spaces import ContinuousCommands


class Controller(eqx.Module):
    """A run's network and what was learned from it for acting.

    Attributes:
        model: The run's network.
        decoder: From codes to motor commands.
        whitening: How the codes of random sequences are spread.
        probe: From displacements to codes.
        bank: Random sequences with their codes.
        commands: The commands that the agent takes.
        remainder: What remains of a goal; None where codes are products of matrices, which say so
            themselves.
    """

    model: Model
    decoder: Decoder
    whitening: Whitening
    probe: Probe
    bank: Examples
    commands: ContinuousCommands = eqx.field(static=True)
    remainder: Remainder | None = None

    @property
    def horizon(self) -> int:
        """Commands of a planned sequence, T."""
        return self.decoder.horizon

    def remaining(self, goal: Code, motors: Motors, carried_out: Bool[Array, " L"]) -> Code:
        """The code that leads to `goal` after the commands carried out.

        Args:
            goal: The code of the whole way, [C].
            motors: Commands as they happened, [L, M].
            carried_out: Those of them that were carried out, the first ones, [L].
        """
        if self.remainder is None:
            return remaining(self.model, goal, motors, carried_out)
        done = held(self.commands, motors, jnp.sum(carried_out, dtype=jnp.int32))
        white = self.whitening(encode(self.model, done)), self.whitening(goal)
        return self.whitening.undone(self.remainder(*white))


def learn_controller(run: Run, config: ControlConfig = USUAL) -> Controller:
    """Learn to act with a run's codes.

    The decoder learns without labels. The map from displacements to codes is fitted on
    `config.labels` random sequences whose nominal displacement is known.

    Args:
        run: A run that learned in simulation, of an agent with continuous commands.
        config: How the controller learns.

    Returns:
        The controller.

    Raises:
        UserError: For a run on a log, and for discrete commands.
    """
    blank, keys = blank_controller(run, config), _keys(config)
    labels = config.labels, blank.horizon
    labelled = _examples(run.model, blank.commands, labels, key=keys.labels)
    agent = simulated(run.config.data).scenario().agent
    moved = nominal(agent, np.asarray(labelled.motors))
    task = Task(run.model, blank.commands, blank.whitening, blank.horizon)
    return dataclasses.replace(
        blank,
        decoder=learn_decoder(task, config, key=keys.decoder),
        probe=fit_probe(moved, labelled.codes),
        remainder=blank.remainder and learn_remainder(task, config, key=keys.remainder),
    )


def blank_controller(run: Run, config: ControlConfig) -> Controller:
    """A controller that has learned nothing: its bank, its whitening, and initial weights.

    Raises `UserError` as `learn_controller`.
    """
    commands, horizon, keys = commands_of(run), simulated(run.config.data).horizon, _keys(config)
    bank = _examples(run.model, commands, (config.bank, horizon), key=keys.bank)
    size = bank.codes.shape[1]
    product = is_product(run.model)
    return Controller(
        run.model,
        config.decoder((size, horizon, commands.size), key=keys.decoder),
        whitening(bank.codes),
        blank_probe(size),
        bank,
        commands,
        None if product else config.remainder(size, key=keys.remainder),
    )


class _Keys(NamedTuple):
    bank: Key
    labels: Key
    decoder: Key
    remainder: Key


def _keys(config: ControlConfig) -> _Keys:
    return _Keys(*jax.random.split(jax.random.key(config.seed), 4))


_examples = eqx.filter_jit(examples)


def commands_of(run: Run) -> ContinuousCommands:
    """The commands of a run's agent. Raises `UserError` unless they are continuous."""
    commands = simulated(run.config.data).scenario().commands
    if not isinstance(commands, ContinuousCommands):
        raise UserError(
            "a controller needs continuous commands, and those of this agent are discrete",
            remedy="use the run of a forward or holonomic agent",
        )
    return commands
