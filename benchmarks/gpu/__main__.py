"""Measures the parts that are named, or all, and prints their table last."""

import argparse
import os
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import date
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from benchmarks.gpu.sizes import Sizes
    from benchmarks.gpu.timing import Case, Part, Row

OUT = Path("results/gpu.json")
NEEDED = ("jax", "equinox", "optax", "jaxtyping", "numpy", "safetensors", "filelock", "lazy_loader")
PARTS = {
    "trajectories": "simulation",
    "scans": "simulation",
    "training": "training",
    "peers": "pytorch",
    "precision": "training",
    "roofline": "bounds",
    "table": "whole_table",
}
"""The module of each part, which has a function of its name; in the order of measurement."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, keep every row at once, and go on where a part fails."""
    options = _options(arguments)
    if lacking := lacks(small=options.small):
        print(f"benchmarks.gpu: skipped, since {lacking}", flush=True)
        return
    from benchmarks.gpu.report import Results, shown, table

    sizes, results = _sizes(options), Results(options.out)
    parts = {name: import_module(f"benchmarks.gpu.{PARTS[name]}") for name in options.parts}
    for name, module in parts.items():
        begun = time.perf_counter()
        results.begin(name, described(small=options.small))
        for rows in measured(name, getattr(module, name), sizes):
            results.add(name, rows)
            print(*map(shown, rows), sep="\n", flush=True)
        print(f"{name}: {time.perf_counter() - begun:.0f} s in all", flush=True)
    print("", table([row for row in results.rows if row["part"] in parts]), sep="\n", flush=True)


def lacks(*, small: bool) -> str:
    """What is missing for measuring, as half a sentence; nothing if all is there."""
    if missing := [name for name in NEEDED if find_spec(name) is None]:
        return f"these packages are not installed: {', '.join(missing)}"
    # PyTorch needs some of the device's memory too.
    os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
    import jax

    try:
        platform = jax.default_backend()
    except RuntimeError as error:
        return f"JAX finds no device ({error})"
    if small or platform == "gpu":
        return ""
    return f"JAX sees no GPU here, only a {platform.upper()} (--small tries all parts on it)"


def measured(name: str, part: "Part", sizes: "Sizes") -> "Iterator[list[Row]]":
    """The rows of every case of a part; of one that fails, what went wrong."""
    cases = part(sizes)
    while (rows := _attempted(name, cases)) is not None:
        yield rows


def _attempted(name: str, cases: "Iterator[Case]") -> "list[Row] | None":
    """The rows of the next case, or None where there is none."""
    from benchmarks.gpu.timing import Skipped

    try:
        case = next(cases, None)
        return None if case is None else case()
    except Skipped as skipped:
        return [{"work": name, "reason": f"skipped, since {skipped}"}]
    except Exception as error:  # whatever it is, the other cases are still to be measured
        traceback.print_exc()
        first_line, *_ = str(error).splitlines() or [""]
        return [{"work": name, "reason": f"failed: {type(error).__name__}: {first_line[:200]}"}]


def described(*, small: bool) -> dict[str, Any]:
    """What a part is measured on."""
    import jax

    from motorspace.running.store import code_version

    return {
        "device": jax.devices()[0].device_kind,
        "cores": len(os.sched_getaffinity(0)),
        "jax": jax.__version__,
        "python": sys.version.split()[0],
        "code": code_version(),
        "date": date.today().isoformat(),
        "small": small,
    }


def _sizes(options: argparse.Namespace) -> "Sizes":
    from benchmarks.gpu.sizes import SMALL, Sizes

    sizes = SMALL if options.small else Sizes()
    return replace(sizes, table_epochs=options.epochs) if options.epochs else sizes


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser("python -m benchmarks.gpu", description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)}")
    parser.add_argument("--small", action="store_true", help="tiny sizes, on any device")
    parser.add_argument("--out", type=Path, help=f"by default {OUT}; with --small no file")
    parser.add_argument("--epochs", type=int, help="of the part table; by default the paper's")
    options = parser.parse_args(arguments)
    if unknown := set(options.parts) - set(PARTS):
        parser.error(f"there is no part {', '.join(sorted(unknown))}: choose of {', '.join(PARTS)}")
    options.parts = [name for name in PARTS if name in options.parts or not options.parts]
    options.out = options.out or (None if options.small else OUT)
    return options


if __name__ == "__main__":
    main()
