"""Published cases of rigid sections: hover, pitch-up ramps, a power-extracting foil and a propulsive foil.

The figures are means, harmonics and peaks of published traces; a phase is of the cosine of the beat.
"""

import cmath
import math
from collections.abc import Mapping
from typing import Any

from ...scored.ramps import RAMPS
from .truths import Published, Truth, around

HOVER, PITCH_UP, STALL, CRUISE = (
    "Hover at low Reynolds number",
    "Pitch-up in a stream, separated",
    "Deep dynamic stall",
    "Propulsion at moderate angles of attack",
)
"""Regimes of the report."""


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
        ramp=RAMPS[int(angle)],
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
