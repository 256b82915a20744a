"""The velocity induced by vortices: an oracle, exact point-vortex solutions, invariants."""

import numpy as np
import pytest
from oracle import velocity

from taichiflap.vortex.sum import induced_velocity


def test_matches_a_plain_double_loop(rng):
    points, vortices = rng.normal(size=(2, 29)), rng.normal(size=(3, 53))
    expected = velocity(points.T, vortices.T, core2=0.04)
    np.testing.assert_allclose(induced_velocity(points, vortices, core=0.2).T, expected, rtol=1e-12, atol=1e-13)


def test_shape_of_the_points_is_kept(rng):
    grid, vortices = rng.normal(size=(2, 5, 7)), rng.normal(size=(3, 4))
    flat = induced_velocity(grid.reshape(2, -1), vortices)
    np.testing.assert_array_equal(induced_velocity(grid, vortices), flat.reshape(2, 5, 7))


def test_a_vortex_does_not_move_itself():
    assert induced_velocity([[0.3], [0.1]], [[0.3], [0.1], [2.0]]).tolist() == [[0.0], [0.0]]


def test_no_vortices_no_velocity():
    assert not induced_velocity(np.ones((2, 3)), np.empty((3, 0))).any()


@pytest.mark.parametrize("shapes", [((4, 2), (3, 5)), ((2, 4), (5, 3)), ((), (3, 5))])
def test_points_in_rows_instead_of_columns_are_refused(shapes):
    points, vortices = map(np.ones, shapes)
    with pytest.raises(ValueError, match=r"has the shape \(.*\); give \([23], \.\.\.\)"):
        induced_velocity(points, vortices)


def test_a_point_does_not_depend_on_its_neighbours(rng):
    points, vortices = rng.normal(size=(2, 40)), rng.normal(size=(3, 100))
    alone = np.hstack([induced_velocity(points[:, [i]], vortices) for i in range(40)])
    np.testing.assert_array_equal(induced_velocity(points, vortices), alone)


def test_a_core_halves_the_velocity_at_its_radius():
    bare = induced_velocity([[0.1], [0.0]], [[0.0], [0.0], [1.0]])
    cored = induced_velocity([[0.1], [0.0]], [[0.0], [0.0], [1.0]], core=0.1)
    np.testing.assert_allclose(cored, bare / 2, rtol=1e-15)


def test_counter_clockwise_is_positive():
    u_y, u_z = induced_velocity([[1.0], [0.0]], [[0.0], [0.0], [2 * np.pi]])
    assert (u_y[0], u_z[0]) == pytest.approx((0.0, 1.0))


def drift(vortices, dt, steps, core=0.0):
    """Fourth-order Runge-Kutta march of free vortices."""
    vortices = np.array(vortices, dtype=float)

    def rate(positions):
        return induced_velocity(positions, np.vstack((positions, vortices[2:])), core)

    for _ in range(steps):
        x = vortices[:2]
        a = rate(x)
        b = rate(x + dt / 2 * a)
        c = rate(x + dt / 2 * b)
        d = rate(x + dt * c)
        vortices[:2] = x + dt / 6 * (a + 2 * b + 2 * c + d)
    return vortices


def test_opposite_pair_translates_at_gamma_over_2_pi_d():
    pair = [[0.0, 0.5], [0.0, 0.0], [3.0, -3.0]]
    moved = drift(pair, 0.01, 100)
    speed = 3.0 / (2 * np.pi * 0.5)
    np.testing.assert_allclose(moved[0], [0.0, 0.5], atol=1e-12)
    np.testing.assert_allclose(np.abs(moved[1]), speed, rtol=1e-10)


def test_like_pair_rotates_about_its_centre():
    first, second, distance = 1.0, 2.0, 0.8
    moved = drift([[0.0, distance], [0.0, 0.0], [first, second]], 0.002, 500)
    angle = (first + second) / (2 * np.pi * distance**2)
    centre = distance * second / (first + second)
    expected = centre - centre * np.cos(angle), -centre * np.sin(angle)
    np.testing.assert_allclose(moved[:2, 0], expected, atol=1e-9)


def invariants(vortices, core):
    y, z, strength = vortices
    upper = np.triu_indices(len(y), 1)
    separation2 = ((y[:, None] - y) ** 2 + (z[:, None] - z) ** 2 + core**2)[upper]
    energy = np.sum((strength[:, None] * strength)[upper] * np.log(separation2))
    return np.array([strength @ y, strength @ z, strength @ (y**2 + z**2), energy])


@pytest.mark.parametrize("core", [0.0, 0.1])
def test_a_random_cloud_keeps_its_invariants(rng, core):
    cloud = rng.normal(size=(3, 12))
    before, after = (invariants(v, core) for v in (cloud, drift(cloud, 5e-4, 400, core)))
    np.testing.assert_allclose(after, before, rtol=1e-7, atol=1e-7)
