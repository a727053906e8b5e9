"""`motorspace navigate`."""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

from motorspace._errors import UserError
from motorspace._files import write_json
from motorspace._kinds import Part, parameters_of
from motorspace.cli.parsing import CommandParser, Usage, count, note, seed
from motorspace.cli.show import show
from motorspace.navigation.config import (
    PARTS,
    TASKS,
    NavigationConfig,
    PolicyConfig,
    PPOConfig,
)
from motorspace.training import folder as run_folder
from motorspace.training.data import simulated
from motorspace.worlds.catalog import AGENTS

SETTINGS = ("act", "level", "reward", "sense_blocked", "max_steps", "num_layouts", "steps", "seed")
"""Fields of the configuration that are flags as they are."""


class Action(NamedTuple):
    """What can be done with a policy."""

    configure: Callable[[CommandParser], None]
    run: Callable[[argparse.Namespace], None]
    help: str


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command, which depend on its first word."""
    described = "; ".join(f"{name}: {action.help}" for name, action in ACTIONS.items())
    parser.add_argument("action", metavar="ACTION", choices=tuple(ACTIONS), help=described + ".")
    if words and words[0] in ACTIONS:
        ACTIONS[words[0]].configure(parser)


def run(options: argparse.Namespace) -> None:
    """Train, measure or watch a policy."""
    ACTIONS[options.action].run(options)


def _train_flags(parser: CommandParser) -> None:
    add = parser.add_argument
    add("task", choices=TASKS, metavar="TASK", help=f"What to learn: {', '.join(TASKS)}.")
    add(
        "--run",
        type=Path,
        default=None,
        metavar="RUN",
        help="The folder of a run: its body and sensor, and its network for chained codes.",
    )
    add("--agent", default=None, metavar="AGENT", help="The body, where no run is given.")
    add(
        "--observe",
        nargs="+",
        choices=PARTS,
        metavar="PART",
        default=None,
        help=f"What is observed: {', '.join(PARTS)} (default: ranges bump command).",
    )
    add("--out", type=Path, default=None, metavar="FOLDER", help="Folder of the policy.")
    known = {parameter.name: parameter for parameter in parameters_of(NavigationConfig)}
    parser.add_parameters("task", [known[name] for name in SETTINGS])
    parser.add_parameters("policy", parameters_of(PolicyConfig))
    parser.add_parameters("learner", parameters_of(PPOConfig))


def _train(options: argparse.Namespace) -> None:
    config = _config(options)
    folder = options.out or Path("runs") / f"navigate-{config.task}-{config.seed}"
    if (folder / run_folder.CONFIG).exists():
        raise UserError(
            "the folder already holds a policy or a run",
            where=folder,
            remedy="choose another folder",
        )
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    from motorspace.navigation.folder import save_policy
    from motorspace.navigation.learning import learn_policy

    save_policy(learn_policy(config, options.run, callback=_progress(config)), folder)
    print(f"finished: {folder}; measure it with: motorspace navigate evaluate {folder}")


def _config(options: argparse.Namespace) -> NavigationConfig:
    """The configuration that the flags describe, known to fit before anything heavy is loaded."""
    given = vars(options)
    parts = _parts(options)
    if options.observe is not None:
        parts["observe"] = tuple(options.observe)
    nested = {
        name: kind(**{f.name: given[f.name] for f in fields(kind) if f.name in given})
        for name, kind in (("policy", PolicyConfig), ("ppo", PPOConfig))
    }
    settings = {name: given[name] for name in SETTINGS if name in given}
    config = NavigationConfig(**{"task": options.task} | parts | nested | settings)
    if config.needs_run and options.run is None:
        raise Usage("a code is computed by a trained network", remedy="give its folder with --run")
    return config


def _parts(options: argparse.Namespace) -> dict[str, Any]:
    """The body and its sensor: those of the run, or the kind that is named."""
    if options.run is None:
        return {} if options.agent is None else {"agent": AGENTS.part(options.agent)}
    data = simulated(run_folder.load_config(options.run).data)
    agent, sensor = data.agent, data.sensor
    assert isinstance(agent, Part) and isinstance(sensor, Part), "as configurations hold them"
    if options.agent not in (None, agent.kind):
        raise UserError(
            f"the run's body is a {agent.kind} agent, not a {options.agent} one",
            where=options.run,
            remedy="leave out --agent, or give the run of such an agent",
        )
    if not run_folder.finished(options.run):
        raise UserError(
            "this run is not finished", where=options.run, remedy="continue it with --resume"
        )
    return {"agent": agent, "sensor": sensor}


def _progress(config: NavigationConfig) -> Callable[[dict[str, float | int]], None]:
    """A line about every tenth of the steps."""
    shown = 0.0

    def callback(record: dict[str, float | int]) -> None:
        nonlocal shown
        if record["steps"] >= shown:
            shown = record["steps"] + config.steps / 10
            print(
                f"{record['steps']:>10,} steps, success {record['success']:.3f},"
                f" reward {record['reward']:.4f}",
                flush=True,
            )

    return callback


def _evaluate_flags(parser: CommandParser) -> None:
    add = parser.add_argument
    add("folder", type=Path, metavar="FOLDER", help="The policy's folder.")
    add(
        "--num",
        type=count,
        default=2048,
        metavar="N",
        help="Problems in seen layouts, and as many in unseen ones (default: 2048).",
    )
    _add_greedy(parser)
    add("--json", action="store_true", default=False, help="Print the results as JSON.")


def _evaluate(options: argparse.Namespace) -> None:
    _check_policy(options.folder)
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    from motorspace.navigation.folder import EVALUATION, load_policy
    from motorspace.navigation.measuring import evaluate_policy

    trained = load_policy(options.folder)
    found = evaluate_policy(trained, num=options.num, sampled=not options.greedy)
    show(found, as_json=options.json)
    try:
        write_json(options.folder / EVALUATION, found)
    except UserError as error:
        note(f"the results are not kept: {error}")


def _watch_flags(parser: CommandParser) -> None:
    add = parser.add_argument
    add("folder", type=Path, metavar="FOLDER", help="The policy's folder.")
    add("--out", type=Path, default=None, metavar="FILE", help="The GIF (default: in the folder).")
    add("--num", type=count, default=4, metavar="N", help="Episodes to show (default: 4).")
    add(
        "--goal",
        type=float,
        nargs="+",
        default=None,
        metavar="X",
        help="A goal: LONGITUDINAL LATERAL from the start, or X Y HEADING for a sensor goal.",
    )
    add("--seen", action="store_true", default=False, help="In layouts of training.")
    add("--seed", type=seed, default=0, metavar="N", help="The seed of the problems (default: 0).")
    _add_greedy(parser)


def _watch(options: argparse.Namespace) -> None:
    _check_policy(options.folder)
    path = options.out or options.folder / "episodes.gif"
    if path.suffix.lower() != ".gif":
        raise UserError("moving pictures are written as GIF", where=path, remedy="call it NAME.gif")
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    from motorspace.navigation.folder import load_policy
    from motorspace.navigation.watch import episodes_of, write_animation

    trained = load_policy(options.folder)
    episodes = episodes_of(
        trained,
        num=options.num,
        goal=options.goal,
        split="train" if options.seen else "test",
        sampled=not options.greedy,
        seed=options.seed,
    )
    write_animation(episodes, path)
    reached = sum(episode.reached for episode in episodes)
    print(f"{reached} of {len(episodes)} goals reached: {path}")


def _add_greedy(parser: CommandParser) -> None:
    parser.add_argument(
        "--greedy",
        action="store_true",
        default=False,
        help="Take the policy's middle command instead of sampling.",
    )


def _check_policy(folder: Path) -> None:
    """Raise `UserError` where no policy is, before anything heavy is loaded."""
    if not (folder / run_folder.CONFIG).exists():
        raise UserError(
            "there is no policy here",
            where=folder,
            remedy="give a folder made by motorspace navigate train",
        )


ACTIONS = {
    "train": Action(_train_flags, _train, "learn a policy"),
    "evaluate": Action(_evaluate_flags, _evaluate, "measure it in seen and unseen layouts"),
    "watch": Action(_watch_flags, _watch, "write some of its episodes as a GIF"),
}
