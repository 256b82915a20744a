"""Every shipped case runs and gives its number; the hawkmoth's are the ones that its physics asks for."""

import numpy as np
import pytest
from conftest import CASES, hawkmoth

import taichiflap

pytestmark = pytest.mark.slow

PEAK_TIP_MM = {"hawkmoth": 7.80, "hawkmoth_dbet": 7.613}


def test_every_case_has_its_number():
    assert {file.stem for file in CASES.glob("*.toml")} == set(PEAK_TIP_MM)


@pytest.mark.parametrize("name", PEAK_TIP_MM)
def test_case(name):
    summary = taichiflap.summarise(taichiflap.simulate(taichiflap.load_case(CASES / f"{name}.toml")))
    assert 1e3 * summary.tip_peak.mean == pytest.approx(PEAK_TIP_MM[name], rel=0.01)


@pytest.mark.parametrize(
    ("settings", "quantity", "expected", "tolerance"),
    [
        (("solver=dbet", "wing.modes=0"), "force_vertical_normal", 2.78e-3, 0.02),
        (("solver=dbet", "wing.modes=0"), "force_vertical", 2.52e-3, 0.02),
        (("solver=dbet",), "force_vertical", 3.08e-3, 0.03),
        (("solver=dbet",), "tip_peak", 7.6e-3, 0.03),
        (("wing.modes=0",), "force_vertical", 3.12e-3, 0.03),
        ((), "force_vertical", 7.2e-3, 0.05),
        ((), "force_vertical_normal", 3.7e-3, 0.05),
        ((), "tip_peak", 7.7e-3, 0.03),
    ],
)
def test_hawkmoth_agrees_with_independent_prototypes(settings, quantity, expected, tolerance):
    summary = taichiflap.summarise(taichiflap.simulate(hawkmoth(*settings)))
    assert getattr(summary, quantity).mean == pytest.approx(expected, rel=tolerance)


def test_peak_tip_deflection_comes_shortly_after_reversal():
    for settings in ((), ("solver=dbet",)):
        summary = taichiflap.summarise(taichiflap.simulate(hawkmoth(*settings)))
        assert summary.tip_peak_after_reversal == pytest.approx(0.11, abs=0.015)


def test_a_longer_wake_lowers_the_rigid_force():
    means = [
        taichiflap.summarise(taichiflap.simulate(hawkmoth("wing.modes=0", f"uvlm.wake={wake}"))).force_vertical.mean
        for wake in (200, 400, 1000)
    ]
    np.testing.assert_allclose(means, [3.1e-3, 2.8e-3, 2.7e-3], rtol=0.03)
