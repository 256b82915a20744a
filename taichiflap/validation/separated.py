"""The Navier-Stokes model compared with published time histories of separated flow."""

import math
from collections.abc import Sequence

import numpy as np

from ..case.case import Case
from ..motion import sampling
from ..scored.ramps import RAMPS
from .checks import Array, Chart, Check, Curve, Row, plate, run
from .viscous import PER_CENT, coefficients, viscous

THIN = 0.02
"""Thickness of the section that stands for a thin plate."""
RMS = {90: 3.0, 45: 4.5}
"""Largest root mean square of the errors, % of that of the coefficient."""
TURNS = {90: (1.00035, 3.86781, 4.8), 45: (1.00178, 0.99643, 4.8)}
"""Start and length of the ramps, and the last time, chords over the stream's speed."""
HOVER = {
    "C_L": ((0.5895, 0.0), (0.0628, 29.0), (0.4885, 160.1), (0.0881, -119.8), (0.3354, -86.0)),
    "C_D": ((1.0399, 0.0), (0.0594, -15.6), (0.6685, -155.8), (0.1691, -105.4), (0.8152, -102.6)),
}
"""Mean and harmonics of the beat, amplitude and phase (deg), of the coefficients of hover by Li, Dong & Liu (2015)."""
STROKE = 1.4
"""Amplitude of the plunge in hover, chords."""


def hovering() -> Case:
    """Symmetrical hover of an ellipse, 45 deg at mid-stroke, Reynolds number 75 with the maximum speed."""
    base = plate("solver=navier_stokes", "fluid.viscosity=1.0", "wing.pivot=0.5", "navier_stokes.thickness=0.1")
    motion = {
        "frequency": 1.0,
        "plunge": {"amplitude": STROKE, "phase_deg": 90.0},
        "pitch": {"amplitude_deg": 45.0, "phase_deg": 0.0},
    }
    fluid = {"density": 1.0, "viscosity": 2.0 * math.pi * STROKE / 75.0}
    return viscous(base, motion=motion, fluid=fluid, time={"periods": 4, "steps_per_period": 500})


def ramp(angle: int) -> Case:
    """A pitch-up about the leading edge in a stream, Reynolds number 1,000."""
    start, length, end = TURNS[angle]
    base = plate("solver=navier_stokes", "fluid.viscosity=0.001", f"navier_stokes.thickness={THIN}")
    pitch = {"kind": "ramp", "smoothing": 11.0, "amplitude_deg": -angle, "start": start, "ramp": length}
    return viscous(base, motion={"pitch": pitch}, time={"duration": end, "step": 0.004})


def separated(angles: Sequence[int] = tuple(RMS)) -> Check:
    """Published time histories of separated flow: hover at a Reynolds number of 75, ramps at 1,000."""
    case = hovering()
    (history,) = run([case])
    beats, along, across = coefficients(case, history)
    speed = sampling.sample(case.motion, beats)[:, sampling.PLUNGE_RATE]
    square = (2.0 * math.pi * STROKE) ** 2
    found = {"C_L": -along / square, "C_D": -across * np.sign(speed) / square}
    kept = beats >= 2.0
    mean = float(found["C_L"][kept].mean())
    rows, charts = [Row("hover, mean C_L", mean, 0.56, mean - 0.56, 0.01)], []
    for name, waves in HOVER.items():
        x, terms = found[name][kept], [size * np.exp(1j * math.radians(phase)) for size, phase in waves]
        ours = [complex(x.mean())]
        ours += [complex(2.0 * np.mean(x * np.exp(-2j * np.pi * n * beats[kept]))) for n in range(1, len(terms))]
        error = PER_CENT * _size(np.subtract(ours, terms)) / _size(np.array(terms))
        rows.append(Row(f"hover, rms of {name}", error, 0.0, error, 8.0, "%"))
    for angle in angles:
        case = ramp(angle)
        (history,) = run([case])
        time, drag, lift = coefficients(case, history)
        known = RAMPS[angle]
        drawn = (time > known.first) & (time < known.last)
        curves = []
        for name, trace in (("C_L", lift), ("C_D", drag)):
            theirs = known.published(name, known.times)
            off = known.filtered(name, time, trace) - theirs
            error = PER_CENT * math.sqrt(np.mean(off**2) / np.mean(theirs**2))
            rows.append(Row(f"ramp to {angle} deg, rms of {name}", error, 0.0, error, RMS[angle], "%"))
            curves += [Curve(name, time[drawn], trace[drawn])]
            curves += [Curve(f"{name}, published, 7 cosines", time[drawn], known.published(name, time[drawn]), "--")]
        charts.append(Chart(f"Ramp to {angle} deg", "Time U t/c (1)", "Coefficient (1)", tuple(curves)))
    return Check(
        "separated",
        "Separated flow: hover and pitch-up ramps",
        "Root mean square of the difference relative to that of the published coefficient. Hover of an ellipse of 10 "
        "% thickness at a Reynolds number of 75, compared with Li, Dong & Liu (2015): mean and four harmonics of "
        "beats 2 to 4; the reference 0.56 of the mean is about the value of two separate codes. Ramps at a Reynolds "
        "number of 1,000, compared with Eldredge's computations (in Ramesh et al., J. Fluid Mech. 751, 2014): mean "
        f"and seven cosines over the time from 1.1 to 4.8, with a section of {100 * THIN:g} % thickness.",
        tuple(rows),
        tuple(charts),
    )


def _size(terms: Array) -> float:
    """Root mean square of a mean and harmonics."""
    return math.sqrt(abs(terms[0]) ** 2 + 0.5 * float(np.sum(np.abs(terms[1:]) ** 2)))
