"""What the paper's systems, the one whose codes are structured best, robots' logs and eyes set."""

from collections.abc import Mapping
from typing import Any, Literal, get_args

from motorspace._errors import UserError

PresetName = Literal["paper", "best", "log", "vision", "vision_paper"]
Settings = Mapping[str, Any]
"""{field of the configuration: value}; names are unique over its parts."""

LATTICE: Settings = {
    "epochs": 500,
    "trajectories_per_epoch": 50_000,
    "learning_rate": 2e-3,
    "curriculum": 0.0,
}
"""The paper's budget for the lattice."""

BEST: Settings = {
    "encoder": "matrix_product",
    "hidden_size": 64,
    "code_size": 6,
    "learning_rate": 4e-3,
    "curriculum": 0.1,
    "code_noise": 0.3,
    "isometry_weight": 1.0,
    "restarts": 3,
}
"""Commands as matrices that multiply, learned by prediction alone."""

LOG: Settings = {
    "encoder": "exponential",
    "code_size": 6,
    "epochs": 150,
    "learning_rate": 2e-3,
    "curriculum": 0.0,
    "isometry_weight": 1.0,
    "ema_decay": 0.99,
    "initial_weights": "scaled",
}
"""Few enough weights of the encoder for some hundred scans of a robot's log."""

EYES: Settings = {"curriculum": 0.3, "blur_weight": 1.0}
"""Views say little of long sequences, so that short ones have to teach the commands."""

VISION: Settings = {**BEST, **EYES, "restarts": 1}
"""`best` for eyes. What a restart predicts by a tenth of the epochs, on sequences of one or two
commands, says nothing of how it will end."""

PRESETS: Mapping[str, Settings] = {
    "paper": {},
    "best": BEST,
    "log": LOG,
    "vision": VISION,
    "vision_paper": EYES,
}


def preset_settings(preset: str, agent: str | None) -> Settings:
    """What a preset sets for an agent. Raises `UserError` for an unknown preset."""
    if preset not in PRESETS:
        raise UserError(
            f"there is no preset {preset!r}",
            remedy=f"choose one of {', '.join(get_args(PresetName))}",
        )
    own = LATTICE if agent == "lattice" else {}
    return {**own, **PRESETS[preset]}
