"""A user's own measurement compared with every model: means, harmonics, peaks and the difference over the beat."""

import csv
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...case.case import Case
from ...march.reference import reference
from ...metrics.beats import settled_beats
from ...motion.stream import in_stream
from ...results.reader import Result
from ...run.blocks import simulate
from .measures import harmonic
from .tiers import ScoreError, Tier

Array = NDArray[np.float64]

PHASES = 400
"""Number of times per beat, or in the measured interval, at which trace and model are compared."""
ORDERS = 3
ROUND_OFF = 1e-9
"""Values below this share of the peak are shown as zero."""
UNITS: Mapping[str, float] = {
    "": 1.0, "1": 1.0, "-": 1.0, "N": 1.0, "mN": 1e-3, "uN": 1e-6, "µN": 1e-6, "W": 1.0, "mW": 1e-3, "uW": 1e-6,
    "m": 1.0, "mm": 1e-3, "cm": 1e-2, "N m": 1.0, "mN m": 1e-3, "s": 1.0, "ms": 1e-3,
}  # fmt: skip
"""Units of a column's heading, in SI."""
COEFFICIENTS = {"C_L": "lift", "C_D": "drag", "C_T": "thrust", "C_V": "force_vertical"}
"""Force coefficients and their series; C_V is that of the vertical force."""
SERIES = ("force_vertical", "force_normal", "force_axial", "force_y", "force_z", "lift", "thrust", "power",
          "moment", "tip_deflection")  # fmt: skip
HEADING = re.compile(r"\s*(?P<name>[\w/]+)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?\s*$")
TIMES = {"t/T": "beats", "t_over_T": "beats", "beats": "beats", "time": "s", "t": "s"}


@dataclass(frozen=True)
class Trace:
    """A measured trace: times in beats (in s for a non-periodic motion) and its quantities in SI units."""

    path: Path
    time: Array
    in_beats: bool
    values: Mapping[str, Array]


@dataclass(frozen=True)
class Comparison:
    """One quantity of a trace and of a model.

    Attributes:
        mean, harmonics, peak, peak_time: pairs of the trace's and the model's value.
        rms: root-mean-square difference, relative to the trace.
        phases, measured, modelled: both series over the compared times.
    """

    quantity: str
    tier: Tier
    mean: tuple[float, float]
    harmonics: tuple[tuple[complex, complex], ...]
    peak: tuple[float, float]
    peak_time: tuple[float, float]
    rms: float
    phases: Array
    measured: Array
    modelled: Array


def read_trace(path: Path) -> Trace:
    """Read a CSV file with a heading: a time (`t/T` or `time [s]`) and quantities with their units.

    Raises:
        ScoreError: if a column is missing, unknown or invalid; one sentence with the cure.
    """
    try:
        lines = [line for line in path.read_text(encoding="utf-8-sig").splitlines() if line and line[0] != "#"]
    except (OSError, UnicodeDecodeError) as error:
        raise ScoreError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or 'not text in UTF-8'}") from None
    if len(lines) < 5:
        raise ScoreError(f"{path}: has {len(lines)} lines; give a line of names and at least 4 rows")
    heads, *rows = csv.reader(lines)
    try:
        table = np.array([[float(cell) for cell in row] for row in rows])
    except ValueError as error:
        raise ScoreError(f"{path}: {error}; give numbers with decimal points between commas") from None
    if table.ndim != 2 or table.shape[1] != len(heads) or not np.isfinite(table).all():
        raise ScoreError(f"{path}: rows have different numbers of columns, or values that are not finite")
    columns = [_column(path, head) for head in heads]
    times = [i for i, (name, _) in enumerate(columns) if name in TIMES]
    if len(times) != 1:
        raise ScoreError(f"{path}: needs one column of time, named t/T or time [s]; it has {', '.join(heads)}")
    name, factor = columns[times[0]]
    values = {name: factor * table[:, i] for i, (name, factor) in enumerate(columns) if i not in times}
    if not values:
        raise ScoreError(f"{path}: has no column besides the time; add one of {', '.join((*SERIES, *COEFFICIENTS))}")
    time = factor * table[:, times[0]]
    if np.any(np.diff(time) <= 0.0):
        raise ScoreError(f"{path}: times must increase from row to row")
    return Trace(path, time, TIMES[name] == "beats", values)


def _column(path: Path, head: str) -> tuple[str, float]:
    found = HEADING.match(head)
    name, unit = (found["name"], (found["unit"] or "").strip()) if found else (head, "")
    if name not in TIMES and name not in SERIES and name not in COEFFICIENTS:
        raise ScoreError(
            f'{path}: column "{head}" is not known; name it t/T, time [s], {", ".join((*SERIES, *COEFFICIENTS))}'
        )
    if unit not in UNITS:
        known = ", ".join(filter(None, UNITS))
        raise ScoreError(f'{path}: column "{head}": unit {unit} is not known; use one of {known}')
    return name, UNITS[unit]


def read_shift(text: str) -> float | None:
    """Delay of a trace in beats; None for `best`.

    Raises:
        ScoreError: for anything else.
    """
    if text == "best":
        return None
    try:
        return float(text)
    except ValueError:
        raise ScoreError(f"--shift {text}: give a number of beats, or best") from None


def compare(
    case: Case,
    trace: Trace,
    tiers: Sequence[Tier],
    *,
    speed: float | None = None,
    area: float | None = None,
    shift: float | None = 0.0,
    threads: int | None = None,
) -> list[Comparison]:
    """Run a case in several models and compare each with a trace.

    Args:
        speed: reference speed of the trace's coefficients, m/s.
        area: reference area of the coefficients, m2; chord times span if None.
        shift: delay of the trace relative to the case, in beats; None finds the delay of least difference for each
            quantity and model.

    Raises:
        ScoreError: if a coefficient has no reference speed, or a quantity needs a stream.
    """
    found = []
    for tier in tiers:
        with simulate(case.override(*tier.settings), threads=threads) as result:
            for quantity, values in trace.values.items():
                found.append(_one(result, trace, tier, quantity, values, speed, area, shift))
    return found


def _one(
    result: Result, trace: Trace, tier: Tier, quantity: str, values: Array, speed: float | None, area: float | None,
    shift: float | None,
) -> Comparison:  # fmt: skip
    case = result.case
    series = _series(result, trace, quantity, speed, area)
    time = trace.time if trace.in_beats else trace.time / (case.beat if case.periodic else 1.0)
    if case.periodic:
        phases = np.arange(PHASES) / PHASES
        beats = settled_beats(result)
        if not beats:
            raise ScoreError(f"{trace.path}: the case has no whole beat to compare with; increase time.periods")
        modelled = _folded(result.time[beats.frames] / case.beat, series[beats.frames], phases)
        late = _best_shift(time, values, phases, modelled) if shift is None else shift
        measured = _folded(time - late, values, phases)
    else:
        phases = np.linspace(max(time[0], 0.0), min(time[-1], case.duration), PHASES)
        measured, modelled = np.interp(phases, time, values), np.interp(phases, result.time, series)
    size = math.sqrt(float(np.mean(measured**2)))
    peaks = [int(np.argmax(np.abs(rows))) for rows in (measured, modelled)]
    orders = range(1, ORDERS + 1) if case.periodic else ()
    waves = tuple((harmonic(phases, measured, n), harmonic(phases, modelled, n)) for n in orders)
    return Comparison(
        quantity=quantity,
        tier=tier,
        mean=(float(measured.mean()), float(modelled.mean())),
        harmonics=waves,
        peak=(float(measured[peaks[0]]), float(modelled[peaks[1]])),
        peak_time=(float(phases[peaks[0]]), float(phases[peaks[1]])),
        rms=math.sqrt(float(np.mean((modelled - measured) ** 2))) / size if size else math.inf,
        phases=phases,
        measured=measured,
        modelled=modelled,
    )


def _series(result: Result, trace: Trace, quantity: str, speed: float | None, area: float | None) -> Array:
    case = result.case
    name = COEFFICIENTS.get(quantity, quantity)
    if name in ("lift", "thrust", "drag"):
        if not any(case.fluid.velocity):
            raise ScoreError(f"{trace.path}: {quantity} needs a stream; in hover give force_vertical or C_V")
        lift, thrust = in_stream(case, result.force_y, result.force_z)
        series = {"lift": lift, "thrust": thrust, "drag": -thrust}[name]
    else:
        series = getattr(result, name)
    if quantity in COEFFICIENTS:
        if not speed:
            raise ScoreError(f"{trace.path}: {quantity} needs the reference speed: --speed, in m/s")
        scale = reference(case)
        series = series / replace(scale, speed=speed, area=area or scale.area).force
    return series


def _folded(time: Array, values: Array, phases: Array) -> Array:
    """Mean over the whole beats at phases of a beat; less than one beat is treated as periodic."""
    first, last = math.ceil(time[0] - ROUND_OFF), math.floor(time[-1] + ROUND_OFF)
    if last > first:
        return np.mean([np.interp(beat + phases, time, values) for beat in range(first, last)], axis=0)
    order = np.argsort(time % 1.0, kind="stable")
    return np.interp(phases, (time % 1.0)[order], values[order], period=1.0)


def _best_shift(time: Array, values: Array, phases: Array, modelled: Array) -> float:
    errors = [float(np.sum((_folded(time - late, values, phases) - modelled) ** 2)) for late in phases]
    return float(phases[int(np.argmin(errors))])


def lines(trace: Trace, found: Sequence[Comparison]) -> list[str]:
    """The comparison as text."""
    heads = ("mean", *(f"harmonic {order}" for order in range(1, ORDERS + 1)), "peak", "at", "rms diff.")
    said = [f"{trace.path} compared with the models"]
    for quantity in trace.values:
        own = [one for one in found if one.quantity == quantity]
        said += [f"  {quantity}", f"    {'':<16}" + "".join(f"{head:>12}" for head in heads)]
        said.append(_line("measured", own[0], 0))
        said += [_line(one.tier.label, one, 1) for one in own]
    return said


def _line(label: str, one: Comparison, which: int) -> str:
    size = max(abs(one.peak[0]), abs(one.peak[1]))
    waves = [_told(abs(pair[which]), size) for pair in one.harmonics] or ["-"] * ORDERS
    cells = [_told(one.mean[which], size), *waves, _told(one.peak[which], size), f"{one.peak_time[which]:.3f}"]
    if which:
        cells.append(f"{100 * one.rms:.0f} %")
    return f"    {label:<16}" + "".join(f"{cell:>12}" for cell in cells)


def _told(value: float, size: float) -> str:
    return f"{value:.4g}" if abs(value) > ROUND_OFF * size else "0"
