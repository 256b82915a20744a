"""Figures of the reproduction, with the ranges and the origin of time of the paper's plots."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ... import files
from ...drawing import palette
from . import paper
from .measured import Measured, Progress
from .paper import TABLE_5, Settings
from .plan import NO_ADDED_MASS, RIGID, Runs, key

WIDTH = 7.1
RESOLUTION = 200
FIGURES = 8
DBET, UVLM = palette.LINES
INK, MUTED = palette.LIGHT.ink, palette.LIGHT.muted
FORCE = "Normal force $F_N$ (mN)"
TIME = "t/T, stroke reversal at 0.25 and 0.75"
STYLE: Any = {
    "font.family": "DejaVu Sans", "font.size": 8, "axes.labelsize": 8, "axes.titlesize": 8, "axes.linewidth": 0.6,
    "axes.spines.right": False, "axes.spines.top": False, "lines.linewidth": 1.3, "lines.markersize": 3.5,
    "legend.fontsize": 7.5, "legend.frameon": False, "svg.hashsalt": "taichiflap", "text.color": INK,
    "axes.labelcolor": INK, "axes.edgecolor": MUTED, "xtick.color": MUTED, "ytick.color": MUTED,
    "xtick.labelcolor": INK, "ytick.labelcolor": INK,
}  # fmt: skip


def draw(settings: Settings, runs: Runs, folder: Path, progress: Progress | None = None) -> None:
    """Write every figure into a folder as PNG and SVG.

    Raises:
        OutputError: if a file cannot be written.
    """
    with mpl.rc_context(STYLE):
        for number, (name, figure) in enumerate(_figures(settings, runs)):
            if progress is not None:
                progress(number / FIGURES)
            for kind in ("png", "svg"):
                metadata = {"Date": None} if kind == "svg" else None
                with files.replacing(folder / f"{name}.{kind}") as file:
                    figure.savefig(file, format=kind, dpi=RESOLUTION, metadata=metadata)


def _figures(settings: Settings, runs: Runs) -> Iterator[tuple[str, Figure]]:
    yield "figure4", _elements(settings, runs)
    yield "figure5", _panels_and_wakes(settings, runs)
    yield "wake", _long_wakes(settings, runs)
    yield "figure6", _rigid(runs)
    yield "figure7", _flexible(runs)
    yield "cause", _cause(runs)
    yield "table5", _mean_forces(runs)
    yield "density", _densities(settings, runs)


def _figure(rows: int, columns: int, height: float, **options: Any) -> tuple[Figure, NDArray[Any]]:
    figure = Figure(figsize=(WIDTH if columns > 1 else 0.62 * WIDTH, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def _ladder(ax: Any, runs: Runs, solver: str, name: str, counts: Sequence[int]) -> None:
    """Tip deflection and mean forces against a count, each as a share of its value at the last one."""
    drawn = (
        ("tip deflection", (), "tip_peak", INK, "o-"),
        ("mean vertical force, flexible", (), "force_vertical", UVLM, "s--"),
        ("mean vertical force, rigid", (RIGID,), "force_vertical", DBET, "^:"),
    )
    for label, more, quantity, colour, line in drawn:
        values = [getattr(runs[key(solver, f"{name}={n}", *more)].summary, quantity).mean for n in counts]
        ax.plot(counts, np.array(values) / values[-1], line, color=colour, label=label)
    ax.axhline(1.0, color=MUTED, linewidth=0.5, zorder=1)
    ax.set(xlim=(0, 1.02 * counts[-1]), ylabel=f"Share of the value at {counts[-1]}")


def _elements(settings: Settings, runs: Runs) -> Figure:
    figure, axes = _figure(1, 1, 2.8)
    _ladder(axes[0, 0], runs, "dbet", "dbet.elements", settings.elements)
    axes[0, 0].set(xlabel="Number of blade elements", title="Figure 4: DBET")
    axes[0, 0].legend()
    return figure


def _panels_and_wakes(settings: Settings, runs: Runs) -> Figure:
    figure, axes = _figure(2, 1, 5.0)
    _ladder(axes[0, 0], runs, "uvlm", "uvlm.panels", settings.panels)
    axes[0, 0].set(xlabel="Number of panels, at 200 wake vortices", title="Figure 5: UVLM")
    axes[0, 0].legend()
    _ladder(axes[1, 0], runs, "uvlm", "uvlm.wake", settings.wakes)
    axes[1, 0].set(xlabel="Number of wake vortices, at 50 panels")
    return figure


def _long_wakes(settings: Settings, runs: Runs) -> Figure:
    figure, axes = _figure(1, 2, 2.9)
    counts = [*settings.wakes, *settings.long_wakes]
    steps = settings.periods * settings.steps_per_period
    beats = [(steps if count == "all" else int(count)) / settings.steps_per_period for count in counts]
    for wing, more, colour, line in (("flexible", (), UVLM, "s-"), ("rigid", (RIGID,), DBET, "^-")):
        found = [runs[key("uvlm", f"uvlm.wake={count}", *more)].summary for count in counts]
        means = [1e3 * one.force_vertical.mean for one in found]
        spread = [1e3 * one.force_vertical.spread for one in found]
        axes[0, 1].errorbar(beats, means, spread, fmt=line, color=colour, capsize=2, label=f"{wing}, mean ± spread")
        axes[0, 1].axhline(1e3 * TABLE_5["uvlm", int(wing == "flexible")], color=colour, linewidth=0.8, linestyle=":")
    tips = [1e3 * runs[key("uvlm", f"uvlm.wake={count}")].summary.tip_peak.mean for count in counts]
    axes[0, 0].plot(beats, tips, "o-", color=INK)
    axes[0, 0].set(ylabel="Largest tip deflection (mm)", ylim=(0, None))
    axes[0, 1].set(ylabel="Mean vertical force (mN)", ylim=(0, None))
    axes[0, 1].plot([], [], ":", color=MUTED, linewidth=0.8, label="paper, Table 5")
    axes[0, 1].legend()
    for ax in axes[0]:
        ax.axvline(1.0, color=MUTED, linewidth=0.6, linestyle="--")
        ax.set(xscale="log", xlabel="Wake kept (beats); the paper keeps one")
        ax.xaxis.set_major_formatter(mpl.ticker.FuncFormatter(lambda value, _: f"{value:g}"))
    return figure


def _beat(run: Measured, values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The last beat with the paper's origin of time, in order, in thousandths."""
    time = (run.time + paper.REVERSAL) % 1.0
    order = np.argsort(time)
    return time[order], 1e3 * values[order]


def _over_beat(ax: Any, label: str) -> None:
    for reversal in (paper.REVERSAL, paper.REVERSAL + 0.5):
        ax.axvline(reversal, color=palette.LIGHT.faint, linewidth=2.5, zorder=0)
    ax.axhline(0.0, color=MUTED, linewidth=0.5, zorder=1)
    ax.set(xlim=(0, 1), xlabel=TIME, ylabel=label)


def _rigid(runs: Runs) -> Figure:
    figure, axes = _figure(1, 1, 2.8)
    ax = axes[0, 0]
    for name, colour, line in (("dbet", DBET, "-"), ("uvlm", UVLM, "--")):
        run = runs[key(name, RIGID)]
        ax.plot(*_beat(run, run.beat["force_normal"]), line, color=colour, label=name.upper())
    _over_beat(ax, FORCE)
    ax.set_title("Figure 6: rigid wing")
    ax.legend()
    return figure


def _flexible(runs: Runs) -> Figure:
    figure, axes = _figure(2, 1, 5.0, sharex=True)
    labels = {"tip_deflection": "Tip deflection W(c) (mm)", "force_normal": FORCE}
    for ax, (series, label) in zip(axes[:, 0], labels.items(), strict=True):
        for name, colour, line in (("dbet", DBET, "-"), ("uvlm", UVLM, "--")):
            run = runs[key(name)]
            ax.plot(*_beat(run, run.beat[series]), line, color=colour, label=name.upper())
        _over_beat(ax, label)
    axes[0, 0].set(title="Figure 7: flexible wing", xlabel="")
    axes[0, 0].legend()
    return figure


def _cause(runs: Runs) -> Figure:
    figure, axes = _figure(1, 2, 3.0, sharey=True)
    for ax, more, title in ((axes[0, 0], (RIGID,), "rigid wing"), (axes[0, 1], (), "flexible wing")):
        lattice, blades, bare = (runs[key(*one, *more)] for one in (("uvlm",), ("dbet",), ("dbet", NO_ADDED_MASS)))
        ax.plot(*_beat(lattice, lattice.beat["force_normal"]), "--", color=UVLM, label="UVLM")
        ax.plot(*_beat(blades, blades.beat["force_normal"]), color=DBET, label="DBET")
        ax.plot(*_beat(blades, blades.quasi_steady), ":", color=DBET, label="DBET less its added-mass part")
        if not more:
            ax.plot(*_beat(bare, bare.beat["force_normal"]), "-.", color=INK, label="DBET run without added mass")
        _over_beat(ax, FORCE)
        ax.set_title(title)
    axes[0, 1].set_ylabel("")
    handles, labels = axes[0, 1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _mean_forces(runs: Runs) -> Figure:
    figure, axes = _figure(1, 1, 2.8)
    ax, where = axes[0, 0], np.arange(len(TABLE_5))
    found = [runs[key(solver, f"wing.modes={modes}")].summary for solver, modes in TABLE_5]
    bars = (
        ("paper, Table 5", list(TABLE_5.values()), MUTED),
        ("full vector", [one.force_vertical.mean for one in found], DBET),
        ("wing-normal part", [one.force_vertical_normal.mean for one in found], UVLM),
    )
    for number, (label, values, colour) in enumerate(bars):
        drawn = ax.bar(where + 0.27 * (number - 1), 1e3 * np.array(values), 0.25, color=colour, label=label)
        ax.bar_label(drawn, fmt="%.2f", fontsize=6.5, padding=1)
    names = [f"{solver.upper()}\n{'flexible' if modes else 'rigid'}" for solver, modes in TABLE_5]
    ax.set(xticks=where, xticklabels=names, ylabel="Mean vertical force (mN)", title="Table 5")
    ax.legend(loc="upper left")
    return figure


def _densities(settings: Settings, runs: Runs) -> Figure:
    figure, axes = _figure(1, 2, 2.9)
    for ax, solver in zip(axes[0], ("dbet", "uvlm"), strict=True):
        for wing, more, colour in (("flexible", (), UVLM), ("rigid", (RIGID,), DBET)):
            for quantity, label, line in (
                ("force_vertical", "full vector", "s-"),
                ("force_vertical_normal", "wing-normal part", "o--"),
            ):
                found = [runs[key(solver, f"fluid.density={rho}", *more)].summary for rho in settings.densities]
                values = [1e3 * getattr(one, quantity).mean for one in found]
                if solver == "dbet" or wing == "flexible" or quantity == "force_vertical":
                    ax.plot(settings.densities, values, line, color=colour, label=f"{wing}, {label}")
            printed = 1e3 * TABLE_5[solver, int(wing == "flexible")]
            ax.axhline(printed, color=colour, linewidth=0.8, linestyle=":", label=f"{wing}, paper")
        ax.set(xlabel="Density of the fluid (kg/m³)", ylabel="Mean vertical force (mN)", title=solver.upper())
        ax.set_ylim(0, None)
        ax.legend(fontsize=6.5)
    return figure
