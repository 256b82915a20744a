"""Time units of motion tables, and hints about times given in a different unit."""

import itertools
import math
import statistics
from collections.abc import Sequence

COUNTS = {"s": "s", "ms": "ms", "periods": "fractions of the period"}
"""Names of the units."""
ALIKE = 0.15
"""Relative tolerance within which a time span is taken for a round one."""


def period(clock: str, frequency: float | None) -> float:
    """Period of a frequency (Hz) in a time unit; NaN without a frequency."""
    return 1.0 if clock == "periods" else {"s": 1.0, "ms": 1e3}[clock] / (frequency or math.nan)


def spacing(times: Sequence[float]) -> float:
    """Median time between points."""
    return statistics.median(late - early for early, late in itertools.pairwise(times))


def looks_like(times: Sequence[float], clock: str, frequency: float | None) -> str:
    """Suggested cure for times that do not span about one period in units of `clock`."""
    span, usual = times[-1] - times[0], spacing(times)
    for unit in COUNTS:
        if unit != clock and _near(span, usual, period(unit, frequency)):
            return f'; they look like {unit}: give time = "{unit}"'
    if all(late - early == 1.0 for early, late in itertools.pairwise(times)):
        return "; they look like row numbers: set time_column to the number or name of the time column"
    for name, round_one in (("percent of the period", 100.0), ("degrees of phase", 360.0), ("radians", math.tau)):
        if _near(span, usual, round_one):
            return f"; they look like {name}: divide them by {round_one:.6g}"
    beats = span / period(clock, frequency)
    if beats > 1.5 and abs(beats - round(beats)) < ALIKE:
        return f"; they look like {round(beats)} beats: give a single beat"
    return f"; check the times, their unit (time = ...) and motion.frequency = {frequency:g} Hz"


def _near(span: float, usual: float, length: float) -> bool:
    """Whether points over a span, with or without the last one, cover about a given length of time."""
    return span < (1.0 + ALIKE) * length and span + usual > (1.0 - ALIKE) * length
