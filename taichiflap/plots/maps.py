"""Figures of maps: heat maps with contours, families of lines, Pareto fronts, and the path of a convergence study."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from ..drawing import palette
from ..maps.design import Axis
from ..maps.file import Map, MapError
from ..maps.labels import factor_of, is_log, label, model, named
from ..metrics.names import POWER, gains, resolve, shown
from ..metrics.pareto import pareto_front
from ..notation import short
from ..run import limits
from ..run.warnings import BENT, BROKEN
from . import formats, style
from .style import WIDTH

if TYPE_CHECKING:
    from ..studies.converge import Convergence

GREY = palette.LIGHT.faint
"""Colour of cases in which the model is invalid."""
CONTOURS = 8
LINES_AT_MOST = 7
MARKS = ("o", "^", "s", "D", "v", "P")


def plot(
    sheet: Map,
    stem: Path | None = None,
    overwrite: bool = False,
    whole: bool = False,
    *,
    metrics: Sequence[str] = (),
    look: str | None = None,
) -> list[Path]:
    """Write the figures that suit a map, as PNG and SVG: `STEM-map` or `STEM-lines`, and `STEM-pareto`.

    Args:
        stem: start of the file names, or their folder; if None, the map's name in the current folder. With the
            extension pdf, eps, svg or png only that type is written.
        whole: draw cases in which the model is invalid like all others, instead of in grey.
        metrics: which to draw; the foremost that the map has, if none are given.
        look: a style of matplotlib's, or a `.mplstyle` file, over the house's own.

    Raises:
        MapError: when the map has no metric to draw, or not one that is asked for.
        MetricError: for a name that is no metric.
        OutputError: when a file exists already or cannot be written, or there is no such style.
    """
    stem, kinds = formats.asked(stem)
    own = sheet.path.stem if sheet.path else "map"
    stem = Path(own) if stem is None else stem / own if stem.is_dir() else stem
    drawn = [resolve(name) for name in metrics] or shown(sheet.metrics)
    for name in drawn:
        if name not in sheet.metrics:
            raise MapError(f"{sheet.path}: kept no {name}; it has {', '.join(sheet.metrics)}")
    numeric = _varying(sheet)
    if not drawn or not numeric:
        raise MapError(f"{sheet.path}: nothing to draw: no numeric key varies, or no metric was stored")
    with style.using(look):
        figures = _figures(sheet, drawn, len(numeric), whole)
        return formats.write(figures, stem, kinds, style.current(), overwrite)


def _figures(sheet: Map, metrics: Sequence[str], numeric: int, whole: bool) -> dict[str, Figure]:
    """The figures that suit a map with so many numeric keys that vary, by their names, with headings and notes."""
    figures: dict[str, Figure] = {}
    with mpl.rc_context(style.current()):
        if sheet.design.grid and numeric >= 2:
            figures["map"] = heat_maps(sheet, metrics, whole)
        elif sheet.design.grid:
            figures["lines"] = lines(sheet, metrics, whole)
        else:
            figures["scatter"] = scatter(sheet, metrics, whole)
        if gains(sheet.metrics):
            figures["pareto"] = pareto(sheet, whole)
        heading = ", ".join(filter(None, (sheet.title, model(sheet))))
        for name, figure in figures.items():
            figure.suptitle(heading, fontsize=8, x=0.01, ha="left")
            note = _note(sheet, whole, name)
            if note:
                figure.supxlabel(note, fontsize=7, x=0.01, ha="left")
    return figures


def convergence(found: "Convergence", stem: Path) -> list[Path]:
    """Write `STEM.png` and `STEM.svg`: deviation of every metric from its finest value, against every key.

    It is relative to the finest value, or to the scale of the study for a metric that is smaller.
    """
    keys = list(dict.fromkeys(trial.key for trial in found.trials))
    with mpl.rc_context(style.current()):
        figure = Figure((WIDTH, 2.6), layout="constrained")
        axes = figure.subplots(1, len(keys), sharey=True, squeeze=False)[0]
        for ax, key in zip(axes, keys, strict=True):
            trials = [trial for trial in found.trials if trial.key == key]
            values = [trial.value for trial in trials]
            names = list(trials[0].metrics)
            for colour, mark, name in zip(_colours(len(names)), MARKS * len(names), names, strict=False):
                series = np.array([trial.metrics[name] for trial in trials])
                size = max(abs(series[-1]), found.scales.get(name, 0.0)) or 1.0
                deviation = 100.0 * (series - series[-1]) / size
                ax.plot(values, deviation, mark + "-", color=colour, markersize=3.5, linewidth=1, label=label(name))
            if key != "wing.modes":
                ax.set_xscale("log", base=2)
            ax.set_xticks(values, [str(value) for value in values], rotation=45 if len(values) > 4 else 0)
            ax.minorticks_off()
            share = 100.0 * found.tolerance
            ax.axhspan(-share, share, color=palette.LIGHT.faint, zorder=0, label=f"within {share:g} %")
            taken = found.accepted[key]
            ax.axvline(taken, color=palette.LIGHT.force, linewidth=0.8, linestyle="--", label="fine enough")
            ax.set_xlabel(key)
        axes[0].set_ylabel("Deviation from the finest (%)")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=len(names) + 2)
    return formats.write({"": figure}, stem, formats.BOTH, style.current(), overwrite=True)


def heat_maps(sheet: Map, metrics: Sequence[str], whole: bool = False) -> Figure:
    """One column of heat maps with contours for each value of a third key, one row a metric.

    The first two numeric keys span the maps; other varied keys are named above the columns.
    """
    down, across = _varying(sheet)[:2]
    y, x = sheet.design.axes[down], sheet.design.axes[across]
    columns = _columns(sheet, {down, across})
    figure = Figure((WIDTH, 0.4 + 1.9 * len(metrics)), layout="constrained")
    grid = figure.subplots(len(metrics), len(columns), sharex=True, sharey=True, squeeze=False)
    for row, name in zip(grid, metrics, strict=True):
        fields = [_slice(sheet, _holding(sheet, name, whole), place, down, across) for _, place in columns]
        finite = np.concatenate([field[np.isfinite(field)] for field in fields])
        low, high = (finite.min(), finite.max()) if finite.size else (0.0, 1.0)
        for ax, field, (title, place) in zip(row, fields, columns, strict=True):
            _shade(ax, sheet, (x, y), place, (down, across), whole)
            mesh = ax.pcolormesh(*_edges(x, y, sheet), field, cmap="viridis", vmin=low, vmax=high, rasterized=True)
            if low < high and np.isfinite(field).any():
                levels = MaxNLocator(CONTOURS).tick_values(low, high)
                drawn = ax.contour(*_middles(x, y, sheet), field, levels, colors="white", linewidths=0.5)
                for text in ax.clabel(drawn, fontsize=6):
                    # Readable on bright colours as well.
                    text.set_path_effects([withStroke(linewidth=1.2, foreground="#00000080")])
            _scale_axes(ax, x, y)
            if ax in grid[0]:
                ax.set_title(title, fontsize=8)
            if ax in grid[-1]:
                ax.set_xlabel(named(x.key, sheet))
            if ax is row[0]:
                ax.set_ylabel(named(y.key, sheet))
        bar = figure.colorbar(mesh, ax=row, pad=0.01, aspect=15)
        bar.set_label(named(name, sheet))
    return figure


def lines(sheet: Map, metrics: Sequence[str], whole: bool = False) -> Figure:
    """Metrics over a single numeric key, one line for every combination of the others."""
    along = _varying(sheet)[0]
    axis = sheet.design.axes[along]
    x, columns = np.sort(_scaled(axis, sheet)), _columns(sheet, {along})
    rows = math.ceil(len(metrics) / 2)
    figure = Figure((WIDTH, 2.1 * rows), layout="constrained")
    grid = figure.subplots(rows, 2, sharex=True, squeeze=False).ravel()
    for ax, name in zip(grid, metrics, strict=False):
        held, doubtful = _holding(sheet, name, whole), _holding(sheet, name, whole, doubtful=True)
        for colour, mark, (title, place) in zip(_colours(len(columns)), MARKS * len(columns), columns, strict=False):
            index = tuple(slice(None) if i == along else p for i, p in enumerate(place))
            values = held[index][axis.order]
            ax.plot(x, doubtful[index][axis.order], mark, color=GREY, markersize=3, zorder=1)
            ax.plot(x, values, mark + "-", color=colour, markersize=3, linewidth=1, label=title or None)
        _scale_axes(ax, axis)
        ax.set_ylabel(named(name, sheet))
    for ax in grid[-2:]:
        ax.set_xlabel(named(axis.key, sheet))
    for ax in grid[len(metrics) :]:
        ax.set_axis_off()
    if len(columns) > 1:
        grid[0].legend()
    return figure


def scatter(sheet: Map, metrics: Sequence[str], whole: bool = False) -> Figure:
    """Metrics of a sample against each numeric key, with a colour for each value of the first key of text."""
    keys = [sheet.design.axes[i] for i in _varying(sheet)[:4]]
    figure = Figure((WIDTH, 0.4 + 1.6 * len(metrics)), layout="constrained")
    grid = figure.subplots(len(metrics), len(keys), sharex="col", sharey="row", squeeze=False)
    for row, name in zip(grid, metrics, strict=True):
        held, doubtful = _holding(sheet, name, whole), _holding(sheet, name, whole, doubtful=True)
        for ax, axis in zip(row, keys, strict=True):
            x = _scaled(axis, sheet)
            for colour, mark, title, numbers in _kinds(sheet):
                ax.plot(x[numbers], doubtful[numbers], mark, color=GREY, markersize=2, zorder=1)
                ax.plot(x[numbers], held[numbers], mark, color=colour, markersize=2, label=title or None)
            if ax in grid[-1]:
                ax.set_xlabel(named(axis.key, sheet))
            _scale_axes(ax, axis)
        row[0].set_ylabel(named(name, sheet))
    if len(_kinds(sheet)) > 1:
        grid[0, 0].legend()
    return figure


def pareto(sheet: Map, whole: bool = False) -> Figure:
    """Vertical force, or lift and thrust, against power, with the Pareto front."""
    forces = gains(sheet.metrics)
    figure = Figure((0.55 * WIDTH * len(forces), 3.0), layout="constrained")
    for ax, name in zip(figure.subplots(1, len(forces), squeeze=False)[0], forces, strict=True):
        _draw_front(ax, sheet, name, whole)
    return figure


def _draw_front(ax: Any, sheet: Map, name: str, whole: bool) -> None:
    force, power = (_holding(sheet, one, whole).ravel() for one in (name, POWER))
    for colour, mark, title, numbers in _kinds(sheet):
        ax.plot(power[numbers], force[numbers], mark, color=colour, markersize=2, alpha=0.35, markeredgewidth=0)
        front = numbers[pareto_front(power[numbers], force[numbers])]
        ax.plot(
            power[front],
            force[front],
            mark + "-",
            color=colour,
            markersize=3,
            linewidth=1,
            label=", ".join(filter(None, ("Pareto front", title))),
        )
    ax.set_xlabel(named(POWER, sheet))
    ax.set_ylabel(named(name, sheet))
    ax.legend()


def _holding(sheet: Map, name: str, whole: bool, doubtful: bool = False) -> np.ndarray:
    """A metric in display units, for the cases in which the model is valid (or all); or for the invalid ones."""
    broken = limits.broken(sheet).reshape(sheet.design.shape) & (not whole)
    return np.where(broken == doubtful, factor_of(sheet, name) * sheet.values(name), np.nan)


def _note(sheet: Map, whole: bool, figure: str) -> str:
    """Note on grey, hatched or omitted cases in a figure."""
    said = []
    if not whole and limits.broken(sheet).any():
        word = "left out" if figure == "pareto" else "grey"
        said.append(f"{word}: the model is invalid (tip deflection above {BROKEN:g} chord, or unphysical forces)")
    if figure == "map" and limits.bent(sheet).any():
        said.append(f"hatched: tip deflection above {BENT:g} chords")
    return "; ".join(said)


def _shade(
    ax: Any, sheet: Map, sides: tuple[Axis, Axis], place: tuple[int, ...], spanned: tuple[int, int], whole: bool
) -> None:
    """Grey behind the colours of cells in which the model is invalid; hatching where the linear beam is invalid."""
    broken, bent = (_slice(sheet, one.reshape(sheet.design.shape), place, *spanned) for one in (
        limits.broken(sheet), limits.bent(sheet)
    ))  # fmt: skip
    x, y = _edges(*sides, sheet)
    if broken.any() and not whole:
        ax.pcolormesh(x, y, np.where(broken, 1.0, np.nan), cmap=ListedColormap([GREY]), zorder=0)
    if bent.any():
        # Four points to a cell, so that the hatching ends with it.
        sides_of = (np.repeat(edges, 2)[1:-1] for edges in (x, y))
        with mpl.rc_context({"hatch.linewidth": 0.4}):
            ax.contourf(
                *sides_of, np.kron(bent, np.ones((2, 2))), [0.5, 1.5], colors="none", hatches=["////"], zorder=2
            )


def _varying(sheet: Map) -> list[int]:
    """Indices of the keys that can form an axis: numeric, with more than one value."""
    return [i for i, axis in enumerate(sheet.design.axes) if axis.numeric and len(set(axis.values)) > 1]


def _columns(sheet: Map, spanned: set[int]) -> list[tuple[str, tuple[int, ...]]]:
    """Titles and indices of the values of all other keys, thinned evenly to fit a page."""
    rest = [i for i in range(len(sheet.design.axes)) if i not in spanned]
    shape = [len(sheet.design.axes[i].values) for i in rest]
    count = int(np.prod(shape, dtype=int))
    most = LINES_AT_MOST if len(spanned) == 1 else 3
    chosen = np.unique(np.rint(np.linspace(0, count - 1, min(count, most))).astype(int))
    found = []
    for number in chosen:
        places = np.unravel_index(number, shape) if rest else ()
        place = dict(zip(rest, map(int, places), strict=True))
        named = [(sheet.design.axes[i].key, sheet.design.axes[i].values[p]) for i, p in place.items()]
        title = ", ".join(f"{key} = {short(value)}" for key, value in named)
        found.append((title, tuple(place.get(i, 0) for i in range(len(sheet.design.axes)))))
    return found


def _slice(sheet: Map, values: np.ndarray, place: tuple[int, ...], down: int, across: int) -> np.ndarray:
    """Values over two keys, each in rising order, with all others at `place`."""
    cut = values[tuple(slice(None) if i in (down, across) else p for i, p in enumerate(place))]
    return cut[np.ix_(sheet.design.axes[down].order, sheet.design.axes[across].order)]


def _kinds(sheet: Map) -> list[tuple[Any, str, str, np.ndarray]]:
    """Colour, mark, value and numbers of the cases with each value of the first key of text; all cases without one."""
    text = [i for i, axis in enumerate(sheet.design.axes) if not axis.numeric]
    groups = _groups(sheet, text[0]) if text else {"": np.arange(sheet.design.size)}
    looks = zip(_colours(len(groups)), MARKS * len(groups), groups.items(), strict=False)
    return [(colour, mark, title, numbers) for colour, mark, (title, numbers) in looks]


def _groups(sheet: Map, position: int) -> dict[str, np.ndarray]:
    """Indices of the cases with each value of a key."""
    axis = sheet.design.axes[position]
    numbers = np.arange(sheet.design.size)
    places = np.unravel_index(numbers, sheet.design.shape)[position if sheet.design.grid else 0]
    taken = np.array([axis.values[int(place)] for place in places], dtype=object)
    return {str(value): numbers[taken == value] for value in dict.fromkeys(axis.values)}


def _scaled(axis: Axis, sheet: Map) -> np.ndarray:
    return factor_of(sheet, axis.key) * np.array(axis.values, dtype=float)


def _middles(x: Axis, y: Axis, sheet: Map) -> tuple[np.ndarray, np.ndarray]:
    """Values of two keys in display units, in rising order."""
    return np.sort(_scaled(x, sheet)), np.sort(_scaled(y, sheet))


def _edges(x: Axis, y: Axis, sheet: Map) -> tuple[np.ndarray, np.ndarray]:
    """Borders of the cells around the values, half-way on a linear or logarithmic scale."""
    edges = []
    for axis, rising in zip((x, y), _middles(x, y, sheet), strict=True):
        values = np.log(rising) if is_log(axis) else rising
        middle = 0.5 * (values[1:] + values[:-1])
        bounds = np.r_[values[0] - (middle[0] - values[0]), middle, values[-1] + (values[-1] - middle[-1])]
        edges.append(np.exp(bounds) if is_log(axis) else bounds)
    return edges[0], edges[1]


def _scale_axes(ax: Any, x: Axis, y: Axis | None = None) -> None:
    for axis, scale, drawn in ((x, ax.set_xscale, ax.xaxis), (y, ax.set_yscale, ax.yaxis)):
        if axis is not None and is_log(axis):
            scale("log")
            few = float(max(axis.values)) < 10.0 * float(min(axis.values))
            drawn.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0) if few else (1.0, 2.0, 5.0)))
            drawn.set_major_formatter(lambda value, _: f"{value:g}")
            drawn.set_minor_formatter(NullFormatter())


def _colours(count: int) -> list[Any]:
    if count <= len(palette.LINES):
        return list(palette.LINES[:count])
    return list(mpl.colormaps["viridis"](np.linspace(0.0, 0.85, count)))
