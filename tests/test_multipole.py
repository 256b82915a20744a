"""The tree compared with the sum over all pairs, and long wakes with short ones."""

import numpy as np
import pytest
from conftest import hawkmoth, march

import taichiflap
from taichiflap.fluids.uvlm import long_wake, wake
from taichiflap.kernels.runtime import LANE, Floats3, start, ti, view
from taichiflap.vortex import multipole
from taichiflap.vortex.multipole import LEAF, ORDER, Tree, expand, induce_by_tree, octet_at
from taichiflap.vortex.sum import TINY, Y, Z, induced_velocity, store_octet

CORE = 0.01


@ti.kernel
def grow(tree: Tree, leaves: ti.i32):
    for i in range(LANE):
        if i == 0:
            for m in range(1, 2 * leaves):
                expand(tree, 0, m)


@ti.kernel
def velocities(tree: Tree, found: Floats3, count: ti.i32):
    for i in range(LANE):
        if i == 0:
            for block in range(count // 8):
                y = octet_at(tree.source, 0, Y, 8 * block, count)
                z = octet_at(tree.source, 0, Z, 8 * block, count)
                u_y, u_z = induce_by_tree(y, z, ti.Vector([CORE * CORE + TINY] * 8), tree, 0)
                store_octet(found, 0, Y, 8 * block, u_y)
                store_octet(found, 0, Z, 8 * block, u_z)


def planted(cloud, error):
    start()
    tree = multipole.allocate(1, cloud.shape[1])
    vortices = np.vstack((cloud, np.full(cloud.shape[1], CORE**2)))
    multipole.sort(tree, 0, vortices, error)
    grow(tree, int(view(tree.leaves)[0]))
    return tree


def clusters(rng, count):
    """Vortices in rolled-up clusters, as in a wake."""
    centres = 3.0 * rng.normal(size=(2, 12))
    points = centres[:, rng.integers(0, 12, count)] + 0.2 * rng.normal(size=(2, count))
    return np.vstack((points, rng.normal(size=count)))


@pytest.mark.parametrize("error", [1e-1, 1e-3, 1e-6])
@pytest.mark.parametrize("count", [8, 256, 1000])
def test_no_velocity_is_further_off_than_allowed(rng, count, error):
    cloud = clusters(rng, count)
    tree = planted(cloud, error)
    found = np.zeros((1, 2, count))
    velocities(tree, found, count)
    theirs = induced_velocity(cloud[:2], cloud, np.sqrt(2.0) * CORE)[:, view(tree.order)[0, :count]]
    off = np.hypot(*(found[0] - theirs)).max()
    assert off <= error
    assert count < 1000 or error < 1e-3 or off > 1e-12, "no node was distant: the tree did nothing"


def test_moments_and_circles(rng):
    cloud = clusters(rng, 100)
    tree = planted(cloud, 1.0)
    zeta = (view(tree.source)[0, Y] + 1j * view(tree.source)[0, Z])[:100]
    strength = view(tree.source)[0, 2, :100]
    for node, stretch in ((1, slice(0, 100)), (4, slice(0, LEAF)), (7, slice(3 * LEAF, 100))):
        c_y, c_z, radius, cores = view(tree.node)[0, node]
        away = zeta[stretch] - (c_y + 1j * c_z)
        assert radius == pytest.approx(np.abs(away).max(), rel=1e-14)
        assert cores == CORE**2
        moments = np.array([np.sum(strength[stretch] * away**m) for m in range(ORDER)])
        found = view(tree.moment)[0, node, ::2] + 1j * view(tree.moment)[0, node, 1::2]
        np.testing.assert_allclose(found, moments, rtol=1e-11, atol=1e-11 * np.abs(moments).max())


def test_the_curve_keeps_neighbours_together(rng):
    cloud = rng.uniform(size=(3, 1024))
    radius = view(planted(cloud, 1.0).node)[0, 32:64, 2]
    assert radius.mean() < 0.2, "a leaf of 32 of 1024 points in a square of side 1"


def test_a_wide_march_gives_the_bits_of_a_fused_one(monkeypatch):
    case = hawkmoth("uvlm.wake=all", "time.periods=1", "uvlm.panels=9")
    fused, _ = march(case)
    monkeypatch.setattr(long_wake, "WIDE", 60)
    for block in (1000, 7):
        wide, marched = march(case, block=block)
        assert marched.flow.first == 60
        for name, values in vars(fused).items():
            np.testing.assert_array_equal(getattr(wide, name), values, err_msg=name)


@pytest.mark.slow
def test_a_march_by_tree_is_itself_in_any_company_and_near_the_sum_over_pairs(monkeypatch):
    monkeypatch.setattr(long_wake, "FAR", 60)
    settings = ("uvlm.wake=all", "time.periods=1", "uvlm.panels=9", "uvlm.core=0.02")
    exact, treed = hawkmoth(*settings), hawkmoth(*settings, "uvlm.far_error=1e-4")
    pairs, _ = march(exact)
    alone, marched = march(treed)
    error = view(marched.groups["wake"].scalar)[0, wake.FAR_ERROR]
    assert 0.0 < error < 1e-4 * long_wake.typical_speed_of(treed)
    np.testing.assert_allclose(alone.force, pairs.force, atol=1e-4 * np.abs(pairs.force).max())
    assert not np.array_equal(alone.force, pairs.force)
    for threads in (1, None):
        together, _ = march([exact, treed], threads=threads)
        np.testing.assert_array_equal(together[0].force, pairs.force)
        np.testing.assert_array_equal(together[1].force, alone.force)


@pytest.mark.slow
def test_the_error_found_is_in_the_result_of_a_case_that_allows_one(monkeypatch):
    monkeypatch.setattr(long_wake, "FAR", 60)
    case = hawkmoth("uvlm.wake=all", "time.periods=1", "uvlm.panels=9", "uvlm.far_error=1e-3", "uvlm.core=0.02")
    found = taichiflap.simulate(case)
    error = found.wake_far_error
    assert np.all(np.diff(error) >= 0.0)
    assert error[59] == 0.0 < error[-1] < 1e-3 * long_wake.typical_speed_of(case)
    assert taichiflap.summarise(found).wake_far_error == error[-1]
    assert "wake_far_error" not in taichiflap.simulate(case.override("uvlm.far_error=0")).variables
