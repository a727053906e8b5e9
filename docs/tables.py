"""Fill the tables of the documentation from `results/` and draw its figures of results.

With --check nothing is written: what is not as the results say is named.
"""

import json
import sys
from pathlib import Path
from typing import Any

import benchmarks.claims
import benchmarks.gpu.claims
from motorspace._files import write_atomically
from motorspace.analysis.measures import Measure, measures
from motorspace.reports.tables import filled, markdown_table, places
from motorspace.studies.tables import Results
from motorspace.studies.targets import Claim, complaints

ROOT = Path(__file__).parent.parent
RESULTS = Results(ROOT / "results")
PICTURES = ROOT / "docs" / "pictures"


def pages() -> list[Path]:
    """The pages that hold tables."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def tables() -> dict[str, str]:
    """Every table by the name of its place."""
    rows, gpu = _measured("benchmarks")["rows"], _measured("gpu")
    others = benchmarks.claims.tables(rows, speed())
    others |= {"gpu": benchmarks.gpu.claims.lines(gpu, short=False)}
    others |= {"gpu_short": benchmarks.gpu.claims.lines(gpu, short=True)}
    others |= {"measures": [_measure(row) for row in measures()]}
    return RESULTS.tables() | {name: markdown_table(lines) for name, lines in others.items()}


def speed() -> list[Claim]:
    """What is claimed of the rates, on a CPU and on a GPU."""
    rows, reasons = _measured("benchmarks")["rows"], RESULTS.reasons()
    on_gpu = benchmarks.gpu.claims.claims(_measured("gpu"), rows, reasons)
    return benchmarks.claims.claims(rows, reasons) + on_gpu


def _measured(what: str) -> Any:
    """What a command of the benchmarks has written."""
    return json.loads((RESULTS.folder / f"{what}.json").read_text())


def _measure(row: Measure) -> dict[str, object]:
    return {
        "key": f"`{row.key}`",
        "measure": row.label,
        "perfect": "" if row.perfect is None else f"{row.perfect:g}",
        "chance": "" if row.chance is None else f"{row.chance:g}",
        "meaning": row.meaning,
    }


def problems() -> list[str]:
    """A sentence for each thing that is wrong in the results."""
    stale = [f"{name}: the configuration has changed since" for name in RESULTS.stale()]
    return stale + complaints(RESULTS.claims() + speed(), RESULTS.reasons())


def main(check: bool) -> None:
    """Fill the pages, or see that they are filled; name what is wrong in the results."""
    made, found = tables(), problems()
    for page in pages():
        text = page.read_text()
        found += [f"{page}: there is no table {n!r}" for n in places(text) if n not in made]
        if (new := filled(text, made)) == text:
            continue
        if check:
            found.append(f"{page}: a table is not as the results say (run make tables)")
        else:
            write_atomically(page, new.encode())
    if not check:
        for name, picture in RESULTS.pictures().items():
            write_atomically(PICTURES / f"{name}.png", picture)
    for sentence in found:
        print(sentence, file=sys.stderr)
    sys.exit(1 if check and found else 0)


if __name__ == "__main__":
    main("--check" in sys.argv)
