"""`motorspace export`."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from motorspace.cli.parsing import CommandParser, Usage, count, seed
from motorspace.training import folder as run_folder


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command."""
    del words
    add = parser.add_argument
    add("run", type=Path, metavar="RUN", help="The run's folder.")
    add(
        "--num",
        type=count,
        default=None,
        metavar="N",
        help="Write codes, displacements, motors and sensors of N fresh trajectories.",
    )
    add(
        "--format",
        choices=("npy", "parquet"),
        default="npy",
        help="How those are written (default: npy).",
    )
    add("--onnx", action="store_true", default=False, help="Write encoder.onnx and predictor.onnx.")
    add(
        "--numpy",
        action="store_true",
        default=False,
        help="Write a module that runs the network with NumPy alone.",
    )
    add(
        "--out",
        type=Path,
        default=Path("export"),
        metavar="FOLDER",
        help="Folder to write (default: export).",
    )
    add("--seed", type=seed, default=0, metavar="N", help="Seed of the trajectories.")
    add("--force", action="store_true", default=False, help="Replace files that are there.")


def run(options: argparse.Namespace) -> None:
    """Write what was asked for."""
    if options.num is None and not options.onnx and not options.numpy:
        raise Usage("nothing to export was named", remedy="give --num N, --onnx or --numpy")
    run_folder.read_description(options.run)
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    from motorspace.export.arrays import export_arrays
    from motorspace.export.onnx import export_onnx
    from motorspace.export.standalone import export_numpy
    from motorspace.training.run import load_run

    found, out, force = load_run(options.run), options.out, options.force
    if options.num is not None:
        export_arrays(
            found, out, num=options.num, seed=options.seed, format=options.format, force=force
        )
    if options.onnx:
        export_onnx(found, out, force=force)
    if options.numpy:
        export_numpy(found, out, force=force)
    print(f"written: {out}")
