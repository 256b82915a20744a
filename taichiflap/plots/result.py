"""Figures for print: series over the last beat, and the wing with its wake or its loads at instants of that beat."""

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
from ..drawing import flow, palette, scene
from ..drawing.orientation import INERTIAL
from ..notation import prefixed
from ..results.reader import Result
from . import formats, style
from .histories import panels, summary
from .style import WIDTH

__all__ = ["panels", "plot", "summary", "wing"]

POINTS = 72
"""Points per inch."""
INSTANTS = 8
LINE = 0.26
"""Height of a line of the heading, inches."""
ARROWS = 9
"""Number of load arrows along a chord."""
ACROSS = 320
"""Points along the longer side of a picture of the flow."""
FINE = 0.7
"""Width of the wing over such a picture, relative to that of one alone."""
MANY_DOTS = 6000
"""Above this number dots are drawn as pixels in an SVG, to keep the file small."""


def plot(
    results: Sequence[Result],
    stem: Path | None = None,
    overwrite: bool = False,
    sheets: bool = False,
    *,
    width: float = WIDTH,
    metrics: Sequence[str] = (),
    beats: int = 1,
    look: str | None = None,
    reference: str = INERTIAL,
) -> list[Path]:
    """Write `STEM-summary` of all results, and `STEM-wing`, `STEM-wing-2`, ... of each, as PNG and SVG.

    Args:
        stem: start of the file names, or their folder; if None, the first result's name in the current folder. With the
            extension pdf, eps, svg or png only that type is written.
        sheets: colour wakes by the edge that shed them instead of by circulation.
        width: width of the figures, inches.
        metrics: names of series for the summary, instead of tip deflection, forces and power.
        beats: how many of the last beats the summary shows.
        look: a style of matplotlib's, or a `.mplstyle` file, over the house's own.
        reference: the frame of reference that wings are drawn in, `inertial` or `wing`.

    Returns:
        The files written.

    Raises:
        SceneError: when a result has no whole beat.
        SeriesError: when a result has no such series.
        OutputError: when a file exists already or cannot be written, or there is no such style.
    """
    stem, kinds = formats.asked(stem)
    stem = files.place(results[0], stem)
    names = ["summary", *("wing" if number == 1 else f"wing-{number}" for number in range(1, len(results) + 1))]
    for name in names:
        for kind in kinds:
            files.check(stem.with_name(f"{stem.name}-{name}.{kind}"), overwrite)
    with style.using(look):
        wings = (wing(one, sheets, width, reference) for one in results)
        figures = dict(zip(names, (summary(results, width, metrics, beats), *wings), strict=True))
        return formats.write(figures, stem, kinds, style.current(), overwrite)


def wing(result: Result, sheets: bool = False, width: float = WIDTH, reference: str = INERTIAL) -> Figure:
    """The wing at instants of the last beat: with its wake or the vorticity if there is one, else its load.

    Raises:
        SceneError: when the result has no whole beat.
    """
    stored = scene.last_beats(result)
    # A beat ends as it begins; a non-periodic motion starts without a wake and is shown to its end.
    instants = np.linspace(0, len(stored) - 1, INSTANTS + 1)
    chosen = stored[np.rint(instants).astype(int)[:-1] if result.case.periodic else np.rint(instants).astype(int)[1:]]
    frames = [scene.frame(result, int(index), reference) for index in chosen]
    beat = round(frames[0].beats)
    chord = result.case.wing.chord
    backdrop = flow.Backdrop.of(result, chosen, reference)
    shared = scene.bounds(frames, result.case, backdrop.box if backdrop else None)
    dotted = any(len(frame.wake) for frame in frames)
    many = sum(len(frame.wake) for frame in frames) > MANY_DOTS
    left, right, bottom, top = (1e3 * edge for edge in shared.page)
    narrow = width < style.NARROW
    rows, columns = (4, 2) if narrow else (2, 4)
    title = f"{scene.label(result)}, {result.case.model}{f': beat {beat + 1}' if result.case.periodic else ''}"
    lines = style.wrapped(title, width) if narrow else title
    coloured = bool(dotted or backdrop)
    beside = 1.75 if coloured and not narrow else 0.6
    cell = (width - beside) / columns - 0.1
    size = POINTS * cell * 1e3 * chord / (right - left)
    # Of a narrow figure the key to the arrows is below the title, and that to the colours below the panels.
    heading = LINE * (1 + narrow * (1 + lines.count("\n")))
    height = rows * (cell * (top - bottom) / (right - left) + 0.22) + 0.45 + heading
    height = min(height + 0.6 * (narrow and coloured), 9.0)
    layout = ConstrainedLayoutEngine(compress=True, rect=(0.0, 0.0, 1.0, 1.0 - heading / height))
    with mpl.rc_context(style.current()):
        figure = Figure(figsize=(width, height), layout=layout)
        axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for ax, frame in zip(axes.flat, frames, strict=True):
            dots = _draw_wake(ax, frame, shared, size, many, sheets) if dotted else None
            if backdrop:
                dots = _draw_flow(ax, frame, shared, backdrop)
            _draw_wing(ax, frame, size * (FINE if backdrop else 1.0))
            ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
            ax.set_title(scene.when(result.case, round(frame.beats, 6)), fontsize=8, pad=3)
            arrows = (_draw_load if dots is None else _draw_force)(ax, frame, shared, chord, size)
        streams = scene.stream(result.case)
        across, up = ("Along the stream", "Lift up") if streams else ("Along the stroke, Z", "Up, −Y")
        if reference != INERTIAL:
            across, up, streams = "Along the chord, y", "Normal to it, z", ""
        figure.supxlabel(f"{across} (mm)", fontsize=8)
        figure.supylabel(f"{up} (mm)", fontsize=8)
        if streams:
            _draw_stream(axes.flat[0], streams)
        if dots is None:
            text, size = f"{shared.traction:g} Pa, force of the fluid per area", shared.traction
        else:
            factor, unit = prefixed(shared.force, "N")
            text, size = f"{factor * shared.force:g} {unit}, force of the fluid", shared.force
            place = "bottom" if narrow else "right"
            _draw_key(figure, axes, dots, backdrop is not None, shared.saturated, sheets, place)
        _draw_heading(figure, axes[0, 0], lines, heading / height, arrows, size, text)
    return figure


def _draw_heading(figure: Figure, ax: Any, lines: str, share: float, arrows: Any, size: float, text: str) -> None:
    """The title, and the scale of the arrows next to it, or below it in a narrow figure.

    Args:
        share: the heading's share of the figure's height.
        size, text: force of an arrow of the key, and what it says.
    """
    width, height = figure.get_size_inches()
    right, level = 0.86 if width < style.NARROW else 0.94, 1.0 - share + 0.5 * LINE / height
    figure.text(0.01, 1.0 - 0.4 * LINE / height, lines, va="top", fontsize=8.5)
    ax.quiverkey(arrows, right, level, size, text, labelpos="W", coordinates="figure", fontproperties={"size": 7.5})


def _draw_key(figure: Figure, axes: Any, drawn: Any, flows: bool, saturated: bool, sheets: bool, place: str) -> None:
    """Key to the colours of the vorticity (if it `flows`) or of the wake."""
    if sheets and not flows:
        marks = [
            Line2D([], [], marker="o", linestyle="", markersize=4, color=colour, label=f"{edge} edge")
            for colour, edge in zip(palette.SHEETS, ("trailing", "leading"), strict=True)
        ]
        outside: Any = {"right": "outside right center", "bottom": "outside lower center"}
        figure.legend(handles=marks, loc=outside[place], title="Shed by the", ncols=1 if place == "right" else 2)
        return
    ends = "both" if flows or saturated else "neither"
    bar = figure.colorbar(drawn, ax=axes, location=place, shrink=0.85, aspect=35, pad=0.015, extend=ends)
    key = "Vorticity, ω (s⁻¹)" if flows else "Circulation of wake vortices, Γ (m² s⁻¹)"
    bar.set_label(f"{style.wrapped(key, 0.8 * figure.get_figwidth())}\npositive counter-clockwise")
    bar.outline.set_linewidth(0.4)


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


def _draw_flow(ax: Any, frame: scene.Frame, shared: scene.Bounds, backdrop: flow.Backdrop) -> Any:
    """The vorticity as a picture that fills the panel."""
    cmap = ListedColormap(palette.table(palette.LIGHT.flow) / 255.0)
    return ax.imshow(
        backdrop.vorticity(frame, shared.page, ACROSS), cmap=cmap, norm=Normalize(-backdrop.limit, backdrop.limit),
        extent=[1e3 * edge for edge in shared.page], origin="lower", interpolation="bicubic", zorder=1,
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
    """Arrows on axes in mm; `scale` is the length per unit, `width` is in points."""
    return ax.quiver(
        *(1e3 * feet).T, *vectors.T, color=palette.LIGHT.force, angles="xy", scale_units="xy", scale=1e-3 * scale,
        units="inches", width=width / POINTS, headwidth=4.0, headlength=5.0, headaxislength=4.5, zorder=5,
    )  # fmt: skip
