"""Codes as actions: a policy chooses a code, and a controller's decoder makes commands of it."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._types import Flags, Key, Motors
from motorspace.control.codes import Whitening
from motorspace.control.controller import Controller
from motorspace.control.decoder import Decoder, squash
from motorspace.navigation.arena import Arena, State
from motorspace.navigation.interface import Step
from motorspace.worlds.simulation import select, to_rows
from motorspace.worlds.spaces import ContinuousCommands

SPREAD = 2.0
"""Standard deviations of random codes that an action of 1 stands for, in each direction."""


class CodeCommands(eqx.Module):
    """The commands that have a code; the code is an action in [-1, 1] for each direction.

    The directions are those in which the codes of random sequences vary independently.
    """

    decoder: Decoder
    weights: Float[Array, "C C"]
    """From an action to the whitened code that the decoder takes."""
    offset: Float[Array, " C"]
    commands: ContinuousCommands = eqx.field(static=True)

    def __call__(self, action: Float[Array, " C"]) -> Motors:
        """The commands [T, M] of one action."""
        white = self.weights @ jnp.clip(action, -1.0, 1.0) + self.offset
        return squash(self.commands, self.decoder(white, jnp.zeros(self.decoder.noise_size)))

    @property
    def size(self) -> int:
        """Channels of an action (C)."""
        return len(self.offset)

    @property
    def horizon(self) -> int:
        """Commands of an action (T)."""
        return self.decoder.horizon


def code_commands(controller: Controller, space: Whitening | None = None) -> CodeCommands:
    """Returns what turns actions into the commands of a controller's body.

    Args:
        controller: The body's own.
        space: The whitened codes that the actions are taken from, if they are not the body's own:
            a policy keeps its actions in another body, whose codes mean the same.
    """
    own = controller.whitening
    space = own if space is None else space
    weights = own.weights @ jnp.linalg.inv(space.weights)
    offset = own.weights @ (space.centre - own.centre)
    return CodeCommands(controller.decoder, SPREAD * weights, offset, controller.commands)


class InCodes(eqx.Module):
    """An arena whose actions are codes.

    The commands of a code are carried out one after the other. A bump that is sensed ends the
    sequence, and so do the end of the episode and the end of the wander.
    """

    arena: Arena
    code_commands: CodeCommands

    @property
    def num_agents(self) -> int:
        """How many agents there are (N)."""
        return self.arena.num_agents

    @property
    def action_size(self) -> int:
        """Channels of an action (C)."""
        return self.code_commands.size

    @property
    def commands_per_action(self) -> int:
        """Commands that an action makes (T)."""
        return self.code_commands.horizon

    def begin(self, *, key: Key) -> State:
        """Every agent at the start of a random one of its problems."""
        return self.arena.begin(key=key)

    def observed(self, state: State) -> Float[Array, "N O"]:
        """What each agent observes now."""
        return self.arena.observed(state)

    def step(self, state: State, action: Float[Array, "N C"], *, key: Key) -> tuple[State, Step]:
        """What comes of the commands of one code of each agent; who has ended begins anew."""
        sequences = jnp.moveaxis(jax.vmap(self.code_commands)(action), 0, -1)
        acting = state.steps >= state.problem.num_wander
        nobody = jnp.zeros_like(acting)
        first = _Course(state, ~nobody, state.walked * 0.0, nobody, nobody)
        done = jax.lax.scan(lambda *given: self._command(*given), first, sequences)[0]
        then = self.arena.anew(done.state, done.terminated | done.truncated, key=key)
        return then, Step(
            to_rows(done.state.observation),
            to_rows(then.observation),
            done.reward,
            done.terminated,
            done.truncated,
            acting,
        )

    def _command(self, now: "_Course", motor: Float[Array, "M N"]) -> tuple["_Course", None]:
        after, outcome = self.arena.advance(now.state, motor)
        begins = ~outcome.acted & (after.steps == after.problem.num_wander)
        terminated = now.terminated | now.live & outcome.terminated
        truncated = now.truncated | now.live & outcome.truncated
        stops = outcome.acted & after.bumped | begins | terminated | truncated
        return _Course(
            select(now.live, after, now.state),
            now.live & ~stops,
            now.reward + jnp.where(now.live, outcome.reward, 0.0),
            terminated,
            truncated,
        ), None


class _Course(NamedTuple):
    """How far agents have come with the commands of a code."""

    state: State
    live: Flags
    """Whether the next command will be carried out."""
    reward: Float[Array, " N"]
    terminated: Flags
    truncated: Flags


def blank_code_commands(
    sizes: tuple[int, int, int, int, int], commands: ContinuousCommands
) -> CodeCommands:
    """What `code_command_sizes` described, before its weights are read."""
    size, horizon, noise_size, width_size, depth = sizes
    decoder = Decoder(
        (size, horizon, commands.size),
        noise_size,
        width_size=width_size,
        depth=depth,
        key=jax.random.key(0),
    )
    return CodeCommands(decoder, jnp.zeros((size, size)), jnp.zeros(size), commands)


def code_command_sizes(made: CodeCommands) -> tuple[int, int, int, int, int]:
    """Units of a code, commands, numbers of noise, width and depth of the network."""
    decoder = made.decoder
    return made.size, made.horizon, decoder.noise_size, decoder.mlp.width_size, decoder.mlp.depth
