"""Published cases of rigid sections: hover, pitch-up ramps, a power-extracting foil and a propulsive foil.

The figures are means, harmonics and peaks of published traces; a phase is of the cosine of the beat.
"""

import cmath
import math
from collections.abc import Mapping
from typing import Any

from .truths import Published, Truth, around

HOVER, PITCH_UP, STALL, CRUISE = (
    "Hover at low Reynolds number",
    "Pitch-up in a stream, separated",
    "Deep dynamic stall",
    "Propulsion at moderate angles of attack",
)
"""Regimes of the report."""


POINTS = {
    25: (
        (1.2, 1.00, -0.05), (1.4, 1.18, -0.02), (1.6, 1.33, 0.05), (1.8, 1.54, 0.09), (2, 1.72, 0.10),
        (2.2, 1.92, 0.15), (2.4, 2.19, 0.24), (2.6, 2.42, 0.36), (2.8, 2.43, 0.51), (3, 1.63, 0.39),
        (3.2, 1.86, 0.57), (3.4, 1.86, 0.62), (3.6, 1.91, 0.65), (3.8, 1.95, 0.67), (4, 1.39, 0.51),
        (4.2, 1.25, 0.49), (4.4, 1.27, 0.43), (4.6, 1.07, 0.33), (4.8, 0.80, 0.22), (5, 0.56, 0.17),
        (5.2, 0.30, 0.13), (5.4, 0.08, 0.12), (5.6, -0.13, 0.11), (5.8, -0.35, 0.15), (6, 0.34, 0.01),
        (6.2, 0.21, 0.01), (6.4, 0.12, 0.03), (6.6, 0.08, 0.03), (6.8, 0.07, 0.03), (7, 0.08, 0.02),
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
}  # fmt: skip
"""Time, lift and drag coefficient of the ramps: at 25 deg as measured, at 45 and 90 deg as computed."""


def document(
    title: str, motion: Mapping[str, Any], stream: float, time: Mapping[str, Any], pivot: float, viscosity: float
) -> dict[str, Any]:
    """The case file of a rigid plate of unit chord and span in a fluid of unit density."""
    return {
        "title": title,
        "solver": "uvlm",
        "wing": {
            "chord": 1.0, "span": 1.0, "modes": 0, "pivot": pivot,
            "thickness": 0.02, "density": 1000.0, "youngs_modulus": 1e9,
        },
        "motion": dict(motion),
        "fluid": {"density": 1.0, "velocity": [stream, 0.0], "viscosity": viscosity},
        "time": dict(time),
    }  # fmt: skip


def _waves(mean: float, *harmonics: tuple[float, float]) -> tuple[complex, ...]:
    """Mean and complex harmonics, given by their amplitudes and phases in degrees."""
    return (complex(mean), *(cmath.rect(size, math.radians(phase)) for size, phase in harmonics))


def hover() -> Published:
    """Symmetrical hover of an ellipse."""
    beats = (2.0, 4.0)
    sources = "Li, Dong & Liu and Eldredge (Navier-Stokes), Wang et al. (robotic wing); band: their scatter"
    return Published(
        name="hover",
        group=HOVER,
        about="hover with a stroke of 2.8 chords, 45 deg at mid-stroke, symmetrical rotation about mid-chord, Re 75",
        document=document(
            "Hover, Re 75",
            {
                "frequency": 0.25,
                "plunge": {"amplitude": 1.4, "phase_deg": 90.0},
                "pitch": {"amplitude_deg": 45.0, "phase_deg": 0.0},
            },
            0.0,
            {"periods": 4, "steps_per_period": 200},
            0.5,
            2.0 * math.pi * 0.25 * 1.4 / 75.0,
        ),
        reynolds=75.0,
        speed=2.0 * math.pi * 0.25 * 1.4,
        truths=(
            Truth("C_L mean", 0.588, 0.517, 0.590, beats, sources),
            Truth("C_D mean", 1.020, 0.956, 1.040, beats, sources),
            Truth("C_L amplitude 2", 0.467, 0.445, 0.504, beats, sources),
            Truth("C_L phase 2", 158.0, 156.0, 164.0, beats, sources),
            Truth("C_D amplitude 2", 0.690, 0.573, 0.711, beats, sources),
            Truth("C_D phase 2", -155.0, -156.0, -150.0, beats, sources),
            Truth("C_L peak", 1.53, 1.21, 1.55, beats, sources),
        ),
        citation="Wang, Birch & Dickinson, J. Exp. Biol. 207 (2004); Eldredge, J. Comput. Phys. 221 (2007); "
        "Li, Dong & Liu (2015)",
        waves={
            "C_L": _waves(0.5895, (0.0628, 29.0), (0.4885, 160.1), (0.0881, -119.8), (0.3354, -86.0)),
            "C_D": _waves(1.0399, (0.0594, -15.6), (0.6685, -155.8), (0.1691, -105.4), (0.8152, -102.6)),
        },
        settings={"navier-stokes": ("navier_stokes.thickness=0.1", "time.steps_per_period=500")},
    )


def _ramp(
    name: str, angle: float, ramp: Mapping[str, float], duration: float, step: float, reynolds: float,
    truths: tuple[Truth, ...], citation: str,
) -> Published:  # fmt: skip
    return Published(
        name=name,
        group=PITCH_UP,
        about=f"pitch-up to {angle:g} deg about the leading edge, Re {reynolds:g}",
        document=document(
            f"Pitch-up to {angle:g} deg",
            {"pitch": {"kind": "ramp", "smoothing": 11.0, "amplitude_deg": -angle, **ramp}},
            1.0,
            {"duration": duration, "step": step},
            0.0,
            1.0 / reynolds,
        ),
        reynolds=reynolds,
        speed=1.0,
        truths=truths,
        citation=citation,
        points=POINTS[int(angle)],
        settings={"navier-stokes": ("time.step=0.004",)},
    )


def ramps() -> list[Published]:
    """Eldredge's ramps: 25 deg with a return, and 45 and 90 deg held."""
    both = "experiment and computation; band: between them"
    one = "one computation; band: 3 %"
    eldredge = "J. D. Eldredge's computations, as Ramesh et al., J. Fluid Mech. 751 (2014) compare with"
    return [
        _ramp(
            "ramp25", 25.0, {"start": 1.00505, "ramp": 1.96348, "hold": 1.12074}, 7.5, 0.015, 1e4,
            (
                Truth("C_L mean", 1.083, 1.0815, 1.322, (1.0, 7.0), both),
                Truth("C_D mean", 0.246, 0.2304, 0.358, (1.0, 7.0), both),
                Truth("C_L peak", 2.52, 2.51, 2.78, (1.0, 7.0), both),
                Truth("C_L peak time", 2.72, 2.70, 2.78, (1.0, 7.0), both),
            ),
            "Ol, Granlund and co-workers' water-tunnel run and the computation beside it in Ramesh et al., "
            "J. Fluid Mech. 751 (2014)",
        ),
        _ramp(
            "ramp45", 45.0, {"start": 1.00178, "ramp": 0.99643}, 4.8, 0.015, 1000.0,
            (
                around("C_L mean", 2.953, 0.03, (1.0, 4.8), one),
                around("C_D mean", 2.219, 0.03, (1.0, 4.8), one),
                around("C_L peak", 6.03, 0.03, (1.0, 4.8), one),
                around("C_D peak", 3.85, 0.03, (1.0, 4.8), one),
            ),
            eldredge,
        ),
        _ramp(
            "ramp90", 90.0, {"start": 1.00035, "ramp": 3.86781}, 4.8, 0.01, 1000.0,
            (
                around("C_L mean", 2.529, 0.03, (1.0, 4.8), one),
                around("C_D mean", 2.646, 0.03, (1.0, 4.8), one),
                around("C_L peak", 3.85, 0.03, (1.0, 4.8), one),
                around("C_D peak", 4.25, 0.03, (1.0, 4.8), one),
            ),
            eldredge,
        ),
    ]  # fmt: skip


def turbine() -> Published:
    """A foil that extracts power."""
    read = "laminar Navier-Stokes, read from a figure; band: 3 %"
    beat = (4.0, 5.0)
    return Published(
        name="kinsey-dumas",
        group=STALL,
        about="plunge of 1 chord and pitch of 76.3 deg about the third of the chord, f c/U = 0.12, Re 1,100",
        document=document(
            "Power extraction, Re 1100",
            {
                "frequency": 0.1200028,
                "plunge": {"amplitude": 1.0, "phase_deg": 90.0},
                "pitch": {"amplitude_deg": 76.33, "phase_deg": 0.0},
                "start_up_periods": 1.0,
            },
            1.0,
            {"periods": 5, "steps_per_period": 200},
            1.0 / 3.0,
            1.0 / 1100.0,
        ),
        reynolds=1100.0,
        speed=1.0,
        truths=(
            around("C_L amplitude", 1.855, 0.03, beat, read),
            Truth("C_L phase", 87.1, 84.0, 90.0, beat, "laminar Navier-Stokes, read from a figure; band: 3 deg"),
            around("C_D mean", 2.017, 0.03, beat, read),
            around("C_D amplitude 2", 1.592, 0.03, beat, read),
        ),
        citation="Kinsey & Dumas, AIAA J. 46 (2008)",
        settings={"navier-stokes": ("navier_stokes.thickness=0.15", "time.steps_per_period=1500")},
    )


def propulsion() -> list[Published]:
    """A propulsive foil at three Strouhal numbers, plunge of 0.75 chords and 15 deg angle of attack."""
    source = "water channel, and nonlinear inviscid theory beside it; band: between them, 0.02 wider"
    figures = {
        0.2: (0.298, 0.300, 0.377, 0.390),
        0.3: (0.494, 0.453, 0.656, 0.620),
        0.4: (0.754, 0.653, 1.070, 0.981),
    }
    found = []
    for strouhal, (thrust, thrust_theory, power, power_theory) in figures.items():
        pitch = math.degrees(math.atan(math.pi * strouhal)) - 15.0
        window, pairs = (3.0, 5.0), (("C_T mean", thrust, thrust_theory), ("C_P mean", power, power_theory))
        found.append(
            Published(
                name=f"anderson-{strouhal:g}",
                group=CRUISE,
                about=f"plunge of 0.75 chords, angle of attack of 15 deg, St {strouhal:g}, Re 40,000",
                document=document(
                    f"Propulsive foil, St {strouhal:g}",
                    {
                        "frequency": strouhal / 1.5,
                        "plunge": {"amplitude": 0.75, "phase_deg": 0.0},
                        "pitch": {"amplitude_deg": pitch, "phase_deg": 270.0},
                        "start_up_periods": 1.0,
                    },
                    1.0,
                    {"periods": 5, "steps_per_period": 160},
                    1.0 / 3.0,
                    1.0 / 4e4,
                ),
                reynolds=4e4,
                speed=1.0,
                truths=tuple(
                    Truth(quantity, value, min(value, other) - 0.02, max(value, other) + 0.02, window, source)
                    for quantity, value, other in pairs
                ),
                citation="Anderson, Streitlien, Barrett & Triantafyllou, J. Fluid Mech. 360 (1998)",
            )
        )
    return found
