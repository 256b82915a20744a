"""The models compared with the exact lift of a plate in a gust: Kuessner's sharp edge and Sears's sinusoid."""

import math
from collections.abc import Sequence

import numpy as np

from .. import theory
from ..case.case import Case
from ..march.state import NORMAL
from .checks import Array, Chart, Check, Curve, History, Row, plate, run

SMALL = 1e-3
"""Velocity of the gust over that of the stream."""
TRAVEL = 0.02
"""Chords travelled per step into a sharp-edged gust."""
HALF_CHORDS = (0.5, 1.0, 1.5, 3.0, 5.0, 10.0, 20.0)
FREQUENCIES = (0.1, 0.2, 0.5, 1.0, 2.0)
STEPS = 200
"""Steps per period in a sinusoidal gust."""
AHEAD = 0.5
"""Initial distance of a sharp edge ahead of the leading edge, chords."""
MODELS = ("dbet", "uvlm")
PER_CENT = 100.0
VISCOUS = 0.5, 1.0
"""Reduced frequencies in a viscous fluid."""
REYNOLDS = 4000.0
STRIDE = 0.0045
"""Chords a step in a viscous fluid."""


def entering(solver: str) -> Case:
    """The plate in a sharp-edged gust."""
    steps = round((0.5 * max(HALF_CHORDS) + AHEAD + 0.5) / TRAVEL)
    return plate(
        f"solver={solver}", f"motion.frequency={1.0 / (steps * TRAVEL)}", "time.periods=1",
        f"time.steps_per_period={steps}", "fluid.gust=sharp_edged", f"fluid.gust_velocity={SMALL}",
        f"fluid.gust_arrival={AHEAD}",
    )  # fmt: skip


def entered(solver: str, places: Sequence[float] = HALF_CHORDS) -> Array:
    """Fraction of the steady lift at several distances (half-chords) after the leading edge meets a sharp edge."""
    history = run([entering(solver)])[0]
    return np.interp(places, 2.0 * (TRAVEL * history.step - AHEAD), history.force[:, NORMAL] / (math.pi * SMALL))


def sinusoidal(solver: str, k: float) -> Case:
    """The plate in a sinusoidal gust of reduced frequency `k`."""
    beats = 4 + round(6 * k)
    return plate(
        f"solver={solver}", f"motion.frequency={k / math.pi}", f"time.periods={beats}",
        f"time.steps_per_period={STEPS}", "fluid.gust=sinusoidal", f"fluid.gust_velocity={SMALL}",
        f"fluid.gust_length={math.pi / k}",
    )  # fmt: skip


def response(case: Case, history: History, k: float) -> complex:
    """Lift over the quasi-steady `2 pi w/U`, with the phase of the gust at mid-chord as reference."""
    steps = round(case.steps_per_beat)
    last = history.step > case.steps - 2 * steps
    angle = 2.0 * math.pi * history.step[last] / steps
    base = np.stack((np.cos(angle), np.sin(angle), np.ones_like(angle), angle), axis=1)
    cosine, sine = np.linalg.lstsq(base, history.force[last, NORMAL], rcond=None)[0][:2]
    # The gust is sin(omega t - 2 k x): its phase at mid-chord lags that at the leading edge by k.
    return complex(sine + 1j * cosine) / (math.pi * SMALL) * complex(np.exp(1j * k))


def gusts(places: Sequence[float] = HALF_CHORDS, frequencies: Sequence[float] = FREQUENCIES) -> list[Check]:
    """Kuessner's and Sears's functions; that of Sears in a viscous fluid too."""
    return [_kuessner(places), _sears(frequencies), viscous_sears()]


def _kuessner(places: Sequence[float]) -> Check:
    expected = np.array([theory.kuessner(s) for s in places])
    line = np.linspace(0.05, max(places), 60)
    rows, errors = [], []
    curves = [Curve("Küssner", line, np.array([theory.kuessner(float(s)) for s in line]))]
    for solver in MODELS:
        name = solver.upper()
        found = entered(solver, [*places, *line])
        here = found[: len(places)]
        error = PER_CENT * (here - expected)
        rows += [
            Row(f"{name}, s = {s:g}", float(here[i]), float(expected[i]), float(error[i]), 2.0, "% of steady lift")
            for i, s in enumerate(places)
        ]
        curves.append(Curve(name, line, found[len(places) :], "--"))
        errors.append(Curve(name, np.array(places), error, "o-"))
    return Check(
        "kuessner",
        "Küssner: lift in a sharp-edged gust",
        "Lift as a fraction of the steady lift 2π w/U after the leading edge has met the edge of the gust. The exact "
        f"function is an integral of Sears's function (von Kármán & Sears 1938). w/U = {SMALL:g}, {TRAVEL:g} chords "
        "per step. The models smooth the edge over one element or panel. When the edge leaves the trailing edge, at "
        "s = 2, both have an equally short spike of a few percent.",
        tuple(rows),
        (
            Chart("Lift in the gust", "Distance into it s (half-chords)", "Lift over steady lift (1)", tuple(curves)),
            Chart("Error", "Distance into it s (half-chords)", "Error (% of steady lift)", tuple(errors), "x"),
        ),
    )


def _sears(frequencies: Sequence[float]) -> Check:
    rows, amplitudes, phases = [], [], []
    x = np.array(frequencies)
    exact = np.array([theory.sears(k) for k in frequencies])
    for solver in MODELS:
        cases = [sinusoidal(solver, k) for k in frequencies]
        found = np.array(
            [response(case, history, k) for case, history, k in zip(cases, run(cases), frequencies, strict=True)]
        )
        name, ratio = solver.upper(), found / exact
        late = np.degrees(np.angle(ratio))
        for i, k in enumerate(frequencies):
            rows.append(Row.relative(f"{name}, k = {k:g}, amplitude", abs(found[i]), abs(exact[i]), 2.0))
            phase = math.degrees(float(np.angle(exact[i])))
            rows.append(Row(f"{name}, k = {k:g}, phase", phase + late[i], phase, float(late[i]), 1.0, "deg"))
        amplitudes.append(Curve(name, x, PER_CENT * (np.abs(ratio) - 1.0), "o-"))
        phases.append(Curve(name, x, late, "o-"))
    label = "Reduced frequency k = ωc/2U (1)"
    return Check(
        "sears",
        "Sears: lift in a sinusoidal gust",
        "Sears (1941): lift over 2π w/U, with the phase relative to the gust at the middle of the chord; w/U = "
        f"{SMALL:g}, {STEPS} steps per period.",
        tuple(rows),
        (
            Chart("Amplitude", label, "Error of the amplitude (%)", tuple(amplitudes), "x"),
            Chart("Phase", label, "Error of the phase (deg)", tuple(phases), "x"),
        ),
    )


def viscous(k: float, reynolds: float = REYNOLDS, *settings: str) -> Case:
    """The plate in a sinusoidal gust of reduced frequency `k` in a viscous fluid."""
    return plate(
        "solver=navier_stokes", f"fluid.viscosity={1.0 / reynolds}", f"motion.frequency={k / math.pi}",
        f"time.periods={2 + round(3 * k)}", f"time.steps_per_period={round(math.pi / k / STRIDE)}",
        "fluid.gust=sinusoidal", f"fluid.gust_velocity={SMALL}", f"fluid.gust_length={math.pi / k}",
        "navier_stokes.cells=256", *settings,
    )  # fmt: skip


def viscous_sears(frequencies: Sequence[float] = VISCOUS) -> Check:
    """Deviation of the lift in a viscous fluid from Sears's function."""
    cases = [viscous(k) for k in frequencies]
    found = np.array(
        [response(case, history, k) for case, history, k in zip(cases, run(cases), frequencies, strict=True)]
    )
    exact = np.array([theory.sears(k) for k in frequencies])
    rows = []
    for k, ours, theirs in zip(frequencies, found, exact, strict=True):
        rows.append(Row.relative(f"Navier-Stokes, k = {k:g}, amplitude", abs(ours), abs(theirs), 8.0))
        phase = math.degrees(float(np.angle(theirs)))
        late = math.degrees(float(np.angle(ours / theirs)))
        rows.append(Row(f"Navier-Stokes, k = {k:g}, phase", phase + late, phase, late, 8.0, "deg"))
    line = np.linspace(0.1, 2.0, 40)
    curve = np.array([theory.sears(float(k)) for k in line])
    x, label = np.array(frequencies), "Reduced frequency k = ωc/2U (1)"
    return Check(
        "viscous-sears",
        "Sears in a viscous fluid",
        f"The same in the Navier-Stokes model at a Reynolds number of {REYNOLDS:g}. Boundary layers and the rounded "
        "trailing edge weaken the Kutta condition, so that the tolerance is wide. The page of the model shows how "
        "the difference decreases with the Reynolds number.",
        tuple(rows),
        (
            Chart("Amplitude", label, "Lift over 2π w/U (1)",
                  (Curve("Sears", line, np.abs(curve)), Curve("Navier-Stokes", x, np.abs(found), "o"))),
            Chart("Phase", label, "Phase (deg)",
                  (Curve("Sears", line, np.degrees(np.angle(curve))),
                   Curve("Navier-Stokes", x, np.degrees(np.angle(found)), "o"))),
        ),
    )  # fmt: skip
