"""The lattice against exact theory of a plate in a stream: Wagner's start, Theodorsen's lift, Garrick's thrust."""

import math
from collections.abc import Sequence

import numpy as np

from .. import theory
from ..body import AXIAL, NORMAL
from ..case import Case
from ..motion import PITCH, sample
from .checks import Array, Chart, Check, Curve, History, Row, plate, run

PANELS = 50
STEPS = 200
BEATS = 4
SMALL = 1e-4
"""Amplitude of motions held against linear theory, chords or rad."""
FREQUENCIES = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
HIGH = (1.0, 2.0, 5.0)
REFINED = (12, 25, 50, 100)
HALF_CHORDS = (1, 2, 5, 10, 20)
PER_CENT = 100.0

_PITCH = (f"motion.pitch.amplitude_deg={math.degrees(SMALL)}", "motion.pitch.phase_deg=90.0")
MOTIONS: dict[str, dict[str, float]] = {
    "plunge": {"plunge": SMALL},
    "pitch about leading edge": {"pitch": -SMALL},
    "pitch about quarter chord": {"pitch": -SMALL, "axis": 0.25},
}
"""Motions by name, as `taichiflap.theory` takes them; the case file's pitch is nose down."""
DRIVES = {
    "plunge": (f"motion.plunge.amplitude={SMALL}", "motion.plunge.phase_deg=90.0"),
    "pitch about leading edge": _PITCH,
    "pitch about quarter chord": (
        *_PITCH,
        f"motion.plunge.amplitude={0.25 * SMALL}",
        "motion.plunge.phase_deg=-90.0",
    ),
}
"""The same motions in the words of the case file, whose pitch axis is the leading edge."""


def wagner(grids: Sequence[tuple[int, float]] = ((25, 0.04), (50, 0.02), (100, 0.01))) -> Check:
    """Lift after a sudden start; a grid is panels and travel a step, chords."""
    expected = np.array([theory.wagner(s) for s in HALF_CHORDS])
    histories = run([_started(panels, travel) for panels, travel in grids])
    rows, curves = [], []
    for (panels, travel), history in zip(grids, histories, strict=True):
        lift = np.interp(HALF_CHORDS, 2.0 * travel * history.step, _share_of_steady(history))
        errors = PER_CENT * (lift / expected - 1.0)
        label = f"{panels} panels, U Δt/c = {travel:g}"
        curves.append(Curve(label, np.array(HALF_CHORDS, dtype=float), np.abs(errors), "o-"))
        if panels == PANELS:
            rows = [Row.relative(f"s = {s}, {label}", lift[i], expected[i], 1.0) for i, s in enumerate(HALF_CHORDS)]
            measured = Curve(
                label, (2.0 * travel * history.step[2:]).astype(float), _share_of_steady(history)[2:], "--"
            )
    line = np.linspace(0.0, 21.0, 106)
    return Check(
        "wagner",
        "Wagner: lift after a sudden start",
        "The exact function, by integration of Theodorsen's (Garrick 1938), s in half-chords travelled; 0.1 degree.",
        tuple(rows),
        (
            Chart(
                "Lift after a sudden start",
                "Distance travelled s (half-chords)",
                "Lift over steady lift (1)",
                (Curve("exact", line, np.array([theory.wagner(s) for s in line])), measured),
            ),
            Chart(
                "Error, panels and steps refined together",
                "Distance travelled s (half-chords)",
                "Error of the lift (%)",
                tuple(curves),
                "xy",
            ),
        ),
    )


def _started(panels: int, travel: float) -> Case:
    steps = round((0.5 * max(HALF_CHORDS) + 0.5) / travel)
    return plate(
        f"motion.frequency={1.0 / (steps * travel)}", "time.periods=1", f"time.steps_per_period={steps}",
        "motion.pitch.mean_deg=-0.1", panels=panels,
    )  # fmt: skip


def _share_of_steady(history: History) -> Array:
    return 2.0 * history.force[:, NORMAL] / theory.plate_normal_force(math.radians(0.1))


def oscillating(name: str, k: float, panels: int = PANELS, steps: int = STEPS, beats: int = BEATS) -> Case:
    """A plate in one of `MOTIONS` at reduced frequency `k`."""
    return plate(
        *DRIVES[name], f"motion.frequency={k / math.pi}", f"time.periods={beats}", f"time.steps_per_period={steps}",
        panels=panels,
    )  # fmt: skip


def lift_amplitude(case: Case, history: History) -> complex:
    """Complex lift coefficient over the last two beats, beside a mean and a drift that the start leaves behind."""
    steps = round(case.steps_per_beat)
    last = history.step > case.steps - 2 * steps
    angle = 2.0 * math.pi * history.step[last] / steps
    base = np.stack((np.cos(angle), np.sin(angle), np.ones_like(angle), angle), axis=1)
    fitted = np.linalg.lstsq(base, 2.0 * history.force[last, NORMAL], rcond=None)[0]
    return complex(fitted[0], -fitted[1])


def mean_thrust(case: Case, history: History) -> float:
    """Mean of the thrust coefficient over the last beat; the stream is along Y."""
    steps = round(case.steps_per_beat)
    last = slice(-steps, None)
    pitch = sample(case.motion, case.step * history.step[last])[:, PITCH]
    along = history.force[last, AXIAL] * np.cos(pitch) - history.force[last, NORMAL] * np.sin(pitch)
    return -2.0 * float(np.mean(along))


def oscillation(frequencies: Sequence[float] = FREQUENCIES, refined: Sequence[int] = REFINED) -> list[Check]:
    """Lift of a plunging and pitching plate, and the thrust of its normal force, from one batch of marches.

    `refined` are the numbers of panels of the chart that shows how errors at high frequency fall.
    """
    pairs = [(name, k) for name in MOTIONS for k in frequencies]
    cases = [oscillating(name, k) for name, k in pairs]
    histories = run(cases)
    ratios = {
        pair: lift_amplitude(case, history) / theory.oscillating_loads(pair[1], **MOTIONS[pair[0]])[0]
        for pair, case, history in zip(pairs, cases, histories, strict=True)
    }
    thrusts = {
        pair: mean_thrust(case, history)
        for pair, case, history in zip(pairs, cases, histories, strict=True)
        if "pitch" in MOTIONS[pair[0]]
    }
    return [_theodorsen(ratios, frequencies, _refinement(refined)), _garrick(thrusts, frequencies)]


def _refinement(panels: Sequence[int]) -> Chart:
    name = "pitch about quarter chord"
    curves = []
    for k in HIGH:
        cases = [oscillating(name, k, count, 4 * count) for count in panels]
        exact = theory.oscillating_loads(k, **MOTIONS[name])[0]
        found = [lift_amplitude(case, history) / exact for case, history in zip(cases, run(cases), strict=True)]
        errors = PER_CENT * np.abs(np.array(found) - 1.0)
        curves.append(Curve(f"k = {k:g}", np.array(panels, dtype=float), errors, "o-"))
    title = "Pitch about quarter chord, four steps a panel"
    return Chart(title, "Panels", "Error of the complex lift (%)", tuple(curves), "xy")


def _theodorsen(ratios: dict[tuple[str, float], complex], frequencies: Sequence[float], refinement: Chart) -> Check:
    rows = []
    for (name, k), ratio in ratios.items():
        exact = theory.oscillating_loads(k, **MOTIONS[name])[0] / MOTIONS[name].get("pitch", SMALL)
        rows.append(Row.relative(f"{name}, k = {k:g}, amplitude", abs(ratio * exact), abs(exact), 3.0))
        phase = float(np.degrees(np.angle(exact)))
        late = float(np.degrees(np.angle(ratio)))
        rows.append(Row(f"{name}, k = {k:g}, phase", phase + late, phase, late, 1.0, "deg"))
    x = np.array(frequencies)
    found = {name: np.array([ratios[name, k] for k in frequencies]) for name in MOTIONS}
    return Check(
        "theodorsen",
        "Theodorsen: lift in plunge and pitch",
        "NACA Report 496 (1935), lift coefficient per chord of plunge and per radian of pitch; 50 panels, 200 steps a "
        "period, amplitude 1e-4. The pitch axis of a case is the leading edge: pitch about the quarter chord is that "
        "and a plunge. The last chart shows how the errors at high frequency fall with panels and steps.",
        tuple(rows),
        (
            Chart(
                "Amplitude",
                "Reduced frequency k = ωc/2U (1)",
                "Error of the amplitude (%)",
                tuple(Curve(n, x, PER_CENT * (np.abs(r) - 1.0), "o-") for n, r in found.items()),
                "x",
            ),
            Chart(
                "Phase",
                "Reduced frequency k = ωc/2U (1)",
                "Error of the phase (deg)",
                tuple(Curve(n, x, np.degrees(np.angle(r)), "o-") for n, r in found.items()),
                "x",
            ),
            refinement,
        ),
    )


def _garrick(thrusts: dict[tuple[str, float], float], frequencies: Sequence[float]) -> Check:
    rows, charts = [], []
    x = np.array(frequencies)
    line = np.geomspace(x.min(), x.max(), 60)
    for name in sorted({name for name, _ in thrusts}):
        found = np.array([thrusts[name, k] for k in frequencies])
        exact, largest = _lean(name, x, suction=False), _largest_lean(name, x)
        errors = PER_CENT * (found - exact) / largest
        rows += [
            Row(
                f"{name}, k = {k:g}, no suction", found[i] / SMALL**2, exact[i] / SMALL**2, errors[i], 3.0,
                "% of |L||α|/2",
            )
            for i, k in enumerate(frequencies)
        ]  # fmt: skip
        scale = _largest_lean(name, line)
        curves = (
            Curve("Garrick without suction", line, _lean(name, line, suction=False) / scale),
            Curve("Garrick with suction", line, _lean(name, line, suction=True) / scale, "--"),
            Curve("lattice", x, found / largest, "o"),
        )
        charts.append(
            Chart(name.capitalize(), "Reduced frequency k = ωc/2U (1)", "Mean thrust over |L||α|/2 (1)", curves, "x")
        )
    return Check(
        "garrick",
        "Garrick: mean thrust in pitch, normal force alone",
        "NACA Report 567 (1936), thrust coefficient per radian². The lattice gives the normal force and no suction at "
        "the leading edge, so it is held against Garrick without suction; in plunge that thrust is zero. It crosses "
        "zero, so errors are in shares of the largest thrust that such a lift could lean forward.",
        tuple(rows),
        tuple(charts),
    )


def _lean(name: str, frequencies: Array, *, suction: bool) -> Array:
    return np.array([theory.mean_thrust(k, **MOTIONS[name], suction=suction) for k in frequencies])


def _largest_lean(name: str, frequencies: Array) -> Array:
    """Mean thrust coefficient of the lift if it were in phase with the pitch."""
    return np.array([0.5 * SMALL * abs(theory.oscillating_loads(k, **MOTIONS[name])[0]) for k in frequencies])
