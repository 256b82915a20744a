"""Statistics of synthetic and of real runs."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import hawkmoth

import taichiflap
from taichiflap import metrics


def synthetic(case, **series):
    """A result-like object with the given functions of time."""
    time = case.step * np.arange(0, case.steps + 1, case.output.every)
    names = (
        "tip_deflection", "force_normal", "force_vertical", "force_vertical_normal", "power", "power_aerodynamic",
        "power_inertial",
    )  # fmt: skip
    values = {name: series.get(name, np.zeros_like)(time) for name in names}
    return SimpleNamespace(case=case, time=time, **values)


def test_means_and_spread_over_the_last_five_beats():
    case = hawkmoth("time.periods=12")
    beat = lambda t: np.ceil(np.round(t * 25.0, 9))  # noqa: E731
    summary = metrics.summarise(synthetic(case, force_vertical=beat, power=lambda t: np.sin(50 * np.pi * t)))
    assert summary.beats == 5
    assert summary.force_vertical.mean == pytest.approx(10.0)
    assert summary.force_vertical.spread == pytest.approx(np.std([8, 9, 10, 11, 12]))
    assert summary.power.mean == pytest.approx(0.0, abs=1e-12)
    assert summary.power_positive.mean == pytest.approx(1 / np.pi, rel=1e-3)


@pytest.mark.parametrize("every", [1, 3, 7])
@pytest.mark.parametrize(("lag", "phase"), [(0.0, 0.0), (30.0, -30.0), (200.0, 160.0)])
def test_phase_of_the_first_harmonic_to_the_stroke(lag, phase, every):
    case = hawkmoth("time.periods=14", f"output.every={every}", "motion.plunge.phase_deg=90.0")

    def force(t):
        stroke = 50 * np.pi * t + np.pi / 2
        return 3.0 * np.sin(stroke - np.radians(lag)) + np.sin(3 * stroke)

    tolerance = 1e-9 if every == 1 else 1.5
    summary = metrics.summarise(synthetic(case, force_normal=force))
    assert summary.force_normal_phase == pytest.approx(phase, abs=tolerance)


def test_harmonics_are_recovered_exactly():
    case = hawkmoth()
    time = case.step * np.arange(1, 401)
    values = 2.0 * np.cos(50 * np.pi * time + 0.3) + 0.5 * np.cos(150 * np.pi * time - 1.0) + 7.0
    assert metrics.harmonic(case, time, values) == pytest.approx(2.0 * np.exp(0.3j))
    assert metrics.harmonic(case, time, values, 3) == pytest.approx(0.5 * np.exp(-1j))


def test_peak_and_its_time_after_reversal():
    case = hawkmoth("motion.plunge.phase_deg=0.0")
    summary = metrics.summarise(synthetic(case, tip_deflection=lambda t: 0.007 * np.cos(50 * np.pi * (t - 0.012))))
    assert summary.tip_peak.mean == pytest.approx(0.007)
    assert summary.tip_peak_time % 0.5 == pytest.approx(0.3)
    assert summary.tip_peak_after_reversal == pytest.approx(0.05)


@pytest.mark.parametrize(("beats", "after"), [(0.0, 0.0), (0.115, 0.115), (0.5, 0.0), (7.63, 0.13)])
def test_reversal_of_the_papers_stroke_is_at_0_and_a_half(beats, after):
    assert metrics.after_reversal(hawkmoth(), beats) == pytest.approx(after)


def test_no_summary_before_the_first_beat_is_whole():
    case = hawkmoth()
    time = case.step * np.arange(150)
    assert metrics.summarise(SimpleNamespace(case=case, time=time)) is None


def test_a_still_wing_has_no_phase():
    case = hawkmoth("motion.plunge.amplitude=0.0", "motion.pitch.amplitude_deg=0.0", "time.periods=2")
    summary = metrics.summarise(taichiflap.simulate(case))
    assert summary.force_normal_phase is None
    assert summary.tip_peak_after_reversal is None
    assert summary.tip_peak.mean == 0.0
