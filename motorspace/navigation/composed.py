"""Where the goal is, by codes that are no products: what is left of a code is learned.

The controller of such a run has learned what remains of a sequence's code after its first commands.
It has learned that of the codes of single sequences: there is none for what is farther away.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._types import Code, Motor
from motorspace.control.codes import Probe, Whitening, blank_probe, encode, examples, fit_probe
from motorspace.control.composing import Remainder, held
from motorspace.control.controller import Controller, blank_controller
from motorspace.control.learning import ControlConfig, Task, learn_remainder
from motorspace.models.model import Model
from motorspace.navigation.observations import FAR, AbstractPart, Memory, Moment, Rows
from motorspace.navigation.tasks import AbstractNavigation, Bounds
from motorspace.training.data import simulated
from motorspace.training.run import Run
from motorspace.trajectories.commands import nominal
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.scenario import Scenario
from motorspace.worlds.spaces import ContinuousCommands


class Composition(eqx.Module):
    """What a controller knows about codes that are no products."""

    remainder: Remainder
    whitening: Whitening
    probe: Probe
    commands: ContinuousCommands = eqx.field(static=True)
    horizon: int = eqx.field(static=True)


def composition(controller: Controller) -> Composition | None:
    """Returns what a controller knows about codes that are no products; None for those that are."""
    if controller.remainder is None:
        return None
    learned = controller.remainder, controller.whitening, controller.probe
    return Composition(*learned, controller.commands, controller.horizon)


class ComposedCode(AbstractPart):
    """The whitened code of what is left of the way to the goal, by a learned composition.

    A command that was blocked counts with its translation taken as 0, if the bump is sensed.
    """

    model: Model
    known: Composition
    agent: AbstractAgent
    task: AbstractNavigation

    def bounds(self, scenario: Scenario) -> Bounds:
        size = len(self.known.whitening.centre)
        return (-FAR,) * size, (FAR,) * size

    def begin(self, moment: Moment) -> Memory:
        hint = self.task.hint(moment.problem)
        if self.task.gives_displacement:
            goal = jnp.concatenate([hint, jnp.zeros_like(hint[:1])])
            return jax.vmap(self._wanted, in_axes=-1, out_axes=-1)(goal)
        still = self._white(jnp.zeros(self.known.commands.size))
        return jnp.broadcast_to(still[:, None], (len(still), moment.blocked.shape[-1]))

    def update(self, memory: Memory, moment: Moment) -> Memory:
        motor = self.agent.commands.without_translation(moment.motor, moment.blocked)
        done = jax.vmap(self._white, in_axes=-1, out_axes=-1)(motor)
        left: Rows = jax.vmap(self.known.remainder, in_axes=-1, out_axes=-1)(done, memory)
        return left

    def read(self, memory: Memory, moment: Moment) -> Rows:
        return memory

    def _wanted(self, displacement: Float[Array, "3"]) -> Code:
        return self.known.whitening(self.known.probe(displacement))

    def _white(self, motor: Motor) -> Code:
        """The whitened code of one command."""
        alone = jnp.zeros((self.known.horizon, len(motor))).at[0].set(motor)
        sequence = held(self.known.commands, alone, jnp.array(1, jnp.int32))
        return self.known.whitening(encode(self.model, sequence))


def blank_composition(
    sizes: tuple[int, int, int, int], commands: ContinuousCommands
) -> Composition:
    """What `composition_shape` described, before its weights are read."""
    size, width_size, depth, horizon = sizes
    network = eqx.nn.MLP(2 * size, size, width_size, depth, jax.nn.relu, key=jax.random.key(0))
    whitening = Whitening(jnp.zeros(size), jnp.zeros((size, size)))
    return Composition(Remainder(network), whitening, blank_probe(size), commands, horizon)


def composition_sizes(known: Composition) -> tuple[int, int, int, int]:
    """Units of a code, width and depth of the network, commands of a sequence."""
    mlp = known.remainder.mlp
    return len(known.whitening.centre), mlp.width_size, mlp.depth, known.horizon


def learn_composition(run: Run, config: ControlConfig) -> Composition:
    """Returns the composition of a run's codes, learned without the rest of its controller.

    Raises:
        UserError: As `learn_controller`.
    """
    blank = blank_controller(run, config)
    task = Task(run.model, blank.commands, blank.whitening, blank.horizon)
    label_key, key = jax.random.split(jax.random.key(config.seed))
    sizes = config.labels, blank.horizon
    labelled = eqx.filter_jit(examples)(run.model, blank.commands, sizes, key=label_key)
    agent = simulated(run.config.data).scenario().agent
    return Composition(
        learn_remainder(task, config, key=key),
        blank.whitening,
        fit_probe(nominal(agent, np.asarray(labelled.motors)), labelled.codes),
        blank.commands,
        blank.horizon,
    )
