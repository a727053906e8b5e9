"""A network whose codes are the displacements themselves, so that right answers are known."""

import jax
import jax.numpy as jnp
import numpy as np

from motorspace.control.codes import examples, fit_probe, whitening
from motorspace.control.controller import Controller
from motorspace.control.learning import ControlConfig
from motorspace.models.encoders.base import AbstractMotorEncoder
from motorspace.models.model import Model, Scaling
from motorspace.models.predictors import SensorPredictor
from motorspace.trajectories.commands import nominal
from motorspace.worlds.agents import ForwardAgent

HORIZON = 3
AGENT = ForwardAgent(max_rotation=1.0)
CONFIG = ControlConfig(updates=40, batch_size=32, width_size=32, depth=2, noise_size=2, bank=256)


class Exact(AbstractMotorEncoder):
    """The product of the forward agent's displacements as matrices, without its last row."""

    def __call__(self, motors, num_steps):
        product = jnp.eye(3)
        for step, motor in enumerate(motors):
            product = jnp.where(step < num_steps, product @ self.matrices(motor)[0], product)
        return product[:-1].reshape(-1)

    def matrices(self, motor):
        cos, sin = jnp.cos(motor[0]), jnp.sin(motor[0])
        rows = [[cos, -sin, cos * motor[1]], [sin, cos, sin * motor[1]], [0.0, 0.0, 1.0]]
        return jnp.array(rows, jnp.float32), jnp.eye(3)


def model() -> Model:
    """The network; its predictor has learned nothing."""
    predictor = SensorPredictor(9, 6, 8, 1, key=jax.random.key(0))
    return Model(Exact(), predictor, None, Scaling((10.0,) * 9, (1.0, 1.0)))


def controller(agent: ForwardAgent = AGENT, horizon: int = HORIZON) -> Controller:
    """A controller whose decoder has learned nothing yet."""
    size = CONFIG.bank, horizon
    bank = examples(model(), agent.commands, size, key=jax.random.key(1))
    few = jax.tree.map(lambda leaf: leaf[: CONFIG.labels], bank)
    return Controller(
        model(),
        CONFIG.decoder((6, horizon, 2), key=jax.random.key(2)),
        whitening(bank.codes),
        fit_probe(nominal(agent, np.asarray(few.motors)), few.codes),
        bank,
        agent.commands,
    )
