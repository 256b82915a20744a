"""Flexible blade elements: identities of their frame, added mass and attached flow, and exact theory of plates."""

import math

import numpy as np
import pytest
from conftest import PAPERS_BLADES, hawkmoth, march
from oracle import BladesOracle

from taichiflap import fluids, theory
from taichiflap.case.case import CaseError, parse_case
from taichiflap.fluids.dbet import added_mass, attached, elements
from taichiflap.fluids.dbet.elements import AREA, PRESSURE, SHEAR
from taichiflap.kernels.runtime import view
from taichiflap.march import march as marching
from taichiflap.march.series import Series
from taichiflap.march.state import AXIAL, MOMENT, NORMAL, UNSTEADY
from taichiflap.structure import beam
from taichiflap.validation import elastic

SHORT = ("solver=dbet", "dbet.elements=24", "time.periods=1", "time.steps_per_period=60")
STREAM = "fluid.velocity=[3.0, 0.5]"
AT_REST = ("motion.plunge.amplitude=0.0", "motion.pitch.amplitude_deg=0.0")
NO_BLADES = ("dbet.lift_max=0.0", "dbet.drag_min=0.0", "dbet.drag_max=0.0", "dbet.rotation=0.0", "dbet.attached=false")
TAPERED = "wing.span=[[0, 0.05], [0.5, 0.06], [1, 0]]"


def film(case):
    """Frames of a case, and its elements at the end, as rows along the chord."""
    frames, marched = march(case)
    laid = view(marched.groups["flow"].element)[0].reshape(elements.ROWS, -1)[:, : case.dbet.elements]
    return frames, marched, laid


@pytest.mark.parametrize(
    "settings",
    [
        ("wing.modes=3",),
        ("wing.modes=3", STREAM),
        ("wing.modes=2", "fluid.velocity=[9.0, -1.0]", "fluid.viscosity=1.5e-5"),
        ("wing.modes=0", "wing.pivot=0.3", STREAM, TAPERED, "dbet.suction=0.5"),
        ("wing.modes=1", "dbet.attached=false", "dbet.frame=chord", "motion.pitch.amplitude_deg=45"),
        ("wing.modes=2", "dbet.attached=false", "dbet.added_mass=strip", STREAM),
        ("wing.modes=2", TAPERED, "wing.thickness=[[0, 60e-6], [1, 20e-6]]", STREAM),
    ],
)
def test_matches_an_independent_march(settings):
    case = hawkmoth(*SHORT, *settings)
    frames, _ = march(case)
    oracle = BladesOracle(case).march(case.steps)
    for name, ours in (("q", frames.q[:, 0]), ("a", frames.q[:, 2]), ("force", frames.force)):
        theirs = np.array([step[name] for step in oracle.history])
        size = np.abs(theirs).max(axis=0, initial=0.0)
        assert np.all(np.abs(ours - theirs).max(axis=0, initial=0.0) <= 1e-7 * size + 1e-13), name


def modal_mass(shapes, count):
    """Added mass of velocities of given shapes along the chord, over `pi rho b^2`."""
    case = hawkmoth("solver=dbet", f"dbet.elements={count}", "wing.chord=1.0", "wing.span=1.0")
    moments = np.array([added_mass.table(case) @ shape((np.arange(count) + 0.5) / count) for shape in shapes])
    return moments @ moments.T / (math.pi / 4)


@pytest.mark.parametrize("count", [1, 7, 50])
def test_added_mass_in_heave_is_exact_with_any_elements(count):
    assert modal_mass([np.ones_like], count)[0, 0] == pytest.approx(1.0, rel=1e-14)


def test_added_mass_of_pitch_and_of_the_modes_of_a_cantilever():
    roots = theory.cantilever_roots(4)
    shapes = [np.ones_like, lambda x: x, *(lambda x, beta=beta: theory.cantilever_shape(beta, x) for beta in roots)]
    found = modal_mass(shapes, 400)
    assert found[1, 1] == pytest.approx(9 / 32, rel=1e-4)
    expected = [
        [0.72022, 0.37632, -0.00889, 0.09763],
        [0.37632, 0.63890, 0.16000, 0.03951],
        [-0.00889, 0.16000, 0.35392, 0.07555],
        [0.09763, 0.03951, 0.07555, 0.25119],
    ]
    np.testing.assert_allclose(found[2:, 2:], expected, atol=1e-4)
    np.testing.assert_allclose(found[0, 2:], [0.75644, 0.64590, 0.18321, 0.17572], atol=1e-4)
    np.testing.assert_allclose(found[1, 2:], [0.44573, 0.27917, 0.02293, 0.06655], atol=1e-4)
    np.testing.assert_allclose(found * math.pi / 4, theory.added_mass(shapes), atol=1e-4)


def test_the_operator_of_attached_flow():
    """Means and moments of its load over the chord compared with thin-aerofoil theory."""
    count = 200
    case = hawkmoth("solver=dbet", f"dbet.elements={count}")
    x = (np.arange(count) + 0.5) / count
    operate = attached.loads(case.dbet.elements).T @ attached.cosines(case.dbet.elements)[:-1]
    flat = operate @ np.ones(count)
    assert flat.mean() == pytest.approx(1.0, rel=1e-12)
    assert (flat * x).mean() == pytest.approx(0.25, abs=1e-4)
    assert (operate @ x).mean() == pytest.approx(0.75, abs=1e-4)
    assert (operate @ x**2).mean() == pytest.approx(0.625, abs=2e-4)
    assert attached.cosines(case.dbet.elements)[-1] @ x == pytest.approx(0.75, abs=1e-4)


def test_the_lag_is_wagners():
    s = np.array([0.0, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0])
    lag = np.array(attached.LAG_AMPLITUDE) @ np.exp(-np.outer(attached.LAG_EXPONENT, s))
    assert sum(attached.LAG_AMPLITUDE) == pytest.approx(0.5, abs=1e-12)
    np.testing.assert_allclose(1 - lag, [theory.wagner(one) for one in s], atol=6e-4)


def gained(*settings):
    """Work of the fluid on a wing over its last beat relative to the gross work, with added mass alone."""
    case = hawkmoth("solver=dbet", *NO_BLADES, "wing.damping_ratio=0.3", "time.periods=6", *settings)
    frames, marched = march(case)
    told = {"step": frames.step, "q": frames.q, "force": frames.force, "modal_force": frames.modal_force}
    power = -Series.of(case, marched.sections[0], marched.motion[0], told).power_aerodynamic[0]
    power = (power + (frames.modal_force * frames.q[:, 1]).sum(axis=1))[-201:]
    return np.trapezoid(power) / np.trapezoid(np.abs(power))


@pytest.mark.parametrize(
    ("settings", "bound"),
    [
        (("wing.modes=0", "motion.pitch.amplitude_deg=45"), 1e-12),
        (("wing.modes=0", "motion.pitch.amplitude_deg=45", "wing.pivot=0.3", TAPERED), 1e-12),
        (("wing.modes=3",), 5e-5),
        (("wing.modes=3", "motion.surge.amplitude=0.01", "motion.surge.phase_deg=30"), 5e-5),
    ],
)
def test_added_mass_makes_no_energy_over_a_closed_beat(settings, bound):
    assert abs(gained(*settings)) < bound


@pytest.mark.parametrize(("modes", "share"), [(0, 0.106), (3, 0.118)])
def test_strips_of_added_mass_make_energy(modes, share):
    strips = ("dbet.frame=chord", "dbet.added_mass=strip", "motion.pitch.amplitude_deg=45")
    assert gained(*strips, f"wing.modes={modes}") == pytest.approx(share, abs=0.002)


@pytest.mark.parametrize("settings", [(), (STREAM,), ("fluid.velocity=[10.0, 0.0]",)])
def test_the_modal_force_is_the_work_of_the_elements(settings):
    case = hawkmoth(*SHORT, "wing.modes=3", *settings)
    frames, _, laid = film(case)
    shape = beam.modes(case.wing).shape(elements.middles(case))
    worked = shape @ (laid[AREA] * laid[PRESSURE])
    np.testing.assert_allclose(frames.modal_force[-1], worked, rtol=1e-9, atol=1e-12 * np.abs(worked).max())
    assert frames.force[-1, NORMAL] == pytest.approx(float(laid[AREA] @ laid[PRESSURE]), rel=1e-12)
    sucked = frames.force[-1, AXIAL] - float(laid[AREA] @ laid[SHEAR])
    assert sucked <= 1e-15


def test_stream_and_wing_may_turn_together():
    """Forces in wing axes do not change if stream and motion are rotated by an angle."""
    turn, speed = 30.0, 4.0
    cosine, sine = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    beating = (*SHORT, "wing.modes=3", "motion.plunge.phase_deg=90.0")
    one = march(hawkmoth(*beating, "motion.plunge.amplitude=0.02", f"fluid.velocity=[{speed}, 0.0]"))[0]
    turned = (
        f"motion.pitch.mean_deg={turn}", f"fluid.velocity=[{speed * cosine}, {speed * sine}]",
        f"motion.plunge.amplitude={0.02 * cosine}", f"motion.surge.amplitude={0.02 * sine}",
        "motion.surge.phase_deg=-90.0",
    )  # fmt: skip
    two = march(hawkmoth(*beating, *turned))[0]
    np.testing.assert_allclose(two.force, one.force, rtol=1e-9, atol=1e-9 * np.abs(one.force).max())
    np.testing.assert_allclose(two.q, one.q, rtol=1e-9, atol=1e-12)


def separation(angle_deg, *settings):
    stream = 3.0 * np.array([np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))])
    case = hawkmoth(*SHORT, *AT_REST, "wing.modes=0", f"fluid.velocity=[{stream[0]}, {stream[1]}]", *settings)
    _, marched, _ = film(case)
    return float(view(marched.groups["flow"].lag)[0, attached.SEPARATED])


def test_attached_flow_gives_way_smoothly():
    angles = np.array([0.0, 10.0, 19.9, 20.0, 21.0, 32.5, 44.0, 45.0, 60.0, 90.0, 120.0, 180.0, -32.5])
    share = np.array([separation(angle) for angle in angles])
    expected = np.clip((np.abs(angles) - 20) / 25, 0, 1)
    expected = expected**2 * (3 - 2 * expected)
    np.testing.assert_allclose(share, expected, atol=1e-9)
    assert separation(32.5, "dbet.stall_deg=[30, 50]") == pytest.approx(0.125**2 * (3 - 2 * 0.125), abs=1e-9)


def test_a_steady_plate_lifts_by_thin_aerofoil_theory():
    still = (*AT_REST, "wing.modes=0", "fluid.velocity=[3.0, 0.0]", "dbet.friction=none", "motion.frequency=1e-3")
    alpha = np.radians(4.0)
    frames, _ = march(hawkmoth(*SHORT, *still, "motion.pitch.mean_deg=-4.0", "dbet.elements=400"))
    pressure = 0.5 * 1.225 * 3.0**2 * 0.02 * 0.05
    normal, axial, moment, unsteady = frames.force[-1] / pressure
    assert normal == pytest.approx(2 * np.pi * np.sin(alpha) * np.cos(alpha), rel=1e-6)
    assert axial == pytest.approx(-2 * np.pi * np.sin(alpha) ** 2, rel=1e-6)  # no drag: d'Alembert
    assert moment == pytest.approx(0.25 * 0.02 * normal, rel=1e-3)
    assert unsteady == 0.0


def test_laminar_friction_is_blasius():
    still = (*AT_REST, "wing.modes=0", "fluid.velocity=[3.0, 0.0]", "fluid.viscosity=1.5e-5")
    frames, _ = march(hawkmoth(*SHORT, *still))
    reynolds = 3.0 * 0.02 / 1.5e-5
    drag = 2 * 1.328 / np.sqrt(reynolds)
    assert frames.force[-1, AXIAL] == pytest.approx(0.5 * 1.225 * 9.0 * 1e-3 * drag, rel=1e-12)


@pytest.mark.parametrize("k", [0.1, 0.5, 1.0, 2.0])
def test_theodorsen_and_garrick_in_plunge(k):
    found = elastic.oscillating_blades(k)
    exact = theory.oscillating_loads(k, plunge=elastic.SMALL)[0]
    assert abs(abs(found.lift / exact) - 1) < 3e-3
    assert abs(np.degrees(np.angle(found.lift / exact))) < 0.15
    assert found.thrust == pytest.approx(theory.mean_thrust(k, plunge=elastic.SMALL), rel=3e-3)


def test_the_exact_elastic_plate():
    """The tip within 0.3 % and half a degree: `validate` has all points."""
    for setting in elastic.POINTS[:3]:
        found, exact = elastic.heaving("dbet", [setting])[0], elastic.exact(setting)
        assert abs(abs(found.tip / exact.tip) - 1) < 3e-3, setting
        assert abs(np.degrees(np.angle(found.tip / exact.tip))) < 0.5, setting
        assert abs(abs(found.lift / exact.lift) - 1) < 3e-3, setting


@pytest.mark.slow
def test_flutter_begins_where_it_should():
    for mass_ratio in (0.2, 1.0):
        assert elastic.onset("dbet", mass_ratio) == pytest.approx(theory.flutter_onset(mass_ratio)[0], rel=0.02)


@pytest.mark.slow
def test_without_its_lag_attached_flow_would_flutter_at_half_the_speed(monkeypatch):
    monkeypatch.setattr(attached, "LAG_AMPLITUDE", (0.0, 0.0, 0.0, 0.0))
    monkeypatch.setattr(marching, "_kernels", {})
    assert elastic.growth("dbet", 0.2, 0.5 * theory.flutter_onset(0.2)[0])[0] > 0.0


@pytest.mark.parametrize(
    ("settings", "phrase"),
    [
        (("dbet.frame=chord",), 'frame = "chord"'),
        (("dbet.added_mass=strip",), 'added_mass = "strip"'),
        (("dbet.added_mass=none",), "attached = false"),
        (("dbet.speed=truncated",), 'dbet.frame = "deformed"'),
        (("dbet.stall_deg=[45, 20]",), "smaller than the second"),
    ],
)
def test_what_would_flutter_falsely_is_refused(settings, phrase):
    with pytest.raises(CaseError, match="dbet") as caught:
        fluids.check(hawkmoth("solver=dbet", *settings))
    assert phrase in str(caught.value)
    fluids.check(hawkmoth("solver=dbet", "wing.modes=0", "dbet.frame=chord", "dbet.added_mass=none"))  # nothing bends


def test_coefficients_outside_their_range_are_warned_of():
    water = hawkmoth("solver=dbet", "fluid.viscosity=1.5e-5", "dbet.coefficients=wang")
    (said,) = fluids.load("dbet").warnings(water)
    assert "30 to 200" in said
    assert not fluids.load("dbet").warnings(water.override("dbet.coefficients=whitney_wood"))


def test_files_of_version_1_mean_the_papers_model():
    paper = hawkmoth("solver=dbet", *PAPERS_BLADES)
    document = hawkmoth("solver=dbet").to_dict()
    for given, mass in ((True, "strip"), (False, "none")):
        old = {"elements": 50, "lift_max": 1.8, "drag_min": 0.4, "drag_max": 4.0, "added_mass": given, "speed": "full"}
        case = parse_case({**document, "dbet": old})
        assert (case.dbet.frame, case.dbet.attached, case.dbet.rotation) == ("chord", False, 0.0)
        assert case.dbet.added_mass == mass
    one, two = (march(case.override("time.periods=1"))[0] for case in (paper, parse_case({**document, "dbet": {
        "lift_max": 1.8, "drag_min": 0.4, "drag_max": 4.0, "added_mass": True}})))  # fmt: skip
    np.testing.assert_array_equal(one.force, two.force)


def test_named_coefficients_and_own_ones():
    named = hawkmoth("dbet.coefficients=wang").dbet.polar
    assert (named.lift_max, named.drag_min, named.drag_max) == (1.2, 0.4, 2.4)
    own = hawkmoth("dbet.coefficients=wang", "dbet.lift_max=1.0").dbet.polar
    assert (own.lift_max, own.drag_min, own.drag_max) == (1.0, 0.4, 2.4)


def test_unsteady_share_and_moment_of_a_pushed_plate():
    """The added mass of potential flow on a rigid plate in pitch about its leading edge."""
    case = hawkmoth(*SHORT, *NO_BLADES, "wing.modes=0", "motion.plunge.amplitude=0.0", "dbet.elements=400")
    frames, marched = march(case)
    accel = marched.motion[0, frames.step, 5]
    mass = np.pi * 1.225 * 0.01**2 * 0.05
    np.testing.assert_allclose(frames.force[:, UNSTEADY], -mass * 0.01 * accel, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(frames.force[:, MOMENT], -mass * 0.02**2 * 9 / 32 * accel, rtol=1e-4, atol=1e-15)
