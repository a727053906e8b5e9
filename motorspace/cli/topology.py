"""`motorspace topology`."""

import argparse
import warnings
from collections.abc import Sequence
from pathlib import Path

from motorspace._errors import UserError
from motorspace._files import json_text, write_atomically
from motorspace.cli.parsing import CommandParser, note


def configure(parser: CommandParser, words: Sequence[str]) -> None:
    """The flags of the command."""
    del words
    add = parser.add_argument
    add(
        "codes",
        type=Path,
        metavar="CODES",
        help="Codes, one row for each motor sequence (.npy, .npz, .csv, .parquet, .zarr), or a "
        "run's folder.",
    )
    add(
        "displacements",
        type=Path,
        nargs="?",
        default=None,
        metavar="DISPLACEMENTS",
        help="Longitudinal and lateral displacement and orientation change (radians) of each "
        "code; left out for a run.",
    )
    add(
        "--motors",
        type=Path,
        default=None,
        metavar="MOTORS",
        help="The motor commands behind each code: shows whether codes copy them.",
    )
    add(
        "--out",
        type=Path,
        default=Path("topology.html"),
        metavar="FILE",
        help="The page to write (default: topology.html).",
    )
    add(
        "--standard-form",
        action="store_true",
        default=False,
        help="Measure a run's codes with unit, body point and readout standardised (encoder "
        "matrix_product only).",
    )
    add("--seed", type=int, default=0, metavar="N", help="Seed of the random subsets of pairs.")
    add("--json", action="store_true", default=False, help="Print the measures as JSON.")


def run(options: argparse.Namespace) -> None:
    """Measure codes, or those of a run."""
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_, **__: note(str(message))
        found = _of_files(options) if options.displacements else _of_run(options)
    from motorspace.analysis.projections import pca
    from motorspace.reports.topology_page import topology_page

    what = "codes in standard form" if options.standard_form else "codes"
    coordinates = pca(found.codes).coordinates
    page = topology_page(found.topology, coordinates, found.displacements, what=what)
    write_atomically(options.out, page.encode())
    if options.json:
        print(json_text({key: float(value) for key, value in found.topology.items()}))
    else:
        print(f"{found.topology}\nopen {options.out}")


def _of_run(options: argparse.Namespace):  # type: ignore[no-untyped-def]
    from motorspace.training import folder as run_folder

    if options.codes.is_file():
        raise UserError(
            "codes alone cannot be measured",
            where=options.codes,
            remedy="give their displacements too: motorspace topology CODES DISPLACEMENTS",
        )
    run_folder.read_description(options.codes)
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    from motorspace.evaluation.structure import run_topology
    from motorspace.training.run import load_run

    return run_topology(load_run(options.codes), seed=options.seed, standard=options.standard_form)


def _of_files(options: argparse.Namespace):  # type: ignore[no-untyped-def]
    if options.standard_form:
        raise UserError(
            "codes from files are measured as they are",
            remedy="leave --standard-form out, or give the folder of a run alone",
        )
    from motorspace._arrays import read_array

    codes = read_array(options.codes, name="codes")
    displacements = read_array(options.displacements, name="displacements")
    motors = None if options.motors is None else read_array(options.motors, name="motors")
    from motorspace.analysis.topology import topology
    from motorspace.evaluation.structure import Sampled

    found = topology(codes, displacements, motors, seed=options.seed)
    return Sampled(codes.reshape(len(codes), -1), displacements, found)
