"""The folder of a policy: what determined it, its networks, and what it was measured at.

```
FOLDER/config.json         the configuration, and what the network behind observed codes is
FOLDER/policy.safetensors  the policy, and that network
FOLDER/log.jsonl           one record for every few updates
FOLDER/evaluation.json     what `motorspace navigate evaluate` measured
```
"""

import json
from pathlib import Path
from typing import Any

import jax

from motorspace._errors import UserError
from motorspace._files import locked, write_atomically, write_json
from motorspace.models.model import Scaling
from motorspace.navigation.arenas import Codes
from motorspace.navigation.coded import blank_code_commands, code_command_sizes
from motorspace.navigation.composed import blank_composition, composition_sizes
from motorspace.navigation.config import NavigationConfig, navigation_from_json
from motorspace.navigation.learning import TrainedPolicy
from motorspace.navigation.policies import Policy
from motorspace.training.checkpoint import packed, unpacked
from motorspace.training.config import RunConfig, config_from_json
from motorspace.training.data import simulated
from motorspace.training.fit import init
from motorspace.training.folder import read_log
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.catalog import AGENTS
from motorspace.worlds.spaces import ContinuousCommands

FORMAT_VERSION = 1

CONFIG, POLICY, LOG = "config.json", "policy.safetensors", "log.jsonl"
EVALUATION = "evaluation.json"


def save_policy(trained: TrainedPolicy, folder: str | Path) -> None:
    """Write a policy, whole, into a folder of its own.

    Args:
        trained: The policy.
        folder: Where to; it may exist, and must hold no policy.

    Raises:
        UserError: Where the folder holds a policy already or cannot be written.
    """
    folder = Path(folder)
    with locked(folder):
        refuse_used(folder)
        lines = "".join(json.dumps(record) + "\n" for record in trained.log)
        write_atomically(folder / LOG, lines.encode())
        write_atomically(folder / POLICY, packed((trained.policy, trained.codes)))
        write_json(folder / CONFIG, _described(trained))


def refuse_used(folder: Path) -> None:
    """Raise `UserError` where a folder holds a policy."""
    if (folder / CONFIG).exists():
        raise UserError(
            "the folder already holds a policy or a run",
            where=folder,
            remedy="choose another folder",
        )


def load_policy(folder: str | Path) -> TrainedPolicy:
    """Return the policy in a folder that `motorspace navigate train` has filled.

    Args:
        folder: The folder.

    Raises:
        UserError: Where there is no policy, or it is broken.
    """
    folder = Path(folder)
    written = _read(folder / CONFIG, folder)
    config = navigation_from_json(written["config"], where=folder / CONFIG)
    network, where = written["network"], folder / CONFIG
    found = None if network is None else config_from_json(network["config"], where=where)
    agent = AGENTS.build(config.agent)
    codes = None if found is None else _blank(found, network, agent)
    actions = agent.commands.size
    if config.act == "codes" and codes is not None and codes.code_commands is not None:
        actions = codes.code_commands.size
    policy = Policy(config.policy, written["observation_size"], actions, key=jax.random.key(0))
    policy, codes = unpacked((policy, codes), folder / POLICY)
    return TrainedPolicy(config, policy, codes, found, tuple(read_log(folder)))


def config_of(folder: Path) -> NavigationConfig:
    """The configuration of the policy in a folder. Raises `UserError` where there is none."""
    return navigation_from_json(_read(folder / CONFIG, folder)["config"], where=folder / CONFIG)


def _described(trained: TrainedPolicy) -> dict[str, Any]:
    described: dict[str, Any] | None = None
    if trained.codes is not None and trained.network is not None:
        scaling = trained.codes.trained.scaling
        described = {
            "config": trained.network.as_json(),
            "sensors": list(scaling.sensors),
            "motors": list(scaling.motors),
        }
        codes, parts = trained.codes, dict[str, tuple[int, ...]]()
        if codes.code_commands is not None:
            parts["code_commands"] = code_command_sizes(codes.code_commands)
        if codes.composition is not None:
            parts["composition"] = composition_sizes(codes.composition)
        described["controller"] = parts
    return {
        "format_version": FORMAT_VERSION,
        "config": trained.config.as_json(),
        "observation_size": len(trained.policy.offset),
        "network": described,
    }


def _blank(network: RunConfig, described: dict[str, Any], agent: AbstractAgent) -> Codes:
    """Networks of the right shape, whose weights are to be read."""
    scaling = Scaling(tuple(described["sensors"]), tuple(described["motors"]))
    model = init(network, scaling, horizon=simulated(network.data).horizon).selected
    parts, commands = described["controller"], agent.commands
    assert isinstance(commands, ContinuousCommands), "no policy has learned to jump among nodes"
    acting, composing = (parts.get(name) for name in ("code_commands", "composition"))
    return Codes(
        model,
        model,
        acting and blank_code_commands(tuple(acting), commands),
        composing and blank_composition(tuple(composing), commands),
    )


def _read(path: Path, folder: Path) -> dict[str, Any]:
    try:
        written: dict[str, Any] = json.loads(path.read_bytes())
        if written["format_version"] != FORMAT_VERSION or "observation_size" not in written:
            raise ValueError
        return written
    except (FileNotFoundError, NotADirectoryError):
        raise UserError(
            "there is no policy here",
            where=folder,
            remedy="give a folder made by motorspace navigate train",
        ) from None
    except (OSError, ValueError, KeyError, TypeError):
        raise UserError(
            "this is no policy, or one of another version",
            where=folder,
            remedy="give a folder made by motorspace navigate train",
        ) from None
