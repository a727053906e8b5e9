"""From a goal to motor commands: decode, decode and refine, or search."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Code, Key, Motors, Scalar, Sensors
from motorspace.control.codes import encode
from motorspace.control.controller import Controller
from motorspace.control.decoder import Logits, squash, unsquash
from motorspace.control.goals import METHODS, CodeGoal, DisplacementGoal, Goal, Method, SensorGoal
from motorspace.control.refine import levenberg_marquardt
from motorspace.control.search import cross_entropy, descent, shooting


@dataclass(frozen=True)
class Effort:
    """How hard each method tries."""

    guesses: int = 8
    """Sequences that the decoder, or the bank, offers."""
    starts: int = 1
    """The best of them that are refined, or descended from; the best end is kept."""
    refinements: int = 2
    """Steps of Levenberg and Marquardt."""
    shots: int = 1000
    """Sequences of random shooting."""
    generations: int = 20
    """Generations of the cross-entropy method."""
    population: int = 128
    """Sequences in each generation."""
    descent_steps: int = 50
    """Steps of gradient descent."""


USUAL = Effort()


@dataclass(frozen=True)
class Plan:
    """Motor commands that should reach a goal.

    Attributes:
        motors: The commands [T, M], the agent's units.
        code: Their code [C].
        sensors: The readings that the network expects after them [K], raw units.
        miss: How far the plan is from the goal by the network's own account: between whitened
            codes, or root mean square over scaled readings for a `SensorGoal`.
    """

    motors: Float[np.ndarray, "T M"]
    code: Float[np.ndarray, " C"]
    sensors: Float[np.ndarray, " K"]
    miss: float


class Target(NamedTuple):
    """A goal as the planner sees it."""

    residual: Callable[[Motors], Float[Array, " R"]]
    """What should be zero of a motor sequence."""
    guesses: Callable[[int, Key], Float[Array, "S T M"]]
    """So many sequences that may be near, as logits."""

    def cost(self, motors: Motors) -> Scalar:
        """The squared residual."""
        return jnp.sum(self.residual(motors) ** 2)


def code_target(controller: Controller, code: Code) -> Target:
    """Reach a code: the decoder knows where to start."""
    white = controller.whitening(code)

    def residual(motors: Motors) -> Float[Array, " R"]:
        return controller.whitening(encode(controller.model, motors)) - white

    def guesses(num: int, key: Key) -> Float[Array, "S T M"]:
        noise = jax.random.normal(key, (num, controller.decoder.noise_size))
        return jax.vmap(lambda z: controller.decoder(white, z))(noise)

    return Target(residual, guesses)


def sensor_target(controller: Controller, now: Sensors, goal: Sensors) -> Target:
    """Reach readings: those sequences of the bank are near after which they are expected."""
    model, bank = controller.model, controller.bank
    scale = jnp.array(model.scaling.sensors)

    def off(code: Code) -> Float[Array, " R"]:
        return (model.predict(now, code) - goal) / scale

    def guesses(num: int, key: Key) -> Float[Array, "S T M"]:
        del key
        costs = jax.vmap(lambda code: jnp.sum(off(code) ** 2))(bank.codes)
        nearest = jax.lax.top_k(-costs, num)[1]
        return jax.vmap(lambda m: unsquash(controller.commands, m))(bank.motors[nearest])

    return Target(lambda motors: off(encode(model, motors)), guesses)


def reach(
    controller: Controller, target: Target, method: Method, effort: Effort = USUAL, *, key: Key
) -> Motors:
    """The motor sequence [T, M] that the method finds."""
    commands, size = controller.commands, controller.horizon

    def best(logits: Float[Array, "G T M"], num: int) -> Float[Array, "S T M"]:
        costs = jax.vmap(lambda one: target.cost(squash(commands, one)))(logits)
        return logits[jax.lax.top_k(-costs, num)[1]]

    match method:
        case "amortised":
            return squash(commands, target.guesses(1, key)[0])
        case "hybrid":

            def residual(logits: Logits) -> Float[Array, " R"]:
                return target.residual(squash(commands, logits))

            starts = best(target.guesses(effort.guesses, key), effort.starts)
            steps = effort.refinements
            ends = jax.vmap(lambda one: levenberg_marquardt(residual, one, steps))(starts)
            return squash(commands, best(ends, 1)[0])
        case "descent":
            starts = best(target.guesses(effort.guesses, key), effort.starts)
            return descent(target.cost, commands, starts, effort.descent_steps)
        case "shooting":
            return shooting(target.cost, commands, (effort.shots, size), key=key)
        case "cross_entropy":
            sizes = effort.generations, effort.population, size
            return cross_entropy(target.cost, commands, sizes, key=key)


def plan(
    controller: Controller,
    sensors: Float[Any, " K"],
    goal: Goal,
    *,
    method: Method | str = "hybrid",
    effort: Effort = USUAL,
    seed: int = 0,
) -> Plan:
    """Return motor commands that should reach a goal from here.

    Args:
        controller: What `learn_controller` returned.
        sensors: The readings now [K], raw units.
        goal: A `DisplacementGoal`, a `CodeGoal` or a `SensorGoal`.
        method: `"amortised"` decodes the goal's code at once; `"hybrid"` decodes and refines;
            `"shooting"`, `"cross_entropy"` and `"descent"` search.
        effort: How hard the method tries.
        seed: Many sequences reach one goal: the seed chooses.

    Returns:
        The plan.

    Raises:
        UserError: For readings or a goal of the wrong length, a displacement that no sequence
            reaches, and an unknown method.
    """
    if method not in METHODS:
        raise UserError(
            f"there is no method {method!r}", remedy=f"choose one of {', '.join(METHODS)}"
        )
    now = _checked("the readings now", sensors, len(controller.model.scaling.sensors))
    match goal:
        case DisplacementGoal():
            _refuse_too_far(controller, goal)
            wanted = np.array([goal.longitudinal, goal.lateral, goal.turn], np.float32)
        case CodeGoal():
            wanted = _checked("the code", goal.code, len(controller.whitening.centre))
        case SensorGoal():
            wanted = _checked("the readings wanted", goal.sensors, len(now))
    # All of it is one program: a plan takes less time than a few operations by themselves.
    found = _solved(controller, (now, wanted), type(goal), method, effort, np.uint32(seed))
    motors, reached, expected, miss = map(np.asarray, found)
    return Plan(motors, reached, expected, float(miss))


def _refuse_too_far(controller: Controller, goal: DisplacementGoal) -> None:
    scale, channels = controller.commands.scale, controller.commands.translating
    farthest = controller.horizon * math.hypot(*(scale[channel] for channel in channels))
    if channels and math.hypot(goal.longitudinal, goal.lateral) > farthest:
        raise UserError(
            f"no sequence of {controller.horizon} commands leads farther than {farthest:.3g} units",
            remedy="follow the goal in several sequences, with ms.follow",
        )


def _checked(what: str, values: Any, size: int) -> Float[np.ndarray, " D"]:
    array = np.asarray(values, np.float32)
    if array.shape != (size,):
        raise UserError(f"{what} must be {size} numbers, got an array of shape {array.shape}")
    if not np.isfinite(array).all():
        raise UserError(f"{what} must be finite")
    return array


@eqx.filter_jit
def _solved(
    controller: Controller,
    given: tuple[Any, Any],
    kind: type[Goal],
    method: Method,
    effort: Effort,
    seed: Any,
) -> tuple[Array, ...]:
    now, wanted = given
    if kind is SensorGoal:
        target = sensor_target(controller, now, wanted)
    else:
        code = controller.probe(wanted) if kind is DisplacementGoal else wanted
        target = code_target(controller, code)
    motors = reach(controller, target, method, effort, key=jax.random.key(seed))
    code = encode(controller.model, motors)
    miss = jnp.sqrt(jnp.mean(target.residual(motors) ** 2))
    return motors, code, controller.model.predict(now, code), miss
