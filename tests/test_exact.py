"""The exact solutions compared with tabulated values and independent formulas."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import iv, kve

from taichiflap import theory

RIGID = [np.ones_like, lambda x: x]


@pytest.mark.parametrize(
    ("k", "value"),
    [
        (0.1, 0.8319241 - 0.1723022j),
        (0.5, 0.5979361 - 0.1507095j),
        (1.0, 0.5394349 - 0.1002729j),
        (2.0, 0.5129548 - 0.0576913j),
    ],
)
def test_theodorsens_function_is_as_tabulated(k, value):
    assert theory.theodorsen(k) == pytest.approx(value, abs=1e-7)


def test_theodorsens_function_of_imaginary_bessel_functions():
    for k in (0.01, 0.3, 4.0):
        one, zero = (kve(n, 1j * k) for n in (1, 0))
        assert theory.theodorsen(k) == pytest.approx(one / (zero + one), rel=1e-12)
    assert theory.theodorsen(0.0) == 1.0
    assert theory.theodorsen(1e6) == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("s", [0.5, 1, 2, 5, 10, 20, 100])
def test_wagner_as_a_decaying_integral(s):
    """von Karman & Sears: the same function along the branch cut of Theodorsen's, where nothing oscillates."""

    def weight(x):
        cut = ((kve(0, x) - kve(1, x)) * math.exp(-x)) ** 2 + (math.pi * (iv(0, x) + iv(1, x))) ** 2
        return math.exp(-x * s) / (x * x * cut)

    deficit = quad(weight, 0, 1, epsabs=1e-12, limit=400)[0] + quad(weight, 1, 300, epsabs=1e-12, limit=400)[0]
    assert theory.wagner(s) == pytest.approx(1 - deficit, abs=2e-8)


def test_wagner_as_tabulated():
    table = {1: 0.6006056, 2: 0.6692896, 5: 0.7882032, 10: 0.8750447, 20: 0.9366493}
    assert [theory.wagner(s) for s in table] == pytest.approx(list(table.values()), abs=1e-7)
    assert theory.wagner(0.0) == 0.5
    assert theory.wagner(1e-4) == pytest.approx(0.5 + 1e-4 / 8, abs=1e-7)


def test_slow_oscillation_is_quasi_steady():
    lift, moment = theory.oscillating_loads(1e-6, pitch=0.1, axis=0.25)
    assert lift == pytest.approx(2 * math.pi * 0.1, rel=1e-4)
    assert abs(moment) < 1e-5


def test_pitch_about_one_axis_is_pitch_and_plunge_about_another():
    k, pitch = 0.7, 0.1 + 0.02j
    lift, moment = theory.oscillating_loads(k, pitch=pitch, axis=0.25)
    same, other = theory.oscillating_loads(k, plunge=0.25 * pitch, pitch=pitch, axis=0.0)
    assert same == pytest.approx(lift, rel=1e-12)
    assert other == pytest.approx(moment - 0.25 * lift, rel=1e-12)


@pytest.mark.parametrize("k", [0.05, 0.5, 5.0])
def test_what_the_wake_does_to_the_load_acts_at_the_quarter_chord(k):
    """Fung (1955): there the moment is that of the added mass, in plunge at mid-chord, in pitch with its couple."""
    plunge, pitch, rate = 0.2, 0.1, 2j * k
    heave, turn = theory.oscillating_loads(k, plunge, axis=0.25), theory.oscillating_loads(k, pitch=pitch, axis=0.25)
    assert heave[1] == pytest.approx(0.25 * math.pi / 2 * rate**2 * plunge, rel=1e-12)
    assert turn[1] == pytest.approx(-math.pi / 4 * pitch * (rate + 3 / 16 * rate**2), rel=1e-12)


@pytest.mark.parametrize("k", [0.05, 0.5, 5.0])
@pytest.mark.parametrize(("plunge", "pitch", "axis"), [(0.2, 0.0, 0.0), (0.0, 0.1, 0.0), (0.1, 0.3j, 0.25)])
def test_power_is_thrust_and_what_the_wake_carries_off(k, plunge, pitch, axis):
    """Garrick's energy equation; the wake's share follows from its circulation alone (his Eq. 26)."""
    wash = -2j * k * plunge + pitch + (0.75 - axis) * 2j * k * pitch
    deficiency = theory.theodorsen(k)
    lost = math.pi * abs(wash) ** 2 * (deficiency.real - abs(deficiency) ** 2)
    thrust = theory.mean_thrust(k, plunge, pitch, axis)
    assert theory.mean_power(k, plunge, pitch, axis) == pytest.approx(thrust + lost, rel=1e-10)


def test_thrust_of_plunge_is_all_suction():
    k, plunge = 0.4, 0.1
    assert theory.mean_thrust(k, plunge, suction=False) == 0.0
    expected = math.pi * (2 * k * plunge) ** 2 * abs(theory.theodorsen(k)) ** 2
    assert theory.mean_thrust(k, plunge) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("load", [theory.oscillating_loads, theory.mean_power, theory.mean_thrust])
def test_a_plate_does_what_it_is_told_and_nothing_else(load):
    np.testing.assert_array_equal(load(0.5), 0.0)
    assert load(0.5, plunge=0.1) == load(0.5, 0.1, 0.0, 0.0)
    assert load(0.5, pitch=0.1) == load(0.5, 0.0, 0.1, 0.0)


def test_steady_plate_and_camber():
    assert theory.plate_normal_force(1e-4) == pytest.approx(2e-4 * math.pi, rel=1e-7)
    assert theory.plate_normal_force(math.pi / 4) == pytest.approx(math.pi)
    assert theory.plate_normal_force(math.pi / 2) == pytest.approx(0.0, abs=1e-15)
    whole = quad(lambda x: math.sqrt((1 - x) / x), 0, 1)[0]
    for x in (0.01, 0.3, 0.9):
        ahead = quad(lambda s: math.sqrt((1 - s) / s), 0, x)[0]
        assert theory.plate_load_ahead(x) == pytest.approx(ahead / whole, rel=1e-6)
    slope_integral = quad(lambda t: 4 * 0.03 * math.cos(t) * (math.cos(t) - 1), 0, math.pi)[0] / math.pi
    assert theory.parabolic_camber_lift(0.02, 0.03) == pytest.approx(2 * math.pi * (0.02 + slope_integral))


def test_added_mass_of_rigid_motion_is_its_closed_form():
    b = 0.5
    expected = math.pi * np.array([[b**2, b**3], [b**3, 9 / 8 * b**4]])
    np.testing.assert_allclose(theory.added_mass(RIGID), expected, rtol=1e-12)


def test_added_mass_between_rigid_motion_and_any_shape_is_the_work_of_its_load():
    """Unit rates have the potential jumps `2 r` and, in a turn, `(x - 1/2) r`, r^2 = x (1 - x) (Lamb 1932, art. 71)."""
    root = theory.cantilever_roots(2)[1]
    for shape in (np.exp, lambda x: theory.cantilever_shape(root, x)):
        mass = theory.added_mass([np.ones_like, lambda x: x - 0.5, shape])
        for rigid, jump in ((0, lambda x: 2.0), (1, lambda x: x - 0.5)):
            work = quad(lambda x, f=shape, j=jump: j(x) * math.sqrt(x * (1.0 - x)) * float(f(x)), 0.0, 1.0)[0]
            assert mass[rigid, 2] == pytest.approx(work, rel=1e-8)


def test_added_mass_is_the_limit_of_fast_oscillation():
    k = 1e5
    lift, moment = theory.oscillating_loads(k, pitch=1.0)
    mass = theory.added_mass(RIGID)
    assert -lift / (2 * (2j * k) ** 2) == pytest.approx(-mass[0, 1], rel=1e-4)
    assert -moment / (2 * (2j * k) ** 2) == pytest.approx(mass[1, 1], rel=1e-4)


def test_wet_frequencies():
    assert theory.wet_frequencies([80.0], [[0.47]]) == pytest.approx([80 / math.sqrt(1.47)])
    coupled = np.array([[0.5, 0.1], [0.1, 0.3]])
    expected = np.sqrt(np.linalg.eigvals(np.linalg.solve(np.eye(2) + coupled, np.diag([1.0, 36.0]))))
    np.testing.assert_allclose(theory.wet_frequencies([1.0, 6.0], coupled), np.sort(expected), rtol=1e-12)


def test_cantilever_is_as_tabulated():
    roots = [1.87510406871, 4.69409113297, 7.85475743824, 10.9955407349]
    np.testing.assert_allclose(theory.cantilever_roots(4), roots, rtol=1e-11)
    paper = theory.cantilever_frequencies(3, 0.02, 40e-6, 1000.0, 24.5e9)
    assert paper == pytest.approx([79.96, 501.1, 1403.1], rel=1e-4)
    s = np.linspace(0, 1, 20001)
    for beta in roots:
        shape = theory.cantilever_shape(beta, s)
        assert np.trapezoid(shape**2, s) == pytest.approx(1.0, abs=1e-6)
        assert abs(shape[-1]) == pytest.approx(2.0, rel=1e-8)


def test_vortices():
    assert theory.pair_speed(2 * math.pi, 2.0) == 0.5
    assert theory.pair_rotation(1.3, 1.3, 3.0) == pytest.approx(theory.polygon_rotation(2, 1.3, 1.5))
    corners = 0.7 * np.exp(0.5j * math.pi * np.arange(4))
    across = corners[0] - corners[1:]
    conjugate_velocity = 1.3 * np.sum(1.0 / (2j * math.pi * across))
    assert theory.polygon_rotation(4, 1.3, 0.7) == pytest.approx(-conjugate_velocity.imag / 0.7)


def test_places_in_single_precision_are_computed_with_in_double():
    x = np.array([0.1, 0.5, 0.9], np.float32)
    for function in (theory.plate_load_ahead, lambda at: theory.cantilever_shape(1.8751, at)):
        np.testing.assert_array_equal(function(x), function(x.astype(float)))
    mass = [[0.5, 0.1, 0.0], [0.1, 0.3, 0.0], [0.0, 0.0, 0.2]]
    np.testing.assert_array_equal(theory.wet_frequencies(x, mass), theory.wet_frequencies(x.astype(float), mass))
