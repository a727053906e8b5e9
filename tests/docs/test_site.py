"""The site is built strictly, and its pages load nothing from the network."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from docs.check import faults_of, main

ROOT = Path(__file__).parents[2]
SECURE = "https:" + "//"
pytest.importorskip("zensical", reason="the extra docs is not installed")


def build(folder):
    return subprocess.run(
        [sys.executable, "-m", "zensical", "build", "--strict"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_site_is_built_and_loads_nothing_from_the_network(tmp_path):
    shutil.copy(ROOT / "mkdocs.yml", tmp_path)
    shutil.copytree(ROOT / "docs", tmp_path / "docs", ignore=shutil.ignore_patterns("*.pyc"))
    (tmp_path / "motorspace").symlink_to(ROOT / "motorspace")
    done = build(tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len([*(tmp_path / "site").rglob("*.html")]) > 50
    assert not [*faults_of(tmp_path / "site")]


def test_every_page_is_in_the_navigation():
    listed = re.findall(r"[\w/-]+\.md", (ROOT / "mkdocs.yml").read_text())
    there = {str(page.relative_to(ROOT / "docs")) for page in (ROOT / "docs").rglob("*.md")}
    assert set(listed) == there


@pytest.mark.parametrize(
    "text",
    [
        "[a page that is not there](nowhere.md)",
        "[an anchor that is not there](#nowhere)",
        "[`name`][motorspace.nowhere.nothing]",
        "::: motorspace.nowhere",
    ],
)
def test_a_broken_reference_fails_the_build(text, tmp_path):
    settings, _, _ = (ROOT / "mkdocs.yml").read_text().partition("\nnav:")
    (tmp_path / "mkdocs.yml").write_text(settings + "\nnav:\n  - index.md\n")
    (tmp_path / "motorspace").symlink_to(ROOT / "motorspace")
    (tmp_path / "docs").mkdir()
    for name in ("site.css", "docstrings.py"):
        shutil.copy(ROOT / "docs" / name, tmp_path / "docs")
    page = tmp_path / "docs" / "index.md"
    page.write_text("# Page\n\nNothing wrong.\n")
    done = build(tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    page.write_text(f"# Page\n\n{text}\n")
    assert build(tmp_path).returncode != 0


@pytest.mark.parametrize(
    ("tag", "fault"),
    [
        (f'<script src="{SECURE}cdn.example/mathjax.js">', "from the network"),
        ("<link rel=stylesheet href=//fonts.example/css>", "from the network"),
        ('<img src="nothing.png">', "not there"),
        ('<div class="mermaid">', "on the network"),
        (f'<img src="there.png"><a href="{SECURE}example.org">a link</a>', None),
    ],
)
def test_what_a_page_loads_is_seen(tag, fault, tmp_path):
    (tmp_path / "there.png").touch()
    (tmp_path / "index.html").write_text(tag)
    found = [*faults_of(tmp_path)]
    assert [fault in sentence for sentence in found] == ([True] if fault else [])
    if fault:
        with pytest.raises(SystemExit, match=fault):
            main(tmp_path)


def test_what_a_style_loads_is_seen(tmp_path):
    (tmp_path / "site.css").write_text(f"src: url({SECURE}fonts.example/a.woff2)")
    assert ["from the network" in sentence for sentence in faults_of(tmp_path)] == [True]


def test_examples_in_docstrings_become_a_section():
    from docs.docstrings import with_examples

    wanted = "What it is.\n\nExamples:\n    >>> 1\n    1"
    assert with_examples("What it is.\n\n>>> 1\n1") == wanted
    assert with_examples("What it is.\n\nExample:\n    >>> 1\n    1") == wanted
