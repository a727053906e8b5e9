"""How a network is fitted, as a compiled program takes it: numbers are arguments."""

import equinox as eqx
import jax.numpy as jnp
import optax

from motorspace._types import Count, Scalar
from motorspace.training.config import Precision, TrainingConfig


class Recipe(eqx.Module):
    """A `TrainingConfig`, split into what makes a program and what a program is given.

    Runs whose static fields are equal, and that have the same numbers at all, are one program.
    """

    num_updates: int = eqx.field(static=True)
    """Updates of an epoch."""
    batch_size: int = eqx.field(static=True)
    """Transitions of an update."""
    total_updates: int = eqx.field(static=True)
    """Updates of the whole run."""
    cosine: bool = eqx.field(static=True)
    """Whether the learning rate follows a cosine; it is constant otherwise."""
    train_encoder: bool = eqx.field(static=True)
    precision: Precision = eqx.field(static=True)
    view: tuple[int, ...] = eqx.field(static=True)
    """How the sensors are arranged, where they are blurred."""
    learning_rate: Scalar
    """The peak."""
    curriculum_epochs: Count
    """Epochs in which the longest trajectory still grows."""
    weights: dict[str, Scalar]
    """The weight of every loss beside the prediction loss that has one."""
    code_noise: Scalar | None
    ema_decay: Scalar | None

    @classmethod
    def of(cls, config: TrainingConfig, view: tuple[int, ...] = ()) -> "Recipe":
        """The recipe of a configuration; what is 0 there is left out of the program.

        `view` is how the sensors are arranged, which matters where these are blurred.
        """
        weights = {n: jnp.float32(weight) for n, weight in config.weights.items() if weight > 0}
        return cls(
            num_updates=config.num_updates,
            batch_size=config.batch_size,
            total_updates=config.epochs * config.num_updates,
            cosine=config.schedule == "cosine",
            train_encoder=config.train_encoder,
            precision=config.precision,
            view=view if "blur" in weights else (),
            learning_rate=jnp.float32(config.learning_rate),
            curriculum_epochs=jnp.int32(config.curriculum_epochs),
            weights=weights,
            code_noise=jnp.float32(config.code_noise) if config.code_noise > 0 else None,
            ema_decay=jnp.float32(config.ema_decay) if config.ema_decay > 0 else None,
        )

    @property
    def optimiser(self) -> optax.GradientTransformation:
        """Adam with the schedule."""
        if not self.cosine:
            return optax.adam(self.learning_rate)
        warm_up = max(1, self.total_updates // 100)
        shape = optax.warmup_cosine_decay_schedule(
            0.0, 1.0, warm_up, max(self.total_updates, warm_up + 1)
        )
        return optax.adam(lambda count: self.learning_rate * shape(count))
