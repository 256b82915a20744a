"""The same UVLM in NumPy: the test suite's independent march, its sum over pairs written with whole arrays."""

import numpy as np

from taichiflap.case.case import Case
from tests import oracle


def velocity(points: np.ndarray, vortices: np.ndarray, core2: np.ndarray | float = 0.0) -> np.ndarray:
    """Velocity (n, 2) at points (n, 2) of squared cores `core2` from vortices (m, 3), or (m, 4) with theirs."""
    points, vortices = np.asarray(points), np.asarray(vortices)
    if not len(vortices):
        return np.zeros((len(points), 2))
    dy = points[:, :1] - vortices[:, 0]
    dz = points[:, 1:] - vortices[:, 1]
    r2 = dy * dy + dz * dz + np.broadcast_to(core2, len(points))[:, None]
    if vortices.shape[1] > 3:
        r2 += vortices[:, 3]
    with np.errstate(divide="ignore"):
        strength = np.where(r2 > 0.0, vortices[:, 2] / r2, 0.0) / (2.0 * np.pi)
    return np.stack((-np.sum(dz * strength, axis=1), np.sum(dy * strength, axis=1)), axis=1)


def march(case: Case) -> np.ndarray:
    """Modal amplitudes (step, mode) of a case, step by step."""
    looped = oracle.velocity
    oracle.velocity = velocity
    try:
        return np.array([frame["q"] for frame in oracle.UvlmOracle(case).march(case.steps).history])
    finally:
        oracle.velocity = looped
