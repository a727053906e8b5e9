"""A controller: what an agent needs, beside its network, to act in the space of codes."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool

from motorspace._errors import UserError
from motorspace._types import Code, Motors
from motorspace.control.codes import (
    Examples,
    Probe,
    Whitening,
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
    commands, data = commands_of(run), simulated(run.config.data)
    seed = jax.random.key(config.seed)
    bank_key, label_key, learn_key, rest_key = jax.random.split(seed, 4)
    bank = _examples(run.model, commands, (config.bank, data.horizon), key=bank_key)
    labelled = _examples(run.model, commands, (config.labels, data.horizon), key=label_key)
    moved = nominal(data.scenario().agent, np.asarray(labelled.motors))
    spread = whitening(bank.codes)
    task = Task(run.model, commands, spread, data.horizon)
    return Controller(
        run.model,
        learn_decoder(task, config, key=learn_key),
        spread,
        fit_probe(moved, labelled.codes),
        bank,
        commands,
        None if is_product(run.model) else learn_remainder(task, config, key=rest_key),
    )


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
