"""Sections of any distribution: closed forms, the exact wedge and tip mass, orthonormality, an independent FEM."""

from itertools import pairwise

import numpy as np
import pytest
from conftest import hawkmoth
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.special import iv, jv

from taichiflap.march import series
from taichiflap.structure import beam
from taichiflap.structure.chordwise import Profile
from taichiflap.structure.distribution import Section

E, RHO, H, T, C = 24.5e9, 1000.0, 0.05, 40e-6, 0.02
GRADED = (
    "wing.span=[[0, 0.05], [0.4, 0.06], [1, 0]]",
    "wing.thickness=[[0, 60e-6], [0.7, 30e-6], [1, 20e-6]]",
    "wing.youngs_modulus=[[0, 30e9], [1, 10e9]]",
    "wing.point_masses=[[0.55, 3e-6], [1.0, 1e-6]]",
)


def rules(breaks, points):
    """Gauss' rule on each piece of the chord."""
    x, w = np.polynomial.legendre.leggauss(points)
    return [(a + (b - a) * (x + 1) / 2, (b - a) * w / 2) for a, b in pairwise(breaks)]


def test_a_uniform_table_gives_the_closed_forms():
    exact = beam.modes(hawkmoth("wing.modes=8").wing)
    table = beam.modes(hawkmoth("wing.modes=8", "wing.thickness=[[0, 40e-6], [0.37, 40e-6], [1, 40e-6]]").wing)
    y = np.linspace(0.0, C, 201)
    for name in ("omega", "lam", "psi", "mass", "first_moment", "second_moment"):
        np.testing.assert_allclose(getattr(table, name), getattr(exact, name), rtol=1e-10)
    np.testing.assert_allclose(table.shape(y), exact.shape(y), atol=1e-9 * np.abs(exact.shape(y)).max())
    np.testing.assert_allclose(table.slope(y), exact.slope(y), atol=1e-9 * np.abs(exact.slope(y)).max())


def test_twenty_modes_of_many_pieces_are_still_good():
    exact = beam.modes(hawkmoth("wing.modes=20").wing)
    entries = ", ".join(f"[{s:.2f}, {E}]" for s in np.linspace(0, 1, 21))
    table = beam.modes(hawkmoth("wing.modes=20", f"wing.youngs_modulus=[{entries}]").wing)
    np.testing.assert_allclose(table.omega, exact.omega, rtol=1e-8)
    np.testing.assert_allclose(table.psi, exact.psi, rtol=1e-7)
    y, rule = (C * np.concatenate(parts) for parts in zip(*rules(np.linspace(0, 1, 21), 12), strict=True))
    phi = table.shape(y)
    # The tables' modes are normal to round-off, however many.
    np.testing.assert_allclose((phi * (RHO * T * H * rule)) @ phi.T, np.eye(20), atol=1e-12)


def test_wedge():
    """Kirchhoff: `J1(z) I2(z) + I1(z) J2(z) = 0` with `omega = z^2/4 sqrt(E I0/(m0 L^4))`, I0 and m0 at the clamp."""
    roots = [
        brentq(lambda z: jv(1, z) * iv(2, z) + iv(1, z) * jv(2, z), *ends) for ends in ((4, 5), (7, 8.5), (10, 12))
    ]
    section = beam.modes(hawkmoth("wing.modes=3", "wing.thickness=[[0, 40e-6], [1, 0]]").wing)
    unit = T * np.sqrt(E / (12 * RHO)) / C**2
    np.testing.assert_allclose(section.omega / unit, np.array(roots) ** 2 / 4, rtol=1e-10)
    assert (section.omega[:2] / unit).tolist() == pytest.approx([5.315, 15.207], abs=1e-3)


@pytest.mark.parametrize("share", [0.1, 1.0, 5.0])
def test_tip_mass(share):
    mass = RHO * T * H * C
    section = beam.modes(hawkmoth("wing.modes=3", f"wing.point_masses=[[1.0, {share * mass}]]").wing)

    def frequency_equation(b):
        inertia = share * b * (np.cos(b) * np.tanh(b) - np.sin(b))
        return 1 / np.cosh(b) + np.cos(b) + inertia

    beta = np.sqrt(section.omega / (T * np.sqrt(E / (12 * RHO)))) * C
    exact = [brentq(frequency_equation, b * (1 - 1e-3), b * (1 + 1e-3), xtol=1e-14) for b in beta]
    np.testing.assert_allclose(beta, exact, rtol=1e-10)
    assert beta[0] < beam.cantilever_root(1)


@pytest.mark.parametrize("count", [1, 8, 20])
def test_graded_modes_are_orthonormal_and_meet_lambda_and_psi(count):
    wing = hawkmoth(f"wing.modes={count}", *GRADED).wing
    section, spread = beam.modes(wing), Section.of(wing)
    x, w = np.polynomial.legendre.leggauss(80)
    pieces = list(zip(spread.breaks[:-1], spread.breaks[1:], strict=True))
    s = np.concatenate([a + (b - a) * (x + 1) / 2 for a, b in pieces])
    rule = np.concatenate([(b - a) * w / 2 for a, b in pieces])
    span, thickness = (np.interp(s, *np.array(table).T) for table in (wing.span, wing.thickness))
    mass = np.concatenate((C * rule * RHO * thickness * span, [3e-6, 1e-6]))
    y = C * np.concatenate((s, [0.55, 1.0]))
    phi = section.shape(y)
    np.testing.assert_allclose((phi * mass) @ phi.T, np.eye(count), atol=1e-10)
    np.testing.assert_allclose(section.lam, phi @ mass, atol=1e-10 * np.sqrt(mass.sum()))
    np.testing.assert_allclose(section.psi, phi @ (mass * y), atol=1e-10 * C * np.sqrt(mass.sum()))
    assert np.all(section.psi > 0)
    moments = [mass.sum(), mass @ y, mass @ y**2]
    np.testing.assert_allclose([section.mass, section.first_moment, section.second_moment], moments, rtol=1e-12)


def test_graded_modes_bend_without_work_on_one_another():
    """`int EI phi_j'' phi_k'' dy` is `omega_k^2` for j = k and 0 otherwise: what makes them modes of this stiffness."""
    wing = hawkmoth("wing.modes=6", *GRADED).wing
    section, stored = beam.modes(wing), np.zeros((6, 6))
    for s, rule in rules([0.0, 0.4, 0.55, 0.7, 1.0], 60):
        span, thickness, modulus = (
            np.interp(s, *np.array(table).T) for table in (wing.span, wing.thickness, wing.youngs_modulus)
        )
        # Slopes are polynomials on a piece; their derivative is exact.
        slopes = np.polynomial.legendre.legfit(2 * (s - s[0]) / (s[-1] - s[0]) - 1, section.slope(C * s).T, 45)
        bent = np.polynomial.legendre.legder(slopes, scl=2 / (C * (s[-1] - s[0])))
        curvature = np.polynomial.legendre.legval(2 * (s - s[0]) / (s[-1] - s[0]) - 1, bent)
        stored += (curvature * (C * rule * modulus * span * thickness**3 / 12)) @ curvature.T
    size = np.outer(section.omega, section.omega)
    np.testing.assert_allclose(stored / size, np.eye(6), atol=1e-9)


def test_a_mass_on_the_way_to_the_tip():
    """A cantilever in two pieces: deflection, slope and moment go on at the mass, the shear jumps by its inertia."""
    at, share = 0.3, 2.0
    section = beam.modes(hawkmoth("wing.modes=3", f"wing.point_masses=[[{at}, {share * RHO * T * H * C}]]").wing)

    def mismatch(b):
        def wave(x, n):
            """The n-th derivative of `cosh + cos`."""
            return [np.cosh(x) + np.cos(x), np.sinh(x) - np.sin(x), np.cosh(x) - np.cos(x), np.sinh(x) + np.sin(x)][
                n % 4
            ]

        # The clamped piece has no deflection and slope at its end, the free one no moment and shear at its own.
        x, z = b * at, b * (1.0 - at)
        clamped = np.array([[wave(x, 2 + n), wave(x, 1 + n)] for n in range(4)])
        free = np.array([[(-1) ** n * wave(z, n), (-1) ** n * wave(z, 3 + n)] for n in range(4)])
        clamped[3] += share * b * clamped[0]
        return np.linalg.det(np.hstack((clamped, -free))) / np.cosh(b)

    beta = np.sqrt(section.omega / (T * np.sqrt(E / (12 * RHO)))) * C
    exact = [brentq(mismatch, b * (1 - 1e-3), b * (1 + 1e-3), xtol=1e-14) for b in beta]
    np.testing.assert_allclose(beta, exact, rtol=1e-10)


def test_damping_and_pivot_of_a_graded_wing():
    section = beam.modes(hawkmoth("wing.modes=2", "wing.damping_ratio=[0.1, 0.2]", *GRADED).wing)
    assert section.damping_ratio.tolist() == [0.1, 0.2]
    rigid = beam.modes(hawkmoth("wing.modes=0", *GRADED).wing)
    assert [one.shape for one in (rigid.omega, rigid.damping_ratio, rigid.lam, rigid.psi)] == [(0,)] * 4
    assert rigid.shape([0.0, 0.01]).shape == rigid.slope([0.0, 0.01]).shape == (0, 2)


def hermite_frequencies(spread, elements=100):
    """Natural angular frequencies from cubic beam elements on a uniform mesh, point masses at their nearest nodes."""
    x, w = np.polynomial.legendre.leggauss(5)
    a, length = np.linspace(0, spread.chord, elements + 1), spread.chord / elements
    stiffness, mass = (np.zeros((2 * elements + 2, 2 * elements + 2)) for _ in range(2))
    t = (x + 1) / 2
    shape = np.array(
        [1 - 3 * t**2 + 2 * t**3, length * (t - 2 * t**2 + t**3), 3 * t**2 - 2 * t**3, length * (t**3 - t**2)]
    )
    bend = np.array([12 * t - 6, length * (6 * t - 4), 6 - 12 * t, length * (6 * t - 2)]) / length**2
    for e in range(elements):
        s, at = (a[e] + length * t) / spread.chord, slice(2 * e, 2 * e + 4)
        stiffness[at, at] += (bend * (length * w / 2 * spread.flexural_rigidity(s))) @ bend.T
        mass[at, at] += (shape * (length * w / 2 * spread.mass_per_length(s))) @ shape.T
    for s, kg in spread.point_masses:
        node = 2 * round(s * elements)
        mass[node, node] += kg
    last = 2 * elements - 1
    slow = eigh(mass[2:, 2:], stiffness[2:, 2:], eigvals_only=True, subset_by_index=(last - 3, last))
    return 1 / np.sqrt(slow[::-1])


def test_graded_frequencies_agree_with_finite_elements():
    wing = hawkmoth("wing.modes=4", *GRADED).wing
    np.testing.assert_allclose(beam.modes(wing).omega, hermite_frequencies(Section.of(wing)), rtol=1e-6)


def measured(*numbers):
    mass, rigidity = numbers
    keys = {"chord": C, "span": H, "modes": 3, "mass_per_length": mass, "flexural_rigidity": rigidity}
    return beam.modes(hawkmoth().override(wing=keys).wing)


def test_a_measured_wing_is_the_same_as_its_material():
    material, found = beam.modes(hawkmoth("wing.modes=3").wing), measured(RHO * T * H, E * H * T**3 / 12)
    for name in ("omega", "lam", "psi", "mass", "first_moment", "second_moment"):
        np.testing.assert_allclose(getattr(found, name), getattr(material, name), rtol=1e-14)


def test_a_measured_table_is_the_same_as_a_modulus_and_a_density_that_vary():
    slopes = ("wing.youngs_modulus=[[0, 30e9], [1, 10e9]]", "wing.density=[[0, 900], [1, 500]]")
    unit = H * T**3 / 12
    found = measured([[0, 900 * T * H], [1, 500 * T * H]], [[0, 30e9 * unit], [1, 10e9 * unit]])
    np.testing.assert_allclose(found.omega, beam.modes(hawkmoth("wing.modes=3", *slopes).wing).omega, rtol=1e-12)


def test_means_of_a_profile_are_its_integrals(rng):
    s = np.concatenate(([0.0], np.sort(rng.random(5)), [1.0]))
    profile = Profile.of(list(zip(s, rng.random(7), strict=True)))
    edges = np.concatenate(([0.0], np.sort(rng.random(6)), [1.0]))
    for mean, a, b in zip(profile.means(edges), edges[:-1], edges[1:], strict=True):
        corners = np.unique(np.clip(np.concatenate(([a, b], s)), a, b))
        assert mean == pytest.approx(np.trapezoid(profile(corners), corners) / (b - a), rel=1e-12)
    np.testing.assert_array_equal(Profile.of(0.3).means(edges), [0.3] * 7)
    assert Profile.of([[0, 2], [1, 2]]).means(edges).dtype == float
    # Whole pieces and parts of them, edges at corners and at both ends.
    table = Profile.of([[0, 1.0], [0.5, 3.0], [1.0, 0.0]])
    np.testing.assert_allclose(table.means(np.array([0.0, 0.25, 0.5, 1.0])), [1.5, 2.5, 1.5], rtol=1e-15)
    assert table.mean == 1.75


@pytest.mark.parametrize("settings", [("wing.modes=0", "wing.pivot=0.3"), ("wing.modes=2",)])
def test_inertial_power_is_the_rate_of_the_kinetic_energy_of_all_points(settings, rng):
    wing = hawkmoth(*GRADED, *settings).wing
    section = beam.modes(wing)
    s, rule = np.polynomial.legendre.leggauss(60)
    pieces = [(a, b) for a, b in zip((0, 0.4, 0.7), (0.4, 0.7, 1), strict=True)]
    at = np.concatenate([a + (b - a) * (s + 1) / 2 for a, b in pieces])
    span, thickness = (np.interp(at, *np.array(table).T) for table in (wing.span, wing.thickness))
    mass = np.concatenate(
        (C * RHO * np.concatenate([(b - a) * rule / 2 for a, b in pieces]) * span * thickness, [3e-6, 1e-6])
    )
    y = C * (np.concatenate((at, [0.55, 1.0])) - wing.pivot)
    phi = section.shape(y)
    a = rng.standard_normal((3 + section.count, 3)) * np.array([[0.02], [0.5], [0.02], *[[1e-5]] * section.count])

    def path(t):
        """Plunge, pitch, surge and amplitudes as cubics of t, with two derivatives."""
        return [a @ powers for powers in ([t, t**2, t**3], [1, 2 * t, 3 * t**2], [0, 2, 6 * t])]

    def places(t):
        (plunge, pitch, surge, *q), _, _ = path(t)
        w = np.array(q) @ phi if q else 0 * y
        return np.array([surge + y * np.cos(pitch) - w * np.sin(pitch), plunge + y * np.sin(pitch) + w * np.cos(pitch)])

    def energy(t, h=1e-4):
        velocity = (8 * (places(t + h) - places(t - h)) - (places(t + 2 * h) - places(t - 2 * h))) / (12 * h)
        return 0.5 * float(mass @ np.sum(velocity**2, axis=0))

    t, h = 0.7, 1e-3
    value, rate, accel = path(t)
    turned = np.cos(value[1]), np.sin(value[1])
    moved = np.array([[*(row[axis] for axis in range(3) for row in (value, rate, accel)), *turned]])
    state = np.array([[value[3:], rate[3:], accel[3:]]])
    found = series.inertial_power(section, moved.T, state.transpose(1, 2, 0))[0]
    if section.count:  # the modes take their own share of the energy: what is left is the actuator's
        theta_rate = rate[1]
        heave = accel[0] * turned[0] - accel[2] * turned[1]
        lifted = section.lam * heave + section.psi * accel[1] - theta_rate**2 * value[3:]
        found += float(rate[3:] @ (accel[3:] + lifted))
    assert found == pytest.approx((energy(t + h) - energy(t - h)) / (2 * h), rel=1e-5)
