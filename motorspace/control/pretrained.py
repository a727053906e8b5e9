"""Networks and controllers that come with the package, ready to act."""

from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from motorspace._errors import UserError
from motorspace.control.controller import Controller
from motorspace.control.store import load_controller
from motorspace.training.run import Run, load_run

CARD = "README.md"


class Pretrained(NamedTuple):
    """A run that comes with the package, and its controller."""

    run: Run
    """The network and what determined it."""
    controller: Controller
    """What it needs to act."""
    card: str
    """Where it comes from, how good it is, and what it cannot do."""


def pretrained_names() -> list[str]:
    """The names that `load_pretrained` knows, in order."""
    return sorted(path.parent.name for path in _home().glob(f"*/{CARD}"))


def load_pretrained(name: str) -> Pretrained:
    """Return a network that comes with the package, with its controller and its card.

    Args:
        name: One of `pretrained_names()`, such as `"forward-0.4pi"`.

    Raises:
        UserError: For an unknown name, naming the nearest one.

    Example:
        >>> load_pretrained("forward-0.4pi").controller.horizon
        6
    """
    known = pretrained_names()
    if name not in known:
        near = get_close_matches(name, known, 1)
        raise UserError(
            f"there is no pretrained network {name!r}",
            remedy=f"perhaps {near[0]!r}" if near else f"choose one of {', '.join(known)}",
        )
    folder = _home() / name
    return Pretrained(load_run(folder), load_controller(folder), (folder / CARD).read_text())


def _home() -> Path:
    return Path(str(files("motorspace"))) / "pretrained"
