"""What a reader meets: narrow tables, code that runs, pages that show what their scripts do."""

import re
from pathlib import Path

import matplotlib
import pytest

from docs import reference
from docs.run_tutorials import NAMES, TUTORIALS, cells, run

ROOT = Path(__file__).parents[2]
MOST_COLUMNS = 6
RANGE = re.compile(r"\(-?[\d.]+(e[+-]?\d+)? to ")

GENERATED = ("appendix", "reference")
TEXT = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *(
        page
        for page in sorted((ROOT / "docs").rglob("*.md"))
        if page.relative_to(ROOT / "docs").parts[0] not in GENERATED
    ),
]


def named(page):
    return str(page.relative_to(ROOT))


def rows(text):
    without_code = re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)
    return [line for line in without_code.splitlines() if line.startswith("|")]


def too_wide(text):
    return [row for row in rows(text) if row.count("|") - 1 > MOST_COLUMNS or RANGE.search(row)]


@pytest.mark.parametrize("page", TEXT, ids=named)
def test_tables_in_the_text_are_narrow_and_have_no_ranges_in_brackets(page):
    assert not too_wide(page.read_text())


@pytest.mark.parametrize("row", ["| 1 | 2 | 3 | 4 | 5 | 6 | 7 |", "| 3.65 (3.63 to 3.65) |"])
def test_a_wide_table_and_a_range_are_seen(row):
    assert too_wide(f"text\n\n{row}\n")


RETIRED = re.compile(
    r"\b(foretells?|lessons?|organisation|misjudged|drawn from nowhere|dead codes|collapse ratio)\b"
)


@pytest.mark.parametrize("page", TEXT, ids=named)
def test_words_are_those_of_the_field(page):
    assert not RETIRED.findall(page.read_text())


@pytest.mark.parametrize("name", NAMES)
def test_a_tutorials_page_shows_its_script(name):
    page = (TUTORIALS / f"{name}.md").read_text()
    for cell in cells((TUTORIALS / f"{name}.py").read_text()):
        assert (cell.source if cell.markdown else f"```python\n{cell.source}\n```") in page
    for picture in re.findall(r"\]\((\S+\.png)\)", page):
        assert (TUTORIALS / picture).exists()


def test_a_script_in_cells_becomes_a_page(tmp_path):
    script = tmp_path / "toy.py"
    script.write_text(
        "# %% [markdown]\n# # Title\n#\n# Text.\n\n"
        "# %%\nimport matplotlib.pyplot as plt\nfrom matplotlib.figure import Figure\n\nNUM = 3\n"
        "# %%\nprint('number', NUM)\nplt.plot([1, 2])\n"
        "# %%\nFigure()\n"
    )
    page, pictures = run(script, {"NUM": 5})
    assert page.count("```python") == 3
    assert "# Title\n\nText." in page and "number 5" in page and "![Title](toy-1.png)" in page
    assert list(pictures) == ["toy-1.png", "toy-2.png"]
    assert all(picture.startswith(b"\x89PNG") for picture in pictures.values())
    with pytest.raises(ValueError, match="no constant MANY"):
        run(script, {"MANY": 1})


def test_a_traceback_names_the_line_of_the_script(tmp_path):
    script = tmp_path / "broken.py"
    script.write_text("# %% [markdown]\n# # Title\n\n# %%\n\nvalue = 1\nraise KeyError\n")
    with pytest.raises(KeyError) as caught:
        run(script)
    assert caught.traceback[-1].lineno + 1 == 7


def test_the_reference_shows_every_module():
    for path, text in reference.pages().items():
        assert path.read_text() == text, f"{named(path)}: run python -m docs.reference"


def blocks(page):
    return re.findall(r"^```python[^\n]*\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)


HOW_TO = [f"docs/how-to/{name}.md" for name in ("sensor", "reader", "study")]
LONG = (
    *("README", "docs/quickstart", "docs/navigation"),
    *(f"docs/how-to/{name}" for name in ("agent", "encoder", "colours")),
)


@pytest.mark.parametrize(
    "page",
    [
        "docs/environments.md",
        "docs/concepts/measures.md",
        *HOW_TO,
        *(pytest.param(f"{name}.md", marks=pytest.mark.slow) for name in LONG),
    ],
)
def test_the_code_of_a_page_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = blocks(ROOT / page)
    assert found
    names = {"__name__": "page"}
    for block in found:
        exec(compile(block, page, "exec"), names)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("first_map", {"EPOCHS": 20, "NUM": 1000}),
        ("own_layout_and_sensor", {"EPOCHS": 10, "NUM": 1000}),
        ("robot_log", {"STEPS": 2000, "EPOCHS": 3}),
        ("bag_to_map", {"SCANS": 500, "EPOCHS": 20}),
        ("measure_codes", {"NUM": 1000}),
        ("navigate", {"STEPS": 1000, "NUM": 16}),
        ("eyes", {"EPOCHS": 10, "NUM": 1000}),
    ],
)
def test_a_tutorial_runs(name, changes):
    with matplotlib.rc_context():
        page, pictures = run(TUTORIALS / f"{name}.py", changes)
    assert page.count("```text") >= 2 and pictures
