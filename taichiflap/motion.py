"""Prescribed motion of the leading edge: plunge Z and pitch theta, with exact first and second derivatives.

Table 2 of Reade & Jankauski (2020). A motion is sampled once, at all the steps of a case, before the march.
"""

import math

import numpy as np
from numpy.typing import NDArray

from .sections.motion import Motion

PLUNGE, PLUNGE_RATE, PLUNGE_ACCEL, PITCH, PITCH_RATE, PITCH_ACCEL = range(6)
"""Columns of a sampled motion."""


def sample(motion: Motion, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Motion at `times` (s).

    Returns:
        Shape (times, 6): Z (m), dZ/dt, d2Z/dt2, theta (rad), dtheta/dt, d2theta/dt2.
    """
    plunge = _harmonic(times, motion.frequency, motion.plunge.amplitude, motion.plunge.phase_deg)
    pitch = _harmonic(times, motion.frequency, math.radians(motion.pitch.amplitude_deg), motion.pitch.phase_deg)
    pitch[:, 0] += math.radians(motion.pitch.mean_deg)
    return np.hstack((plunge, pitch))


def _harmonic(times: NDArray[np.float64], frequency: float, amplitude: float, phase_deg: float) -> NDArray[np.float64]:
    """`amplitude * sin(2 pi frequency t + phase)` and its two derivatives, shape (times, 3)."""
    rate = 2.0 * math.pi * frequency
    angle = rate * times + math.radians(phase_deg)
    sine, cosine = np.sin(angle), np.cos(angle)
    return amplitude * np.stack((sine, rate * cosine, -(rate**2) * sine), axis=1)
