"""The Navier-Stokes model compared with exact and published viscous flows."""

import math
from collections.abc import Sequence

import numpy as np
from scipy.special import kv

from ..case.case import Case, parse_case
from ..march.state import AXIAL, MOMENT, NORMAL
from ..motion import sampling
from .checks import Array, Chart, Check, Curve, History, Row, observed_order, plate, run

PER_CENT = 100.0
TURNS = 0.05, 0.01
"""Viscosity (diameters^2 a period) of the cylinder that turns to and fro."""
SHEDDING = 150.0
"""Diameters that the stream moves on past the cylinder; its second half is looked at."""
CD, STROUHAL = 1.33, 0.165
"""Of a cylinder at a Reynolds number of 100: 1.33 to 1.37 and 0.164 to 0.166 in the literature."""
THIN = 0.01
"""Thickness of the section that stands for a thin plate."""
CELLS = 64, 96, 128, 256
"""Of the study of grids, the last of which counts as exact."""
FIRST_BEAT = ((0, 2.58, 0.03), (1, 6.9, 0.1))
"""Modes, mean vertical force (mN) of the hawkmoth's first beat, and tolerance."""


def viscous(case: Case, **tables: object) -> Case:
    """A case with some tables replaced."""
    document = {name: table for name, table in case.to_dict().items() if name != "output"}
    return parse_case({**document, **tables}, "validation")


def coefficients(case: Case, history: History) -> tuple[Array, Array, Array]:
    """Time, and coefficients along Y and Z for a unit stream, chord and density."""
    time = case.step * history.step.astype(np.float64)
    turn = np.exp(1j * sampling.sample(case.motion, time)[:, sampling.PITCH])
    force = 2.0 * (history.force[:, AXIAL] + 1j * history.force[:, NORMAL]) * turn
    return time, force.real, force.imag


def circle(*settings: str) -> Case:
    """A cylinder of unit diameter: a section as thick as its chord, with the pivot in the middle."""
    return plate("solver=navier_stokes", "navier_stokes.thickness=1.0", "wing.pivot=0.5", *settings)


def stokes(viscosities: Sequence[float] = TURNS, cells: int = 64) -> Check:
    """Moment on a cylinder in rotational oscillation in a fluid at rest: Stokes's second problem on a cylinder."""
    rows, curves = [], []
    steps, periods, angle = 400, 4, 1.0
    for viscosity in viscosities:
        case = circle(
            f"fluid.viscosity={viscosity}", "fluid.velocity=[0.0, 0.0]", f"navier_stokes.cells={cells}",
            "navier_stokes.radius=5.0", "navier_stokes.wall_spacing=0.005", "motion.pitch.phase_deg=90.0",
            f"motion.pitch.amplitude_deg={math.degrees(angle)}", f"time.periods={periods}",
            f"time.steps_per_period={steps}", "motion.start_up_periods=1.0",
        )  # fmt: skip
        (history,) = run([case])
        last = history.step > case.steps - steps
        phase = 2.0 * math.pi * history.step[last] / steps
        base = np.stack((np.cos(phase), np.sin(phase), np.ones_like(phase)), axis=1)
        cosine, sine, _ = np.linalg.lstsq(base, history.force[last, MOMENT], rcond=None)[0]
        radius, rate = 0.5, 2j * math.pi
        depth = complex(np.sqrt(rate / viscosity))
        stress = depth * kv(0, depth * radius) / kv(1, depth * radius) + 2.0 / radius
        exact = -2.0 * math.pi * radius**3 * viscosity * rate * angle * complex(stress)
        ratio = complex(cosine, -sine) / exact
        setting = f"viscosity {viscosity:g}"
        rows.append(Row.relative(f"{setting}, moment", abs(ratio * exact), abs(exact), 0.3))
        late = math.degrees(float(np.angle(ratio)))
        expected = math.degrees(float(np.angle(exact)))
        rows.append(Row(f"{setting}, phase", expected + late, expected, late, 0.3, "deg"))
        wave = base[:, 0] * exact.real - base[:, 1] * exact.imag
        turns = history.step[last] / steps
        curves += [
            Curve(f"exact, viscosity {viscosity:g}", turns, wave / abs(exact)),
            Curve("Navier-Stokes", turns, history.force[last, MOMENT] / abs(exact), "--"),
        ]
    return Check(
        "stokes",
        "Stokes's second problem on a cylinder",
        "A cylinder in rotational oscillation in a fluid at rest, where vorticity only diffuses. The exact moment of "
        "friction is given by Bessel functions (Lamb, Hydrodynamics, 1932, art. 347, treats a flat wall). Viscosity "
        f"in diameters squared per period, {cells} cells around the cylinder, {steps} steps per period, fourth "
        "period.",
        tuple(rows),
        (Chart("Moment of friction", "Time (periods)", "Moment over its exact amplitude (1)", tuple(curves)),),
    )


def cylinder(cells: int = 128, length: float = SHEDDING) -> Check:
    """Drag and frequency of the vortices behind a cylinder at a Reynolds number of 100."""
    kick = {"pitch": {"kind": "ramp", "amplitude_deg": 60.0, "start": 2.0, "ramp": 1.0, "smoothing": 10.0}}
    base = circle("fluid.viscosity=0.01", f"navier_stokes.cells={cells}")
    case = viscous(base, motion=kick, time={"duration": length, "step": 0.025})
    (history,) = run([case])
    time, drag, lift = coefficients(case, history)
    settled = time > 0.5 * length
    t, x = time[settled], lift[settled]
    rises = np.flatnonzero((x[1:] > 0.0) & (x[:-1] <= 0.0))
    crossed = t[rises] + case.step * x[rises] / (x[rises] - x[rises + 1])
    strouhal = (len(crossed) - 1) / (crossed[-1] - crossed[0])
    mean = float(drag[settled][rises[0] : rises[-1]].mean())
    return Check(
        "cylinder",
        "A cylinder in a stream, Reynolds number 100",
        "Vortex shedding from a cylinder, started by a small rotation. The literature has drag coefficients of 1.33 "
        f"to 1.37 and Strouhal numbers of 0.164 to 0.166. {cells} cells around the cylinder, 0.025 diameters per "
        "step.",
        (
            Row("drag coefficient", mean, CD, mean - CD, 0.01),
            Row("Strouhal number", strouhal, STROUHAL, strouhal - STROUHAL, 0.001),
        ),
        (
            Chart(
                "Forces",
                "Time U t/d (1)",
                "Coefficient (1)",
                (Curve("drag", time[time > 1.0], drag[time > 1.0]), Curve("lift", time, lift)),
            ),
        ),
    )


def thin_plate(reynolds: float = 1000.0) -> Check:
    """Drag of a thin plate along a stream."""
    base = plate("solver=navier_stokes", f"fluid.viscosity={1.0 / reynolds}", f"navier_stokes.thickness={THIN}")
    case = viscous(base, motion={}, time={"duration": 12.0, "step": 0.01})
    (history,) = run([case])
    time, drag, _ = coefficients(case, history)
    blasius, exact = 2.0 * 1.3282 / math.sqrt(reynolds), triple_deck(reynolds)
    late = time > 1.0
    return Check(
        "thin-plate",
        "A thin plate along a stream: boundary layers",
        "Friction of both sides of a flat plate: Blasius, and with the triple deck at the trailing edge (Stewartson "
        f"1969, Messiter 1970), 2 (1.328 Re^-1/2 + 2.67 Re^-7/8). Re = {reynolds:g}, with a section of {100 * THIN:g} "
        "% thickness, whose pressure drag is included in the measured value.",
        (Row.relative(f"drag coefficient, Re = {reynolds:g}", float(drag[-1]), exact, 5.0),),
        (
            Chart(
                "Drag",
                "Time U t/c (1)",
                "Drag coefficient (1)",
                (
                    Curve("Navier-Stokes", time[late], drag[late]),
                    Curve("triple deck", time[late], np.full(np.count_nonzero(late), exact), "--"),
                    Curve("Blasius", time[late], np.full(np.count_nonzero(late), blasius), ":"),
                ),
            ),
        ),
    )


def triple_deck(reynolds: float) -> float:
    """Drag coefficient of a flat plate along a stream, both sides."""
    return 2.0 * (1.3282 * reynolds**-0.5 + 2.668 * reynolds**-0.875)


def hawkmoth(modes: int, steps: int = 2000, *settings: str) -> Case:
    """The hawkmoth's first beat at a Reynolds number of 2,667, with a pitch start-up of a quarter of a beat."""
    frequency, chord = 25.0, 0.02
    beat = np.linspace(0.0, 1.0, 401)
    grown = np.minimum(4.0 * beat, 1.0)
    pitch = 15.0 * grown**3 * (10.0 - 15.0 * grown + 6.0 * grown**2) * np.sin(2.0 * np.pi * beat)
    table = [[float(t), float(angle)] for t, angle in zip(beat / frequency, pitch, strict=True)]
    document = {
        "solver": "navier_stokes",
        "wing": {
            "chord": chord, "span": 0.05, "thickness": 40e-6, "density": 1000.0, "youngs_modulus": 24.5e9,
            "modes": modes, "damping_ratio": 0.05,
        },
        "motion": {
            "frequency": frequency,
            "plunge": {"amplitude": chord, "phase_deg": 90.0},
            "pitch": {"kind": "table", "points_deg": table},
        },
        "fluid": {"density": 1.225, "viscosity": 4.0 * frequency * chord**2 / (8000.0 / 3.0)},
        "time": {"periods": 1, "steps_per_period": steps},
        "navier_stokes": {"cells": 256, "wall_spacing": 0.006},
    }  # fmt: skip
    return parse_case(document, "validation").override(*settings)


def first_beat(expected: Sequence[tuple[int, float, float]] = FIRST_BEAT, steps: int = 2000, *settings: str) -> Check:
    """Mean vertical force of the hawkmoth's first beat, rigid and bending."""
    rows, curves = [], []
    for modes, force, tolerance in expected:
        case = hawkmoth(modes, steps, *settings)
        (history,) = run([case])
        time = case.step * history.step.astype(np.float64)
        pitch = sampling.sample(case.motion, time)[:, sampling.PITCH]
        vertical = 1e3 * (np.sin(pitch) * history.force[:, NORMAL] - np.cos(pitch) * history.force[:, AXIAL])
        mean = float(vertical[1:].mean())
        name = f"{modes} mode" if modes else "rigid"
        rows.append(Row(f"{name}, mean vertical force", mean, force, mean - force, tolerance, "mN"))
        curves.append(Curve(name, time[2:] * 25.0, vertical[2:]))
    return Check(
        "first-beat",
        "The hawkmoth's first beat, Reynolds number 2,667",
        "Comparison with a separate implementation of the same method, which gives 2.57 to 2.58 mN for the rigid "
        "wing on three grids, and 6.92 and 6.97 mN with one mode by two schemes in time. The plunge starts at its "
        f"end, and the pitch has a start-up of a quarter of a beat; {steps} steps. (With three modes the force is "
        "7.05 mN here and 7.04 mN there.)",
        tuple(rows),
        (Chart("Vertical force", "Time (beats)", "Force (mN)", tuple(curves)),),
    )


def grids(cells: Sequence[int] = CELLS) -> Check:
    """Convergence of the forces with the cells: half a beat of the rigid hawkmoth wing at a Reynolds number of 100."""
    cases = [
        hawkmoth(0, 1600, f"fluid.viscosity={4.0 * 25.0 * 0.02**2 / 100.0}", f"navier_stokes.cells={n}",
                 f"navier_stokes.wall_spacing={0.03 * 64 / n}")
        for n in cells
    ]  # fmt: skip
    forces = [history.force[40:800, NORMAL] for history in run(cases)]
    errors = [float(np.sqrt(np.mean((one - forces[-1]) ** 2) / np.mean(forces[-1] ** 2))) for one in forces[:-1]]
    sizes = [1.0 / n for n in cells[:-1]]
    return Check(
        "viscous-grids",
        "Convergence with the grid of a viscous flow",
        "Normal force in the first half beat of the hawkmoth's rigid wing at a Reynolds number of 100, compared with "
        f"{cells[-1]} cells around the section, with the rows in proportion.",
        (Row.order("order with the cells", observed_order(sizes, errors), 2.0),),
        (
            Chart(
                "Error of the force",
                "Cells around (1)",
                "RMS error (%)",
                (Curve("Navier-Stokes", np.array(cells[:-1], float), PER_CENT * np.array(errors), "o-"),),
                "xy",
            ),
        ),
    )


def checks() -> list[Check]:
    """All of them."""
    return [stokes(), cylinder(), thin_plate(), first_beat(), grids()]
