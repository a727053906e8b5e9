"""Pages: whole, escaped, and loading nothing."""

import json
import re

import numpy as np
import pytest

from motorspace.analysis.report import Estimate, report
from motorspace.reports.codes_view import MOST_POINTS, codes_view
from motorspace.reports.figures.measures import learning_figure
from motorspace.reports.page import Picture, Section, picture, report_page
from motorspace.reports.topology_page import topology_page

RNG = np.random.default_rng(0)
CODES, DISPLACEMENTS = RNG.normal(size=(200, 4)), RNG.uniform(-3, 3, (200, 3))


@pytest.fixture(scope="module")
def curve():
    return picture("a <curve>", lambda: learning_figure({"training": np.array([3.0, 2.0])}))


def test_a_page_holds_all_it_is_given_and_escapes_it(curve):
    section = Section(
        "A <b> heading",
        "x < y, see `code`.\n\nMore.",
        facts=[("error <", 3.803)],
        rows=[{"name": "<i>", "value": 1.5}],
        pictures=[curve],
    )
    page = report_page("title & more", [section], lead="a lead")
    for text in (
        "<h1>title &amp; more</h1><p>a lead</p>",
        "<h2>A &lt;b&gt; heading</h2>",
        "<p>x &lt; y, see <code>code</code>.</p><p>More.</p>",
        "<dt>error &lt;</dt><dd>3.80</dd>",
        '<td>&lt;i&gt;</td><td class="number">1.50</td>',
        "a &lt;curve&gt;",
        '<a href="#1-a-b-heading">',
    ):
        assert text in page
    assert page.count("data:image/png;base64,") == 2, "one for light pages, one for dark ones"


def test_a_page_loads_nothing_and_forbids_it(curve):
    page = report_page("t", [Section("s", pictures=[curve])])
    assert "http:" not in page and "https:" not in page and 'src="data:' in page
    assert "default-src 'none'" in page
    assert not re.findall(r"<(?:link|iframe|script src)", page)


def test_pictures_of_one_theme_and_wide_ones(curve):
    page = report_page("t", [Section("s", pictures=[Picture("p", curve.light)])])
    assert '<figure class="plain">' in page and "<source" not in page
    wide = curve.light[:16] + (4000).to_bytes(4, "big") + curve.light[20:]
    page = report_page("t", [Section("s", pictures=[Picture("p", wide)])])
    assert '<figure class="plain wide">' in page


def test_columns_of_numbers_stand_to_the_right_and_sentences_have_room():
    rows = [{"n": 1.5, "m": None, "words": "short", "text": 60 * "x"}]
    page = report_page("t", [Section("s", rows=rows)])
    assert '<th class="number">n</th><th class="number">m</th><th>words</th>' in page
    assert '<th class="prose">text</th>' in page


def test_codes_to_turn_hold_their_points_and_colours():
    many = np.tile(CODES, (30, 1)), np.tile(DISPLACEMENTS, (30, 1))
    html = codes_view(*many, "a <title>").html
    data = json.loads(re.search(r'<script type="application/json">(.*?)</script>', html)[1])
    assert "<figcaption>a &lt;title&gt;</figcaption>" in html
    assert len(data["points"]) == len(data["moved"]) == len(data["scales"]) == 3
    assert 1000 < len(data["points"][0]) <= MOST_POINTS
    orientation = data["scales"][2]
    assert orientation["low"] == -np.pi and orientation["names"][-1] == "π"
    first, *_, last = (colour for _, colour in orientation["stops"])
    assert first[:-1] == last[:-1], "a circle of colours"
    assert [html.count(f">{name}</button>") for name in ("longitudinal", "orientation")] == [1, 1]


def test_codes_of_one_column_that_never_turn_are_shown():
    still = DISPLACEMENTS * [1.0, 1.0, 0.0]
    data = codes_view(CODES[:, :1], still).html
    assert '"ticks":null' in data and "NaN" not in data


def test_the_script_is_in_a_page_once_and_only_where_it_is_needed():
    view = codes_view(CODES, DISPLACEMENTS, "one")
    two = report_page("t", [Section("a", views=[view]), Section("b", views=[view])])
    none = report_page("t", [Section("a")])
    assert two.count("Plotly.newPlot(scene") == 1 and len(two) > 3e6 > 3e4 > len(none)
    own = two[: two.index("<script>")] + two[two.rindex("<script>") :]
    assert "http:" not in own and "https:" not in own


def test_a_page_about_a_report():
    found = report(200, 1.0, 0, {"linear_r2.worst": Estimate(0.9), "seam_gap": Estimate(2.0, 0.1)})
    page = topology_page(found, CODES, DISPLACEMENTS, what="codes in standard form")
    assert "How the structure of codes in standard form follows displacement" in page
    assert "<dt>linear R², worst</dt><dd>0.900</dd>" in page
    assert '<td class="number">2.00 ± 0.10</td>' in page
