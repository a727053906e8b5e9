"""Figures that are drawn, tables that say what they were given, a page that loads nothing."""

import jax
import jax.numpy as jnp
import numpy as np

from motorspace import ForwardAgent, RangeFan, layout, rollout
from motorspace.reports import figures
from motorspace.reports.page import Section, markdown_table, report_page, shown

RNG = np.random.default_rng(0)


def test_every_figure_becomes_a_png():
    world, agent = layout("paper"), ForwardAgent()
    start = world.place(key=jax.random.key(0))
    path = rollout(world, agent, start, jnp.ones((4, 2)))
    displacements = RNG.uniform(-1, 1, (200, 3))
    rows = [("a run", RNG.normal(size=(200, 3)), displacements)]
    drawn = [
        figures.environment_figure(world, [start], RangeFan()),
        figures.trajectories_figure(world, [path]),
        figures.layouts_figure({"paper": world, "again": world}),
        figures.codes_figure(rows, colours=figures.UNIFORM_COLOURS),
        figures.lattice_figure(rows),
        figures.learning_curve_figure({"training": np.array([3.0, 2.0])}, {"oracle": 1.0}),
    ]
    for figure in drawn:
        assert figures.png(figure, dots_per_inch=40).startswith(b"\x89PNG")
    assert len(drawn[3].axes) == 6  # three panels, each with its colour bar
    assert len(drawn[0].axes[0].patches) == 5  # the solids


def test_tables_show_means_with_their_range_and_gaps_as_dashes():
    spread = {"mean": 2.344, "low": 2.1, "high": 2.5}
    table = markdown_table([{"cell": "a", "error": spread}, {"cell": "b", "error": None}])
    assert table.splitlines()[2:] == ["| a | 2.34 (2.1 to 2.5) |", "| b | – |"]
    assert markdown_table([]) == ""
    assert markdown_table([{"a": "x|y"}]).splitlines()[2] == "| x\\|y |"
    assert shown(np.float32(0.5)) == "0.5" and shown(float("nan")) == "nan"
    assert shown(0.12345) == "0.123" and shown(True) == "yes" and shown(3) == "3"


def test_the_page_is_whole_and_escapes_what_it_is_given():
    picture = figures.png(figures.layouts_figure({"empty": layout("empty")}))
    section = Section("A <b> heading", "x < y", [{"name": "<i>", "value": 1.5}], [("p", picture)])
    page = report_page("title & more", [section])
    assert "A &lt;b&gt; heading" in page and "x &lt; y" in page and "&lt;i&gt;" in page
    assert "data:image/png;base64," in page
    assert "http" not in page and "<script" not in page
