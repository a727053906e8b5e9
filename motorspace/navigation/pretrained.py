"""Networks, controllers and policies that come with the package, ready to act.

```
NAME/policy.json         the configuration of the policy
NAME/policy.safetensors  its weights; the codes that it observes are those of the run beside it
```
"""

import json
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

import jax

from motorspace._errors import UserError
from motorspace._files import write_atomically, write_json
from motorspace.control.controller import Controller
from motorspace.control.store import load_controller
from motorspace.navigation.arenas import Codes
from motorspace.navigation.config import navigation_from_json
from motorspace.navigation.learning import TrainedPolicy
from motorspace.navigation.policies import Policy
from motorspace.training.checkpoint import packed, unpacked
from motorspace.training.run import Run, load_run
from motorspace.worlds.catalog import AGENTS

CARD, POLICY, POLICY_WEIGHTS = "README.md", "policy.json", "policy.safetensors"


class Pretrained(NamedTuple):
    """A run that comes with the package, its controller and a policy."""

    run: Run
    """The network and what determined it."""
    controller: Controller
    """What it needs to act."""
    card: str
    """Where it comes from, how good it is, and what it cannot do."""
    policy: TrainedPolicy
    """It finds home by what it senses and the chained code."""


def pretrained_names() -> list[str]:
    """The names that `load_pretrained` knows, in order."""
    return sorted(path.parent.name for path in _home().glob(f"*/{CARD}"))


def load_pretrained(name: str) -> Pretrained:
    """Return a network that comes with the package, with its controller, a policy and its card.

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
    run, card = load_run(folder), (folder / CARD).read_text()
    return Pretrained(run, load_controller(folder), card, _load_policy(folder, run))


def store_policy(trained: TrainedPolicy, folder: Path) -> None:
    """Write a policy beside the run whose codes it observes."""
    described = {
        "config": trained.config.as_json(),
        "observation_size": len(trained.policy.offset),
    }
    write_atomically(folder / POLICY_WEIGHTS, packed(trained.policy))
    write_json(folder / POLICY, described)


def _load_policy(folder: Path, run: Run) -> TrainedPolicy:
    written = json.loads((folder / POLICY).read_bytes())
    config = navigation_from_json(written["config"], where=folder / POLICY)
    actions = AGENTS.build(config.agent).commands.size
    blank = Policy(config.policy, written["observation_size"], actions, key=jax.random.key(0))
    policy = unpacked(blank, folder / POLICY_WEIGHTS)
    # None of them observes codes of an untrained network.
    return TrainedPolicy(config, policy, Codes(run.model, run.model), run.config)


def _home() -> Path:
    return Path(str(files("motorspace"))) / "pretrained"
