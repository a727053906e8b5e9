"""How organisation changes with the largest rotation and the length of sequences, as pictures."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

Row = Mapping[str, Any]

PANELS: tuple[tuple[str, str, float | None, bool], ...] = (
    ("linear R2", "R2 of the worst component", 0.99, False),
    ("collapse ratio", "collapse ratio", 0.01, True),
    ("AUC", "AUC of equivalent pairs", 0.99, False),
    ("partial, motors", "partial correlation with motors", 0.05, False),
    ("D_topo", "normalised D_topo", 0.1, False),
    ("trustworthiness", "trustworthiness, k = 20", 0.98, False),
    ("winding", "winding number", 1.0, False),
    ("loop", "loop persistence", None, False),
)
"""Measure, what its panel is called, its target, whether on a logarithmic scale."""

STYLES = {"best": "-", "paper": "--"}
COLOURS = {"forward": "tab:blue", "holonomic": "tab:orange"}


def organisation_figure(rows: Sequence[Row]) -> Figure:
    """Every measure with a target over the largest rotation, with its interval over seeds."""
    figure = Figure(figsize=(14, 6.4), layout="constrained")
    for axes, (name, title, target, logarithmic) in zip(
        figure.subplots(2, 4).flat, PANELS, strict=True
    ):
        for label, curve in _curves(rows).items():
            points = [(r["rotation"], r[name]) for r in curve if name in r]
            _preset_line(axes, label, points)
        if target is not None:
            axes.axhline(target, color="0.4", lw=0.8, ls=":")
        axes.set(title=title, xlabel="largest rotation, units of pi")
        if logarithmic:
            axes.set_yscale("log")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def turns_figure(rows: Sequence[Row]) -> Figure:
    """How far apart equivalent sequences lie that differ by whole turns, at each rotation."""
    figure = Figure(figsize=(11, 3.8), layout="constrained")
    for axes, (label, curve) in zip(
        figure.subplots(1, 4, sharey=True), sorted(_curves(rows).items()), strict=True
    ):
        for row in curve:
            found = [(n, row[f"{n} full turns"]) for n in range(5) if f"{n} full turns" in row]
            if found:
                _line(axes, f"r = {row['rotation']} pi", found)
        axes.set(title=", ".join(label), xlabel="full turns apart", yscale="log")
    figure.axes[0].set_ylabel("squared distance / all pairs'")
    figure.axes[0].legend(fontsize=8)
    return figure


def drawn_figure(rows: Sequence[Row]) -> Figure:
    """How far apart whole turns lie over how often training draws them, a panel for each agent."""
    figure = Figure(figsize=(9, 3.8), layout="constrained")
    for axes, agent in zip(figure.subplots(1, 2, sharey=True), COLOURS, strict=True):
        for name, style in STYLES.items():
            for place, turns in enumerate(sorted({r["turns"] for r in rows})):
                found = (agent, name, turns)
                curve = [r for r in rows if (r["agent"], r["row"], r["turns"]) == found]
                points = [(r["drawn"], r["ratio"]) for r in curve]
                _line(axes, f"{name}, {turns} full turns", points, color=f"C{place}", ls=style)
        axes.set(title=agent, xlabel="share of the sequences drawn", yscale="log")
        axes.set_xscale("symlog", linthresh=1e-5)  # three turns may never be drawn
        axes.set_xlim(left=-5e-6)
    figure.axes[0].set_ylabel("squared distance / all pairs'")
    figure.axes[0].legend(fontsize=8, loc="center left")
    return figure


def lengths_figure(rows: Sequence[Row], *, rotation: float) -> Figure:
    """Error of the decoded translation over the length of the sequence."""
    figure = Figure(figsize=(5.2, 4), layout="constrained")
    axes = figure.add_subplot()
    for label, curve in _curves(rows).items():
        for row in curve:
            if row["rotation"] == rotation:
                lengths = [n for n in range(1, 25) if f"T = {n}" in row]
                _preset_line(axes, label, [(n, row[f"T = {n}"]) for n in lengths])
    axes.axvline(6, color="0.4", lw=0.8, ls=":")
    axes.set(
        xlabel="commands in a sequence (trained on 6)",
        ylabel="error of the translation, world units",
        xscale="log",
        yscale="log",
    )
    axes.legend()
    return figure


def copies_figure(rows: Sequence[Row]) -> Figure:
    """Correlation of codes with motors over that of their part which is affine in displacement."""
    figure = Figure(figsize=(5.2, 4), layout="constrained")
    axes = figure.add_subplot()
    for (agent, name), curve in _curves(rows).items():
        told = [r for r in curve if "partial, affine" in r]
        x, y = (_ends([r[m] for r in told]) for m in ("partial, affine", "partial, motors"))
        filled = COLOURS[agent] if name == "best" else "none"
        axes.errorbar(
            x["mean"],
            y["mean"],
            xerr=(x["mean"] - x["low"], x["high"] - x["mean"]),
            yerr=(y["mean"] - y["low"], y["high"] - y["mean"]),
            label=f"{agent}, {name}",
            fmt="o",
            ms=4,
            lw=0.8,
            color=COLOURS[agent],
            mfc=filled,
        )
    axes.axline((0, 0), slope=1, color="0.4", lw=0.8, ls=":")
    axes.set(
        xlabel="that of the part which is affine in displacement",
        ylabel="partial correlation with motors",
    )
    axes.legend()
    return figure


def standard_figure(rows: Sequence[Row]) -> Figure:
    """Codes as they are and in standard form: order of distances, and what motors add to it."""
    figure = Figure(figsize=(11, 3.8), layout="constrained")
    for axes, name in zip(
        figure.subplots(1, 2), ("rank correlation", "semipartial, motors"), strict=True
    ):
        for label, curve in _curves(rows).items():
            _preset_line(axes, label, [(r["rotation"], r[name]) for r in curve if name in r])
            standard = f"{name}, standard"
            if points := [(r["rotation"], r[standard]) for r in curve if standard in r]:
                title = ", ".join((*label, "standard form"))
                _line(axes, title, points, color=COLOURS[label[0]], ls=":")
        axes.set(title=name, xlabel="largest rotation, units of pi")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside right center")
    return figure


def folding_figure(rows: Sequence[Row]) -> Figure:
    """Collapse by whole turns over the course of training, a panel for each preset."""
    figure = Figure(figsize=(9, 3.8), layout="constrained")
    for axes, name in zip(figure.subplots(1, 2, sharey=True), STYLES, strict=True):
        for turns in sorted({r["turns"] for r in rows}):
            curve = [r for r in rows if r["row"] == name and r["turns"] == turns]
            points = [(r["epoch"], r["ratio"]) for r in curve]
            if points:
                _line(axes, f"{turns} full turns apart", points)
        axes.set(title=name, xlabel="epoch", yscale="log")
    figure.axes[0].set_ylabel("squared distance / all pairs'")
    figure.axes[0].legend(fontsize=8)
    return figure


def angle_figure(rows: Sequence[Row]) -> Figure:
    """How much worse the sensors are predicted where angles are wrong by a factor."""
    figure = Figure(figsize=(5.2, 4), layout="constrained")
    axes = figure.add_subplot()
    for rotation in sorted({r["rotation"] for r in rows}):
        curve = [r for r in rows if r["rotation"] == rotation and "ratio" in r]
        _line(axes, f"r = {rotation} pi", [(r["angle"], r["ratio"]) for r in curve])
    axes.set(xlabel="angles are taken for ... times what they are", ylabel="error / that with 1")
    axes.legend()
    return figure


def changes_figure(rows: Sequence[Row], label: str, panels: Mapping[str, str]) -> Figure:
    """One line for each row, called by its `label`; a panel for each measure, {name: title}."""
    size = (1.5 + 3 * len(panels), 1.2 + 0.26 * len(rows))
    figure = Figure(figsize=size, layout="constrained")
    places = range(len(rows))
    for axes, (name, title) in zip(
        figure.subplots(1, len(panels), sharey=True, squeeze=False)[0], panels.items(), strict=True
    ):
        shown = [place for place in places if name in rows[place]]
        told = _ends([rows[place][name] for place in shown])
        axes.hlines(shown, told["low"], told["high"], color="tab:blue")
        axes.plot(told["mean"], shown, "o", ms=4, color="tab:blue")
        axes.set(title=title, yticks=places, yticklabels=[row[label] for row in rows])
        axes.grid(axis="y", lw=0.4)
    figure.axes[0].invert_yaxis()
    return figure


def _curves(rows: Sequence[Row]) -> dict[tuple[str, str], list[Row]]:
    return {
        (agent, name): curve
        for agent in COLOURS
        for name in STYLES
        if (curve := [r for r in rows if r["agent"] == agent and r["row"] == name])
    }


def _preset_line(
    axes: Axes, label: tuple[str, str], points: Sequence[tuple[float | int, Row]]
) -> None:
    agent, name = label
    _line(axes, f"{agent}, {name}", points, color=COLOURS[agent], ls=STYLES[name])


def _ends(intervals: Sequence[Row]) -> dict[str, Float[np.ndarray, " _"]]:
    """Means and ends of many intervals."""
    return {k: np.array([told[k] for told in intervals]) for k in ("low", "mean", "high")}


def _line(axes: Axes, label: str, points: Sequence[tuple[float | int, Row]], **style: Any) -> None:
    x, told = [value for value, _ in points], _ends([found for _, found in points])
    drawn = axes.plot(x, told["mean"], marker="o", ms=3.5, label=label, **style)
    axes.fill_between(x, told["low"], told["high"], alpha=0.2, color=drawn[0].get_color(), lw=0)
