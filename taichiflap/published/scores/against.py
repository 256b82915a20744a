"""A user's own measurement compared with every model: means, harmonics, peaks and the difference over the beat."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...case.case import Case, CaseError
from ...march.reference import Reference, reference
from ...metrics.beats import settled_beats
from ...metrics.summary import summarise
from ...metrics.uncertainty import standard_errors
from ...metrics.unsettled import unsettled
from ...motion.stream import in_stream
from ...results.reader import Result
from ...run.blocks import simulate
from .measures import harmonic
from .tiers import ScoreError, Tier
from .traces import COEFFICIENTS, Trace

Array = NDArray[np.float64]

PHASES = 400
"""Number of times per beat, or in the measured interval, at which trace and model are compared."""
ORDERS = 3
ACROSS = ("lift", "thrust", "drag")
"""Forces that need a stream."""
ROUND_OFF = 1e-9
ALIKE = 1.05
"""Shifts whose differences are within this factor of the minimum count as equal; the smallest is used."""


@dataclass(frozen=True)
class Figures:
    """Numbers of a measured or computed trace, in the unit of the measurement.

    Attributes:
        values: at the times compared.
        mean, peak: the peak is the largest magnitude.
        peak_time: in beats, or in s of a motion that does not repeat.
        harmonics: complex amplitudes `a` of `Re(a exp(2 pi i n t))`, from n = 1 on; none of what does not repeat.
        error: standard error of the mean, of ten and more settled beats of a model; not-a-number otherwise.
    """

    values: Array
    mean: float
    peak: float
    peak_time: float
    harmonics: tuple[complex, ...]
    error: float = math.nan

    @classmethod
    def of(cls, phases: Array, values: Array, periodic: bool, error: float = math.nan) -> "Figures":
        """Those of values over phases of a beat, or over times."""
        top = int(np.argmax(np.abs(values)))
        waves = tuple(harmonic(phases, values, n) for n in range(1, ORDERS + 1)) if periodic else ()
        return cls(values, float(values.mean()), float(values[top]), float(phases[top]), waves, error)


@dataclass(frozen=True)
class Comparison:
    """A trace compared with the models.

    Attributes:
        trace: as it was read.
        scale: the reference speed and area of its coefficients.
        speed_given, area_given: whether these were stated, or are the case's own.
        shift: beats by which the trace is late against the case's time: one for all its quantities and every model.
        alone: the shift that each model would take; empty where the shift was given.
        phases: times compared: of a beat, or in s.
        measured: by quantity.
        modelled: by quantity and the model's name.
        own: keys of a model's own that the case sets, by the model's name; only of models with such keys.
        doubts: why the means of a model are not yet known to their digits, by its name; only of models with a doubt.
        failed: why a model gave nothing, by its name.
    """

    trace: Trace
    scale: Reference
    speed_given: bool
    area_given: bool
    shift: float
    alone: Mapping[str, float]
    phases: Array
    measured: Mapping[str, Figures]
    modelled: Mapping[str, Mapping[str, Figures]]
    own: Mapping[str, Sequence[str]]
    doubts: Mapping[str, str]
    failed: Mapping[str, str]

    @property
    def periodic(self) -> bool:
        """Whether the motion repeats."""
        return all(one.harmonics for one in self.measured.values())

    def rms(self, quantity: str, tier: str) -> float:
        """Root mean square of the difference, over that of the trace."""
        own = self.measured[quantity].values
        size = float(np.mean(own**2))
        apart = float(np.mean((self.modelled[quantity][tier].values - own) ** 2))
        return math.sqrt(apart / size) if size else math.inf


def read_shift(text: str) -> float | None:
    """Delay of a trace in beats; None for `best`.

    Raises:
        ScoreError: for anything else.
    """
    if text == "best":
        return None
    try:
        shift = float(text)
    except ValueError:
        shift = math.nan
    if not math.isfinite(shift):
        raise ScoreError(f"--shift {text}: give a number of beats, or best")
    return shift


def compare(
    case: Case,
    traces: Sequence[Trace],
    tiers: Sequence[Tier],
    *,
    speed: float | None = None,
    area: float | None = None,
    shift: float | None = 0.0,
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[Comparison]:
    """Run a case in several models, once each, and compare them with traces.

    Args:
        speed: reference speed of the traces' coefficients, m/s; that of the case (see `metrics.coefficients`), if None.
        area: their reference area, m2; chord times span, if None.
        shift: beats (s, if the motion does not repeat) by which the traces are late against the case's time. None finds
            for each trace the one of the least difference, over all its quantities and models together.
        threads: how many threads to use; all of them if None. It does not change any result.
        progress: called with the number of models done, and of all models.

    Raises:
        ScoreError: when a quantity needs a stream that is not there, or the case has no whole beat.
    """
    if shift is None and not case.periodic:
        raise ScoreError("--shift best: the motion does not repeat; state the shift, in s")
    own = reference(case)
    scale = replace(own, speed=speed or own.speed, area=area or own.area)
    for trace in traces:
        _possible(case, trace)
    series: dict[str, list[dict[str, Array]]] = {}
    errors: dict[str, list[dict[str, float]]] = {}
    doubts: dict[str, str] = {}
    failed: dict[str, str] = {}
    times = [_times(case, trace, shift or 0.0) for trace in traces]
    for done, tier in enumerate(tiers, 1):
        try:
            with simulate(case.override(*tier.settings), threads=threads) as result:
                if result.status == "complete":
                    both = [_modelled(result, trace, at, scale) for trace, at in zip(traces, times, strict=True)]
                    series[tier.name], errors[tier.name] = map(list, zip(*both, strict=True))
                    summary = summarise(result)
                    if summary and (doubt := unsettled(summary)):
                        doubts[tier.name] = doubt
                else:
                    failed[tier.name] = str(result.attributes.get("reason", ""))
        except CaseError as error:  # the case has settings that this model does not take
            failed[tier.name] = "; ".join(error.problems)
        if progress:
            progress(done, len(tiers))
    found = []
    for number, (trace, at) in enumerate(zip(traces, times, strict=True)):
        rows = {tier: of_traces[number] for tier, of_traces in series.items()}
        late, alone = (shift, {}) if shift is not None else _best_shift(case, trace, at, rows)
        measured = {name: _measured(case, trace, name, at, late) for name in trace.values}
        found.append(
            Comparison(
                trace, scale, speed is not None, area is not None, late, alone, at,
                {name: Figures.of(at, values, case.periodic) for name, values in measured.items()},
                {name: {tier: Figures.of(at, row[name], case.periodic, errors[tier][number][name])
                        for tier, row in rows.items()} for name in trace.values},
                {tier.name: keys for tier in tiers if tier.name not in failed and (keys := tier.own(case))},
                doubts, failed,
            )
        )  # fmt: skip
    return found


def _possible(case: Case, trace: Trace) -> None:
    for quantity in trace.values:
        if COEFFICIENTS.get(quantity, quantity) in ACROSS and not case.fluid.streams:
            raise ScoreError(f"{trace.path}: {quantity} needs a stream; in hover give force_vertical or C_V")
    if not case.periodic and trace.in_beats:
        raise ScoreError(f"{trace.path}: the motion does not repeat and has no beat; give time [s]")


def _times(case: Case, trace: Trace, late: float) -> Array:
    """Phases of a beat, or times (s) that both a trace and its case reach."""
    if case.periodic:
        return np.arange(PHASES) / PHASES
    first, last = max(trace.time[0] - late, 0.0), min(trace.time[-1] - late, case.duration)
    if first >= last:
        raise ScoreError(f"{trace.path}: its times end before the case begins, or begin after its {case.duration:g} s")
    return np.linspace(first, last, PHASES)


def _measured(case: Case, trace: Trace, quantity: str, at: Array, late: float) -> Array:
    if not case.periodic:
        return np.interp(at, trace.time - late, trace.values[quantity])
    time = trace.time if trace.in_beats else trace.time / case.beat
    return _folded(time - late, trace.values[quantity], at)


def _modelled(result: Result, trace: Trace, at: Array, scale: Reference) -> tuple[dict[str, Array], dict[str, float]]:
    """Each quantity of a trace in a model, in the unit of the measurement, and the standard error of its mean."""
    case, found = result.case, {}
    errors = dict.fromkeys(trace.values, math.nan)
    beats = settled_beats(result) if case.periodic else None
    if beats is not None and not beats:
        raise ScoreError(f"{trace.path}: the case has no whole beat to compare with; give more time.periods")
    for quantity in trace.values:
        series = _series(result, COEFFICIENTS.get(quantity, quantity))
        series = series / (scale.force if quantity in COEFFICIENTS else trace.units[quantity][1])
        if beats is None:
            found[quantity] = np.interp(at, result.time, series)
        else:
            found[quantity] = _folded(result.time[beats.frames] / case.beat, series[beats.frames], at)
            errors[quantity] = float(standard_errors(beats.means(series[None]))[0])
    return found, errors


def _series(result: Result, name: str) -> Array:
    if name not in ACROSS:
        return getattr(result, name)
    lift, thrust = in_stream(result.case, result.force_y, result.force_z)
    return {"lift": lift, "thrust": thrust, "drag": -thrust}[name]


def _folded(time: Array, values: Array, phases: Array) -> Array:
    """Mean over the whole beats at phases of a beat; less than one beat is treated as periodic."""
    first, last = math.ceil(time[0] - ROUND_OFF), math.floor(time[-1] + ROUND_OFF)
    if last > first:
        return np.mean([np.interp(beat + phases, time, values) for beat in range(first, last)], axis=0)
    order = np.argsort(time % 1.0, kind="stable")
    return np.interp(phases, (time % 1.0)[order], values[order], period=1.0)


def _best_shift(
    case: Case, trace: Trace, at: Array, rows: Mapping[str, Mapping[str, Array]]
) -> tuple[float, dict[str, float]]:
    """The shift of a trace, and the shift that each model alone would have.

    The start of a trace is a property of the measurement: it has one shift for all variables and models.
    Squared differences are relative to the mean square of the variable, so that all variables count equally.
    """
    errors = {tier: np.zeros(len(at)) for tier in rows}
    for quantity in trace.values:
        shifted = np.array([_measured(case, trace, quantity, at, late) for late in at])
        size = float(np.mean(shifted**2)) or 1.0
        for tier, row in rows.items():
            errors[tier] += np.mean((shifted - row[quantity]) ** 2, axis=1) / size
    return _least(at, list(errors.values())), {tier: _least(at, [error]) for tier, error in errors.items()}


def _least(shifts: Array, errors: Sequence[Array]) -> float:
    """The shift, between half a beat early and late, of the least sum; the smallest of minima that are alike.

    A force that repeats twice a beat fits as well half a beat later.
    """
    total = np.sum(errors, axis=0) if errors else np.zeros(len(shifts))
    low = (total <= np.roll(total, 1)) & (total <= np.roll(total, -1)) & (total <= ALIKE * total.min() + ROUND_OFF)
    candidates = (shifts[low] + 0.5) % 1.0 - 0.5
    return float(candidates[np.argmin(np.abs(candidates))])
