"""A controller: what an agent needs, beside its network, to act in the space of codes."""

import equinox as eqx
import jax
import numpy as np

from motorspace._errors import UserError
from motorspace.control.codes import Examples, Probe, Whitening, examples, fit_probe, whitening
from motorspace.control.decoder import Decoder
from motorspace.control.learning import USUAL, ControlConfig, Task, learn_decoder
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
    """

    model: Model
    decoder: Decoder
    whitening: Whitening
    probe: Probe
    bank: Examples
    commands: ContinuousCommands = eqx.field(static=True)

    @property
    def horizon(self) -> int:
        """Commands of a planned sequence, T."""
        return self.decoder.horizon


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
    bank_key, label_key, learn_key = jax.random.split(jax.random.key(config.seed), 3)
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
