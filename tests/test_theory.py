"""The lattice compared with exact theory of a plate in a stream: Wagner's start and Theodorsen's plunge.

Tolerances are what uniform panels with the local shedding rule reach; with the paper's fixed distance
the errors are 16 % and 27 %, which a test here also shows.
"""

import numpy as np
import pytest
from conftest import hawkmoth, march
from scipy.special import hankel2

from taichiflap import theory
from taichiflap.march.state import MOMENT, NORMAL
from taichiflap.validation import oscillation
from taichiflap.validation.checks import accurate, run

CHORD, SPAN, DENSITY = 0.02, 0.05, 1.225
WAGNER = {1: 0.6006056, 2: 0.6692896, 5: 0.7882032, 10: 0.8750447, 20: 0.9366493}
STREAM = ("wing.modes=0", "fluid.velocity=[1.0, 0.0]", "uvlm.wake=all", "motion.pitch.amplitude_deg=0.0")


def wagner_errors(shedding, panels, travel, *settings):
    """Relative errors of the lift after a sudden start, at the s of the table; `travel` in chords a step."""
    alpha_deg = 0.1
    steps = round(10.5 / travel)
    case = hawkmoth(
        *STREAM, "motion.plunge.amplitude=0.0", f"motion.pitch.mean_deg={-alpha_deg}", "time.periods=1",
        f"motion.frequency={1 / (steps * travel * CHORD)}", f"time.steps_per_period={steps}",
        f"uvlm.panels={panels}", f"uvlm.shedding={shedding}", *settings,
    )  # fmt: skip
    frames, _ = march(case)
    steady = 0.5 * DENSITY * CHORD * SPAN * 2 * np.pi * np.radians(alpha_deg)
    lift = np.interp(list(WAGNER), 2 * frames.step * travel, frames.force[:, NORMAL] / steady)
    return lift / list(WAGNER.values()) - 1


def theodorsen_error(shedding, panels, k):
    """Relative error in amplitude, and error in phase (degrees), of the lift of a plunging plate."""
    half, omega = CHORD / 2, 2 * k / CHORD
    amplitude = 1e-3 * CHORD
    case = hawkmoth(
        *STREAM, f"motion.plunge.amplitude={amplitude}", "motion.plunge.phase_deg=0.0",
        f"motion.frequency={omega / (2 * np.pi)}", "time.periods=4", f"uvlm.panels={panels}",
        f"uvlm.shedding={shedding}",
    )  # fmt: skip
    frames, _ = march(case)
    last = frames.step[-200:] * case.step
    lift = 2 * np.mean(frames.force[-200:, NORMAL] * np.exp(-1j * omega * last))
    plunge = -1j * amplitude
    deficiency = hankel2(1, k) / (hankel2(1, k) + 1j * hankel2(0, k))
    exact = np.pi * DENSITY * SPAN * half * plunge * (half * omega**2 - 2j * omega * deficiency)
    return abs(lift / exact) - 1, np.degrees(np.angle(lift / exact))


def test_wagner():
    errors = np.abs(wagner_errors("local", 50, 0.02))
    assert errors.max() < 0.01
    assert errors[-1] < 1e-3


@pytest.mark.parametrize(
    ("k", "amplitude", "phase"), [(0.1, 0.01, 0.5), (0.5, 0.01, 0.5), (1, 0.02, 0.5), (2, 0.03, 0.6)]
)
def test_theodorsen_in_plunge(k, amplitude, phase):
    error, lag = theodorsen_error("local", 50, k)
    assert abs(error) < amplitude
    assert abs(lag) < phase


def test_finer_panels_bring_theodorsen_closer():
    errors = [abs(theodorsen_error("local", panels, 1.0)[0]) for panels in (12, 25, 50)]
    assert errors[0] > 1.7 * errors[1] > 1.7**2 * errors[2]


def test_the_papers_fixed_distance_is_inconsistent():
    assert wagner_errors("fixed", 50, 0.02)[0] == pytest.approx(0.16, abs=0.02)
    assert theodorsen_error("fixed", 50, 1.0)[0] == pytest.approx(0.27, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(("panels", "amplitude", "phase"), [(20, 0.5, 0.5), (12, 2.0, 1.0)])
def test_defaults_meet_theodorsen(panels, amplitude, phase):
    """Per cent and degrees, k = 0.1 to 2, at 200 steps a period."""
    pairs = [(name, k) for name in oscillation.MOTIONS for k in (0.1, 0.3, 1.0, 2.0)]
    cases = [oscillation.oscillating(name, k, accurate(panels)) for name, k in pairs]
    for (name, k), case, history in zip(pairs, cases, run(cases), strict=True):
        ratio = oscillation.loads(case, history).lift / oscillation.exact(name, k).lift
        assert 100 * abs(abs(ratio) - 1) < amplitude, (name, k)
        assert abs(np.degrees(np.angle(ratio))) < phase, (name, k)


@pytest.mark.parametrize(("panels", "bound"), [(20, 0.007), (12, 0.02)])
def test_defaults_meet_wagner(panels, bound):
    settings = ("spacing=cosine", "loads=vortices", "convection=second_order", "core=0.02", "core_growth=0.1")
    assert np.abs(wagner_errors("local", panels, 0.02, *(f"uvlm.{one}" for one in settings))).max() < bound


@pytest.mark.parametrize(("k", "pivot"), [(0.1, 0.25), (1.0, 0.25), (0.5, 0.5)])
def test_theodorsen_in_pitch_about_a_pivot(k, pivot):
    omega, amplitude = 2 * k / CHORD, np.radians(0.05)
    case = hawkmoth(
        *STREAM[:3], "motion.plunge.amplitude=0.0", f"motion.pitch.amplitude_deg={np.degrees(amplitude)}",
        "motion.pitch.phase_deg=180.0", f"motion.frequency={omega / (2 * np.pi)}", "time.periods=4", "uvlm.panels=50",
        "uvlm.shedding=local", f"wing.pivot={pivot}",
    )  # fmt: skip
    frames, _ = march(case)
    turn = np.exp(-1j * omega * frames.step[-200:] * case.step) / (0.5 * DENSITY * CHORD * SPAN)
    lift = 2 * np.mean(frames.force[-200:, NORMAL] * turn)
    nose_up = -2 * np.mean(frames.force[-200:, MOMENT] * turn) / CHORD
    exact = theory.oscillating_loads(k, pitch=-1j * amplitude, axis=pivot)
    assert abs(lift / exact[0] - 1) < 0.02
    assert abs(nose_up - exact[1]) < 0.01 * abs(exact[0])  # the force acts within 1 % of the chord of where it should
