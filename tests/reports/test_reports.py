"""Figures that are drawn, tables that say what they were given, a page that loads nothing."""

import jax
import jax.numpy as jnp
import numpy as np

from motorspace import ForwardAgent, RangeFan, layout, rollout
from motorspace.reports import figures, topology_figures
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


def told(mean):
    return {"mean": mean, "low": 0.9 * mean, "high": 1.1 * mean}


MORE_MEASURES = ("partial, affine", "rank correlation", "semipartial, motors")


def test_the_figures_of_organisation_show_every_row():
    measures = [name for name, *_ in topology_figures.PANELS]
    cells = [
        {
            "agent": agent,
            "row": preset,
            "rotation": rotation,
            "T = 1": told(0.1),
            "T = 6": told(0.2),
        }
        | {f"{n} full turns": told(0.5) for n in range(3)}
        | {name: told(0.7) for name in (*measures, *MORE_MEASURES)}
        | ({f"{name}, standard": told(0.9) for name in MORE_MEASURES} if preset == "best" else {})
        for agent in ("forward", "holonomic")
        for preset in ("best", "paper")
        for rotation in (0.4, 0.8)
    ]
    panels = topology_figures.organisation_figure(cells).axes
    assert [len(axes.lines) for axes in panels[:2]] == [5, 5], "four curves and the target"
    (axes,) = topology_figures.copies_figure(cells).axes
    assert [bars.get_label() for bars in axes.containers][1] == "forward, paper"
    assert [len(bars.lines[0].get_xdata()) for bars in axes.containers] == [2] * 4
    assert [len(axes.lines) for axes in topology_figures.standard_figure(cells).axes] == [6, 6]
    assert [len(axes.lines) for axes in topology_figures.turns_figure(cells).axes] == [2] * 4
    (axes,) = topology_figures.lengths_figure(cells, rotation=0.8).axes
    np.testing.assert_array_equal(axes.lines[0].get_xdata(), [1, 6])
    drawn = [
        {"agent": agent, "row": "best", "turns": 1, "drawn": share, "ratio": told(0.5)}
        for agent in ("forward", "holonomic")
        for share in (0.0, 0.2)
    ]
    for axes in topology_figures.drawn_figure(drawn).axes:
        np.testing.assert_array_equal(axes.lines[0].get_xdata(), [0.0, 0.2])
    course = [
        {"row": preset, "turns": turns, "epoch": epoch, "ratio": told(0.5)}
        for preset in ("best", "paper")
        for turns in ("1", "2")
        for epoch in (50, 100)
    ]
    assert [len(axes.lines) for axes in topology_figures.folding_figure(course).axes] == [2, 2]
    angles = [
        {"rotation": rotation, "angle": angle, "ratio": told(1.1)}
        for rotation in (0.2, 0.8)
        for angle in (0.9, 1.0)
    ]
    (axes,) = topology_figures.angle_figure(angles).axes
    assert [line.get_label() for line in axes.lines] == ["r = 0.2 pi", "r = 0.8 pi"]
    changes = [{"change": "one", "error": told(2.0)}, {"change": "dead"}]
    (axes,) = topology_figures.changes_figure(changes, "change", {"error": "error"}).axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["one", "dead"]
    assert axes.lines[0].get_ydata().tolist() == [0]


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
