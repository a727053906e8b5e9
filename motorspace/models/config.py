"""The network as data."""

from dataclasses import dataclass
from typing import Literal

from motorspace.models.encoder import EncoderName


@dataclass(frozen=True)
class ModelConfig:
    """Sizes and kinds of the network's parts; the defaults are the paper's."""

    encoder: EncoderName = "lstm"
    """How the motor sequence is encoded: lstm (the paper), gru, linear (a state space),
    attention, group (commands as matrices that multiply), sum, mlp, none or identity."""
    hidden_size: int = 100
    """Units of the recurrent layer, or of the encoder's hidden layers."""
    code_size: int = 50
    """Units of the code h^m."""
    width_size: int = 200
    """Units of each ReLU layer of the predictor."""
    depth: int = 3
    """ReLU layers of the predictor."""
    inverse_weight: float = 0.0
    """Weight of the inverse model's loss; 0 leaves it out."""
    slowness_weight: float = 0.0
    """Weight of the slowness of the code, which the paper does not have; 0 leaves it out."""
    composition_weight: float = 0.0
    """Weight of telling the code of a sequence from those of its halves, which the paper does not
    have; 0 leaves it out."""
    isometry_weight: float = 0.0
    """Weight of commands that keep lengths, of the encoder group alone; it grows from 0 once the
    curriculum is over. The paper does not have it; 0 leaves it out."""
    train_encoder: bool = True
    """False leaves the encoder at its initial weights: a reference for what training adds."""
    motor_scaling: Literal["raw", "maximum"] = "raw"
    """Commands as they are (radians, world units), or divided by their largest magnitude."""
    initial_weights: Literal["wide", "scaled", "uniform"] = "wide"
    """wide: input weights of about one per radian, so that turns fold, the rest scaled;
    scaled: variance-preserving; uniform: within 1 / sqrt(inputs), the plain recipe."""
