"""Where the goal is, in the space that an encoder has learned: a product of its matrices.

An encoder whose codes are products of matrices says of each command m what it does to all that
follows: A(m). After the commands m_1 ... m_t, what was G when the agent started is
A(m_t)^-1 ... A(m_1)^-1 G seen from where it is. G is the identity for the start itself. No position
is sensed and no displacement is known.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Key, Motor, Pose
from motorspace.models.model import Model
from motorspace.navigation.observations import FAR, AbstractPart, Memory, Moment, Rows
from motorspace.navigation.tasks import AbstractNavigation, Bounds, body
from motorspace.se2 import relative
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.scenario import Scenario

Matrices = Float[Array, "n n N"]
"""A matrix for each agent; its last row is (0 ... 0 1)."""

NUM_LABELS = 50
"""Walks whose displacement is told, for the map from displacements to matrices."""

WALK = 12
"""Commands of each of them."""


class ChainedCode(AbstractPart):
    """The goal, seen from here, by the products of an encoder's matrices.

    A command that was blocked counts with its translation taken as 0, if the bump is sensed.
    """

    model: Model
    agent: AbstractAgent
    task: AbstractNavigation
    probe: Float[Array, "F C"] | None
    """From a displacement as `features` to the first n - 1 rows of its matrix."""

    def bounds(self, scenario: Scenario) -> Bounds:
        size = len(self._unit) * (len(self._unit) - 1)
        return (-FAR,) * size, (FAR,) * size

    def begin(self, moment: Moment) -> Memory:
        num = moment.blocked.shape[-1]
        unit = jnp.broadcast_to(self._unit[..., None], (*self._unit.shape, num))
        hint = self.task.hint(moment.problem)
        if self.probe is None:
            return unit
        code = self.probe.T @ features(hint[0], hint[1], jnp.zeros(num))
        return unit.at[:-1].set(code.reshape(-1, len(unit), num))

    def update(self, memory: Memory, moment: Moment) -> Memory:
        motor = self.agent.commands.without_translation(moment.motor, moment.blocked)
        return multiplied(inverted(command_matrices(self.model, motor)), memory)

    def read(self, memory: Memory, moment: Moment) -> Rows:
        return memory[:-1].reshape(-1, memory.shape[-1])

    @property
    def _unit(self) -> Float[Array, "n n"]:
        motor = jnp.zeros((self.agent.commands.size, 1))
        return jnp.eye(len(command_matrices(self.model, motor)))


def chained_code(
    model: Model, agent: AbstractAgent, task: AbstractNavigation, *, key: Key
) -> ChainedCode:
    """The part of an observation that a network's codes make.

    For a goal that is given as a displacement, an affine map from displacements to matrices is
    fitted to `NUM_LABELS` walks in free space.

    Raises:
        UserError: For an encoder whose codes are no products of matrices, and for a network of
            another agent.
    """
    if len(model.scaling.motors) != agent.commands.size:
        raise UserError(
            f"the run's commands have {len(model.scaling.motors)} channels, and those of a"
            f" {type(agent).__name__} have {agent.commands.size}",
            remedy="give the run of such an agent",
        )
    if model.encoder.matrices(jnp.zeros(agent.commands.size)) is None:
        raise UserError(
            "the codes of this run are no products of matrices, so they cannot be chained",
            remedy="give a run of the preset best",
        )
    probe = fitted_probe(model, agent, key=key) if task.gives_displacement else None
    return ChainedCode(model, agent, task, probe)


@eqx.filter_jit
def fitted_probe(
    model: Model, agent: AbstractAgent, *, num: int = NUM_LABELS, key: Key
) -> Float[Array, "F C"]:
    """The least-squares map from the displacement of a walk to the matrix of its commands."""
    keys = jax.random.split(key, (WALK, num))
    sample = jax.vmap(jax.vmap(lambda key: agent.commands.sample(key=key), out_axes=-1))
    motors = sample(keys)
    start = Pose(*jnp.zeros((4, num)))

    def advance(now: tuple[Pose, Matrices], motor: Motor) -> tuple[tuple[Pose, Matrices], None]:
        pose, product = now
        return (
            agent.move(pose, motor)[-1],
            multiplied(product, command_matrices(model, motor)),
        ), None

    unit = jnp.eye(len(command_matrices(model, motors[0])))
    first = (start, jnp.broadcast_to(unit[..., None], (*unit.shape, num)))
    (end, product), _ = jax.lax.scan(advance, first, motors)
    inputs = features(*relative(body(start), body(end)))
    codes = product[:-1].reshape(-1, num)
    return jnp.linalg.lstsq(inputs.T, codes.T)[0]


def features(
    longitudinal: Float[Array, " N"], lateral: Float[Array, " N"], turn: Float[Array, " N"]
) -> Float[Array, "5 N"]:
    """A displacement as what the probe is linear in."""
    ones = jnp.ones_like(turn)
    return jnp.stack([longitudinal, lateral, jnp.cos(turn), jnp.sin(turn), ones])


def command_matrices(model: Model, motor: Float[Array, "M N"]) -> Matrices:
    """A of each agent's command, in raw units."""
    scale = np.asarray(model.scaling.motors, np.float32)

    def one(motor: Motor) -> Float[Array, "n n"]:
        found = model.encoder.matrices(motor / scale)
        assert found is not None, "checked before"
        return found[0]

    return jax.vmap(one, in_axes=-1, out_axes=-1)(motor)


def multiplied(left: Matrices, right: Matrices) -> Matrices:
    """left @ right for each agent."""
    return jnp.sum(left[:, :, None] * right[None, :, :], axis=1)


def inverted(matrices: Matrices) -> Matrices:
    """The inverse for each agent."""
    if len(matrices) != 3:
        return jnp.moveaxis(jnp.linalg.inv(jnp.moveaxis(matrices, -1, 0)), 0, -1)
    (a, b, x), (c, d, y), last = matrices
    scale = 1 / (a * d - b * c)[None]
    first = jnp.stack([d, -b, b * y - d * x]) * scale
    second = jnp.stack([-c, a, c * x - a * y]) * scale
    return jnp.stack([first, second, last])
