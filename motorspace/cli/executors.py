"""Where the runs of a sweep or a study are trained: the flags, and the executor they ask for."""

import argparse

from motorspace.cli.parsing import CommandParser, count
from motorspace.running.executors import Executor, OneProgram


def add_executor_flags(parser: CommandParser) -> None:
    """Flags that say where runs are trained."""
    add = parser.add_argument_group("where the runs are trained").add_argument
    add(
        "--jobs",
        type=count,
        default=2,
        metavar="N",
        help="Processes of this machine (default: 2). On an accelerator runs that differ by seeds "
        "and by numbers train as one program instead.",
    )
    add(
        "--address",
        default=None,
        metavar="HOST:PORT",
        help="Head of a Ray cluster instead; auto: the one of this machine.",
    )
    add(
        "--gpus",
        type=float,
        default=0.0,
        metavar="X",
        help="Accelerators of the cluster that a run takes; 0.25: four runs share one.",
    )


def executor_of(options: argparse.Namespace) -> Executor:
    """The executor: a Ray cluster, one program on an accelerator, or processes of this machine.

    To be called when JAX is set up.
    """
    modules = tuple(options.imports)
    if options.address is not None:
        from motorspace.running.ray_cluster import RayExecutor

        return RayExecutor(options.address, gpus=options.gpus, modules=modules)
    from motorspace._devices import on_accelerator

    if on_accelerator():
        from motorspace.running.trainer import train_team

        return OneProgram(train_team, modules)
    from motorspace.running.processes import Processes

    return Processes(options.jobs, modules)
