"""Elastic modes, wet frequencies, energy and free vortices compared with exact solutions."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.integrate import quad

from .. import fluids, theory
from ..case.case import Case, parse_case
from ..kernels.runtime import view
from ..march import loads
from ..march.march import March
from ..march.state import MOMENT, RATE
from ..motion import sampling
from ..structure import beam
from ..vortex.sum import induced_velocity
from .checks import Array, Chart, Check, Curve, Row, follow, observed_order

PER_CENT = 100.0
ALL_MODES = 5


CHORD, SPAN, THICKNESS, DENSITY, YOUNGS_MODULUS = 0.02, 0.05, 40e-6, 1000.0, 24.5e9
"""The paper's wing, SI units."""


def hawkmoth(*settings: str) -> Case:
    """The wing and motion of Reade & Jankauski (2020), Tables 1 and 2, with the solver's own defaults."""
    document = {
        "wing": {
            "chord": CHORD,
            "span": SPAN,
            "thickness": THICKNESS,
            "density": DENSITY,
            "youngs_modulus": YOUNGS_MODULUS,
        },
        "motion": {
            "frequency": 25.0,
            "plunge": {"amplitude": 0.02, "phase_deg": 90.0},
            "pitch": {"amplitude_deg": 15.0},
        },
    }
    return parse_case(document, "validation").override(*settings)


def modes() -> Check:
    """Frequencies, modal constants and orthonormality of the section's modes."""
    wing = hawkmoth(f"wing.modes={ALL_MODES}").wing
    section = beam.modes(wing)
    exact = theory.cantilever_frequencies(ALL_MODES, CHORD, THICKNESS, DENSITY, YOUNGS_MODULUS)
    roots = theory.cantilever_roots(ALL_MODES)
    mass = DENSITY * THICKNESS * CHORD * SPAN
    rows = [
        Row.relative(f"frequency of mode {k + 1}, Hz", section.frequency[k], exact[k], 1e-8) for k in range(ALL_MODES)
    ]
    for k, root in enumerate(roots):
        lifted = _integral(lambda s, beta=root: theory.cantilever_shape(beta, s))
        turned = _integral(lambda s, beta=root: s * theory.cantilever_shape(beta, s))
        rows.append(Row.relative(f"λ of mode {k + 1} over √m", section.lam[k] / mass**0.5, lifted, 1e-6))
        rows.append(Row.relative(f"ψ of mode {k + 1} over c √m", section.psi[k] / mass**0.5 / wing.chord, turned, 1e-6))
    points, weights = np.polynomial.legendre.leggauss(60)
    shape = section.shape(wing.chord * (points + 1.0) / 2.0)
    product = 0.5 * mass * (shape * weights) @ shape.T
    worst = float(np.abs(product - np.eye(ALL_MODES)).max())
    rows.append(Row(f"mass matrix less identity, {ALL_MODES} modes, largest", worst, 0.0, worst, 1e-10))
    s = np.linspace(0.0, 1.0, 101)
    ours = section.shape(wing.chord * s) * mass**0.5
    curves = [Curve(f"mode {k + 1}", s, theory.cantilever_shape(roots[k], s)) for k in range(3)]
    curves.append(Curve("the section's", np.tile(s[::5], 3), ours[:3, ::5].ravel(), "k."))
    return Check(
        "modes",
        "Frequencies and modal constants of a cantilever",
        "The paper's wing (24.5 GPa, 40 µm, 2 cm) compared with Blevins (1979), table 8-1; λ and ψ by numerical "
        "integration of the textbook's mode shapes.",
        tuple(rows),
        (Chart("Mode shapes", "Distance from the clamp (chords)", "Shape times √mass (1)", tuple(curves)),),
    )


def _integral(function: Any) -> float:
    return quad(function, 0.0, 1.0, epsabs=1e-12, epsrel=1e-12)[0]


def wet_frequency(steps: Sequence[int] = (50, 100, 200, 400)) -> Check:
    """Natural frequency of the elastic plate in still air with both fluid models, against steps per period."""
    still = (
        "motion.frequency=80.0", "motion.plunge.amplitude=0.0", "motion.pitch.amplitude_deg=0.0",
        "wing.damping_ratio=0.0", "time.periods=6", "dbet.lift_max=0.0", "dbet.drag_min=0.0", "dbet.drag_max=0.0",
    )  # fmt: skip
    first = hawkmoth("wing.modes=1")
    section = beam.modes(first.wing)
    air = first.fluid.density * CHORD**2 * SPAN / section.mass
    root = theory.cantilever_roots(1)[0]
    sheet = theory.added_mass([lambda x: theory.cantilever_shape(root, x)]) * air
    plate = theory.wet_frequencies(section.frequency, sheet)[0]
    strips = theory.wet_frequencies(section.frequency, [[np.pi / 4.0 * air]])[0]
    rows, curves = [], []
    strip = ("solver=dbet", "dbet.frame=chord", "dbet.added_mass=strip")
    models = (
        ("DBET, the paper's strips", (*strip, "dbet.attached=false"), strips),
        ("DBET, potential flow about the mode", ("solver=dbet", "dbet.attached=false"), plate),
        ("UVLM, potential flow about the mode", ("solver=uvlm",), plate),
    )
    for name, model, exact in models:
        found = [_ring(hawkmoth(*model, *still, f"time.steps_per_period={count}")) for count in steps]
        at = list(steps).index(200)
        rows.append(Row.relative(f"{name}, Hz", found[at], exact, 0.1))
        errors = PER_CENT * np.abs(np.array(found) / exact - 1.0)
        curves.append(Curve(name, np.array(steps, dtype=float), errors, "o-"))
    return Check(
        "wet-frequency",
        "Wet natural frequency of the elastic plate",
        "The paper's wing with one undamped mode, released in still air from a deflection of 2e-8 chords, with "
        f"{steps[at]} steps of 1/80 s in the rows; blades without drag. The paper gives every strip the added mass of "
        f"the whole plate, so that f/√(1 + µ) = {strips:.2f} Hz is exact for its model. Potential flow about the "
        f"first mode, without circulation, gives {plate:.2f} Hz, the reference for the blades' default and the "
        "lattice. At this amplitude the shed vortices stay at the trailing edge, so that wing and wake together have "
        "no circulation.",
        tuple(rows),
        (Chart("Error against the time step", "Steps of 1/80 s", "Error of the frequency (%)", tuple(curves), "xy"),),
    )


def _ring(case: Case) -> float:
    """Frequency (Hz) of the first mode released from a small deflection, from its zero crossings."""
    march = March([case], fluids.load(case.solver))
    view(march.body.q)[0, 0, 0] = 1e-12
    q = follow(march)[0].amplitude[:, 0]
    falls = np.flatnonzero((q[:-1] > 0) & (q[1:] <= 0))
    exact = falls + q[falls] / (q[falls] - q[falls + 1])
    return float(1.0 / (np.diff(exact).mean() * case.step))


def energy(steps: Sequence[int] = (100, 200, 400, 800)) -> Check:
    """Energy residual of a coupled run."""
    rows, curves = [], []
    for solver in ("dbet", "uvlm"):
        left = [PER_CENT * _unaccounted(solver, count) for count in steps]
        name = solver.upper()
        at = list(steps).index(200)
        rows.append(Row(f"{name}, 200 steps a beat", left[at], 0.0, left[at], 0.02, "% of work"))
        rows.append(Row.order(f"{name}, order in the time step", observed_order([1 / n for n in steps], left), 2.0))
        curves.append(Curve(name, np.array(steps, dtype=float), np.array(left), "o-"))
    return Check(
        "energy",
        "Energy balance of a coupled run",
        "The paper's flapping wing with two modes, second beat: the work of the actuator and of the fluid on the "
        "wing, minus the energy lost by damping, compared with the change of the wing's kinetic and elastic energy, "
        "relative to the actuator's gross work. Core of 0.02 chords, 20 panels.",
        tuple(rows),
        (Chart("Energy unaccounted for", "Steps a beat", "Share of the gross work (%)", tuple(curves), "xy"),),
    )


def _unaccounted(solver: str, steps: int) -> float:
    case = hawkmoth(
        f"solver={solver}", "wing.modes=2", "time.periods=2", f"time.steps_per_period={steps}", "uvlm.panels=20",
        "uvlm.core=0.02", "wing.damping_ratio=[0.05, 0.2]", "uvlm.wake=all",
    )  # fmt: skip
    march = March([case], fluids.load(solver))
    frames = march.advance(march.steps + 1)[0]
    section, moved, state = march.sections[0], march.motion[0], frames["q"]
    derived = loads.derive(case, section, np.array([0.0, case.wing.chord]), moved, frames)
    power = derived["power"] + derived["force_z"] * moved[:, sampling.PLUNGE_RATE]
    power += frames["force"][:, MOMENT] * moved[:, sampling.PITCH_RATE]
    power += np.sum(frames["modal_force"] * state[:, RATE], axis=1)
    power -= np.sum(2.0 * section.damping_ratio * section.omega * state[:, RATE] ** 2, axis=1)
    stored = derived["energy"]
    work = np.trapezoid(power[steps:], dx=case.step)
    gross = np.trapezoid(np.abs(derived["power"][steps:]), dx=case.step)
    return float(abs(work - (stored[-1] - stored[steps])) / gross)


def vortices() -> Check:
    """Pairs, a square and a cloud of vortices, integrated with the solver's velocities by a fourth-order method."""
    dt, steps, distance = 0.005, 400, 0.5
    pair = drift(np.array([[0.0, distance], [0.0, 0.0], [3.0, -3.0]]), dt, steps)
    rows = [
        Row.relative("opposite pair, speed", abs(pair[1, 0]) / (dt * steps), theory.pair_speed(3.0, distance), 1e-6)
    ]
    like = drift(np.array([[0.0, distance], [0.0, 0.0], [1.0, 2.0]]), dt, 40)
    turned = np.arctan2(like[1, 1] - like[1, 0], like[0, 1] - like[0, 0]) / (40 * dt)
    rows.append(Row.relative("like pair, rate of rotation", turned, theory.pair_rotation(1.0, 2.0, distance), 1e-4))
    corners = np.array([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0], [2.0] * 4])
    square = drift(corners, dt, steps)
    turned = np.arctan2(square[1, 0], square[0, 0]) / (steps * dt)
    rows.append(Row.relative("four at the corners of a square", turned, theory.polygon_rotation(4, 2.0, 1.0), 1e-6))
    cloud = np.random.default_rng(1).normal(size=(3, 12))
    sizes = (1e-3, 5e-4, 2.5e-4)
    names = ("Σ Γ y", "Σ Γ z", "Σ Γ |z|²", "Hamiltonian")
    before = invariants(cloud)
    changes = np.array([np.abs(invariants(drift(cloud, size, round(0.2 / size))) - before) for size in sizes])
    rows += [
        Row(f"cloud of 12, change of {name}", float(before[i] + changes[-1, i]), float(before[i]),
            float(changes[-1, i]), 1e-7)
        for i, name in enumerate(names)
    ]  # fmt: skip
    return Check(
        "vortices",
        "Vortex pair, four vortices, invariants",
        "Lamb (1932) and Thomson (1883). Velocities are computed by the solver's sum and integrated by a "
        "fourth-order Runge-Kutta method, so that the errors are those of the sum alone.",
        tuple(rows),
        (
            Chart(
                "Change of the invariants of a cloud of 12",
                "Time step (s)",
                "Change (SI units)",
                tuple(
                    Curve(name, np.array(sizes), np.maximum(changes[:, i], 1e-17), "o-") for i, name in enumerate(names)
                ),
                "xy",
            ),
        ),
    )


def drift(cloud: Array, dt: float, steps: int) -> Array:
    """Positions and circulations, shape (3, vortices), after `steps` of a fourth-order Runge-Kutta rule."""
    moved = np.array(cloud, dtype=float)

    def rate(positions: Array) -> Array:
        return induced_velocity(positions, np.vstack((positions, moved[2:])))

    for _ in range(steps):
        x = moved[:2]
        first = rate(x)
        second = rate(x + 0.5 * dt * first)
        third = rate(x + 0.5 * dt * second)
        moved[:2] = x + dt / 6.0 * (first + 2.0 * second + 2.0 * third + rate(x + dt * third))
    return moved


def invariants(cloud: Array) -> Array:
    """Impulse along Z and Y, angular impulse, and Hamiltonian of free vortices, up to constant factors."""
    y, z, strength = cloud
    upper = np.triu_indices(len(y), 1)
    apart = np.log(((y[:, None] - y) ** 2 + (z[:, None] - z) ** 2)[upper])
    hamiltonian = np.sum((strength[:, None] * strength)[upper] * apart)
    return np.array([strength @ y, strength @ z, strength @ (y * y + z * z), hamiltonian])
