"""Draw the pictures of the documentation that show a trained network: `python -m docs.portraits`.

It trains the preset `best` for a few minutes first.
"""

import io
import math

import jax
import matplotlib
import numpy as np
from jaxtyping import Float, Int
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import motorspace as ms
from docs.drawings import BLUE, CARD, FAINT, INK, ORANGE, PICTURES, STYLE
from motorspace.trajectories.equivalent import equivalent_sequences

NIGHT, PALE = "#10141d", "#c9d0dc"
Numbers = Float[np.ndarray, "..."]


def main() -> None:
    """Train a network and draw it."""
    agent = ms.HolonomicAgent()
    config = ms.RunConfig(ms.Simulated(agent=agent), preset="best")
    run = ms.train(ms.changed(config, {"epochs": 400}))
    scenario = config.data.scenario()
    walk = ms.sample(scenario, num=12_000, horizon=6, key=jax.random.key(3))
    motors = np.asarray(walk.experience.motors)
    displacements = np.asarray(walk.displacements.nominal)
    codes = np.asarray(run.encode(motors))
    twins = equivalent_sequences(agent, num_groups=400, horizon=6, key=jax.random.key(5))
    pair = chosen(twins.motors, twins.groups)
    drawn = {
        "hero": hero(motors, displacements, codes),
        "equivalent": equivalent(pair, np.asarray(run.encode(pair)), codes),
    }
    for name, figure in drawn.items():
        (PICTURES / f"{name}.png").write_bytes(png(figure))


def png(figure: Figure) -> bytes:
    """The figure as a PNG file, two pixels to the point of a common screen."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=160, facecolor=figure.get_facecolor())
    return buffer.getvalue()


def hero(
    motors: Float[np.ndarray, "N T M"],
    displacements: Float[np.ndarray, "N 3"],
    codes: Float[np.ndarray, "N C"],
) -> Figure:
    """Where motor sequences lead, and their codes on four independent components.

    The components know nothing of displacements, so they come turned and mirrored at random;
    for the eye each pair is turned back. The colours are the true displacements.
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(12, 4.5), facecolor=NIGHT)
        panels = [figure.add_axes((x, 0.02, 0.31, 0.83)) for x in (0.015, 0.345, 0.675)]
        plane = plane_colours(displacements[:, 0], displacements[:, 1])
        around = wheel_colours(displacements[:, 2])
        _paths(panels[0], motors[:150], plane[:150])
        components = independent(codes)
        place, circle = displacements[:, :2], displacements[:, 2]
        _cloud(panels[1], turned(components[:, 2:], place), plane, 3.2)
        unit = np.stack([np.cos(circle), np.sin(circle)], axis=-1)
        _cloud(panels[2], turned(components[:, :2], unit), around, 1.75)
        titles = (
            "what the agent does: six commands",
            "the codes: where it went",
            "the codes: how far it turned",
        )
        for axes, title in zip(panels, titles, strict=True):
            axes.axis("off")
            axes.set_title(title, color=PALE, fontsize=12.5, pad=8)
    return figure


def _paths(axes: Axes, motors: Numbers, colours: Numbers) -> None:
    for sequence, colour in zip(motors, colours, strict=True):
        path = path_of(sequence)
        axes.plot(*path.T, color=colour, lw=0.9, alpha=0.55, solid_joinstyle="round")
        axes.scatter(*path[-1], color=[colour], s=20, linewidths=0, zorder=3)
    axes.scatter(0, 0, color="white", s=46, zorder=4)
    axes.set(xlim=(-4, 4), ylim=(-4, 4), aspect="equal")


def _cloud(axes: Axes, points: Numbers, colours: Numbers, reach: float) -> None:
    axes.scatter(*points.T, c=colours, s=5, linewidths=0, alpha=0.85)
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")


def independent(codes: Float[np.ndarray, "N C"]) -> Float[np.ndarray, "N 4"]:
    """Four independent components, those of a circle first: they are the least peaked."""
    found = ms.ica(codes, 4)
    return np.asarray(found[:, np.argsort((found**4).mean(axis=0))])


def turned(points: Float[np.ndarray, "N 2"], like: Numbers) -> Float[np.ndarray, "N 2"]:
    """The points, turned and mirrored to lie as much as possible like others (Procrustes)."""
    left, _, right = np.linalg.svd(points.T @ (like - like.mean(axis=0)))
    return np.asarray(points @ left @ right)


def path_of(motors: Float[np.ndarray, "T 4"]) -> Float[np.ndarray, "points 2"]:
    """The way of a holonomic agent from the origin, walls aside."""
    place, heading, way = np.zeros(2), 0.0, [np.zeros(2)]
    for turn, ahead, aside, _ in motors:
        heading += turn
        cos, sin = math.cos(heading), math.sin(heading)
        for step in (np.array([cos, sin]) * ahead, np.array([-sin, cos]) * aside):
            place = place + step
            way.append(place)
    return np.array(way)


def plane_colours(x: Numbers, y: Numbers) -> Float[np.ndarray, "N 3"]:
    """A colour for each point of a plane: hue is direction, chroma is distance (Oklab)."""
    reach = np.quantile(np.hypot(x, y), 0.98)
    chroma = 0.155 * np.minimum(np.hypot(x, y) / reach, 1.0)
    return _oklab(0.80 - 0.4 * chroma, chroma, np.arctan2(y, x))


def wheel_colours(angle: Numbers) -> Float[np.ndarray, "N 3"]:
    """A colour for each angle, of one lightness all round (Oklab)."""
    return _oklab(np.full_like(angle, 0.76), np.full_like(angle, 0.135), angle)


def _oklab(lightness: Numbers, chroma: Numbers, hue: Numbers) -> Float[np.ndarray, "N 3"]:
    """sRGB of Oklab colours in polar form (Ottosson, 2020), cut off at the gamut."""
    a, b = chroma * np.cos(hue), chroma * np.sin(hue)
    to_cone = np.array(
        [
            [1, 0.3963377774, 0.2158037573],
            [1, -0.1055613458, -0.0638541728],
            [1, -0.0894841775, -1.2914855480],
        ]
    )
    to_rgb = np.array(
        [
            [4.0767416621, -3.3077115913, 0.2309699292],
            [-1.2684380046, 2.6097574011, -0.3413193965],
            [-0.0041960863, -0.7034186147, 1.7076147010],
        ]
    )
    cone = (np.stack([lightness, a, b], axis=-1) @ to_cone.T) ** 3
    linear = np.clip(cone @ to_rgb.T, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def chosen(
    motors: Float[np.ndarray, "N T M"], groups: Int[np.ndarray, " N"]
) -> Float[np.ndarray, "3 T M"]:
    """Two sequences of one group that look most different, and one that leads elsewhere."""
    ways = np.array([path_of(sequence) for sequence in motors])
    best, pair = 0.0, (0, 1)
    for group in np.unique(groups):
        members = np.flatnonzero(groups == group)
        apart = np.abs(ways[members][:, None] - ways[members][None]).sum(axis=(-1, -2))
        if apart.max() > best and np.hypot(*ways[members[0], -1]) > 1.5:
            best = float(apart.max())
            pair = tuple(members[list(np.unravel_index(apart.argmax(), apart.shape))])
    # Elsewhere: as far from home as the pair, a quarter turn away.
    end = ways[pair[0], -1]
    wanted = np.array([-end[1], end[0]])
    other = int(np.argmin(np.hypot(*(ways[:, -1] - wanted).T)))
    return motors[[*pair, other]]


def equivalent(
    motors: Float[np.ndarray, "3 T M"],
    codes: Float[np.ndarray, "3 C"],
    all_codes: Float[np.ndarray, "N C"],
) -> Figure:
    """Two different motor sequences with one displacement share a code; a third does not."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(11, 3.9), facecolor=CARD, layout="constrained")
        ways, commands, bars = figure.subplots(1, 3, width_ratios=(1.15, 1, 0.9))
        colours, names = (BLUE, ORANGE, FAINT), ("A", "B", "C")
        for sequence, colour, name in zip(motors, colours, names, strict=True):
            _way(ways, sequence, colour, name)
        ways.scatter(0, 0, color=INK, s=60, zorder=4)
        ways.margins(0.14)
        ways.set(aspect="equal", title="A and B lead to one place ...")
        ways.axis("off")
        _commands(commands, motors[:2], colours[:2])
        for axes in (commands, bars):
            axes.set_facecolor(CARD)
        scaled = (codes - all_codes.mean(axis=0)) / all_codes.std(axis=0)
        places = np.arange(scaled.shape[1])
        for index, (code, colour, name) in enumerate(zip(scaled, colours, names, strict=True)):
            bars.bar(places + 0.27 * (index - 1), code, 0.25, color=colour, label=name)
        bars.axhline(0, color=INK, lw=0.8)
        bars.set(title="... share one code", xlabel="unit of the code", xticks=places)
        bars.set_xticklabels([str(1 + place) for place in places])
        bars.spines[["top", "right", "bottom"]].set_visible(False)
        bars.set_ylim(-2.6, None)
        bars.legend(frameon=False, ncols=3, loc="lower right")
    return figure


def _way(axes: Axes, sequence: Numbers, colour: str, name: str) -> None:
    way = path_of(sequence)
    heading = float(sequence[:, 0].sum())
    axes.plot(*way.T, color=colour, lw=2.2, solid_joinstyle="round", alpha=0.9)
    axes.scatter(*way[1:-1].T, color=colour, s=9)
    nose = (3, 0, math.degrees(heading) - 90)
    axes.plot(*way[-1], marker=nose, markersize=15, color=colour, zorder=5)
    middle = way[len(way) // 2]
    axes.text(*(middle + 0.12), name, color=colour, weight="bold", fontsize=14)


def _commands(axes: Axes, motors: Numbers, colours: tuple[str, ...]) -> None:
    """The commands themselves, channel by channel, as steps."""
    steps = np.arange(1, motors.shape[1] + 1)
    for channel in range(3):
        for sequence, colour in zip(motors, colours, strict=True):
            scale = 2.2 * np.abs(motors[..., channel]).max()
            axes.step(
                steps, sequence[:, channel] / scale - channel, color=colour, lw=1.8, where="mid"
            )
        axes.axhline(-channel, color=INK, alpha=0.15, lw=0.8, zorder=0)
    axes.set(title="by different commands ...", xlabel="command", yticks=(0, -1, -2), xticks=steps)
    axes.set_yticklabels(("turn", "ahead", "aside"))
    axes.tick_params(axis="y", length=0, colors=INK)
    axes.spines[["top", "right", "left"]].set_visible(False)


if __name__ == "__main__":
    main()
