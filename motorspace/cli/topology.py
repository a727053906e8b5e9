"""`motorspace topology`."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from motorspace._errors import UserError
from motorspace._files import json_text, write_atomically
from motorspace.cli.located import add_data_flag, data_of
from motorspace.cli.parsing import CommandParser, Usage, seed

if TYPE_CHECKING:
    from motorspace.evaluation.structure import Sampled


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
    add_data_flag(parser)
    add("--seed", type=seed, default=0, metavar="N", help="Seed of the random subsets of pairs.")
    add("--json", action="store_true", default=False, help="Print the measures as JSON.")


def run(options: argparse.Namespace) -> None:
    """Measure codes, or those of a run."""
    found = _of_files(options) if options.displacements else _of_run(options)
    from motorspace.analysis.projections import pca
    from motorspace.reports.topology_page import topology_page

    # The numbers first: they are there even if the page cannot be written.
    if options.json:
        print(json_text({key: float(value) for key, value in found.topology.items()}))
    else:
        print(found.topology)
    what = "codes in standard form" if options.standard_form else "codes"
    coordinates = pca(found.codes).coordinates
    page = topology_page(found.topology, coordinates, found.displacements, what=what)
    write_atomically(options.out, page.encode())
    if not options.json:
        print(f"open {options.out}")


def _of_run(options: argparse.Namespace) -> "Sampled":
    if options.codes.is_file():
        raise UserError(
            "codes alone cannot be measured",
            where=options.codes,
            remedy="give their displacements too: motorspace topology CODES DISPLACEMENTS",
        )
    if options.motors is not None:
        raise Usage(
            "a run's motor commands are known",
            where="--motors",
            remedy="leave it out, or give codes and displacements",
        )
    data = data_of(options.codes, options.data, command="topology")
    from motorspace.cli.runtime import prepare_jax

    prepare_jax()
    from motorspace.evaluation.structure import run_topology
    from motorspace.training.run import load_run

    run = load_run(options.codes)
    return run_topology(run, data=data, seed=options.seed, standard=options.standard_form)


def _of_files(options: argparse.Namespace) -> "Sampled":
    for name, given in (("--standard-form", options.standard_form), ("--data", options.data)):
        if given:
            raise Usage(
                "codes from files are measured as they are",
                where=name,
                remedy="leave it out, or give the folder of a run alone",
            )
    from motorspace._arrays import read_array

    codes = read_array(options.codes, name="codes")
    displacements = read_array(options.displacements, name="displacements")
    motors = None if options.motors is None else read_array(options.motors, name="motors")
    from motorspace.analysis.topology import topology
    from motorspace.evaluation.structure import Sampled

    found = topology(codes, displacements, motors, seed=options.seed)
    return Sampled(codes.reshape(len(codes), -1), displacements, found)
