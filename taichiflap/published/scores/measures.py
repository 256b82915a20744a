"""Scored quantities: coefficients of a result over a window of time."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...march.reference import reference
from ...motion.stream import in_stream
from ...results.reader import Result

Array = NDArray[np.float64]

MOMENTS = 2000
"""Number of times in a window at which coefficients are sampled."""
ANGLES = ("C_L phase", "C_L phase 2", "C_D phase 2", "tip phase")
"""Quantities in degrees, which wrap."""


@dataclass(frozen=True)
class Trace:
    """Coefficients of a result against time, over `rho U^2 c h / 2` with the reference speed U of the case.

    Attributes:
        time: in beats for a periodic motion, in s otherwise.
        lift, drag: normal to the stream and along it; in hover the vertical force, and the force against the stroke.
        power: mechanical, over `rho U^3 c h / 2`.
        plunge, tip: position of the pivot along Z, and deflection of the trailing edge, chords.
    """

    time: Array
    lift: Array
    drag: Array
    power: Array
    plunge: Array
    tip: Array

    @classmethod
    def of(cls, result: Result, speed: float) -> "Trace":
        """The coefficients of a result.

        Args:
            speed: the reference speed, m/s.
        """
        case = result.case
        scale = replace(reference(case), speed=speed)
        if case.fluid.streams:
            lift, thrust = in_stream(case, result.force_y, result.force_z)
            drag = -thrust
        else:
            lift = result.force_vertical
            drag = -result.force_z * np.sign(np.gradient(result.plunge, result.time))
        return cls(
            time=result.time / (case.beat if case.periodic else 1.0),
            lift=lift / scale.force,
            drag=drag / scale.force,
            power=result.power / scale.power,
            plunge=result.plunge / case.wing.chord,
            tip=result.tip_deflection / case.wing.chord,
        )

    def during(self, window: tuple[float, float]) -> "Trace":
        """The coefficients at evenly spaced times of a window, without its end."""
        times = np.linspace(*window, MOMENTS, endpoint=False)
        rows = (getattr(self, name) for name in ("lift", "drag", "power", "plunge", "tip"))
        return Trace(times, *(np.interp(times, self.time, row) for row in rows))


def harmonic(time: Array, values: Array, order: int) -> complex:
    """Complex amplitude `a` of `Re(a exp(2 pi i order t))`, with the time in beats."""
    return complex(2.0 * np.mean(values * np.exp(-2j * math.pi * order * time)))


def _peak_time(trace: Trace) -> float:
    return float(trace.time[np.argmax(trace.lift)])


def _phase(value: complex) -> float:
    return math.degrees(math.atan2(value.imag, value.real))


def _tip(trace: Trace) -> complex:
    return harmonic(trace.time, trace.tip, 1) / harmonic(trace.time, trace.plunge, 1)


def _strouhal(trace: Trace) -> float:
    """Frequency with which the lift rises through its mean, chords over the stream's speed."""
    above = trace.lift - trace.lift.mean()
    rises = np.flatnonzero((above[1:] > 0.0) & (above[:-1] <= 0.0))
    if len(rises) < 2:
        return 0.0
    share = above[rises] / (above[rises] - above[rises + 1])
    crossed = trace.time[rises] + share * (trace.time[1] - trace.time[0])
    return float((len(crossed) - 1) / (crossed[-1] - crossed[0]))


QUANTITIES: dict[str, Callable[[Trace], float]] = {
    "C_L mean": lambda trace: float(trace.lift.mean()),
    "C_D mean": lambda trace: float(trace.drag.mean()),
    "C_T mean": lambda trace: -float(trace.drag.mean()),
    "C_P mean": lambda trace: float(trace.power.mean()),
    "C_L peak": lambda trace: float(trace.lift.max()),
    "C_L peak time": _peak_time,
    "C_D peak": lambda trace: float(trace.drag.max()),
    "C_L amplitude": lambda trace: abs(harmonic(trace.time, trace.lift, 1)),
    "C_L phase": lambda trace: _phase(harmonic(trace.time, trace.lift, 1)),
    "C_L amplitude 2": lambda trace: abs(harmonic(trace.time, trace.lift, 2)),
    "C_L phase 2": lambda trace: _phase(harmonic(trace.time, trace.lift, 2)),
    "C_D amplitude 2": lambda trace: abs(harmonic(trace.time, trace.drag, 2)),
    "C_D phase 2": lambda trace: _phase(harmonic(trace.time, trace.drag, 2)),
    "Strouhal number": _strouhal,
    "pitch amplitude": lambda trace: math.degrees(math.atan(abs(harmonic(trace.time, trace.tip, 1)))),
    "tip amplitude": lambda trace: abs(_tip(trace)),
    "tip phase": lambda trace: _phase(_tip(trace)),
}
"""Each over a window of a trace. Harmonics are of the beat; "2" is the second, the first of what repeats twice a beat.
The Strouhal number is that of a unit chord in a unit stream. Phases and the pitch of the chord line are in degrees, the
peak's time is in the unit of the window; the tip's deflection is over the plunge, and its phase relative to it."""


def _growth(trace: Trace) -> float:
    """Logarithmic growth of the tip's oscillation from the first half of the times to the second."""
    halves = np.split(trace.tip - trace.tip.mean(), 2)
    first, second = (float(np.mean(half**2)) for half in halves)
    return 0.5 * math.log(second / first)


def _onset(traces: Sequence[Trace], speeds: Sequence[float]) -> float:
    """The speed at which an oscillation neither grows nor dies, by a line through its growth at several speeds.

    Not-a-number where that is further from them than they reach: the oscillation just grows, or dies.
    """
    slope, at_zero = np.polyfit(speeds, [_growth(trace) for trace in traces], 1)
    onset, reach = -at_zero / slope, max(speeds) - min(speeds)
    return float(onset) if min(speeds) - reach <= onset <= max(speeds) + reach else math.nan


FAMILIES: dict[str, Callable[[Sequence[Trace], Sequence[float]], float]] = {"onset of flutter": _onset}
"""Each of the traces of several runs and the values of what these vary, over a window."""


def measure(traces: Sequence[Trace], quantity: str, window: tuple[float, float], varied: Sequence[float] = ()) -> float:
    """A quantity of the trace of a run over a window, or of several runs.

    Args:
        varied: the value of what varies from run to run, one a trace; none for a quantity of one run.
    """
    during = [trace.during(window) for trace in traces]
    return FAMILIES[quantity](during, varied) if quantity in FAMILIES else QUANTITIES[quantity](during[0])
