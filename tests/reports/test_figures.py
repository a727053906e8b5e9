"""Figures: every row is drawn, in both themes, from anybody's arrays."""

import jax
import jax.numpy as jnp
import numpy as np
import PIL.Image
import PIL.ImageSequence
import pytest

from motorspace import ForwardAgent, RangeFan, Retina, layout, rollout
from motorspace.reports.figures import codes, films, maps, measures, style, vision, worlds
from motorspace.reports.figures.measures import Axis

RNG = np.random.default_rng(0)


def is_png(figure):
    return style.png(figure, dots_per_inch=30).startswith(b"\x89PNG")


def test_worlds_agents_and_their_ways():
    world, agent = layout("paper"), ForwardAgent()
    start = world.place(key=jax.random.key(0))
    path = rollout(world, agent, start, jnp.ones((4, 2)))
    seen = worlds.world_figure(world, [start], RangeFan())
    assert is_png(seen) and len(seen.axes[0].patches) == 5, "the solids"
    assert len(worlds.world_figure(world).axes[0].collections) == 1, "walls alone"
    assert is_png(worlds.trajectories_figure(world, [path, path]))
    assert len(worlds.layouts_figure({"one": world, "two": world}).axes) == 2


def test_a_painted_world_has_a_strip_for_each_agent():
    world, retina = layout("paper", paint="texture:4"), Retina(8, samples=1)
    poses = [world.place(key=jax.random.key(seed)) for seed in range(2)]
    figure = vision.view_figure(world, poses, retina)
    assert is_png(figure) and len(figure.axes) == 3
    strip = np.asarray(figure.axes[1].images[0].get_array())
    expected = (np.asarray(retina.sense(world, poses[0])).reshape(8, 3)[::-1] + 1) / 2
    np.testing.assert_allclose(strip[0], expected, atol=1e-6)


def test_a_film_has_a_frame_for_each_command_and_the_end_stays(tmp_path):
    world, agent = layout("paper"), ForwardAgent()
    start = world.place(key=jax.random.key(0))
    paths = [rollout(world, agent, start, jnp.ones((num, 2))) for num in (3, 5)]
    film = films.ways_film(world, paths, np.array([1.0, 2.0, 0.5]), RangeFan())
    film.save(tmp_path / "film.gif", writer="pillow", dpi=20)
    with PIL.Image.open(tmp_path / "film.gif") as image:
        pictures = [frame.convert("RGB").tobytes() for frame in PIL.ImageSequence.Iterator(image)]
    assert len(set(pictures)) >= 5, "they move"


def test_codes_have_a_panel_for_each_component_of_each_run():
    rows = [("a", RNG.normal(size=(90, 3)), RNG.uniform(-3, 3, (90, 3))) for _ in range(2)]
    figure = codes.codes_figure(rows, axis_name="IC")
    assert is_png(figure) and len(figure.axes) == 12, "six panels, each with its colour bar"
    assert is_png(codes.codes_figure(rows[:1], colours=style.JET))
    assert len(codes.lattice_figure(rows).axes) == 8


@pytest.mark.parametrize("columns", [1, 2, 5])
def test_codes_of_any_number_of_columns_are_drawn(columns):
    points = RNG.normal(size=(60, columns))
    assert codes.three_columns(points).shape == (60, 3)
    assert is_png(codes.codes_figure([("", points, RNG.normal(size=(60, 3)))]))


def test_a_cyclic_map_is_for_angles_that_close():
    whole, part = np.linspace(-np.pi, np.pi, 50), np.linspace(-0.5, 0.5, 50)
    assert codes.colour_scale(whole, style.CYCLIC)["vmin"] == -np.pi
    assert codes.colour_scale(part, style.CYCLIC) == codes.colour_scale(part, "viridis")
    assert codes.angle_ticks((-np.pi, np.pi))[np.pi] == "π"
    assert codes.angle_ticks((-1.0, 1.0)) == {}
    colours = style.hues(256)
    steps = np.linalg.norm(np.diff(colours, axis=0, append=colours[:1]), axis=1)
    assert ((colours >= 0) & (colours <= 1)).all() and steps.max() < 0.03


def test_a_theme_holds_for_what_is_drawn_inside():
    def background():
        return style.new_figure(2, 2).get_facecolor()[:3]

    with style.theme("dark"):
        dark = background()
    assert max(dark) < 0.2 and min(background()) == 1.0


def about(mean):
    return {"mean": mean, "low": 0.9 * mean, "high": 1.1 * mean}


ROWS = [
    {"agent": agent, "row": preset, "rotation": rotation}
    | {"linear_r2.worst": about(0.9), "equivalence_ratio": about(0.1), "partial_motors": 0.2}
    | {"partial_motors_affine": about(0.1)}
    | {f"equivalence.full_turns.{n}": about(0.5) for n in range(3)}
    for agent in ("forward", "holonomic")
    for preset in ("best", "paper")
    for rotation in (0.4, 0.8)
]


def test_curves_have_a_panel_for_each_measure():
    figure = measures.curves_figure(
        ROWS,
        Axis("rotation", "largest rotation"),
        ["linear_r2.worst", "equivalence_ratio"],
        series=("agent", "row"),
        targets={"linear_r2.worst": 0.99},
    )
    first, second = figure.axes
    assert is_png(figure)
    assert (first.get_title("left"), first.get_xlabel()) == ("linear R², worst", "largest rotation")
    assert len(first.lines) == 6, "four curves, the target and what is perfect"
    assert len(second.lines) == 4 and second.get_yscale() == "log", "no perfect 0 on its scale"
    curves = {line.get_label(): line for line in first.lines}
    forward = curves["forward, best"], curves["forward, paper"]
    assert forward[0].get_color() == forward[1].get_color() != first.lines[2].get_color()
    assert [line.get_linestyle() for line in forward] == ["-", "--"]
    assert figure.legends[0].texts[0].get_text() == "forward, best"


def test_members_of_a_family_become_the_axis_and_a_column_the_panels():
    long = measures.along(ROWS, "equivalence.full_turns", "turns")
    assert len(long) == 3 * len(ROWS)
    assert long[1]["turns"] == 1 and long[1]["equivalence.full_turns"] == about(0.5)
    figure = measures.curves_figure(
        long,
        Axis("turns", scale="symlog", mark=1.0),
        ["equivalence.full_turns"],
        series=("rotation",),
        panels="agent",
    )
    assert [axes.get_title("left") for axes in figure.axes] == ["forward", "holonomic"]
    np.testing.assert_array_equal(figure.axes[0].lines[0].get_xdata()[:3], [0, 1, 2])
    assert is_png(figure)


def test_rows_without_a_measure_are_left_out_of_its_curve():
    rows = [{"x": 1, "rank_correlation": 0.5}, {"x": 2}, {"x": 3, "rank_correlation": None}]
    (axes,) = measures.curves_figure(rows, "x", ["rank_correlation"]).axes
    np.testing.assert_array_equal(axes.lines[0].get_xdata(), [1])


def test_grids_have_no_empty_panels():
    rows = [{"x": 1} | {f"trustworthiness.{k}": 0.9 for k in range(6)}]
    figure = measures.curves_figure(rows, "x", [f"trustworthiness.{k}" for k in range(6)])
    assert len(figure.axes) == 6


def test_one_measure_over_another():
    figure = measures.comparison_figure(
        ROWS, "partial_motors_affine", "partial_motors", series=("agent", "row")
    )
    (axes,) = figure.axes
    assert [bars.get_label() for bars in axes.containers][1] == "forward, paper"
    assert [len(bars.lines[0].get_xdata()) for bars in axes.containers] == [2] * 4
    assert is_png(figure)


def test_changes_have_a_line_each():
    rows = [{"change": "one", "seam_gap": about(2.0)}, {"change": "collapsed"}]
    figure = measures.changes_figure(rows, "change", ["seam_gap"])
    (axes,) = figure.axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["one", "collapsed"]
    assert axes.lines[0].get_ydata().tolist() == [0]
    assert is_png(figure)


def test_learning_has_levels_to_compare_with():
    figure = measures.learning_figure({"training": np.array([3.0, 2.0])}, {"oracle": 1.0})
    assert is_png(figure) and len(figure.axes[0].lines) == 2


def test_maps_paths_and_their_errors():
    cells = RNG.random((12, 8)) > 0.8
    panel = maps.MapPanel("rooms", cells, ~cells, np.zeros(2), 0.5, RNG.random((2, 30)))
    assert len(maps.map_figure([panel, panel]).axes) == 2
    drawn = maps.paths_figure({"codes": RNG.random((2, 30)), "truth": RNG.random((2, 30))})
    assert [line.get_label() for line in drawn.axes[0].lines] == ["codes", "truth"]
    errors = {"hall": {"codes": {"mean": 1.0, "low": 0.5, "high": 2.0}, "still": 9.0}, "yard": {}}
    figure = maps.errors_figure(errors, unit="metres")
    assert [text.get_text() for text in figure.axes[0].get_yticklabels()] == ["hall", "yard"]
    assert [text.get_text() for text in figure.legends[0].texts] == ["codes", "still"]
    assert is_png(drawn) and is_png(figure)
