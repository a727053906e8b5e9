"""`motorspace control`."""

import argparse
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from motorspace.cli.located import data_of
from motorspace.cli.parsing import CommandParser, Usage, count, note, number, seed
from motorspace.cli.show import show
from motorspace.control.goals import METHODS

if TYPE_CHECKING:
    from motorspace.control.controller import Controller
    from motorspace.control.goals import Goal

FAR_OFF = 0.5
"""A plan that misses by more, in standard deviations of codes, is a person's concern."""


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command."""
    del words
    add = parser.add_argument
    add("run", type=Path, metavar="RUN", help="The run's folder; the controller is kept there.")
    goal = parser.add_argument_group(
        "goal", "One of these prints a plan; without, the controller is measured."
    )
    goal.add_argument(
        "--displacement",
        nargs=3,
        type=number,
        default=None,
        metavar=("AHEAD", "LEFT", "TURN"),
        help="World units ahead and to the left, and degrees to turn to the left.",
    )
    goal.add_argument(
        "--code", nargs="+", type=number, default=None, metavar="X", help="The code to reach."
    )
    goal.add_argument(
        "--sensors",
        nargs="+",
        type=number,
        default=None,
        metavar="X",
        help="The readings to reach, raw units; needs --now.",
    )
    add(
        "--now",
        nargs="+",
        type=number,
        default=None,
        metavar="X",
        help="The readings now, raw units.",
    )
    add("--method", choices=METHODS, default="hybrid", help="How to plan (default: hybrid).")
    add("--num", type=count, default=1000, metavar="N", help="Goals to measure (default: 1000).")
    add(
        "--updates",
        type=count,
        default=None,
        metavar="N",
        help="Learn the controller anew, with so many updates.",
    )
    add("--seed", type=seed, default=0, metavar="N", help="Seed of the plan or of the goals.")
    add("--json", action="store_true", default=False, help="Print the result as JSON.")


def run(options: argparse.Namespace) -> None:
    """Learn a controller if there is none; plan, or measure it."""
    data_of(options.run, None, command="control")
    goal = _goal(options)
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    controller = _controller(options)
    if goal is None:
        from motorspace.control.scores import measure_controller
        from motorspace.training.run import load_run

        scores = measure_controller(
            load_run(options.run), controller, num=options.num, seed=options.seed
        )
        show(scores, as_json=options.json)
        return
    import numpy as np

    from motorspace.control.planning import plan

    size = len(controller.model.scaling.sensors)
    now = np.zeros(size, np.float32) if options.now is None else np.array(options.now, np.float32)
    found_plan = plan(controller, now, goal, method=options.method, seed=options.seed)
    if found_plan.miss > FAR_OFF:
        note("the plan does not get near the goal, by the network's own account")
    shown = {
        name: values.tolist()
        for name, values in zip(
            controller.commands.names, found_plan.motors.astype(float).T, strict=True
        )
    }
    show({"miss": found_plan.miss} | shown, as_json=options.json)


def _goal(options: argparse.Namespace) -> "Goal | None":
    from motorspace.control.goals import CodeGoal, DisplacementGoal, SensorGoal

    given = [n for n in ("displacement", "code", "sensors") if getattr(options, n) is not None]
    if len(given) > 1:
        raise Usage(f"--{given[0]} and --{given[1]} are two goals", remedy="give one of them")
    if given == ["sensors"]:
        if options.now is None:
            raise Usage(
                "from where is not said", where="--sensors", remedy="give the readings with --now"
            )
        return SensorGoal(options.sensors)
    if options.code is not None:
        return CodeGoal(options.code)
    if options.displacement is not None:
        ahead, left, turn = options.displacement
        return DisplacementGoal(ahead, left, math.radians(turn))
    return None


def _controller(options: argparse.Namespace) -> "Controller":
    from motorspace.control.store import CONFIG, load_controller, save_controller

    if options.updates is None and (options.run / CONFIG).exists():
        return load_controller(options.run)
    from motorspace.control.controller import learn_controller
    from motorspace.control.learning import ControlConfig
    from motorspace.training.run import load_run

    config = ControlConfig()
    if options.updates is not None:
        config = ControlConfig(updates=options.updates)
    note(f"learning a controller, {config.updates} updates, some minutes")
    controller = learn_controller(load_run(options.run), config)
    save_controller(controller, config, options.run)
    return controller
