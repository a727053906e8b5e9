"""Run the tutorials and write their pages: `python -m docs.run_tutorials [NAME ...]`.

A tutorial is a script in cells. A cell that begins with `# %% [markdown]` is text, in comments;
one that begins with `# %%` is code. The page shows text, code, what the code prints, every figure
that it leaves open, and the figure or film that its last line gives, if it gives one.
"""

import ast
import contextlib
import io
import itertools
import os
import re
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

TUTORIALS = Path(__file__).parent / "tutorials"
NAMES = (
    "first_map",
    "own_layout_and_sensor",
    "robot_log",
    "bag_to_map",
    "measure_codes",
    "reach_a_goal",
    "navigate",
    "eyes",
)


class Cell(NamedTuple):
    """A part of a script: text or code."""

    markdown: bool
    source: str
    line: int
    """Lines of the script before it."""


def main(names: list[str]) -> None:
    """Run the named tutorials, or all of them, and write their pages and pictures."""
    for name in names or NAMES:
        page, pictures = run(TUTORIALS / f"{name}.py")
        for old in TUTORIALS.glob(f"{name}-[0-9]*"):
            old.unlink()
        for file, content in pictures.items():
            (TUTORIALS / file).write_bytes(content)
        (TUTORIALS / f"{name}.md").write_text(page)
        print(f"{name}: {len(pictures)} pictures")


def cells(script: str) -> Iterator[Cell]:
    """The cells of a script, in order."""
    starts = [found.start() for found in re.finditer(r"^# %%", script, flags=re.MULTILINE)]
    for start, end in itertools.pairwise([*starts, len(script)]):
        kind, _, body = script[start:end].partition("\n")
        markdown = "[markdown]" in kind
        line = script.count("\n", 0, start) + 1 + len(body) - len(body.lstrip("\n"))
        if markdown:
            body = re.sub(r"^# ?", "", body, flags=re.MULTILINE)
        yield Cell(markdown, body.strip("\n"), line)


def run(path: Path, changes: Mapping[str, Any] = {}) -> tuple[str, dict[str, bytes]]:
    """The page of a tutorial, and its pictures by file name.

    The script runs in an empty folder of its own. `changes` replace constants of the script, so
    that a test can run it with less.
    """
    os.environ.setdefault("MPLBACKEND", "agg")
    script = path.read_text()
    for name, value in changes.items():
        script, found = re.subn(rf"^{name} = .*", f"{name} = {value!r}", script, flags=re.MULTILINE)
        if found != 1:
            raise ValueError(f"{path.name} has no constant {name}")
    parts: list[str] = [f"<!-- made from {path.name} by docs/run_tutorials.py -->"]
    pictures: dict[str, bytes] = {}
    names: dict[str, Any] = {"__name__": path.stem}
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for cell in cells(script):
            if cell.markdown:
                parts.append(cell.source)
                continue
            printed, drawn = executed(cell, names, path)
            parts.append(f"```python\n{cell.source}\n```")
            if printed:
                parts.append(f"```text\n{printed}\n```")
            for kind, content in drawn:
                file = f"{path.stem}-{len(pictures) + 1}.{kind}"
                pictures[file] = content
                parts.append(f"![{_title(parts)}]({file})")
    return "\n\n".join(parts) + "\n", pictures


def executed(cell: Cell, names: dict[str, Any], path: Path) -> tuple[str, list[tuple[str, bytes]]]:
    """What a piece of code prints, and the pictures that it makes: their format and content."""
    import matplotlib.pyplot as plt
    from matplotlib.animation import Animation
    from matplotlib.figure import Figure

    # The lines of a traceback are those of the script.
    code = ast.parse("\n" * cell.line + cell.source, str(path))
    last = code.body.pop().value if isinstance(code.body[-1], ast.Expr) else None
    printed, value = io.StringIO(), None
    with contextlib.redirect_stdout(printed):
        exec(compile(code, str(path), "exec"), names)
        if last is not None:
            value = eval(compile(ast.Expression(last), str(path), "eval"), names)
    films = [_gif(value)] if isinstance(value, Animation) else []
    figures = [] if films else [plt.figure(number) for number in plt.get_fignums()]
    figures += [value] * (isinstance(value, Figure) and value not in figures)
    plt.close("all")
    return printed.getvalue().rstrip(), films + [_png(figure) for figure in figures]


def _png(figure: Any) -> tuple[str, bytes]:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return "png", buffer.getvalue()


def _gif(animation: Any) -> tuple[str, bytes]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.gif"
        animation.save(path, writer="pillow", dpi=90)
        return "gif", path.read_bytes()


def _title(parts: list[str]) -> str:
    """What a picture shows: the last heading above it."""
    text = "\n".join(part for part in parts if not part.startswith("```"))
    return re.findall(r"^#+ (.*)", text, flags=re.MULTILINE)[-1]


if __name__ == "__main__":
    main(sys.argv[1:])
