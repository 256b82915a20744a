"""Time to accuracy: processor time against the error in the lift of a plate plunging at k = 0.5, for taichiflap and
PteraSoftware.
"""

import math
from dataclasses import dataclass

from taichiflap.case.case import Case
from taichiflap.kernels.runtime import start
from taichiflap.validation import oscillation
from taichiflap.validation.checks import accurate, run

from .clock import alternate
from .peers import ptera
from .rows import Row
from .runs import marching

SECTION = "Time to accuracy"
K, WITHIN, CYCLES = 0.5, 2.0, 3
OURS = ((2, 16), (3, 16), (4, 20), (6, 25), (8, 40), (12, 60), (16, 100), (24, 200))
"""Panels, and steps a period: refined together."""
PTERA = ((4, 25), (6, 40), (8, 50), (12, 75), (16, 100))
"""Panels along the chord, and steps a period."""
HALF_SPAN_PANELS = 2
OURS_NAME, PTERA_NAME = "taichiflap, plate", "PteraSoftware, wing of aspect ratio 20"


@dataclass(frozen=True)
class Point:
    """A setting: its cost, s of processor time, and the error of its lift in amplitude (%) and phase (deg)."""

    who: str
    panels: int
    steps: int
    seconds: float
    amplitude: float
    phase: float

    @classmethod
    def of(cls, who: str, panels: int, steps: int, seconds: float, ratio: complex) -> "Point":
        """From the measured over the exact complex amplitude."""
        phase = math.degrees(math.atan2(ratio.imag, ratio.real))
        return cls(who, panels, steps, seconds, 100.0 * (abs(ratio) - 1.0), phase)


def measure() -> list[Point]:
    """All settings of all contestants."""
    start()
    exact = oscillation.exact("plunge", K).lift / oscillation.SMALL
    cases = {setting: _case(*setting) for setting in OURS}
    clocked = alternate({str(setting): marching([case]) for setting, case in cases.items()}, 5)
    points = []
    for (panels, steps), case in cases.items():
        lift = oscillation.loads(case, run([case])[0]).lift / oscillation.SMALL
        seconds = clocked[str((panels, steps))].cpu
        points.append(Point.of(OURS_NAME, panels, steps, seconds, lift / exact))
    settings = [
        {"chordwise": panels, "spanwise": HALF_SPAN_PANELS, "steps": steps, "cycles": CYCLES} for panels, steps in PTERA
    ]
    for found in ptera.ask("plunge", *settings) or ():
        lift = complex(found["real"], found["imag"])
        points.append(Point.of(PTERA_NAME, found["chordwise"], found["steps"], found["cpu"], lift / exact))
    return points


def _case(panels: int, steps: int) -> Case:
    return oscillation.oscillating("plunge", K, accurate(panels), steps, CYCLES).override("uvlm.suction=false")


def cheapest(points: list[Point], who: str) -> Point | None:
    """The cheapest setting whose amplitude is within the bound."""
    within = [point for point in points if point.who == who and abs(point.amplitude) <= WITHIN]
    return min(within, key=lambda point: point.seconds, default=None)


def rows(points: list[Point]) -> list[Row]:
    """The table's lines: the cheapest of each, and their ratio."""
    found = {who: cheapest(points, who) for who in (OURS_NAME, PTERA_NAME)}
    lines = []
    for who, point in found.items():
        note = "no setting here"
        if point:
            note = (
                f"{point.panels} panels, {point.steps} steps a period: {point.amplitude:+.1f} %, {point.phase:+.1f} deg"
            )
        elif not any(point.who == who for point in points):
            note = ptera.MISSING
        value = 1e3 * point.seconds if point else None
        lines.append(Row(SECTION, f"{who}: cheapest within {WITHIN:g} % in amplitude", value, "ms", note=note))
    ours, peer = found.values()
    if ours and peer:
        lines.append(Row(SECTION, "PteraSoftware over taichiflap", peer.seconds / ours.seconds, "x"))
    return lines
