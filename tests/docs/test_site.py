"""The site is built strictly, and its pages load nothing from the network."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytest.importorskip("zensical", reason="the extra docs is not installed")

LOADED = re.compile(
    r"""<(?:script|img|iframe|source|video)\b[^>]*\bsrc=["']?(?://|https?:)[^\s>]*"""
    r"""|<link\b[^>]*\bhref=["']?(?://|https?:)[^\s>]*|url\((?:["']?)(?://|https?:)[^)]*""",
    re.IGNORECASE,
)


def build(folder):
    return subprocess.run(
        [sys.executable, "-m", "zensical", "build", "--strict"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    shutil.copy(ROOT / "mkdocs.yml", folder)
    shutil.copytree(ROOT / "docs", folder / "docs", ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "motorspace").symlink_to(ROOT / "motorspace")
    done = build(folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "site"


def test_no_page_loads_anything_from_the_network(site):
    pages = [*site.rglob("*.html"), *site.rglob("*.css")]
    assert len(pages) > 50
    loaded = {str(page.relative_to(site)): LOADED.findall(page.read_text()) for page in pages}
    assert not {page: found for page, found in loaded.items() if found}
    # What the theme's script would fetch is asked for by these alone.
    assert not [page for page in pages if 'class="mermaid"' in page.read_text()]


@pytest.mark.parametrize(
    "tag",
    [
        '<script src="https://cdn.example/mathjax.js">',
        "<link rel=stylesheet href=//fonts.example/css>",
        "src: url(https://fonts.example/a.woff2)",
    ],
)
def test_a_page_that_loads_something_is_seen(tag):
    assert LOADED.search(tag)


def test_every_page_is_in_the_navigation(site):
    listed = re.findall(r"[\w/-]+\.md", (ROOT / "mkdocs.yml").read_text())
    there = {str(p.relative_to(ROOT / "docs")) for p in (ROOT / "docs").rglob("*.md")}
    assert set(listed) == there


@pytest.mark.parametrize(
    "text",
    [
        "[a page that is not there](nowhere.md)",
        "[an anchor that is not there](#nowhere)",
        "![a picture that is not there](nothing.png)",
        "[`name`][motorspace.nowhere.nothing]",
        "::: motorspace.nowhere",
    ],
)
def test_a_broken_reference_fails_the_build(text, tmp_path):
    settings, _, _ = (ROOT / "mkdocs.yml").read_text().partition("\nnav:")
    (tmp_path / "mkdocs.yml").write_text(settings + "\nnav:\n  - index.md\n")
    (tmp_path / "motorspace").symlink_to(ROOT / "motorspace")
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "site.css").touch()
    page = tmp_path / "docs" / "index.md"
    page.write_text("# Page\n\nNothing wrong.\n")
    assert build(tmp_path).returncode == 0
    page.write_text(f"# Page\n\n{text}\n")
    assert build(tmp_path).returncode != 0
