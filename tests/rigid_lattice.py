"""The paper's lattice for a rigid wing in NumPy: with Eq. 32 taken literally, or as the solver has it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taichiflap.case.case import Case
from taichiflap.motion import sampling
from taichiflap.motion.sampling import PITCH, PITCH_RATE, PLUNGE, PLUNGE_RATE
from taichiflap.structure.chordwise import Profile
from taichiflap.vortex.sum import induced_velocity

Array = NDArray[np.float64]
Points = NDArray[np.complex128]


@dataclass(frozen=True)
class Flight:
    """Forces of a rigid wing, shape (steps + 1,): `normal` along e_z and its vertical share, N; times, s."""

    time: Array
    normal: Array
    vertical: Array


def fly(case: Case, *, still: bool = False, heard: int | None = None) -> Flight:
    """March a rigid wing with uniform panels, points for vortices and the fixed shedding distance, in still air.

    Args:
        still: leave every vortex where it was shed.
        heard: number of youngest wake vortices that contribute to the wake's velocity (Eq. 32); None for all.
    """
    panels, chord, size = case.uvlm.panels, case.wing.chord, case.wing.chord / case.uvlm.panels
    kept = case.steps + 1 if case.uvlm.wake == "all" else case.uvlm.wake
    bound, control = ((np.arange(panels) + place) * size for place in (0.25, 0.75))
    shed = chord * (1.0 + case.uvlm.shedding_distance)
    strength = case.fluid.density * Profile.of(case.wing.span).mean
    time: Array = case.step * np.arange(case.steps + 1, dtype=np.float64)
    moved = sampling.sample(case.motion, time)
    # No penetration at every control point, and constant total circulation (Eq. 31); the matrix is constant.
    matrix = np.ones((panels + 1, panels + 1))
    matrix[:-1] = 1.0 / (2.0 * math.pi * (control[:, None] - np.append(bound, shed)))
    solve = np.linalg.inv(matrix)

    wake, circulation = np.empty(0, complex), np.empty(0)
    drift = np.empty(0, complex)
    total, sums = 0.0, np.zeros((2, panels))
    normal = np.zeros(len(time))
    for n, (pitch, rate, plunge, speed) in enumerate(moved[:, [PITCH, PITCH_RATE, PLUNGE, PLUNGE_RATE]]):
        turn = np.exp(1j * pitch)
        if not still:
            wake = wake + case.step * drift
        if len(wake) == kept:
            wake, circulation = wake[1:], circulation[1:]
        of_wake = induced(1j * plunge + turn * control, wake, circulation) / turn
        across = speed * math.cos(pitch) + rate * control - of_wake.imag
        solution = solve @ np.append(across, total)
        bound_now, total = solution[:-1], float(solution[:-1].sum())
        wake = np.append(wake, 1j * plunge + turn * shed)
        circulation = np.append(circulation, solution[-1])
        running = np.cumsum(bound_now)
        tangential = of_wake.real - speed * math.sin(pitch)
        growth = (0.0 * running, running - sums[0], 1.5 * running - 2.0 * sums[0] + 0.5 * sums[1])[min(n, 2)]
        normal[n] = -strength * float(np.sum(tangential * bound_now + size * growth / case.step))
        sums = np.stack((running, sums[0]))
        if not still:
            first = 0 if heard is None else max(0, len(wake) - heard)
            sources = np.append(wake[first:], 1j * plunge + turn * bound)
            drift = induced(wake, sources, np.append(circulation[first:], bound_now))
    return Flight(time, normal, normal * np.sin(moved[:, PITCH]))


def induced(targets: Points, sources: Points, circulation: Array) -> Points:
    """Velocity u_y + i u_z (m/s) at each target (Eq. 30). A vortex induces none on itself."""
    u_y, u_z = induced_velocity((targets.real, targets.imag), (sources.real, sources.imag, circulation), threads=1)
    return u_y + 1j * u_z
