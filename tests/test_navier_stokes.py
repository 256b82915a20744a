"""The Navier-Stokes model: its steps compared with an oracle in NumPy, and exact properties of such flows."""

import math

import numpy as np
import pytest
from conftest import hawkmoth
from navier_stokes_oracle import Oracle

import taichiflap
from taichiflap import fluids
from taichiflap.case.case import CaseError, parse_case
from taichiflap.fluids.navier_stokes import arrays, tables
from taichiflap.fluids.navier_stokes.field import Field
from taichiflap.fluids.navier_stokes.grid import positions
from taichiflap.fluids.navier_stokes.settings import ResolutionError, settings
from taichiflap.kernels.runtime import start, view
from taichiflap.march import state
from taichiflap.march.march import March
from taichiflap.motion.gust import gust_velocity
from taichiflap.motion.sampling import (
    PITCH,
    PITCH_ACCEL,
    PITCH_RATE,
    PLUNGE,
    PLUNGE_ACCEL,
    PLUNGE_RATE,
    SURGE_ACCEL,
    SURGE_RATE,
)
from taichiflap.structure import beam

NS = ("solver=navier_stokes", "fluid.viscosity=4e-4", "time.periods=1", "time.steps_per_period=400")
COARSE = (*NS, "navier_stokes.cells=64", "navier_stokes.radius=4.0")


def case(*more):
    return hawkmoth(*COARSE, *more)


def marching(*cases, threads=1):
    return March(list(cases), fluids.load("navier_stokes"), threads)


def rows_of(march, name, count, b=0):
    """The first rows of an array of a flow, one number an angle."""
    found = view(getattr(march.groups["flow"], name))[b, :count]
    return found.reshape(len(found), -1)[:, : settings(march.cases[b]).cells]


def moving(march, n):
    """Velocity and acceleration of the pivot in the wing's axes, in chords, and those of the pitch angle."""
    moved = march.motion[0][n]
    turn = np.exp(-1j * moved[PITCH]) / march.cases[0].wing.chord
    velocity = complex(moved[SURGE_RATE], moved[PLUNGE_RATE]) * turn
    accel = complex(moved[SURGE_ACCEL], moved[PLUNGE_ACCEL]) * turn
    return velocity, moved[PITCH_RATE], accel, moved[PITCH_ACCEL]


@pytest.mark.parametrize("modes", [0, 2])
def test_steps_are_those_of_the_oracle(modes):
    """From an impulsive start on: vorticity, fluxes, wall flux, forces; load and response of the modes."""
    march = marching(case(f"wing.modes={modes}", "motion.surge={amplitude=0.005,phase_deg=20}"))
    chord, given = 0.02, tables.Given.of(march.cases[0], march.sections[0])
    grid, points = given.grid, given.grid.points
    march.advance(1)
    velocity, rate, _, _ = moving(march, 0)
    oracle = Oracle(grid, given.viscosity, march.cases[0].step, velocity, rate)
    load = march.cases[0].fluid.density * chord**3 * 0.05
    body = march.body
    for n in range(1, 6):
        march.advance(1)
        lines = rows_of(march, "line", arrays.LINES + arrays.MODAL_LINES * modes)
        found, guess = [], ()
        if modes:
            oracle.bend(n, complex_of(view(march.groups["flow"].coefficient)[0, : points // 2 + 1]))
            y = np.clip(oracle.wall.real, 0.0, 1.0)
            series = given.series()
            found = [
                tuple(np.polynomial.chebyshev.chebval(2.0 * y - 1.0, series[row]) for row in (k, modes + k))
                for k in range(modes)
            ]
            assert np.allclose(
                found[0][0], march.sections[0].shape(chord * y)[0] / chord, rtol=0, atol=1e-9 * 100 / chord
            )
            guess = view(body.q_predicted)[0, state.RATE, :modes]

        def solve(fixed, rates, accels, n=n):
            beta = march.cases[0].step / (1.0 if n == 1 else 1.5)
            known = view(body.q_free)[0, state.RATE, :modes]
            ours, response = view(body.load)[0, :modes], view(body.response)[0, :modes, :modes]
            assert np.allclose(ours, load * chord * (fixed + rates @ known), rtol=1e-8)
            assert np.allclose(
                response, load * chord * (beta * rates + accels), rtol=1e-8, atol=1e-9 * abs(response).max()
            )
            return view(body.q)[0, state.RATE, :modes].copy(), view(body.q)[0, state.ACCEL, :modes].copy()

        force, moment = oracle.step(n, *moving(march, n), found, guess, solve)
        for name, theirs in (
            ("vorticity", oracle.w), ("area", oracle.area), ("change", oracle.change),
            ("flux_rho", oracle.flux_rho), ("flux_phi", oracle.flux_phi),
        ):  # fmt: skip
            ours = rows_of(march, name, len(theirs))
            assert np.allclose(ours, theirs, rtol=0, atol=1e-9 * abs(theirs).max()), (name, n)
        assert np.allclose(lines[arrays.FLUX], oracle.g, rtol=0, atol=1e-8 * abs(oracle.g).max())
        ours = view(body.force)[0]
        assert abs(complex(ours[state.AXIAL], ours[state.NORMAL]) - load * force) < 1e-7 * load * abs(force)
        assert abs(ours[state.MOMENT] - load * chord * moment) < 1e-6 * load * chord * abs(force)


def complex_of(pairs):
    return pairs[:, 0] + 1j * pairs[:, 1]


def test_the_map_takes_the_circle_to_the_bent_section():
    march = marching(case("wing.modes=2", "motion.start_up_periods=1.0"))
    march.advance(150)
    coefficients = complex_of(view(march.groups["flow"].coefficient)[0, :33])
    wall = positions(coefficients, np.zeros(1), np.linspace(0.0, 2.0 * np.pi, 400))[0]
    q = view(march.body.q_predicted)[0, state.AMPLITUDE]
    deflection = q @ march.sections[0].shape(0.02 * np.clip(wall.real, 0.0, 1.0)) / 0.02
    assert abs(deflection).max() > 0.02
    off = np.hypot(2.0 * wall.real - 1.0, (wall.imag - deflection) / 0.02) - 1.0
    assert abs(off).max() < 1e-4 * abs(deflection).max() / 0.02
    corner = complex_of(np.stack([rows_of(march, f"corner_{x}", 30)[:, :].ravel() for x in "yz"], axis=1))
    expected = positions(
        coefficients, tables.Given.of(march.cases[0], march.sections[0]).grid.faces[:30], np.arange(1, 65) * np.pi / 32
    )
    assert abs(corner - expected.ravel()).max() < 1e-12


def thin_plate(shapes):
    """Added mass of deflections of a thin plate, of unit chord and density: Glauert's series, exact."""
    angle = (np.arange(4000) + 0.5) * np.pi / 4000
    n = np.arange(1, 200)
    sines = np.sin(np.outer(n, angle))
    found = [2.0 / 4000 * (sines @ (w * np.sin(angle))) for w in shapes(0.5 - 0.5 * np.cos(angle))]
    return np.pi / 4.0 * np.array([[np.sum(a * b / n) for b in found] for a in found])


@pytest.mark.parametrize("thickness", [0.02, 0.1, 0.5])
def test_added_mass_of_heave_is_pi_over_four(thickness):
    given = tables.Given.of(case("wing.modes=0", f"navier_stokes.thickness={thickness}"), marching_modes(0))
    grid = given.grid
    wall = positions(grid.coefficients, np.zeros(1), grid.centres)[0]
    slope = grid.coefficients[0] * np.exp(1j * grid.centres) - grid.coefficients[2] * np.exp(-1j * grid.centres)
    force = (tables.sheet(slope.real, -wall.real) + slope.real) @ wall.real * grid.dphi
    assert abs(force + np.pi / 4.0) < 1e-12


def marching_modes(count):
    return taichiflap.structure.beam.modes(case(f"wing.modes={count}").wing)


def test_added_mass_of_the_modes_is_that_of_a_thin_plate():
    """The response of four modes at the start is exact to round-off, for any thickness."""
    march = marching(case("wing.modes=4", "navier_stokes.cells=128"))
    march.advance(1)
    wing = march.sections[0]
    exact = 1.225 * 0.05 * 0.02**2 * thin_plate(lambda s: wing.shape(0.02 * s))
    ours = view(march.body.response)[0]
    assert np.allclose(ours, -exact, rtol=0, atol=1e-10 * exact[0, 0])


def test_bits_are_the_same_alone_in_a_batch_and_resumed():
    cases = [
        case("wing.modes=1"),
        case("wing.modes=0", "navier_stokes.cells=96"),
        case("wing.modes=2"),
        case("wing.modes=1", "motion.start_up_periods=1.0", *GUST),
    ]
    together = marching(*cases, threads=2)
    together.advance(30)
    for b, one in enumerate(cases):
        alone = marching(one)
        alone.advance(20)
        taken = {name: values.copy() for name, values in alone.state(0).items()}
        again = marching(one)
        short = taken | {"flow.vorticity": taken["flow.vorticity"][:, :-1]}
        with pytest.raises(ValueError, match="vorticity is too short"):
            again.restore([short], 20)
        again.restore([taken], 20)
        again.advance(10)
        rows = tables.Given.of(one, alone.sections[0]).grid.rows
        for name in ("vorticity", "flux_rho"):
            ours = rows_of(again, name, rows)
            assert np.array_equal(ours, rows_of(together, name, rows, b))
        assert np.array_equal(view(again.body.force)[0], view(together.body.force)[b])


def forces(*more):
    """Force (N) and time of a rigid wing that starts smoothly."""
    march = marching(case("wing.modes=0", "motion.start_up_periods=0.5", *more))
    found = march.advance(10**6)[0]
    return found["step"] * march.cases[0].step, found["force"][:, state.NORMAL]


def test_second_order_in_time():
    times = np.linspace(0.006, 0.036, 61)
    found = [np.interp(times, *forces(f"time.steps_per_period={n}")) for n in (400, 800, 3200)]
    coarse, fine = (np.abs(one - found[-1]).max() for one in found[:2])
    assert coarse / fine > 3.3
    assert fine < 0.01 * np.abs(found[-1]).max()


GUST = ("fluid.velocity=[1.0, 0.3]", "fluid.gust=sinusoidal", "fluid.gust_velocity=0.5", "fluid.gust_length=0.02",
        "fluid.gust_arrival=0.004")  # fmt: skip


@pytest.mark.parametrize(("stream", "most"), [((), 0.002), (GUST, 0.005)])
def test_force_is_the_rate_of_the_impulse(stream, most):
    """Surface loads against -d/dt of the vorticity's first moment, while all of it is on the grid.

    In the frame of the stream. A gust `u` adds the force of the vorticity that it carries, `-w i u` of each cell, and
    what the pressure of the fluid with the gust is above that of the fluid without, `u . u'` on the wall.
    """
    march = marching(
        case(
            "wing.modes=0",
            "navier_stokes.cells=128",
            "navier_stokes.radius=7.6",
            "motion.start_up_periods=0.5",
            "time.steps_per_period=1600",
            *stream,
        )
    )
    step, field = march.cases[0].step, np.arange(1600)
    grid, fluid = tables.Given.of(march.cases[0], march.sections[0]).grid, march.cases[0].fluid
    # Frames are rounded.
    force, vorticity = [], []
    for _ in field:
        force.append(march.advance(1)[0]["force"])
        vorticity.append(rows_of(march, "vorticity", grid.rows).copy())
    moved = march.motion[0][field]
    pitch, rate = moved[:, PITCH, None], moved[:, PITCH_RATE, None]
    pivot, heave = 1j * moved[:, PLUNGE, None] / 0.02, 1j * moved[:, PLUNGE_RATE, None] / 0.02
    carried = complex(*fluid.velocity) / 0.02
    time = step * field[:, None]

    def wind(place):
        """The gust at points of each frame, and its curl, 1/s."""
        aside, along = 1e-4, np.exp(1j * np.angle(carried)) if carried else 1.0
        found = [
            np.array([gust_velocity(fluid, t, y, z) for t, y, z in zip(time[:, 0], at.real, at.imag, strict=True)])
            for at in (0.02 * place, 0.02 * (place + aside * along), 0.02 * (place - aside * along))
        ]
        here, ahead, behind = ((one[:, 0] + 1j * one[:, 1]) / 0.02 for one in found)
        return here, ((ahead - behind) / (2.0 * aside) * np.conj(1j * along)).real

    corner = grid.corner
    centre = 0.25 * (corner[1:] + corner[:-1] + np.roll(corner, 1, 1)[1:] + np.roll(corner, 1, 1)[:-1]).ravel()
    content = (np.array(vorticity) * (grid.area * grid.drho[:, None] * grid.dphi)).reshape(len(field), -1)
    place = centre * np.exp(1j * pitch) + pivot
    # The fluid that the section displaces moves with it, and against the gust.
    node, weight = np.polynomial.legendre.leggauss(12)
    radius, angle = np.meshgrid(0.5 * (node + 1.0), grid.centres, indexing="ij")
    within = (0.5 + radius * (0.5 * np.cos(angle) + 1j * grid.half * np.sin(angle))).ravel()
    size = (0.5 * weight[:, None] * radius * 0.5 * grid.half * grid.dphi).ravel()
    inside = within * np.exp(1j * pitch) + pivot
    blown, curl = wind(inside)
    momentum = ((heave + 1j * rate * within * np.exp(1j * pitch) - carried - blown) * size).sum(axis=1)
    spun = (2.0 * rate - curl) * size
    impulse = -1j * ((content * (place - carried * time)).sum(axis=1) + (spun * (inside - carried * time)).sum(axis=1))
    wall = positions(grid.coefficients, np.zeros(1), grid.centres)[0] * np.exp(1j * pitch)
    slope = grid.coefficients[0] * np.exp(1j * grid.centres) - grid.coefficients[2] * np.exp(-1j * grid.centres)
    blown, _ = wind(wall + pivot)
    disturbance = heave + 1j * rate * wall - carried - blown
    above = ((disturbance * blown.conj()).real * slope * np.exp(1j * pitch)).sum(axis=1) * grid.dphi
    expected = above - (1j * wind(place)[0] * content).sum(axis=1)
    expected = expected - np.gradient(impulse - momentum, step * (field[1] - field[0]))
    load = 1.225 * 0.02**3 * 0.05
    force = np.concatenate(force)
    ours = (force[:, state.AXIAL] + 1j * force[:, state.NORMAL]) * np.exp(1j * pitch[:, 0]) / load
    off = np.abs(ours - expected)[5:-5]
    assert np.sqrt(np.mean(off**2)) < most * np.sqrt(np.mean(np.abs(ours) ** 2))


STILL = ("motion.plunge={amplitude=0.0}", "motion.pitch={amplitude_deg=0.0}")


def test_wet_frequency_is_that_of_a_thin_plate():
    """For a wing that vibrates freely in a fluid at rest, as the viscosity vanishes."""
    ringing = case(
        *STILL,
        "wing.modes=1",
        "wing.damping_ratio=0.0",
        "fluid.viscosity=1e-9",
        "time.steps_per_period=1000",
        "navier_stokes.wall_spacing=0.001",  # the wall's vorticity is spread over the first row
    )
    march = marching(ringing)
    march.advance(1)
    view(march.body.q)[0, state.AMPLITUDE, 0] = 1e-9
    q = march.advance(10**6)[0]["q"][:, state.AMPLITUDE, 0]
    turns = np.flatnonzero(q[1:] * q[:-1] < 0.0)
    crossing = turns + q[turns] / (q[turns] - q[turns + 1])
    wet = 0.5 / (np.diff(crossing).mean() * ringing.step)
    dry, wing = march.sections[0].frequency[0], march.sections[0]
    added = 1.225 * 0.05 * 0.02**2 * thin_plate(lambda s: wing.shape(0.02 * s))[0, 0]
    assert wet == pytest.approx(dry / math.sqrt(1.0 + added), rel=3e-3)


@pytest.mark.parametrize("ratio", [10.0, 20.0])
def test_a_light_wing_is_stable_without_iteration(ratio):
    """The added mass is ten and twenty times the mass of the wing, with a tenth of the stroke."""
    dense = ratio * 4.0 * 40e-6 / (math.pi * 0.05 * 0.02**2)
    march = marching(
        case("wing.modes=1", f"fluid.density={dense}", "motion.plunge={amplitude=0.002,phase_deg=90}",
             "motion.pitch={amplitude_deg=2}", "motion.start_up_periods=0.5")
    )  # fmt: skip
    found = march.advance(10**6)[0]
    assert len(found["step"]) == march.steps + 1
    # No force jumps from step to step.
    force = found["force"][20:, state.NORMAL]
    assert np.abs(np.diff(force, 2)).max() < 0.01 * np.abs(force).max()


def test_messages():
    with pytest.raises(CaseError, match=r"fluid.viscosity: missing; .* air 1.5e-5"):
        hawkmoth("solver=navier_stokes")
    with pytest.raises(CaseError, match=r"the nearest such number is 96"):
        case("navier_stokes.cells=100")
    with pytest.raises(CaseError, match=r"at least 0.02 chords"):
        case("navier_stokes.thickness=0.01")
    with pytest.raises(CaseError, match=r"wing.span is a table"):
        case("wing.span=[[0.0, 0.05], [1.0, 0.04]]")
    with pytest.raises(
        ResolutionError,
        match=r"cells = 64 is too few at a Reynolds number, by the mean speed, of .*; give 192",
    ):
        marching(case("fluid.viscosity=1e-5"))
    # Without cells given there is nothing to leave out.
    with pytest.raises(ResolutionError, match=r"cells = 384 is too few .*; give [0-9]+$"):
        marching(hawkmoth(*NS, "fluid.viscosity=2e-6"))
    with pytest.raises(ResolutionError, match=r"give time.steps_per_period = [0-9]+ or more"):
        marching(case("time.steps_per_period=20"))


def test_what_a_run_was_not_good_for_is_said():
    model = fluids.load("navier_stokes")
    ran = hawkmoth(*NS, "fluid.viscosity=1.5e-5")
    said = "\n".join(model.outcome(ran, {"tip_deflection": np.array([0.011]), "courant": np.array([30.0])}.__getitem__))
    for phrase in (
        "tip deflection reaches 0.55 chords; above 0.5",
        "time.periods = 1: the mean of a separated flow needs at least 10",
        "the Courant number reached 30; above 15", "use time.steps_per_period = 800 or more",
        "navier_stokes.thickness = 0.04 chords, the wing has 0.002",
    ):  # fmt: skip
        assert phrase in said
    calm = {"tip_deflection": np.zeros(1), "courant": np.ones(1)}.__getitem__
    assert not model.outcome(ran.override("time.periods=10", "wing.thickness=5e-4"), calm)


def test_a_fast_step_is_cured_in_the_units_of_the_run():
    model, ran = fluids.load("navier_stokes"), hawkmoth(*NS, "fluid.viscosity=1.5e-5")
    seconds = parse_case(ran.to_dict() | {"time": {"duration": 0.04, "step": 1e-4}})
    for number, cure in ((30.0, "use time.step = 5e-05 s or less"), (math.inf, "use far shorter steps")):
        said = model.outcome(seconds, {"tip_deflection": np.zeros(1), "courant": np.array([number])}.__getitem__)
        assert cure in said[-1]
    # Before it runs: of a motion that jumps, and a flow that two dimensions are wrong for.
    assert any("above 3000" in one for one in model.warnings(ran.override("fluid.viscosity=1e-5")))
    assert any("begins with a jump" in one for one in model.warnings(ran))
    assert not model.warnings(ran.override("motion.start_up_periods=2.0"))
    with pytest.raises(ResolutionError, match="no grid of this model resolves the flow"):
        marching(ran.override("fluid.viscosity=1e-8"))


@pytest.mark.parametrize(
    "settings_",
    [(), ("navier_stokes.cells=192", "wing.modes=0"), ("fluid.viscosity=1.5e-5", "time.steps_per_period=auto")],
)
def test_a_study_knows_what_memory_a_case_needs(settings_):
    one = hawkmoth("solver=navier_stokes", "fluid.viscosity=4e-4", *settings_).resolved()
    start()
    flow = fluids.load("navier_stokes").flow([one], [beam.modes(one.wing)], None, 1)
    held = sum(view(values).nbytes for _, values in flow.groups["flow"].items)
    assert fluids.load("navier_stokes").memory(one) == pytest.approx(held, rel=0.1)
    assert held < 20e6


def test_a_map_that_does_not_converge_says_so():
    march = marching(
        case(
            "wing.modes=1",
            "motion.plunge={amplitude=0.08,phase_deg=90}",
            "time.steps_per_period=1600",
            "fluid.viscosity=6e-4",
        )
    )
    march.advance(10**6)
    assert "the map of the bent section did not converge at step" in march.reason(0)


def test_steps_frames_and_start_up_of_its_own():
    own = hawkmoth("solver=navier_stokes", "fluid.viscosity=4e-4").override("time.periods=2").resolved()
    assert own.steps_per_beat == 200  # the file's own
    plain = {name: value for name, value in hawkmoth(*NS).to_dict().items() if name not in ("time", "output")}
    own = taichiflap.case.case.parse_case(plain).resolved()
    assert own.time.steps_per_period > 400
    assert own.output.every == round(own.time.steps_per_period / 40)
    assert own.motion.growth == 1.0 / 25.0
    assert any("begins with a jump" in one for one in fluids.load("navier_stokes").warnings(own))


def test_a_stored_frame_is_a_field_in_space():
    """Positions and vorticity of a bent section's grid from the file; on a uniform grid, in either frame."""
    with taichiflap.simulate(case("wing.modes=1", "motion.start_up_periods=1.0", "output.every=100")) as result:
        field = Field.of(result, -1)
        node = np.asarray(result.node_position[-1])
        pivot = complex(result.surge[-1], result.plunge[-1])
    place = field.positions()
    # The row next to the wall closes about the nodes, which stand on the section's middle line.
    gap = np.abs(node[:, 0, None] + 1j * node[:, 1, None] - place[0]).min(axis=1)
    assert gap.max() < 0.05 * 0.02
    turned = (place - pivot) * np.exp(-1j * field.pitch)
    assert np.allclose(turned, field.positions(inertial=False), rtol=0, atol=1e-15)
    some = place[5:15:3, 3::7].ravel()
    for point, expected in zip(some, field.vorticity[5:15:3, 3::7].ravel(), strict=True):
        assert field.resampled([point.real], [point.imag])[0, 0] == pytest.approx(expected, rel=1e-6, abs=1e-9)
    inside = complex(*node[len(node) // 2])
    assert np.isnan(field.resampled([inside.real], [inside.imag])[0, 0])
    assert field.resampled([5.0], [5.0])[0, 0] == 0.0


@pytest.mark.slow
def test_a_sweep_gives_what_each_run_gives_and_names_what_cannot_be():
    pytest.importorskip("xarray")
    base = case("wing.modes=0", "time.steps_per_period=150", "fluid.viscosity=1e-3", "motion.start_up_periods=0.5")
    found = taichiflap.sweep(base, {"fluid.viscosity": [1e-3, 2e-3, 1e-8]}, threads=1)
    with taichiflap.simulate(base.override("fluid.viscosity=2e-3"), threads=1) as result:
        alone = taichiflap.summarise(result)
    assert float(found.force_vertical_mean[1]) == alone.force_vertical.mean
    assert np.isnan(found.force_vertical_mean[2])
    assert "no grid of this model resolves the flow" in str(found.reason[2].item())
