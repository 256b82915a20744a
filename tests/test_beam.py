"""Modes of a uniform cantilever: closed forms, orthonormality, many modes."""

import numpy as np
import pytest
from conftest import hawkmoth
from scipy.optimize import brentq

from taichiflap import theory
from taichiflap.structure import beam


def quadrature(wing, points=200):
    x, weights = np.polynomial.legendre.leggauss(points)
    return wing.chord * (x + 1) / 2, weights / 2


def test_hawkmoth_frequencies():
    frequency = beam.modes(hawkmoth("wing.modes=3").wing).frequency
    assert frequency.tolist() == pytest.approx([79.96, 501.1, 1403.1], abs=0.05)


def test_roots_are_the_known_ones():
    known = [1.87510406871, 4.69409113297, 7.85475743824, 10.9955407349]
    assert [beam.cantilever_root(k) for k in range(1, 5)] == pytest.approx(known, abs=1e-10)
    # Newton's method and bisection, to the last digits.
    np.testing.assert_allclose([beam.cantilever_root(k) for k in range(1, 21)], theory.cantilever_roots(20), rtol=3e-15)


@pytest.mark.parametrize("count", [1, 3, 8, 20])
def test_modes_are_orthonormal_and_meet_lambda_and_psi(count):
    wing = hawkmoth(f"wing.modes={count}").wing
    section = beam.modes(wing)
    y, weights = quadrature(wing)
    phi = section.shape(y)
    mass = section.mass * weights
    np.testing.assert_allclose((phi * mass) @ phi.T, np.eye(count), atol=1e-10)
    np.testing.assert_allclose(section.lam, phi @ mass, rtol=1e-10, atol=1e-10 * np.sqrt(section.mass))
    np.testing.assert_allclose(
        section.psi, phi @ (y * mass), rtol=1e-10, atol=1e-10 * wing.chord * np.sqrt(section.mass)
    )


def test_lambda_and_psi_are_the_closed_forms():
    section = beam.modes(hawkmoth("wing.modes=4").wing)
    brackets = [(1.5, 2.5), (4.0, 5.5), (7.0, 8.5), (10.0, 12.0)]
    beta = np.array([brentq(lambda b: np.cos(b) * np.cosh(b) + 1, *ends, xtol=1e-15) for ends in brackets])
    sigma = (np.sinh(beta) - np.sin(beta)) / (np.cosh(beta) + np.cos(beta))
    unit = np.sqrt(section.mass)
    np.testing.assert_allclose(section.lam, 2 * sigma / beta * unit, rtol=1e-10)
    np.testing.assert_allclose(section.psi, 2 / beta**2 * unit * 0.02, rtol=1e-10)


def test_shapes_are_clamped_at_the_leading_edge_and_two_at_the_tip():
    section = beam.modes(hawkmoth("wing.modes=20").wing)
    at_ends = section.shape([0.0, 0.02]) * np.sqrt(section.mass)
    np.testing.assert_allclose(at_ends[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.abs(at_ends[:, 1]), 2.0, rtol=1e-12)


def test_mass_constants():
    section = beam.modes(hawkmoth().wing)
    assert section.mass == pytest.approx(40e-6)
    assert section.first_moment == pytest.approx(40e-6 * 0.01)
    assert section.second_moment == pytest.approx(40e-6 * 0.02**2 / 3)


@pytest.mark.parametrize("pivot", [0.0, 0.25, 1.0])
def test_a_rigid_plate_has_the_moments_of_a_rod_about_its_pivot(pivot):
    """Parallel axis theorem."""
    section = beam.modes(hawkmoth("wing.modes=0", f"wing.pivot={pivot}").wing)
    arm = 0.02 * (0.5 - pivot)
    assert section.first_moment == pytest.approx(40e-6 * arm, rel=1e-14, abs=1e-25)
    assert section.second_moment == pytest.approx(40e-6 * (0.02**2 / 12 + arm**2), rel=1e-14)


def test_places_in_single_precision_are_computed_with_in_double():
    section, y = beam.modes(hawkmoth("wing.modes=3").wing), np.array([0.001, 0.013], np.float32)
    np.testing.assert_array_equal(section.shape(y), section.shape(y.astype(float)))
    np.testing.assert_array_equal(section.slope(y), section.slope(y.astype(float)))


def test_damping_ratio_of_each_mode():
    assert beam.modes(hawkmoth("wing.modes=2", "wing.damping_ratio=[0.1, 0.2]").wing).damping_ratio.tolist() == [
        0.1,
        0.2,
    ]
    assert beam.modes(hawkmoth("wing.modes=2").wing).damping_ratio.tolist() == [0.05, 0.05]


def test_a_rigid_wing_has_no_modes():
    section = beam.modes(hawkmoth("wing.modes=0").wing)
    assert section.count == 0
    assert section.shape([0.0, 0.01]).shape == (0, 2)


def test_slopes_are_the_derivatives_of_the_shapes():
    section = beam.modes(hawkmoth("wing.modes=12").wing)
    y = section.chord * np.linspace(0.01, 0.99, 50)
    h = 1e-5 * section.chord
    expected = (section.shape(y + h) - section.shape(y - h)) / (2 * h)
    np.testing.assert_allclose(section.slope(y), expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())
    assert np.abs(section.slope([0.0])).max() < 1e-10 * np.abs(expected).max()
