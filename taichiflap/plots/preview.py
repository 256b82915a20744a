"""Preview of a case before it is run: the wing's path with its chord, the angle of attack, and the speeds."""

import math
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from .. import files
from ..case.case import Case
from ..drawing import palette, scene
from ..drawing.orientation import Orientation
from ..motion import sampling
from ..motion.attack import angle_of_attack, speeds, tells
from ..motion.sampling import PITCH, PLUNGE, PLUNGE_RATE, SURGE
from ..notation import prefixed, printable
from . import formats, style
from .style import WIDTH

Array = NDArray[np.float64]

CHORDS = 24
"""Number of chord lines per beat."""
TIMES = 721
MARGIN = 0.6
"""Free space around the path, chords."""
ARROW = 0.9
"""Length of the arrows of gravity and stream, chords."""


def write(case: Case, path: Path, overwrite: bool = False) -> Path:
    """Write the preview of a case to a file; its extension gives the type.

    Raises:
        OutputError: for another extension, or if the file exists or cannot be written.
    """
    kind = path.suffix[1:].lower()
    if kind not in formats.KINDS:
        raise files.OutputError(f"{path}: unsupported picture type; end the name in {', '.join(formats.KINDS)}")
    files.check(path, overwrite)
    (path,) = formats.write({"": preview(case)}, path.with_suffix(""), (kind,), style.current(), overwrite)
    return path


def preview(case: Case) -> Figure:
    """The wing's path with its chord, gravity, stroke plane and stream; angle of attack, pitch and speeds over time.

    It shows a beat after the start-up, or the whole of a non-periodic motion.
    """
    times, turns, label = _instants(case)
    moved = sampling.sample(case.motion, times)
    stream = case.fluid.velocity
    attack = np.where(tells(stream, moved), np.degrees(angle_of_attack(stream, moved)), np.nan)
    speed, tip = speeds(stream, (1.0 - case.wing.pivot) * case.wing.chord, moved)
    with mpl.rc_context(style.current()):
        figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
        grid = figure.add_gridspec(3, 2, width_ratios=(1.25, 1.0))
        _draw_path(figure.add_subplot(grid[:, 0]), case, moved)
        angles, pace, place = (figure.add_subplot(grid[row, 1]) for row in range(3))
        angles.plot(turns, attack, color=palette.PARTS[0], linewidth=1.2, label="angle of attack")
        angles.plot(turns, np.degrees(moved[:, PITCH]), "--", color=palette.PARTS[1], linewidth=1.0, label="pitch")
        angles.set_ylabel("Angle (deg)")
        pace.plot(turns, tip, color=palette.PARTS[0], linewidth=1.2, label="trailing edge")
        pace.plot(turns, speed, "--", color=palette.PARTS[1], linewidth=1.0, label="pivot")
        pace.set_ylabel("Speed through\nthe fluid (m/s)")
        factor, unit = prefixed(float(np.abs(moved[:, [PLUNGE, SURGE]]).max()), "m")
        place.plot(turns, factor * moved[:, PLUNGE], color=palette.PARTS[0], linewidth=1.2, label="plunge, Z")
        place.plot(
            turns, factor * moved[:, SURGE], "--", color=palette.PARTS[1], linewidth=1.0, label="surge, Y (down)"
        )
        place.set(ylabel=f"Pivot ({unit})", xlabel=label)
        for ax in (angles, pace, place):
            ax.set_xlim(turns[0], turns[-1])
            ax.axhline(0.0, color=palette.LIGHT.muted, linewidth=0.5, zorder=1)
            low, high = ax.get_ylim()
            ax.set_ylim(low, high + 0.22 * (high - low))
            ax.legend(loc="upper center", ncols=2, handlelength=1.9, columnspacing=1.2)
        for ax in (angles, pace):
            ax.tick_params(labelbottom=False)
        figure.suptitle(_title(case, attack, tip), fontsize=8.5, x=0.01, ha="left")
    return figure


def _instants(case: Case) -> tuple[Array, Array, str]:
    """Times (s) of a whole beat after the start-up, their values on the axis, and its label."""
    length, label = scene.abscissa(case)
    first = math.ceil(case.motion.growth / case.beat - 1e-9) if case.periodic else 0
    share = np.linspace(0.0, 1.0, TIMES)
    return case.beat * (first + share), length * share, label.replace("last beat", "beat")


def _title(case: Case, attack: Array, tip: Array) -> str:
    rate = f"{case.motion.frequency:g} Hz, " if case.motion.frequency else ""
    said = f"trailing edge at {math.sqrt(np.mean(tip**2)):.3g} m/s (rms) and {tip.max():.3g} m/s (max)"
    if np.isfinite(attack).any():
        said += f", mean angle of attack {np.nanmean(attack):.3g} deg"
    return f"{printable(case.title) or 'untitled'}\n{rate}{said}"


def _draw_path(ax: Any, case: Case, moved: Array) -> None:
    """The pivot's path, the chord at even times, and the directions of the plane."""
    wing = case.wing
    chord, ahead, behind = 1e3 * wing.chord, 1e3 * wing.pivot * wing.chord, 1e3 * (1.0 - wing.pivot) * wing.chord
    shown = moved[np.linspace(0, len(moved) - 1, CHORDS + 1).astype(int)]
    shown = shown[:-1] if case.periodic else shown
    page = Orientation.of(case)
    pivot = 1e3 * page.on_page(shown[:, SURGE], shown[:, PLUNGE])
    along = page.on_page(np.cos(shown[:, PITCH]), np.sin(shown[:, PITCH]))  # leading to trailing edge
    leading, trailing = pivot - ahead * along, pivot + behind * along
    path = 1e3 * page.on_page(moved[:, SURGE], moved[:, PLUNGE])
    kinds = {palette.LINES[1]: "moving to +Z", palette.LINES[0]: "moving to −Z"}
    colours = np.where(shown[:, PLUNGE_RATE] > 0.0, *kinds)
    if not moved[:, PLUNGE_RATE].any():
        kinds = {palette.LIGHT.muted: "not moving along Z"}
        colours = np.full(len(shown), palette.LIGHT.muted)
    ax.plot(*path.T, color=palette.LIGHT.muted, linewidth=0.6, zorder=2)
    ax.add_collection(
        LineCollection(list(np.stack((leading, trailing), axis=1)), colors=colours, linewidths=1.0, zorder=3)
    )
    ax.scatter(*leading.T, s=9, c=colours, linewidths=0.0, zorder=4)
    everything = np.concatenate((leading, trailing, path))
    low, high = everything.min(axis=0) - MARGIN * chord, everything.max(axis=0) + MARGIN * chord
    plane = case.motion.measured.stroke_plane_deg if case.motion.measured else 0.0
    lean = -math.radians(plane) * (1.0 if not case.motion.measured or case.motion.measured.side == "right" else -1.0)
    middle = 0.5 * (path.min(axis=0) + path.max(axis=0))
    half = 0.5 * max(np.ptp(path[:, 0]), np.ptp(path[:, 1]), chord)
    ends = middle + np.outer((-1.0, 1.0), half * np.array((math.cos(lean), math.sin(lean))))
    if case.motion.measured or not case.fluid.streams:
        ax.plot(*ends.T, ":", color=palette.LIGHT.ink, linewidth=0.8, zorder=1)
        ax.annotate("stroke plane", ends[1], (3, 0), textcoords="offset points", fontsize=7, va="center")
    corner = np.array((low[0] + 0.35 * chord, high[1]))
    _arrow(ax, corner, page.on_page(1.0, 0.0) * ARROW * chord, "gravity", palette.LIGHT.ink)
    stream = page.on_page(*case.fluid.velocity)
    size = float(np.hypot(*stream))
    if size:
        foot = np.array((0.5 * (low[0] + high[0]), high[1] + 0.3 * chord))
        _arrow(ax, foot, ARROW * chord * stream / size, f"stream, {size:.3g} m/s", palette.LIGHT.force)
    for colour, name in kinds.items():
        ax.plot([], [], color=colour, marker="o", markersize=3, linewidth=1.0, label=name)
    ax.legend(loc="lower left", ncols=2, bbox_to_anchor=(0.0, 1.0), handlelength=1.6, title_fontsize=7.5,
              title="The chord at even times, its leading edge a dot")  # fmt: skip
    ax.set(
        xlim=(low[0], high[0] + 0.9 * chord), ylim=(low[1], high[1] + 0.6 * chord), aspect="equal",
        xlabel="Along the stream (mm)" if size else "Horizontal, Z (mm)",
        ylabel="Lift up (mm)" if size else "Up, −Y (mm)",
    )  # fmt: skip


def _arrow(ax: Any, foot: Array, vector: Array, text: str, colour: str) -> None:
    ax.annotate(
        "", foot + vector, foot, arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.0, "shrinkA": 0}
    )
    ax.annotate(text, foot, (3, 2), textcoords="offset points", fontsize=7, color=colour)
