"""Series of results over their last beats, with one panel per series and one colour per result."""

import difflib
import itertools
import math
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..drawing import palette, scene
from ..errors import UserError
from ..metrics.summary import summarise
from ..metrics.waves import reversals
from ..motion.sampling import PLUNGE_RATE, sample
from ..motion.stream import in_stream
from ..notation import prefixed
from ..results.reader import Result
from . import style

Panel = tuple[str, str, tuple[str, ...]]
"""A panel: axis label, unit, and series."""
DEFLECTION: Panel = ("Tip deflection", "m", ("tip_deflection",))
PLUNGE: Panel = ("Plunge", "m", ("plunge",))
PITCH: Panel = ("Pitch", "deg", ("pitch",))
NORMAL: Panel = ("Normal force", "N", ("force_normal",))
VERTICAL: Panel = ("Vertical force, full vector", "N", ("force_vertical",))
LIFT: Panel = ("Lift across the stream", "N", ("lift",))
THRUST: Panel = ("Thrust against the stream", "N", ("thrust",))
POWER: Panel = ("Mechanical power", "W", ("power", "power_aerodynamic", "power_inertial"))
STYLES: Any = (("total", "-"), ("aerodynamic", "--"), ("inertial", ":"))
"""The power and its parts: name and line style."""
PREFIXED = ("m", "N", "W", "N m", "J", "Pa")
"""Units that are scaled by a prefix to suit the values."""
ROW, LOW_ROW, BESIDE = 2.2, 1.75, 0.5
"""Height of a row of panels, of one in a narrow figure, and of the rest of the figure, inches."""
KEY = 0.55
"""Width of a legend's line and margins, inches."""
COLUMN = 3
"""Maximum number of panels in one column; more are drawn in two columns."""
LONG = 30
"""Maximum length of a label next to a panel."""


class SeriesError(UserError):
    """Raised for a series that a result lacks; one sentence with the available ones."""


def summary(
    results: Sequence[Result], width: float = style.WIDTH, metrics: Sequence[str] = (), beats: int = 1
) -> Figure:
    """Tip deflection, forces and power of each result, or the given series, over the last beats.

    Args:
        width: width of the figure, inches.
        metrics: names of series to show instead.
        beats: number of beats, for a periodic motion.

    Raises:
        SceneError: if a result has no whole beat, or the results have different time axes.
        SeriesError: if a result has no such series.
    """
    for result in results:
        scene.last_steps(result)
    lengths, label_of_time = _time_axis(results)
    shown = chosen(results, metrics) if metrics else panels(results)
    columns = 1 if len(shown) <= COLUMN or width < style.NARROW else 2
    rows = math.ceil(len(shown) / columns)
    row = LOW_ROW if width < style.NARROW else ROW
    with mpl.rc_context(style.current()):
        figure = Figure(figsize=(width, row * rows + BESIDE), layout="constrained")
        axes = list(figure.subplots(rows, columns, sharex=True, squeeze=False).flat)
        handles, names = [], _names(results)
        units = [_unit(results, panel, beats) for panel in shown]
        many = max(_whole(result, beats) for result in results)
        if many > 1:
            label_of_time = label_of_time.replace("last beat", f"last {many} beats")
        for number, (result, length) in enumerate(zip(results, lengths, strict=True)):
            colour = palette.SEVERAL[number % len(palette.SEVERAL)]
            turns = result.time[scene.last_steps(result, beats)] / result.case.beat
            turns = length * (turns - round(turns[-1]) + many)
            for ax in axes if result.has_sheets else ():
                _mark_shedding(ax, turns, _last(result, "leading_edge_sheds", beats) > 0.5, number)
            for ax, (factor, _), (_, _, series) in zip(axes, units, shown, strict=False):
                for variable, (_, line) in zip(series, STYLES, strict=False):
                    thick = 1.3 if line == "-" else 1.0
                    ax.plot(turns, factor * _last(result, variable, beats), line, color=colour, linewidth=thick)
            text = style.wrapped(f"{names[number]}{_mean_force(result)}", width - KEY)
            handles.append(Line2D([], [], color=colour, label=text))
        for letter, ax, (label, _, series), (_, unit) in zip(
            "abcdefghijklmnopqrstuvwxyz", axes, shown, units, strict=False
        ):
            _shade(ax, results[0], lengths[0], many, beats)
            named = f"{label} ({unit})" if unit else label
            named = style.wrapped(named, 0.8 * row) if width < style.NARROW else named
            ax.set(ylabel=named, xlim=(0.0, many * max(lengths)))
            ax.axhline(0.0, color=palette.LIGHT.muted, linewidth=0.5, zorder=1)
            if len(shown) > 1:
                ax.annotate(f"({letter})", (0.0, 1.0), (-36, 7), "axes fraction", "offset points", fontweight="bold")
            if len(series) > 1:
                # Above the tallest line, so that the legend crosses no line.
                low, high = ax.get_ylim()
                ax.set_ylim(low, high + 0.14 * (high - low))
                key = [Line2D([], [], linestyle=line, color=palette.LIGHT.ink, label=name) for name, line in STYLES]
                handle, gap = (1.5, 0.8) if width < style.NARROW else (1.9, 1.2)
                ax.legend(handles=key, loc="upper center", ncols=3, handlelength=handle, columnspacing=gap)
        for ax in axes[len(shown) :]:
            ax.set_axis_off()
        for ax in axes[max(len(shown) - columns, 0) : len(shown)]:
            ax.set_xlabel(label_of_time)
            ax.tick_params(labelbottom=True)
        figure.legend(handles=handles, loc="outside upper center", ncols=1)
    return figure


def _time_axis(results: Sequence[Result]) -> tuple[list[float], str]:
    """Length of a beat of each result on the time axis, and its label.

    Raises:
        SceneError: if the results have different ones, such as periods and seconds.
    """
    lengths, labels = zip(*(scene.abscissa(result.case) for result in results), strict=True)
    for result, label in zip(results, labels, strict=True):
        if label != labels[0]:
            first, other = (one.path or scene.label(one) for one in (results[0], result))
            raise scene.SceneError(
                f"{other}: its time axis is {label!r}, that of {first} is {labels[0]!r}; plot each on its own"
            )
    return list(lengths), labels[0]


def panels(results: Sequence[Result]) -> list[Panel]:
    """Default panels: lift and thrust in a stream, and the motion of rigid wings."""
    cases = [result.case for result in results]
    moved = PLUNGE if any(np.ptp(result.plunge) for result in results) else PITCH
    first = DEFLECTION if any(case.wing.modes for case in cases) else moved
    forces = (LIFT, THRUST) if all(case.fluid.streams for case in cases) else (NORMAL, VERTICAL)
    return [first, *forces, POWER]


def chosen(results: Sequence[Result], metrics: Sequence[str]) -> list[Panel]:
    """A panel for each named series.

    Raises:
        SeriesError: if a result has no such series.
    """
    found: list[Panel] = []
    for name in dict.fromkeys(metrics):
        for result in results:
            there = [one for one in result.variables if one != "time" and result.describe(one).dimensions == ("time",)]
            if name not in there:
                near = difflib.get_close_matches(name, there, 1)
                hint = f"did you mean {near[0]}?" if near else f"the series are {', '.join(there)}"
                raise SeriesError(f"--metric {name}: not a series of {result.path or scene.label(result)}; {hint}")
        one = results[0].describe(name)
        said = one.long_name if len(one.long_name) <= LONG else name.replace("_", " ")
        unit = {"1": "", "rad": "deg"}.get(one.units, one.units)
        found.append((said[:1].upper() + said[1:], unit, (name,)))
    return found


def _whole(result: Result, beats: int) -> int:
    """Number of beats shown for a result, at most `beats`."""
    return min(beats, math.floor(round(float(result.time[-1]) / result.case.beat, 9)))


def _last(result: Result, name: str, beats: int) -> np.ndarray:
    """A series over the last beats; in a stream, lift or thrust of a force."""
    steps = scene.last_steps(result, beats)
    if name in ("lift", "thrust"):
        lift, thrust = in_stream(result.case, result.force_y[steps], result.force_z[steps])
        return lift if name == "lift" else thrust
    return np.asarray(getattr(result, name)[steps])


def _unit(results: Sequence[Result], panel: Panel, beats: int) -> tuple[float, str]:
    """Display unit of a panel: factor and name."""
    _, unit, series = panel
    if unit == "deg":
        return 180.0 / math.pi, unit
    if unit not in PREFIXED:
        return 1.0, unit
    largest = max(float(np.abs(_last(result, name, beats)).max()) for result in results for name in series)
    return prefixed(largest, unit)


def _names(results: Sequence[Result]) -> list[str]:
    """Title and model of each result, with file names if there are several."""
    names = [f"{scene.label(result)} ({result.case.model})" for result in results]
    if len(results) == 1:
        return names
    return [f"{name}, {result.path.name}" if result.path else name for name, result in zip(names, results, strict=True)]


def _mean_force(result: Result) -> str:
    """The mean vertical force, or thrust in a stream, as in `info`; empty for a failed run."""
    settled = summarise(result) if result.status != "failed" else None
    if settled is None:
        return ""
    name, force = ("thrust", settled.thrust) if settled.thrust else ("vertical force", settled.force_vertical)
    factor, unit = prefixed(force.mean, "N")
    value = f"{force.shown(factor, 3)} {unit}".replace("-", "−").replace(" ", "\N{NO-BREAK SPACE}")
    return f": mean {name} {value}"


def _shade(ax: Any, result: Result, length: float, many: int, beats: int) -> None:
    """Shade the half-strokes towards +Z of the beats shown of a result.

    Args:
        length: of a beat on the axis, which shows `many`.
    """
    case = result.case
    end = round(result.time[scene.last_steps(result)][-1] / case.beat)
    first, begin = end - _whole(result, beats), end - many
    found = reversals(case, first, end)
    if not len(found):
        return
    edges = [float(first), *found, float(end)]
    for left, right in itertools.pairwise(edges):
        if right - left < 1e-6:
            continue
        middle = 0.5 * (left + right)
        forth = sample(case.motion, np.array([middle * case.beat]))[0, PLUNGE_RATE] > 0.0
        if forth:
            span = length * (left - begin), length * (right - begin)
            ax.axvspan(*span, color=palette.LIGHT.faint, linewidth=0.0, zorder=0)
        if many == 1:
            ax.annotate(
                f"stroke to {'+' if forth else '−'}Z", (length * (middle - begin), 1.0), (0, 3),
                ("data", "axes fraction"), "offset points",
                ha="center", va="bottom", fontsize=7, color=palette.LIGHT.muted,
            )  # fmt: skip


def _mark_shedding(ax: Any, turns: np.ndarray, sheds: np.ndarray, number: int) -> None:
    """A bar along the bottom while the leading edge sheds; bars of several results overlap."""
    low = 0.025 * number
    colour, over = palette.SHEETS[1], ax.get_xaxis_transform()
    ax.fill_between(turns, low, low + 0.02, where=sheds, transform=over, color=colour, linewidth=0.0, zorder=1)
