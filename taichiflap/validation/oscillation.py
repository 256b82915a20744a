"""The lattice compared with exact theory of an oscillating plate in a stream: Theodorsen's loads, Garrick's thrust."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import theory
from ..case.case import Case
from ..march.state import AXIAL, MOMENT, NORMAL
from ..motion.sampling import PITCH, sample
from .checks import Array, Chart, Check, Curve, Grid, History, Row, accurate, papers, plate, run

STEPS = 200
BEATS = 4
SMALL = 1e-4
"""Amplitude of motions compared with linear theory, chords or rad."""
FREQUENCIES = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
HIGH = (1.0, 2.0, 5.0)
REFINED = (8, 12, 20, 32, 48)
PER_CENT = 100.0
QUARTER = 0.25
REDUCED = "Reduced frequency k = ωc/2U (1)"

_PITCH = (f"motion.pitch.amplitude_deg={math.degrees(SMALL)}", "motion.pitch.phase_deg=90.0")
MOTIONS: dict[str, dict[str, float]] = {
    "plunge": {"plunge": SMALL},
    "pitch about leading edge": {"pitch": -SMALL},
    "pitch about quarter chord": {"pitch": -SMALL, "axis": QUARTER},
}
"""Motions by name, for `taichiflap.theory`; the case file's pitch is nose down."""
DRIVES = {
    "plunge": (f"motion.plunge.amplitude={SMALL}", "motion.plunge.phase_deg=90.0"),
    "pitch about leading edge": _PITCH,
    "pitch about quarter chord": (
        *_PITCH,
        f"motion.plunge.amplitude={QUARTER * SMALL}",
        "motion.plunge.phase_deg=-90.0",
    ),
}
"""The same motions as settings of the case file, whose pitch axis is the leading edge."""


@dataclass(frozen=True)
class Loads:
    """Complex amplitudes of the coefficients of lift and of the nose-up moment about the leading edge; mean thrusts.

    `lean` is the thrust of the normal force alone, `thrust` includes leading-edge suction.
    """

    lift: complex
    moment: complex
    lean: float
    thrust: float

    def about(self, axis: float) -> complex:
        """The moment about an axis, chords behind the leading edge."""
        return self.moment + axis * self.lift


Found = dict[tuple[str, float], Loads]


def oscillating(name: str, k: float, grid: Grid | None = None, steps: int = STEPS, beats: int = BEATS) -> Case:
    """A plate in one of `MOTIONS` at reduced frequency `k`, with suction at its leading edge."""
    return plate(
        *DRIVES[name], f"motion.frequency={k / math.pi}", f"time.periods={beats}", f"time.steps_per_period={steps}",
        "uvlm.suction=true", grid=grid,
    )  # fmt: skip


def loads(case: Case, history: History) -> Loads:
    """Loads over the last two beats, fitted with a mean and a drift due to the start; thrust over the last beat."""
    steps = round(case.steps_per_beat)
    last = history.step > case.steps - 2 * steps
    angle = 2.0 * math.pi * history.step[last] / steps
    base = np.stack((np.cos(angle), np.sin(angle), np.ones_like(angle), angle), axis=1)
    fitted = np.linalg.lstsq(base, 2.0 * history.force[last][:, [NORMAL, MOMENT]], rcond=None)[0]
    lift, moment = fitted[0] - 1j * fitted[1]
    beat = slice(-steps, None)
    pitch = sample(case.motion, case.step * history.step[beat])[:, PITCH]
    lean = 2.0 * float(np.mean(history.force[beat, NORMAL] * np.sin(pitch)))
    pull = -2.0 * float(np.mean(history.force[beat, AXIAL] * np.cos(pitch)))
    return Loads(complex(lift), -complex(moment), lean, lean + pull)


def exact(name: str, k: float) -> Loads:
    """The same from theory."""
    motion = MOTIONS[name]
    lift, moment = theory.oscillating_loads(k, **motion)
    axis = motion.get("axis", 0.0)
    lean, thrust = (theory.mean_thrust(k, **motion, suction=suction) for suction in (False, True))
    return Loads(lift, moment - axis * lift, lean, thrust)


def oscillation(frequencies: Sequence[float] = FREQUENCIES, refined: Sequence[int] = REFINED) -> list[Check]:
    """Lift, moment and thrust of a plunging and pitching plate, with the default lattice and with the paper's.

    `refined` are the numbers of panels in the chart of errors at high frequency.
    """
    fine, coarse = (_march(grid, frequencies) for grid in (accurate(), papers()))
    return [_lift(fine, coarse, frequencies, _refinement(refined)), _moment(fine, coarse), _thrust(fine, frequencies)]


def _march(grid: Grid, frequencies: Sequence[float]) -> Found:
    pairs = [(name, k) for name in MOTIONS for k in frequencies]
    cases = [oscillating(name, k, grid) for name, k in pairs]
    return {pair: loads(case, history) for pair, case, history in zip(pairs, cases, run(cases), strict=True)}


def _refinement(panels: Sequence[int]) -> Chart:
    name = "pitch about quarter chord"
    cases = [oscillating(name, k, accurate(count), 8 * count) for k in HIGH for count in panels]
    found = [loads(case, history).lift for case, history in zip(cases, run(cases), strict=True)]
    curves = []
    for number, k in enumerate(HIGH):
        lifts = np.asarray(found[number * len(panels) : (number + 1) * len(panels)])
        errors = PER_CENT * np.abs(lifts / exact(name, k).lift - 1.0)
        curves.append(Curve(f"k = {k:g}", np.array(panels, dtype=float), errors, "o-"))
    title = "Pitch about quarter chord, eight steps a panel"
    return Chart(title, "Cosine panels", "Error of the complex lift (%)", tuple(curves), "xy")


def _lift(fine: Found, coarse: Found, frequencies: Sequence[float], refinement: Chart) -> Check:
    rows = []
    for (name, k), found in fine.items():
        lift = exact(name, k).lift / MOTIONS[name].get("pitch", SMALL)
        ratio = found.lift / exact(name, k).lift
        rows.append(Row.relative(f"{name}, k = {k:g}, amplitude", abs(ratio * lift), abs(lift), 2.0))
        phase, late = (float(np.degrees(np.angle(value))) for value in (lift, ratio))
        rows.append(Row(f"{name}, k = {k:g}, phase", phase + late, phase, late, 0.5, "deg"))
    x = np.array(frequencies)
    amplitudes, phases = [], []
    for grid, loads_of, style in ((accurate(), fine, "o-"), (papers(), coarse, "s:")):
        for number, name in enumerate(MOTIONS):
            colour = f"C{number}"
            ratios = np.array([loads_of[name, k].lift / exact(name, k).lift for k in frequencies])
            amplitudes.append(Curve(f"{name}, {grid.kind}", x, PER_CENT * (np.abs(ratios) - 1.0), colour + style))
            phases.append(Curve(f"{name}, {grid.kind}", x, np.degrees(np.angle(ratios)), colour + style))
    worst = [
        max(float(np.abs(curve.y).max()) for curve in curves if curve.style.endswith("s:"))
        for curves in (amplitudes, phases)
    ]
    return Check(
        "theodorsen",
        "Theodorsen: lift in plunge and pitch",
        f"NACA Report 496 (1935). Lift coefficient per chord of plunge and per radian of pitch; {accurate()}, {STEPS} "
        "steps per period, amplitude 1e-4. The pitch axis of a case is the leading edge, so that pitch about the "
        f"quarter chord is combined with a plunge. Dotted: {papers()} as in the paper, with the consistent shedding "
        f"rule, with errors up to {worst[0]:.1f} % and {worst[1]:.1f} degrees. The last chart shows the convergence "
        "at high frequency.",
        tuple(rows),
        (
            Chart("Amplitude", REDUCED, "Error of the amplitude (%)", tuple(amplitudes), "x"),
            Chart("Phase", REDUCED, "Error of the phase (deg)", tuple(phases), "x"),
            refinement,
        ),
    )


MOMENTS = (
    ("plunge", 0.0),
    ("plunge", QUARTER),
    ("pitch about leading edge", 0.0),
    ("pitch about quarter chord", QUARTER),
)
"""Motions, and the axes of their moments, chords."""


def _moment(fine: Found, coarse: Found) -> Check:
    rows, charts = [], []
    for grid, found in ((accurate(), fine), (papers(), coarse)):
        curves = []
        for name, axis in MOMENTS:
            about = "quarter chord" if axis else "leading edge"
            frequencies = [k for motion, k in found if motion == name]
            errors = []
            for k in frequencies:
                here, there = found[name, k], exact(name, k)
                errors.append(PER_CENT * abs(here.about(axis) - there.about(axis)) / abs(there.lift))
                if found is fine:
                    size = abs(MOTIONS[name].get("pitch", SMALL))
                    measured, expected = (abs(one.about(axis)) / size for one in (here, there))
                    setting = f"{name}, k = {k:g}, about {about}"
                    rows.append(Row(setting, measured, expected, errors[-1], 1.0, "% of |L| c"))
            label = f"{name.split()[0]}, about {about}"
            curves.append(Curve(label, np.array(frequencies), np.array(errors), "o-"))
        charts.append(Chart(str(grid).capitalize(), REDUCED, "Error of the moment over |L| c (%)", tuple(curves), "x"))
    return Check(
        "moment",
        "Theodorsen: moment in plunge and pitch",
        "NACA Report 496 (1935). Moment coefficient per chord of plunge and per radian of pitch, from the runs "
        "above. About the quarter chord the moment vanishes at low frequency. The error of the complex amplitude is "
        "therefore relative to the lift times the chord, which is the error in the position of the load. Right: the "
        "paper's uniform panels.",
        tuple(rows),
        tuple(charts),
    )


def _thrust(fine: Found, frequencies: Sequence[float]) -> Check:
    rows, charts = [], []
    x = np.array(frequencies)
    line = np.geomspace(x.min(), x.max(), 60)
    for name, motion in MOTIONS.items():
        scale = _scale(name, x)
        for kind, wanted in (("no suction", "lean"), ("with suction", "thrust")):
            if wanted == "lean" and "pitch" not in motion:
                continue
            found, there = ([getattr(one, wanted) for one in ones] for ones in (
                [fine[name, k] for k in frequencies], [exact(name, k) for k in frequencies],
            ))  # fmt: skip
            errors = PER_CENT * (np.array(found) - there) / scale
            rows += [
                Row(f"{name}, k = {k:g}, {kind}", found[i] / SMALL**2, there[i] / SMALL**2, errors[i], 1.0,
                    "% of scale")
                for i, k in enumerate(frequencies)
            ]  # fmt: skip
        along = _scale(name, line)
        curves = [
            Curve("Garrick", line, np.array([exact(name, k).thrust for k in line]) / along),
            Curve("lattice", x, np.array([fine[name, k].thrust for k in frequencies]) / scale, "o"),
        ]
        if "pitch" in motion:
            curves += [
                Curve("Garrick without suction", line, np.array([exact(name, k).lean for k in line]) / along, "--"),
                Curve("lattice without suction", x, np.array([fine[name, k].lean for k in frequencies]) / scale, "s"),
            ]
        charts.append(Chart(name.capitalize(), REDUCED, "Mean thrust over its scale (1)", tuple(curves), "x"))
    return Check(
        "garrick",
        "Garrick: mean thrust in plunge and pitch, with and without suction at the leading edge",
        "NACA Report 567 (1936). Thrust coefficient per chord² of plunge and per radian² of pitch. `uvlm.suction` "
        "adds the suction to the normal force; without it the thrust in plunge is zero. The thrust in pitch changes "
        "sign, so that errors are relative to |L||α|/2, the maximum thrust of a normal force of this size; in plunge "
        "they are relative to the thrust itself.",
        tuple(rows),
        tuple(charts),
    )


def _scale(name: str, frequencies: Sequence[float] | Array) -> Array:
    if "pitch" in MOTIONS[name]:
        return np.array([0.5 * SMALL * abs(exact(name, k).lift) for k in frequencies])
    return np.array([exact(name, k).thrust for k in frequencies])
