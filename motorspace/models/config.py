"""The network as data, and the encoders there are."""

from dataclasses import dataclass
from typing import Any, Literal, get_args, get_type_hints

from motorspace._kinds import Builtin, Registry
from motorspace.worlds.checks import one_of, whole

_ROOM = "motorspace.models.encoders"

ENCODERS: Registry[Any] = Registry(
    "encoder",
    {
        "lstm": Builtin(f"{_ROOM}.recurrent", "LSTMEncoder"),
        "gru": Builtin(f"{_ROOM}.recurrent", "GRUEncoder"),
        "linear": Builtin(f"{_ROOM}.recurrent", "LinearRecurrentEncoder"),
        "attention": Builtin(f"{_ROOM}.attention", "AttentionEncoder"),
        "matrix_product": Builtin(f"{_ROOM}.matrix_product", "MatrixProductEncoder"),
        "exponential": Builtin(f"{_ROOM}.exponential", "ExponentialEncoder"),
        "sum": Builtin(f"{_ROOM}.baselines", "SumEncoder"),
        "mlp": Builtin(f"{_ROOM}.baselines", "FlatEncoder"),
        "none": Builtin(f"{_ROOM}.baselines", "ConstantEncoder"),
        "identity": Builtin(f"{_ROOM}.baselines", "IdentityEncoder"),
    },
)


@dataclass(frozen=True)
class ModelConfig:
    """Sizes and kinds of the network's parts; the defaults are the paper's."""

    encoder: str = "lstm"
    """Encoder of the motor sequence: lstm (the paper), gru, linear (a state space), attention,
    matrix_product (commands as matrices that multiply), exponential (the same with commands that
    add up in an exponent), sum, mlp, none or identity."""
    hidden_size: int = 100
    """Units of the recurrent layer, or of the encoder's hidden layers."""
    code_size: int = 50
    """Units of the code h^m."""
    width_size: int = 200
    """Units of each ReLU layer of the predictor."""
    depth: int = 3
    """ReLU layers of the predictor."""
    motor_scaling: Literal["raw", "maximum"] = "raw"
    """Commands as they are (radians, world units), or divided by their largest magnitude."""
    initial_weights: Literal["normal_inputs", "scaled", "uniform"] = "normal_inputs"
    """normal_inputs: input weights of about one per radian, so that full turns can fold, the rest
    scaled; scaled: variance-preserving; uniform: within 1 / sqrt(inputs), the plain recipe."""

    def __post_init__(self) -> None:
        ENCODERS.check(self.encoder)
        for name in ("hidden_size", "code_size", "width_size", "depth"):
            whole(name, getattr(self, name))
        for name in ("motor_scaling", "initial_weights"):
            one_of(name, getattr(self, name), get_args(get_type_hints(ModelConfig)[name]))
