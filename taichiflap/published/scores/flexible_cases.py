"""Published cases of flexible sections: a heaving foil in water, and the exact linear elastic plate."""

import math
from typing import Any

from .truths import Published, Truth, around

FOIL, PLATE, FLUTTER = "Flexible foil in water", "Flexible plate, small motion", "Onset of flutter"
"""Regimes of the report."""
STROUHAL = (0.2, 0.345, 0.5, 0.7, 0.9)
FOILS: dict[float, tuple[tuple[float | None, ...], tuple[float | None, ...]]] = {
    0.56e-3: ((None, 0.834, 1.560, 2.958, 5.170), (5.87, 13.07, 16.36, 18.20, 19.65)),
    0.85e-3: ((0.204, 1.008, 2.866, 5.277, 7.951), (None, 5.35, 10.32, 14.42, 16.50)),
    1.13e-3: ((None, 0.826, 2.621, 6.817, 10.86), (1.22, 3.44, 6.81, 11.23, 14.59)),
    1.41e-3: ((None, None, None, 6.732, 11.88), (0.654, 1.748, 4.408, 7.973, 11.46)),
    4.23e-3: ((0.010, 0.398, 1.559, 4.116, 8.196), (None,) * 5),
}
"""Thrust coefficient and pitch amplitude (deg) by relative thickness of the tail plate, at each Strouhal number; None
where the measurements do not reach. At 1.41e-3 no thrust was measured between St 0.354 and 0.675."""
EXACT = {
    (0.2, 2.0, 0.5): (0.697, -24.0),
    (0.2, 2.0, 2.0): (2.137, -169.1),
    (0.2, 4.0, 0.5): (2.777, -86.1),
    (0.2, 4.0, 2.0): (3.256, -173.3),
    (1.0, 2.0, 0.5): (0.583, -63.8),
    (1.0, 2.0, 2.0): (2.135, -149.7),
    (1.0, 4.0, 0.5): (0.829, -85.9),
    (1.0, 4.0, 2.0): (7.081, -157.9),
    (5.0, 2.0, 0.5): (0.512, -98.8),
    (5.0, 2.0, 2.0): (2.244, -132.2),
    (5.0, 4.0, 0.5): (0.583, -101.9),
    (5.0, 4.0, 2.0): (2.995, -177.9),
}
"""Tip deflection over the heave, and its phase (deg), by mass ratio, reduced speed and reduced frequency."""


ONSETS = {0.2: (6.191, 1.6027), 1.0: (5.553, 1.5446)}
"""Reduced speed and reduced frequency at which a free plate oscillates steadily, by mass ratio."""
ABOUT_ONSET = (0.96, 1.0, 1.04)
"""Shares of that speed at which a plate is let go."""
PERIODS = 30
"""Of the neutral oscillation that it is followed for: all but the mode that flutters dies within half."""


def foils() -> list[Published]:
    """Heathcote & Gursul's heaving foil: a rigid teardrop with a steel tail of five thicknesses."""
    speed, heave, chord = 0.1, 0.0175, 0.09
    found = []
    for thickness, (thrusts, pitches) in FOILS.items():
        for strouhal, thrust, pitch in zip(STROUHAL, thrusts, pitches, strict=True):
            truths = []
            if pitch is not None:
                truths.append(around("pitch amplitude", pitch, 0.05, (4.0, 6.0), "video; band: 5 %"))
            if thrust is not None:
                half = max(0.07 * thrust, 0.05)
                source = "water tunnel; band: 7 %, instrument and reading, or 0.05"
                truths.append(Truth("C_T mean", thrust, thrust - half, thrust + half, (4.0, 6.0), source))
            if truths:
                found.append(
                    Published(
                        name=f"heathcote-{1e3 * thickness:g}-{strouhal:g}",
                        group=FOIL,
                        about=f"heave of 0.194 chords, tail plate of {1e3 * thickness:g}e-3 chords, St {strouhal:g}",
                        document=_foil(thickness, strouhal, speed, heave, chord),
                        reynolds=9000.0,
                        speed=speed,
                        truths=tuple(truths),
                        citation="Heathcote & Gursul, AIAA J. 45 (2007); S. Heathcote, PhD thesis, University of Bath",
                    )
                )
    return found


def _foil(thickness: float, strouhal: float, speed: float, heave: float, chord: float) -> dict[str, Any]:
    """The case file: 4 mm of aluminium over the first third of the chord, then steel."""

    def table(head: float, tail: float) -> list[list[float]]:
        return [[0.0, head], [0.3333, head], [0.3334, tail], [1.0, tail]]

    return {
        "title": f"Heathcote & Gursul, b/c = {1e3 * thickness:g}e-3, St = {strouhal:g}",
        "solver": "uvlm",
        "wing": {
            "chord": chord, "span": 0.3, "modes": 4, "damping_ratio": 0.02,
            "thickness": table(0.004, thickness * chord), "density": table(2700.0, 7800.0),
            "youngs_modulus": table(7e10, 2.05e11),
        },
        "motion": {
            "frequency": strouhal * speed / (2.0 * heave),
            "plunge": {"amplitude": heave, "phase_deg": 90.0},
            "start_up_periods": 1.0,
        },
        "fluid": {"density": 998.0, "velocity": [speed, 0.0], "viscosity": speed * chord / 9000.0},
        "time": {"periods": 6, "steps_per_period": 200},
    }  # fmt: skip


def plates() -> list[Published]:
    """Wu's loads on an elastic plate that heaves at its clamped leading edge, by the exact linear theory."""
    found = []
    for (mass_ratio, reduced_speed, k), (tip, phase) in EXACT.items():
        thickness = 0.01
        inertia = 1.0 / mass_ratio  # rho c / (rho_s h) with unit rho and c
        stiffness = inertia / reduced_speed**2
        exact = "exact linear theory; band: 2 % and 1 deg"
        found.append(
            Published(
                name=f"plate-{mass_ratio:g}-{reduced_speed:g}-{k:g}",
                group=PLATE,
                about=f"mass ratio {mass_ratio:g}, reduced speed {reduced_speed:g}, reduced frequency {k:g}",
                document={
                    "title": f"Elastic plate, mass ratio {mass_ratio:g}, U* {reduced_speed:g}, k {k:g}",
                    "solver": "uvlm",
                    "wing": {
                        "chord": 1.0, "span": 1.0, "modes": 3, "damping_ratio": 0.05, "thickness": thickness,
                        "density": inertia / thickness, "youngs_modulus": 12.0 * stiffness / thickness**3,
                    },
                    "motion": {
                        "frequency": k / math.pi,
                        "plunge": {"amplitude": 1e-4, "phase_deg": 90.0},
                        "start_up_periods": 1.0,
                    },
                    "fluid": {"density": 1.0, "velocity": [1.0, 0.0]},
                    "time": {"periods": 8, "steps_per_period": 200},
                },
                reynolds=None,
                speed=1.0,
                truths=(
                    around("tip amplitude", tip, 0.02, (6.0, 8.0), exact),
                    Truth("tip phase", phase, phase - 1.0, phase + 1.0, (6.0, 8.0), exact),
                ),
                citation="exact linear theory: Wu's loads (J. Fluid Mech. 10, 1961) on an Euler-Bernoulli plate",
            )
        )  # fmt: skip
    return found


def fluttering() -> list[Published]:
    """Free plates clamped at their leading edge, let go by a touch, below and above the exact onset of flutter."""
    found = []
    for mass_ratio, (onset, k) in ONSETS.items():
        period = math.pi / k

        def stiffness(speed: float, mass_ratio: float = mass_ratio) -> float:
            return 1.0 / (mass_ratio * speed**2)

        found.append(
            Published(
                name=f"flutter-{mass_ratio:g}",
                group=FLUTTER,
                about=f"free plate clamped at its leading edge, mass ratio {mass_ratio:g}",
                document={
                    "title": f"Plate about its onset of flutter, mass ratio {mass_ratio:g}",
                    "solver": "uvlm",
                    "wing": {
                        "chord": 1.0, "span": 1.0, "modes": 4, "damping_ratio": 0.0,
                        "mass_per_length": 1.0 / mass_ratio, "flexural_rigidity": stiffness(onset),
                    },
                    "motion": {
                        "pitch": {"kind": "ramp", "amplitude_deg": 1e-3, "start": 0.2 * period, "ramp": 0.3 * period,
                                  "hold": 0.1 * period, "smoothing": 11.0},
                    },
                    "fluid": {"density": 1.0, "velocity": [1.0, 0.0]},
                    "time": {"duration": PERIODS * period, "step": period / 160},
                    "uvlm": {"wake": 600},
                },
                reynolds=None,
                speed=1.0,
                truths=(
                    around("onset of flutter", onset, 0.02, (0.5 * PERIODS * period, PERIODS * period),
                           "exact linear theory; band: 2 %"),
                ),
                citation="exact linear theory: Wu's loads (J. Fluid Mech. 10, 1961) on an Euler-Bernoulli plate",
                family={
                    share * onset: (f"wing.flexural_rigidity={stiffness(share * onset)!r}",) for share in ABOUT_ONSET
                },
            )
        )  # fmt: skip
    return found
