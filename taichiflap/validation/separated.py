"""The Navier-Stokes model against published time histories of separated flow."""

import math
from collections.abc import Sequence

import numpy as np

from ..case.case import Case
from ..motion import sampling
from .checks import Array, Chart, Check, Curve, Row, plate, run
from .viscous import PER_CENT, coefficients, viscous

THIN = 0.02
"""Thickness of the section that stands for a thin plate."""
RAMPS = {
    90: (
        (1.1, 1.986, 0.207), (1.2, 1.902, 0.257), (1.3, 2.102, 0.333), (1.4, 2.286, 0.427), (1.5, 2.479, 0.540),
        (1.6, 2.681, 0.672), (1.7, 2.886, 0.826), (1.8, 3.062, 0.994), (1.9, 3.209, 1.175), (2, 3.392, 1.390),
        (2.1, 3.609, 1.634), (2.2, 3.749, 1.881), (2.3, 3.837, 2.120), (2.4, 3.815, 2.308), (2.5, 3.725, 2.459),
        (2.6, 3.763, 2.709), (2.7, 3.845, 3.015), (2.8, 3.824, 3.260), (2.9, 3.723, 3.445), (3, 3.599, 3.613),
        (3.1, 3.454, 3.765), (3.2, 3.314, 3.926), (3.3, 3.194, 4.118), (3.4, 2.994, 4.206), (3.5, 2.766, 4.242),
        (3.6, 2.478, 4.159), (3.7, 2.225, 4.110), (3.8, 2.006, 4.104), (3.9, 1.796, 4.102), (4, 1.582, 4.070),
        (4.1, 1.374, 4.020), (4.2, 1.172, 3.954), (4.3, 0.959, 3.783), (4.4, 0.768, 3.607), (4.5, 0.579, 3.416),
        (4.6, 0.416, 3.302), (4.7, 0.257, 3.083), (4.8, 0.108, 2.149),
    ),
    45: (
        (1.1, 4.421, 0.509), (1.2, 4.413, 0.761), (1.3, 4.840, 1.154), (1.4, 5.312, 1.655), (1.5, 5.649, 2.212),
        (1.6, 6.008, 2.886), (1.7, 5.690, 3.264), (1.8, 5.457, 3.695), (1.9, 4.588, 3.563), (2, 2.189, 1.745),
        (2.1, 2.631, 2.331), (2.2, 2.982, 2.734), (2.3, 2.903, 2.694), (2.4, 2.883, 2.701), (2.5, 2.846, 2.671),
        (2.6, 2.816, 2.646), (2.7, 2.809, 2.658), (2.8, 2.816, 2.689), (2.9, 2.740, 2.630), (3, 2.616, 2.516),
        (3.1, 2.497, 2.405), (3.2, 2.369, 2.291), (3.3, 2.259, 2.212), (3.4, 2.179, 2.177), (3.5, 2.104, 2.151),
        (3.6, 1.929, 2.025), (3.7, 1.731, 1.876), (3.8, 1.537, 1.736), (3.9, 1.432, 1.685), (4, 1.538, 1.838),
        (4.1, 1.695, 2.023), (4.2, 1.831, 2.170), (4.3, 1.912, 2.250), (4.4, 1.896, 2.235), (4.5, 1.848, 2.196),
        (4.6, 1.788, 2.148), (4.7, 1.717, 2.088), (4.8, 1.635, 2.013),
    ),
}  # fmt: skip
"""Time, lift and drag coefficient of Eldredge's ramps, as Ramesh et al. (J. Fluid Mech. 751, 2014) compare with."""
RMS = {90: 4.0, 45: 6.0}
"""Largest root mean square of the errors, per cent of that of the coefficient."""
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
    """Hover of an ellipse, symmetrical, 45 deg at mid-stroke, Reynolds number 75 by the largest speed."""
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


def separated(angles: Sequence[int] = tuple(RAMPS)) -> Check:
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
        points = np.array(RAMPS[angle])
        drawn = (time > 1.0) & (time < 4.8)
        curves = []
        for name, trace, column in (("C_L", lift, 1), ("C_D", drag, 2)):
            theirs = points[:, column]
            off = np.interp(points[:, 0], time, trace) - theirs
            error = PER_CENT * math.sqrt(np.mean(off**2) / np.mean(theirs**2))
            rows.append(Row(f"ramp to {angle} deg, rms of {name}", error, 0.0, error, RMS[angle], "%"))
            curves += [Curve(name, time[drawn], trace[drawn]), Curve(f"{name}, published", points[:, 0], theirs, "o")]
        charts.append(Chart(f"Ramp to {angle} deg", "Time U t/c (1)", "Coefficient (1)", tuple(curves)))
    return Check(
        "separated",
        "Separated flow: hover and pitch-up ramps",
        "Root mean square of the difference over that of the published coefficient. Hover of an ellipse of 10 % at a "
        "Reynolds number of 75 against Li, Dong & Liu (2015), mean and four harmonics of the beats 2 to 4; the rows of "
        "the mean are about what two separate codes gave, 0.56. Ramps at 1,000 against Eldredge's computations (in "
        f"Ramesh et al., J. Fluid Mech. 751, 2014), with a section of {100 * THIN:g} %.",
        tuple(rows),
        tuple(charts),
    )


def _size(terms: Array) -> float:
    """Root mean square of a mean and harmonics."""
    return math.sqrt(abs(terms[0]) ** 2 + 0.5 * float(np.sum(np.abs(terms[1:]) ** 2)))
