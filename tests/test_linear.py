"""Dense linear solves inside kernels compared with LAPACK."""

import numpy as np
import pytest

from taichiflap.kernels.linear import octets, solve, solve_few
from taichiflap.kernels.runtime import Floats3, Octet, Octets2, Octets3, start, ti, view


@ti.kernel
def solve_all(a: Octets3, x: Floats3, factor: Octets2):
    for i in range(1):
        for b in range(a.shape[0]):
            solve(a, x, factor, b, x.shape[2], x.shape[1])


def solve_systems(matrix, rhs):
    """Solutions of a batch of systems, shape (systems, n, columns), by the solver's elimination."""
    start()
    x = np.ascontiguousarray(np.swapaxes(rhs, 1, 2))
    systems, _, n = x.shape
    a = ti.ndarray(Octet, (systems, 8 * octets(n), octets(n) + octets(x.shape[1])))
    rows = view(a).reshape(systems, 8 * octets(n), -1)
    rows[:] = 0.0
    rows[:, :n, :n] = matrix
    solve_all(a, x, ti.ndarray(Octet, (systems, 8 * octets(n))))
    return np.swapaxes(x, 1, 2)


@pytest.mark.parametrize("n", [1, 2, 7, 8, 9, 16, 50])
@pytest.mark.parametrize("r", [1, 3, 9])
def test_matches_lapack_on_random_systems(rng, n, r):
    matrix, rhs = rng.normal(size=(3, n, n)), rng.normal(size=(3, n, r))
    expected = np.linalg.solve(matrix, rhs)
    error = np.linalg.norm(solve_systems(matrix, rhs) - expected) / np.linalg.norm(expected)
    assert error < 1e-12 * np.linalg.cond(matrix).max()


def test_pivots_where_the_diagonal_is_zero():
    matrix = np.array([[[0.0, 2.0, 0.0], [0.0, 0.0, 3.0], [4.0, 0.0, 0.0]]])
    solution = solve_systems(matrix, np.array([[[2.0], [3.0], [4.0]]]))
    np.testing.assert_array_equal(solution, np.ones((1, 3, 1)))


@ti.kernel
def solve_all_few(a: Floats3, n: ti.i32):
    for i in range(1):
        for b in range(a.shape[0]):
            solve_few(a, b, n)


@pytest.mark.parametrize("n", [0, 1, 2, 5, 8])
def test_few_unknowns_match_lapack(rng, n):
    start()
    matrix = rng.normal(size=(4, n, n)) + 4 * np.eye(n)
    rhs = rng.normal(size=(4, n, 1))
    a = np.concatenate((matrix, rhs), axis=2)
    if n:
        solve_all_few(a, n)
    np.testing.assert_allclose(a[:, :, n:], np.linalg.solve(matrix, rhs), rtol=1e-11, atol=1e-12)
