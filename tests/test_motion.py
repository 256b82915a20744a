"""Prescribed motion: values, and derivatives exact to round-off."""

import numpy as np
from conftest import hawkmoth

from taichiflap import motion

STEP = 1e-30


def test_derivatives_match_the_complex_step():
    prescribed = hawkmoth("motion.pitch.mean_deg=7.0", "motion.pitch.phase_deg=20.0").motion
    times = np.linspace(0.0, 0.1, 57)
    moved = motion.sample(prescribed, times)
    stepped = motion.sample(prescribed, times + 1j * STEP).imag / STEP
    for value in (motion.PLUNGE, motion.PLUNGE_RATE, motion.PITCH, motion.PITCH_RATE):
        scale = np.abs(moved[:, value + 1]).max()
        np.testing.assert_allclose(stepped[:, value], moved[:, value + 1], atol=1e-14 * scale)


def test_the_papers_stroke_starts_at_reversal_with_the_chord_upright():
    z, z_rate, _, theta, theta_rate, _ = motion.sample(hawkmoth().motion, np.array([0.0]))[0]
    assert z == 0.02
    assert abs(z_rate) < 1e-14
    assert theta == 0.0
    np.testing.assert_allclose(theta_rate, np.radians(15.0) * 2 * np.pi * 25.0)
