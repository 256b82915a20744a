"""Differences between two results: means, peaks and phase over their settled beats."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape

from taichiflap.metrics.summary import Statistic, Summary
from taichiflap.notation import prefixed

from .colours import RUNS
from .frames import Run

RESOLVED = 0.05
"""Standard errors below this, in percent, are not shown."""
WHOLE_BEAT = "differences need one whole beat in both results"


@dataclass(frozen=True)
class Difference:
    """One metric of two results.

    Attributes:
        relative: difference in percent of the first; None for angles and times.
        error: standard error of this difference, in percent; None if a run has too few beats.
    """

    name: str
    unit: str
    first: float
    second: float
    relative: float | None
    error: float | None = None

    @property
    def change(self) -> str:
        """Second minus first."""
        if self.relative is None:
            return f"{self.second - self.first:+.3g}"
        error = f" ± {self.error:.1f}" if self.error is not None and self.error >= RESOLVED else ""
        return f"{self.relative:+.1f}{error} %"


def differences(first: Run, second: Run) -> list[Difference]:
    """Differences of two results over their settled beats; empty if one of them has no whole beat."""
    a, b = first.summary(), second.summary()
    if a is None or b is None:
        return []
    return list(_compared(a, b))


def _compared(a: Summary, b: Summary) -> Iterator[Difference]:
    hover = [("vertical force, mean", "N", "force_vertical")]
    stream = [("lift, mean", "N", "lift"), ("thrust, mean", "N", "thrust")]
    for name, unit, attribute in (
        *(stream if a.lift and b.lift else hover),
        ("normal force, peak", "N", "force_normal_peak"),
        ("tip deflection, peak", "m", "tip_peak"),
        ("power, mean", "W", "power"),
    ):
        found = [getattr(summary, attribute) for summary in (a, b)]
        one, other = (statistic.mean for statistic in found)
        factor, shown = prefixed(max(abs(one), abs(other)), unit)
        relative = 100.0 * (other - one) / abs(one) if one else None
        yield Difference(name, shown, factor * one, factor * other, relative, _error(*found))
    if a.force_normal_phase is not None and b.force_normal_phase is not None:
        one, other = a.force_normal_phase, b.force_normal_phase
        # The smaller of both angles.
        yield Difference("normal force, phase", "deg", one, one + (other - one + 180.0) % 360.0 - 180.0, None)
    if a.tip_peak.mean and b.tip_peak.mean:
        one, other = a.tip_peak_after_reversal, b.tip_peak_after_reversal
        if one is not None and other is not None:
            yield Difference("tip peak, after reversal", "T", one, other, None)
        else:
            yield Difference("tip peak, at t/T", "T", a.tip_peak_time, b.tip_peak_time, None)


def _error(one: Statistic, other: Statistic) -> float | None:
    """Standard error of the difference of two means, in percent of the first."""
    if one.error is None or other.error is None or not one.mean:
        return None
    return 100.0 * math.hypot(one.error, other.error) / abs(one.mean)


def text(first: Run, second: Run) -> Iterator[str]:
    """The differences as lines for a terminal."""
    yield f"A = {first.label}: {first.title}"
    yield f"B = {second.label}: {second.title}"
    found = differences(first, second)
    if not found:
        yield WHOLE_BEAT
        return
    yield f"{'':<28}{'A':>10}{'B':>10}  {'B against A'}"
    for one in found:
        yield f"{one.name + ', ' + one.unit:<28}{one.first:>10.4g}{one.second:>10.4g}  {one.change}"


def table(first: Run, second: Run, colours: Sequence[str] = RUNS, heads: tuple[str, str] | None = None) -> str:
    """The differences as an HTML table.

    Args:
        heads: headings of both columns; the labels of the results if None.
    """
    rows = "".join(
        f"<tr><td>{one.name.capitalize()}, {one.unit}</td>"
        f"<td>{one.first:.3g}</td><td>{one.second:.3g}</td><td style='white-space:nowrap'>{one.change}</td></tr>"
        for one in differences(first, second)
    )
    rows = rows or f"<tr><td colspan=4>{WHOLE_BEAT.capitalize()}.</td></tr>"
    named = "".join(
        f'<th style="color:{colour};text-align:left">{escape(head)}</th>'
        for head, colour in zip(heads or (first.label, second.label), colours, strict=True)
    )
    return (
        f'<div data-differences style="font-size:11px;padding:0 4px 6px"><table style="width:100%">'
        f"<tr><th></th>{named}<th style='text-align:left'>change</th></tr>{rows}</table></div>"
    )
