"""Figures of the scores: errors by regime, and time histories."""

import re
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from ...drawing import palette
from .against import Comparison
from .score import Row
from .table import groups
from .tiers import Tier
from .truths import NEARBY, Published

COLOURS = ("#0060a8", "#d55e00", "#008560", "#8a4fbf", "#b58900", "#16191d")
WIDTH, ROW, MARGIN = 8.0, 0.24, 1.1
"""Inches: width of a figure, height of a row, and height of the rest."""
ABREAST = 4
"""Entries of a legend side by side."""
FARTHEST = 150.0
"""Errors above this, %, are drawn at the edge of the chart."""
_INK = palette.LIGHT
STYLE: Any = {
    "font.family": "DejaVu Sans", "font.size": 8, "axes.linewidth": 0.6, "axes.spines.right": False,
    "axes.spines.top": False, "legend.frameon": False, "svg.hashsalt": "taichiflap", "text.color": _INK.ink,
    "axes.labelcolor": _INK.ink, "axes.edgecolor": _INK.muted, "xtick.color": _INK.muted, "ytick.color": _INK.muted,
    "xtick.labelcolor": _INK.ink, "ytick.labelcolor": _INK.ink,
}  # fmt: skip


def errors(rows: Sequence[Row], tiers: Sequence[Tier]) -> Figure:
    """Errors of a regime, one colour per model; the grey bar is the published band."""
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(WIDTH, MARGIN + ROW * len(rows)), layout="constrained")
        axes = drawn.add_subplot()
        axes.axvspan(-100 * NEARBY, 100 * NEARBY, color=_INK.muted, alpha=0.08, linewidth=0)
        axes.axvline(0.0, color=_INK.muted, linewidth=0.6)
        for place, row in enumerate(rows):
            low, high = (100 * row.truth.error(bound) for bound in (row.truth.low, row.truth.high))
            axes.plot((low, high), (place, place), color=_INK.muted, linewidth=6, alpha=0.45, solid_capstyle="butt")
        for tier, colour in zip(tiers, COLOURS, strict=False):
            found = [(row.value(tier.name), place, row) for place, row in enumerate(rows)]
            points = [
                (float(np.clip(100 * row.truth.error(value), -FARTHEST, FARTHEST)), place)
                for value, place, row in found
                if value is not None
            ]
            if points:
                axes.plot(*zip(*points, strict=True), "o", color=colour, markersize=4, label=tier.label)
        axes.set_yticks(range(len(rows)), [f"{row.published.name}: {_written(row.truth.quantity)}" for row in rows])
        axes.set(xlim=(-1.05 * FARTHEST, 1.05 * FARTHEST), ylim=(len(rows) - 0.5, -0.5), xlabel="error, %")
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=len(tiers))
    return drawn


def _written(quantity: str) -> str:
    """A quantity with its symbol as mathematics."""
    return re.sub(r"C_\w", lambda found: f"${found[0]}$", quantity)


def histories(rows: Sequence[Row], tiers: Sequence[Tier]) -> Figure | None:
    """Lift and drag coefficients of the cases with stored time histories; None if there are none."""
    cases = list(dict.fromkeys(row.published for row in rows if row.published.drawn))
    outcomes = {row.published.name: row.outcomes for row in rows}
    cases = [one for one in cases if any(outcome.trace for outcome in outcomes[one.name].values())]
    if not cases:
        return None
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(WIDTH, 1.9 * len(cases)), layout="constrained")
        grid = drawn.subplots(len(cases), 2, squeeze=False)
        for line, one in zip(grid, cases, strict=True):
            for axes, name in zip(line, ("C_L", "C_D"), strict=True):
                _history(axes, one, name, outcomes[one.name], tiers)
        lines = {
            label: line for axes in grid[:, 0] for line, label in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        drawn.legend(lines.values(), lines, loc="outside upper center", ncols=ABREAST)
    return drawn


def _history(axes: Any, one: Published, name: str, outcomes: Any, tiers: Sequence[Tier]) -> None:
    first, last = one.truths[0].window
    style = {"color": _INK.ink, "linewidth": 2.5, "alpha": 0.35}
    if one.waves:
        times = np.linspace(first, last, 400)
        turns = np.exp(2j * np.pi * np.outer(times, np.arange(len(one.waves[name]))))
        axes.plot(times, (turns @ np.array(one.waves[name])).real, label="published, 4 harmonics", **style)
    if one.ramp:
        times = np.linspace(one.ramp.first, one.ramp.last, 400)
        axes.plot(times, one.ramp.published(name, times), linestyle="--", label="published, 7 cosines", **style)
    seen = []
    for tier, colour in zip(tiers, COLOURS, strict=False):
        trace = outcomes[tier.name].trace if tier.name in outcomes else {}
        if trace:
            time, values = np.array(trace["time"]), np.array(trace[name])
            inside = (time >= first) & (time <= last)
            axes.plot(time[inside], values[inside], color=colour, linewidth=1.0, label=tier.label)
            seen.append(values[inside])
    if seen:
        low, high = np.percentile(np.concatenate(seen), (1, 99))
        axes.set_ylim(low - 0.15 * (high - low), high + 0.15 * (high - low))
    unit = "beats" if one.case().periodic else "chords of travel"
    axes.set(xlim=(first, last), ylabel=f"${name}$", xlabel=f"time, {unit}", title=one.name)


def comparison(found: Comparison, tiers: Sequence[Tier]) -> Figure:
    """A measured trace and the models, one chart per quantity."""
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(WIDTH, 0.5 + 2.2 * len(found.measured)), layout="constrained")
        charts = drawn.subplots(len(found.measured), squeeze=False, sharex=True)[:, 0]
        for axes, (name, measured) in zip(charts, found.measured.items(), strict=True):
            axes.plot(found.phases, measured.values, color=_INK.ink, linewidth=2.5, alpha=0.35, label="measured")
            for tier, colour in zip(tiers, COLOURS, strict=False):
                if tier.name in found.modelled[name]:
                    own = found.modelled[name][tier.name]
                    axes.plot(found.phases, own.values, color=colour, linewidth=1.0, label=tier.label)
            unit = found.trace.units[name][0]
            axes.set(ylabel=_written(name.replace("_", " ") if unit != "1" else name) + f" ({unit})" * (unit != "1"))
            axes.margins(x=0.0)
        charts[-1].set_xlabel("time, beats" if found.periodic else "time, s")
        drawn.legend(*charts[0].get_legend_handles_labels(), loc="outside upper center", ncols=ABREAST)
    return drawn


def drawn(rows: Sequence[Row], tiers: Sequence[Tier]) -> list[tuple[str, str, Figure]]:
    """All figures: name, caption and figure."""
    found = []
    for number, (name, own) in enumerate(groups(rows), 1):
        found.append((f"scores-{number}", f"{name}: errors; the grey bars are the bands", errors(own, tiers)))
    history = histories(rows, tiers)
    if history is not None:
        found.append(("scores-histories", "Time histories of hover and of the ramps", history))
    return found
