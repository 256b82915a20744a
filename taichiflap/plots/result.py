"""Figures for print: the last beat in numbers, and the wing with its wake or its loads at instants of that beat."""

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D

from .. import files
from ..drawing import palette, scene
from ..metrics.summary import in_stream, reversals, summarise
from ..motion.sampling import PLUNGE_RATE, sample
from ..notation import prefixed
from ..results.reader import Result
from . import formats

WIDTH = 7.1
"""Width of a figure across two columns of a journal, inches."""
POINTS = 72
"""Points in an inch."""
INSTANTS = 8
ARROWS = 9
"""Arrows of the load along a chord."""
Panel = tuple[str, str, tuple[str, ...]]
"""A panel of the summary: what its axis bears, its unit, and its series."""
DEFLECTION: Panel = ("Tip deflection", "m", ("tip_deflection",))
PLUNGE: Panel = ("Plunge", "m", ("plunge",))
PITCH: Panel = ("Pitch", "deg", ("pitch",))
NORMAL: Panel = ("Normal force", "N", ("force_normal",))
VERTICAL: Panel = ("Vertical force, full vector", "N", ("force_vertical",))
LIFT: Panel = ("Lift across the stream", "N", ("lift",))
THRUST: Panel = ("Thrust against the stream", "N", ("thrust",))
POWER: Panel = ("Mechanical power", "W", ("power", "power_aerodynamic", "power_inertial"))
STYLES: Any = (("total", "-"), ("aerodynamic", "--"), ("inertial", ":"))
"""The power and its parts: name and line."""
MANY_DOTS = 6000
"""More dots than this are drawn as pixels in an SVG, lest it take minutes to open."""

STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "svg.hashsalt": "taichiflap",
    "text.parse_math": False,
    "text.color": palette.LIGHT.ink,
    "axes.labelcolor": palette.LIGHT.ink,
    "axes.edgecolor": palette.LIGHT.muted,
    "xtick.color": palette.LIGHT.muted,
    "ytick.color": palette.LIGHT.muted,
    "xtick.labelcolor": palette.LIGHT.ink,
    "ytick.labelcolor": palette.LIGHT.ink,
}


def plot(
    results: Sequence[Result],
    stem: Path | None = None,
    overwrite: bool = False,
    sheets: bool = False,
    *,
    width: float = WIDTH,
) -> list[Path]:
    """Write `STEM-summary` of all results, and `STEM-wing`, `STEM-wing-2`, ... of each, as PNG and SVG.

    Args:
        stem: how the files' names begin, or a folder to put them in; the first result's own name, here, if None. With
            the extension pdf, eps, svg or png they are written as that alone.
        sheets: colour wakes by the edge that shed them instead of by circulation.
        width: of the figures, inches.

    Returns:
        The files written.

    Raises:
        SceneError: when a result has no whole beat.
        OutputError: when a file exists already or cannot be written.
    """
    stem, kinds = formats.asked(stem)
    stem = files.place(results[0], stem)
    names = ["summary", *("wing" if number == 1 else f"wing-{number}" for number in range(1, len(results) + 1))]
    for name in names:
        for kind in kinds:
            files.check(stem.with_name(f"{stem.name}-{name}.{kind}"), overwrite)
    wings = (wing(one, sheets, width) for one in results)
    figures = dict(zip(names, (summary(results, width), *wings), strict=True))
    return formats.write(figures, stem, kinds, STYLE, overwrite)


def summary(results: Sequence[Result], width: float = WIDTH) -> Figure:
    """Tip deflection, forces and power over the last beat of each result.

    Raises:
        SceneError: when a result has no whole beat.
    """
    for result in results:
        scene.last_steps(result)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, 4.9), layout="constrained")
        axes = list(figure.subplots(2, 2, sharex=True).flat)
        handles, names, shown = [], _names(results), panels(results)
        units = [_unit(results, panel) for panel in shown]
        length, label_of_time = scene.abscissa(results[0].case)
        for number, result in enumerate(results):
            colour = palette.SEVERAL[number % len(palette.SEVERAL)]
            turns = result.time[scene.last_steps(result)] / result.case.beat
            turns = length * (turns - round(turns[-1]) + 1.0)
            for ax in axes if result.has_sheets else ():
                _mark_shedding(ax, turns, _last_beat(result, "leading_edge_sheds") > 0.5, number)
            for ax, (factor, _), (_, _, series) in zip(axes, units, shown, strict=True):
                for variable, (_, line) in zip(series, STYLES, strict=False):
                    thick = 1.3 if line == "-" else 1.0
                    ax.plot(turns, factor * _last_beat(result, variable), line, color=colour, linewidth=thick)
            name = f"{names[number]} ({result.case.model}{_mean_force(result)})"
            handles.append(Line2D([], [], color=colour, label=name))
        for letter, ax, (label, _, series), (_, unit) in zip("abcd", axes, shown, units, strict=True):
            _shade(ax, results[0], length)
            ax.set(ylabel=f"{label} ({unit})", xlim=(0.0, length))
            ax.axhline(0.0, color=palette.LIGHT.muted, linewidth=0.5, zorder=1)
            ax.annotate(f"({letter})", (0.0, 1.0), (-36, 7), "axes fraction", "offset points", fontweight="bold")
            if len(series) > 1:
                # Above the tallest line, so that the key crosses none of them.
                low, high = ax.get_ylim()
                ax.set_ylim(low, high + 0.14 * (high - low))
                key = [Line2D([], [], linestyle=line, color=palette.LIGHT.ink, label=name) for name, line in STYLES]
                ax.legend(handles=key, loc="upper center", ncols=3, handlelength=1.9, columnspacing=1.2)
        for ax in axes[2:]:
            ax.set_xlabel(label_of_time)
        figure.legend(handles=handles, loc="outside upper center", ncols=1)
    return figure


def wing(result: Result, sheets: bool = False, width: float = WIDTH) -> Figure:
    """The wing at instants of the last beat: with its wake if the model has one, else with the load on the chord.

    Raises:
        SceneError: when the result has no whole beat.
    """
    stored = scene.last_beats(result)
    # A beat ends as it begins; a motion that does not repeat is shown to its end, and begins with no wake.
    instants = np.linspace(0, len(stored) - 1, INSTANTS + 1)
    chosen = stored[np.rint(instants).astype(int)[:-1] if result.case.periodic else np.rint(instants).astype(int)[1:]]
    frames = [scene.frame(result, int(index)) for index in chosen]
    beat = round(frames[0].beats)
    chord = result.case.wing.chord
    shared = scene.bounds(frames, result.case)
    dotted = any(len(frame.wake) for frame in frames)
    many = sum(len(frame.wake) for frame in frames) > MANY_DOTS
    left, right, bottom, top = (1e3 * edge for edge in shared.page)
    columns = INSTANTS // 2
    cell = (width - (1.75 if dotted else 0.6)) / columns - 0.1
    size = POINTS * cell * 1e3 * chord / (right - left)
    height = min(2.0 * cell * (top - bottom) / (right - left) + 1.15, 9.0)
    head = 1.0 - 0.13 / height
    layout = ConstrainedLayoutEngine(compress=True, rect=(0.0, 0.0, 1.0, 1.0 - 0.26 / height))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout=layout)
        axes = figure.subplots(2, columns, sharex=True, sharey=True, squeeze=False)
        for ax, frame in zip(axes.flat, frames, strict=True):
            dots = _draw_wake(ax, frame, shared, size, many, sheets) if dotted else None
            _draw_wing(ax, frame, size)
            ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
            ax.set_title(scene.when(result.case, round(frame.beats, 6)), fontsize=8, pad=3)
            arrows = (_draw_load if dots is None else _draw_force)(ax, frame, shared, chord, size)
        streams = scene.stream(result.case)
        across, up = ("Along the stream", "Lift up") if streams else ("Along the stroke, Z", "Up, −Y")
        figure.supxlabel(f"{across} (mm)", fontsize=8)
        figure.supylabel(f"{up} (mm)", fontsize=8)
        if streams:
            _draw_stream(axes.flat[0], streams)
        if dots is None:
            text, size = f"{shared.traction:g} Pa, force of the fluid per area", shared.traction
        else:
            factor, unit = prefixed(shared.force, "N")
            text, size = f"{factor * shared.force:g} {unit}, force of the fluid", shared.force
            if sheets:
                marks = [
                    Line2D([], [], marker="o", linestyle="", markersize=4, color=colour, label=f"{edge} edge")
                    for colour, edge in zip(palette.SHEETS, ("trailing", "leading"), strict=True)
                ]
                figure.legend(handles=marks, loc="outside right center", title="Shed by the")
            else:
                bar = figure.colorbar(
                    dots, ax=axes, shrink=0.85, aspect=35, pad=0.015, extend="both" if shared.saturated else "neither"
                )
                bar.set_label("Circulation of wake vortices, Γ (m² s⁻¹)\npositive counter-clockwise")
                bar.outline.set_linewidth(0.4)
        title = f"{scene.label(result)}, {result.case.model}{f': beat {beat + 1}' if result.case.periodic else ''}"
        figure.text(0.01, head, title, va="center", fontsize=8.5)
        axes[0, 0].quiverkey(
            arrows, 0.94, head, size, text, labelpos="W", coordinates="figure", fontproperties={"size": 7.5}
        )
    return figure


def panels(results: Sequence[Result]) -> list[Panel]:
    """What a summary shows: lift and thrust where there is a stream, and the motion of wings that do not bend."""
    cases = [result.case for result in results]
    moved = PLUNGE if any(np.ptp(result.plunge) for result in results) else PITCH
    first = DEFLECTION if any(case.wing.modes for case in cases) else moved
    forces = (LIFT, THRUST) if all(any(case.fluid.velocity) for case in cases) else (NORMAL, VERTICAL)
    return [first, *forces, POWER]


def _last_beat(result: Result, name: str) -> np.ndarray:
    """A series over the last beat; of a force in a stream its part across or against it."""
    steps = scene.last_steps(result)
    if name in ("lift", "thrust"):
        lift, thrust = in_stream(result.case, result.force_y[steps], result.force_z[steps])
        return lift if name == "lift" else thrust
    return np.asarray(getattr(result, name)[steps])


def _unit(results: Sequence[Result], panel: Panel) -> tuple[float, str]:
    """Factor to what a panel is drawn in, and its name."""
    _, unit, series = panel
    if unit == "deg":
        return 180.0 / math.pi, unit
    return prefixed(max(float(np.abs(_last_beat(result, name)).max()) for result in results for name in series), unit)


def _names(results: Sequence[Result]) -> list[str]:
    """Titles of the results, with their files' names where titles alone would not tell them apart."""
    names = [scene.label(result) for result in results]
    if len(set(names)) == len(names):
        return names
    return [f"{name}, {files.place(result, None)}" for name, result in zip(names, results, strict=True)]


def _mean_force(result: Result) -> str:
    """The mean vertical force, or thrust in a stream, as `info` gives it; nothing of a run that failed."""
    settled = summarise(result) if result.status != "failed" else None
    if settled is None:
        return ""
    name, force = ("thrust", settled.thrust) if settled.thrust else ("vertical force", settled.force_vertical)
    factor, unit = prefixed(force.mean, "N")
    return f", mean {name} {factor * force.mean:.3g} {unit}".replace("-", "−")


def _shade(ax: Any, result: Result, length: float) -> None:
    """Shade the half-strokes towards +Z; `length` is what a beat is on the axis."""
    case = result.case
    end = round(result.time[scene.last_steps(result)][-1] / case.beat)
    found = reversals(case, end - 1.0, end)
    if not len(found):
        return
    edges = [float(end - 1), *found, float(end)]
    for left, right in itertools.pairwise(edges):
        if right - left < 1e-6:
            continue
        middle = 0.5 * (left + right)
        forth = sample(case.motion, np.array([middle * case.beat]))[0, PLUNGE_RATE] > 0.0
        if forth:
            span = length * (left - edges[0]), length * (right - edges[0])
            ax.axvspan(*span, color=palette.LIGHT.faint, linewidth=0.0, zorder=0)
        ax.annotate(
            f"stroke to {'+' if forth else '−'}Z", (length * (middle - edges[0]), 1.0), (0, 3),
            ("data", "axes fraction"), "offset points",
            ha="center", va="bottom", fontsize=7, color=palette.LIGHT.muted,
        )  # fmt: skip


def _mark_shedding(ax: Any, turns: np.ndarray, sheds: np.ndarray, number: int) -> None:
    """A bar along the bottom while the leading edge sheds; those of several results lie over each other."""
    low = 0.025 * number
    colour, over = palette.SHEETS[1], ax.get_xaxis_transform()
    ax.fill_between(turns, low, low + 0.02, where=sheds, transform=over, color=colour, linewidth=0.0, zorder=1)


def _draw_stream(ax: Any, text: str) -> None:
    """An arrow along the free stream, in the upper left corner."""
    end, tail = (0.24, 0.92), (0.04, 0.92)
    look = {"arrowstyle": "->", "shrinkA": 0, "shrinkB": 0, "linewidth": 0.8}
    ax.annotate("", end, tail, "axes fraction", "axes fraction", arrowprops=look)
    ax.annotate(text, (0.04, 0.9), xycoords="axes fraction", va="top", fontsize=7)


def _draw_wake(ax: Any, frame: scene.Frame, shared: scene.Bounds, size: float, many: bool, sheets: bool) -> Any:
    """Dots that shrink with the page; `size` is the chord on it, points."""
    if sheets:
        colours = np.array(palette.SHEETS)[frame.edge]
        area = np.clip(0.105 * size, 0.8, 2.0) ** 2
        return ax.scatter(*(1e3 * frame.wake.T), c=colours, linewidths=0.0, s=area, rasterized=many, zorder=2)
    cmap = ListedColormap(palette.table() / 255.0)
    order = np.argsort(np.abs(frame.circulation))
    return ax.scatter(
        *(1e3 * frame.wake[order].T), c=frame.circulation[order], cmap=cmap, linewidths=0.0,
        s=np.clip(0.105 * size, 0.8, 2.0) ** 2,
        norm=Normalize(-shared.circulation, shared.circulation), rasterized=many, zorder=2,
    )  # fmt: skip


def _draw_wing(ax: Any, frame: scene.Frame, size: float) -> None:
    width = np.clip(0.085 * size, 0.8, 1.6)
    ax.plot(*(1e3 * frame.wing.T), color=palette.LIGHT.ink, linewidth=width, solid_capstyle="round", zorder=4)
    ax.plot(*(1e3 * frame.wing[0]), "o", color=palette.LIGHT.ink, markersize=1.9 * width, zorder=4)


def _draw_force(ax: Any, frame: scene.Frame, shared: scene.Bounds, chord: float, size: float) -> Any:
    return _arrows(
        ax,
        frame.foot[None, :],
        frame.force[None, :],
        shared.force / (scene.REACH * chord),
        np.clip(0.06 * size, 0.5, 1.1),
    )


def _draw_load(ax: Any, frame: scene.Frame, shared: scene.Bounds, chord: float, size: float) -> Any:
    """The load along the chord: arrows from the wing to the curve that joins their tips."""
    scale = shared.traction / (scene.REACH * chord)
    feet = frame.middles
    ax.plot(*(1e3 * (feet + frame.traction / scale)).T, color=palette.LIGHT.force, linewidth=0.8, zorder=3)
    chosen = np.unique(np.rint(np.linspace(0, len(feet) - 1, ARROWS)).astype(int))
    return _arrows(ax, feet[chosen], frame.traction[chosen], scale, 0.7)


def _arrows(ax: Any, feet: np.ndarray, vectors: np.ndarray, scale: float, width: float) -> Any:
    """Arrows on axes in mm; `scale` is what one metre stands for, `width` is in points."""
    return ax.quiver(
        *(1e3 * feet).T, *vectors.T, color=palette.LIGHT.force, angles="xy", scale_units="xy", scale=1e-3 * scale,
        units="inches", width=width / POINTS, headwidth=4.0, headlength=5.0, headaxislength=4.5, zorder=5,
    )  # fmt: skip
