"""Both models compared with the exact linear solution of an elastic plate in a stream, and of its flutter."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .. import fluids, theory
from ..case.case import Case, parse_case
from ..kernels.runtime import view
from ..march.march import March
from ..march.state import AXIAL, NORMAL
from ..structure import beam
from .checks import Array, Chart, Check, Curve, History, Row, follow, run

STEPS = 200
SMALL = 1e-4
"""Heave, chords."""
PER_CENT = 100.0
MODELS = ("dbet", "uvlm")


class Setting(NamedTuple):
    """Mass ratio `rho c/(rho_s t)`, speed `U* = U c sqrt(rho_s t/(E I))` and reduced frequency."""

    mass_ratio: float
    speed: float
    k: float

    def __str__(self) -> str:
        return f"µ = {self.mass_ratio:g}, U* = {self.speed:g}, k = {self.k:g}"


POINTS = tuple(
    Setting(*one)
    for one in (
        (0.2, 1.0, 0.5), (0.2, 2.0, 0.5), (0.2, 4.0, 0.5), (0.2, 1.0, 1.0), (1.0, 1.0, 0.5), (1.0, 2.0, 0.5),
        (1.0, 2.0, 2.0), (1.0, 4.0, 0.5), (0.5, 2.0, 1.0), (5.0, 2.0, 0.5), (5.0, 2.0, 2.0), (5.0, 4.0, 0.5),
    )
)  # fmt: skip
"""Twelve of them, all below the onset of flutter."""
MASS_RATIOS = (0.2, 0.5, 1.0)
"""Settings of the flutter rows."""
BEATS = 40
"""Duration of a free vibration in periods of the neutral oscillation; all modes except the fluttering one decay within
half of it.
"""
FLUTTER_STEPS = 200
"""Steps per period."""


@dataclass(frozen=True)
class Response:
    """Complex amplitudes per chord of heave of the tip and of the lift coefficient; the mean thrust coefficient."""

    tip: complex
    lift: complex
    thrust: float


def plate(solver: str, mass_ratio: float, speed: float, modes: int, *settings: str) -> Case:
    """An undamped plate of unit chord and span in a unit stream of unit density."""
    document = {
        "solver": solver,
        "wing": {
            "chord": 1.0, "span": 1.0, "mass_per_length": 1.0 / mass_ratio, "modes": modes, "damping_ratio": 0.0,
            "flexural_rigidity": 1.0 / (mass_ratio * speed**2),
        },
        "motion": {"frequency": 1.0},
        "fluid": {"density": 1.0, "velocity": [1.0, 0.0]},
        "uvlm": {"suction": True},
    }  # fmt: skip
    return parse_case(document, "validation").override(*settings)


def heaving(solver: str, settings: Sequence[Setting] = POINTS, steps: int = STEPS) -> list[Response]:
    """The plate with three modes, heaving at its leading edge, when periodic."""
    cases = []
    for one in settings:
        frequency = one.k / math.pi
        beats = max(8, round(8 * frequency))
        driven = (
            f"motion.frequency={frequency}", f"time.periods={beats}", f"time.steps_per_period={steps}",
            f"motion.plunge.amplitude={SMALL}", "motion.plunge.phase_deg=90.0", "motion.start_up_periods=3.0",
            "uvlm.wake=1000",
        )  # fmt: skip
        cases.append(plate(solver, one.mass_ratio, one.speed, 3, *driven))
    return [_response(case, history) for case, history in zip(cases, run(cases), strict=True)]


def oscillating_blades(k: float, beats: int = 6) -> Response:
    """A rigid plunging plate in blade element theory."""
    case = plate(
        "dbet", 1.0, 1.0, 0, f"motion.frequency={k / math.pi}", f"time.periods={max(beats, round(20 * k))}",
        f"time.steps_per_period={STEPS}", f"motion.plunge.amplitude={SMALL}", "motion.plunge.phase_deg=90.0",
        "motion.start_up_periods=2.0",
    )  # fmt: skip
    found = _response(case, run([case])[0])
    return Response(found.tip, found.lift * SMALL, found.thrust * SMALL**2)


def _response(case: Case, history: History) -> Response:
    """Amplitudes over the last two beats, fitted with a mean and a drift; thrust over the last beat."""
    steps = round(case.steps_per_beat)
    last = history.step > case.steps - 2 * steps
    angle = 2.0 * math.pi * history.step[last] / steps
    base = np.stack((np.cos(angle), np.sin(angle), np.ones_like(angle), angle), axis=1)
    tip = history.amplitude @ beam.modes(case.wing).shape([case.wing.chord])[:, 0]
    both = np.stack((tip[last], 2.0 * history.force[last, NORMAL]), axis=1)
    fitted = np.linalg.lstsq(base, both, rcond=None)[0] / SMALL
    amplitude, lift = fitted[0] - 1j * fitted[1]
    thrust = -2.0 * float(np.mean(history.force[-steps:, AXIAL])) / SMALL**2
    return Response(complex(amplitude), complex(lift), thrust)


def exact(setting: Setting) -> theory.plate.Heaving:
    """The same from theory."""
    return theory.ElasticPlate(setting.mass_ratio, setting.speed).heaving(setting.k)


def elastic_plate(settings: Sequence[Setting] = POINTS) -> Check:
    """Tip deflection and lift of heaving plates with various stiffnesses and masses."""
    rows, tips, phases = [], [], []
    expected = [exact(setting) for setting in settings]
    numbers = np.arange(1, len(settings) + 1, dtype=float)
    for solver in MODELS:
        found = heaving(solver, settings)
        name = solver.upper()
        amplitude, late = [], []
        for setting, ours, theirs in zip(settings, found, expected, strict=True):
            ratio = ours.tip / theirs.tip
            amplitude.append(PER_CENT * (abs(ratio) - 1.0))
            late.append(math.degrees(float(np.angle(ratio))))
            phase = math.degrees(float(np.angle(theirs.tip)))
            rows.append(Row.relative(f"{name}, {setting}, tip", abs(ours.tip), abs(theirs.tip), TOLERANCE[solver]))
            rows.append(
                Row(f"{name}, {setting}, tip, phase", phase + late[-1], phase, late[-1], PHASE_TOLERANCE[solver], "deg")
            )
            rows.append(Row.relative(f"{name}, {setting}, lift", abs(ours.lift), abs(theirs.lift), LIFT_TOLERANCE))
        tips.append(Curve(name, numbers, np.array(amplitude), "o"))
        phases.append(Curve(name, numbers, np.array(late), "o"))
    return Check(
        "elastic-plate",
        "An elastic plate that heaves in a stream",
        "The exact linear solution: Wu's loads (J. Fluid Mech. 10, 1961) on an Euler-Bernoulli beam clamped at its "
        f"leading edge, with 14 polynomials. Amplitude 1e-4 chords, three modes, {STEPS} steps per period, both "
        "models with their defaults. Points in the figure are numbered in the order of the rows.",
        tuple(rows),
        (
            Chart("Tip, amplitude", "Setting, by number", "Error of the amplitude (%)", tuple(tips)),
            Chart("Tip, phase", "Setting, by number", "Error of the phase (deg)", tuple(phases)),
        ),
    )


TOLERANCE = {"dbet": 0.3, "uvlm": 2.0}
PHASE_TOLERANCE = {"dbet": 0.5, "uvlm": 1.0}
LIFT_TOLERANCE = 2.0
ONSET_TOLERANCE = 2.0
"""Of the rows: % of the tip, degrees of its phase, % of the lift and of the onset of flutter."""


def growth(solver: str, mass_ratio: float, *speeds: float) -> Array:
    """Growth rate (per radian of the neutral oscillation) of a plate's free vibration at several speeds."""
    _, k = theory.flutter_onset(mass_ratio)
    cases = [
        plate(solver, mass_ratio, speed, 4, f"motion.frequency={k / math.pi}", f"time.periods={BEATS}",
              f"time.steps_per_period={FLUTTER_STEPS}", "uvlm.wake=750")
        for speed in speeds
    ]  # fmt: skip
    march = March(cases, fluids.load(solver))
    view(march.body.q)[:, 0, 0] = 1e-6
    found = []
    for history in follow(march):
        size = np.sqrt(np.mean((history.amplitude[1:] ** 2).reshape(BEATS, -1, 4).sum(axis=2), axis=1))
        beats = np.arange(BEATS // 2, BEATS)
        found.append(np.polyfit(2.0 * math.pi * beats, np.log(size[beats]), 1)[0])
    return np.array(found)


def onset(solver: str, mass_ratio: float) -> float:
    """Speed U* of zero growth, interpolated near the exact one."""
    reference, _ = theory.flutter_onset(mass_ratio)
    speeds = reference * np.array([0.96, 1.0, 1.04])
    rates = growth(solver, mass_ratio, *speeds)
    line = np.polyfit(speeds, rates, 1)
    return float(-line[1] / line[0])


def flutter(mass_ratios: Sequence[float] = MASS_RATIOS) -> Check:
    """Onset of flutter of a plate clamped at its leading edge."""
    rows, curves = [], []
    reference = [theory.flutter_onset(one) for one in mass_ratios]
    for solver in MODELS:
        found = [onset(solver, one) for one in mass_ratios]
        for mass_ratio, ours, (theirs, _) in zip(mass_ratios, found, reference, strict=True):
            setting = f"{solver.upper()}, µ = {mass_ratio:g}, U*"
            rows.append(Row.relative(setting, ours, theirs, ONSET_TOLERANCE))
        curves.append(Curve(solver.upper(), np.array(mass_ratios), np.array(found), "o"))
    line = np.linspace(min(mass_ratios), max(mass_ratios), 9)
    exactly = np.array([theory.flutter_onset(float(one))[0] for one in line])
    return Check(
        "flutter",
        "Onset of flutter of an elastic plate",
        "The exact linear solution: the lowest speed at which the free plate, clamped at its leading edge, "
        "oscillates with constant amplitude. Each model is released at 0.96, 1 and 1.04 of this speed, with four "
        "modes and no damping. Its onset is the zero of a line through the three growth rates.",
        tuple(rows),
        (
            Chart(
                "Onset of flutter",
                "Mass ratio ρ c/(ρs t) (1)",
                "Speed U* (1)",
                (Curve("exact", line, exactly), *curves),
            ),
        ),
    )
