"""Every shipped case runs and gives its number."""

import numpy as np
import pytest
from conftest import CASES, hawkmoth
from taichiflap_viewer.frames import Run

import taichiflap
from taichiflap import theory
from taichiflap.case.case import parse_case
from taichiflap.case.uvlm import Uvlm
from taichiflap.metrics import beats, waves

pytestmark = pytest.mark.slow

NUMBERS = {
    # case: (quantity of the summary, its mean in SI units, tolerance). In hover the wake that a wing meets again is
    # chaotic: one bit more or less moves such a mean by a good part of its spread.
    "hawkmoth": ("tip_peak", 7.80e-3, 0.01),
    "hawkmoth_dbet": ("tip_peak", 7.613e-3, 0.001),
    "fruitfly": ("force_vertical", 3.6e-6, 0.05),
    "graded_wing": ("force_vertical", 4.9e-3, 0.07),
    "soft_wing": ("tip_peak", 8.6e-3, 0.04),
    "heaving_plate": ("tip_peak", 1.216e-3, 0.01),
    "pitch_ramp": ("force_normal_peak", 0.851, 0.01),
    "plunging_foil": ("force_normal_peak", 1.609, 0.01),
    "pitch_up": ("force_normal_peak", 3.867, 0.01),
    "hovering_plate": ("force_vertical", 2.02, 0.04),
    "hovering_ellipse": ("force_vertical", 1.682e-4, 0.01),  # a lift coefficient of 0.568; published 0.586 and 0.589
    "hawkmoth_ns": ("tip_peak", 7.46e-3, 0.02),
    "tabulated_stroke": ("tip_peak", 10.09e-3, 0.02),
    "measured_moth": ("force_vertical", 13.58e-3, 0.001),
}


def simulated(name, *settings):
    return taichiflap.simulate(taichiflap.load_case(CASES / f"{name}.toml", settings))


def test_every_case_has_its_number():
    assert {file.stem for file in CASES.glob("*.toml")} == set(NUMBERS)


@pytest.mark.parametrize("name", NUMBERS)
def test_case(name):
    quantity, expected, tolerance = NUMBERS[name]
    result = simulated(name)
    assert getattr(taichiflap.summarise(result), quantity).mean == pytest.approx(expected, rel=tolerance)
    run = Run(result, name)
    assert np.isfinite(run.frame(result.frames - 1).nodes).all()
    run.close()


def test_the_plunging_foils_lift_is_theodorsens():
    result = simulated("plunging_foil")
    frames = beats.settled_beats(result).frames
    lift = waves.harmonic(result.case, result.time[frames], result.force_z[frames])
    lift /= 0.5 * 998.0 * 0.2**2 * 0.1 * 0.4
    exact, _ = theory.oscillating_loads(0.393, plunge=0.5)
    # Linear theory, and half a chord is no small amplitude.
    assert abs(lift) == pytest.approx(abs(exact), rel=0.05)
    assert np.angle(lift / exact, deg=True) == pytest.approx(0.0, abs=2.0)


def test_the_plate_that_pitches_up_lifts_as_the_viscous_computation_says():
    """Lift and drag coefficients of Eldredge's vortex particles at five times, until the vortex is shed."""
    result = simulated("pitch_up")
    at = np.array([1.5, 2.0, 2.5, 3.0, 3.5])
    lift, drag = (np.interp(at, result.time, 2.0 * force) for force in (result.force_z, result.force_y))
    np.testing.assert_allclose(lift, [5.65, 2.19, 2.85, 2.62, 2.10], rtol=0.08)
    np.testing.assert_allclose(drag, [2.21, 1.75, 2.67, 2.52, 2.15], rtol=0.14)
    # Its suction never passes the limit, but for the last bits of a decision at expected rates.
    assert np.abs(result.suction_velocity).max() <= 0.11 * (1.0 + 1e-9)


def test_the_hovering_plate_has_its_coefficients():
    """Values of this model: the lift is 40 % above that of viscous computations."""
    result = simulated("hovering_plate")
    pressure = 0.5 * (2.0 * np.pi * 0.25 * 1.4) ** 2
    settled = slice(400, None)
    speed = np.gradient(result.plunge, result.time)
    assert -result.force_y[settled].mean() / pressure == pytest.approx(0.835, rel=0.04)
    drag = -result.force_z * np.sign(speed) / pressure
    assert drag[settled].mean() == pytest.approx(1.276, rel=0.04)
    assert result.leading_edge_sheds.mean() == 1.0
    assert 0.3 < result.wake(-1)["edge"].mean() < 0.7


def test_a_table_of_a_stroke_is_as_good_as_its_formula():
    """41 points of the waveforms in the comment of the case."""
    table = simulated("tabulated_stroke")
    document = table.case.to_dict()
    document["motion"] = {
        "frequency": 25.0,
        "plunge": {"kind": "triangle", "amplitude": 0.02, "sharpness": 0.7, "phase_deg": 90.0},
        "pitch": {"kind": "trapezoid", "amplitude_deg": 15.0, "sharpness": 2.0},
    }
    formula = taichiflap.simulate(parse_case(document))
    difference = np.abs(table.tip_deflection - formula.tip_deflection).max()
    assert difference < 0.01 * np.abs(formula.tip_deflection).max()


@pytest.mark.parametrize(
    ("settings", "quantity", "expected", "tolerance"),
    [
        (("solver=dbet", "dbet.added_mass=true", "wing.modes=0"), "force_vertical_normal", 2.78e-3, 0.02),
        (("solver=dbet", "dbet.added_mass=true", "wing.modes=0"), "force_vertical", 2.52e-3, 0.02),
        (("solver=dbet", "dbet.added_mass=true"), "force_vertical", 3.08e-3, 0.03),
        (("solver=dbet", "dbet.added_mass=true"), "tip_peak", 7.6e-3, 0.03),
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


def accurate(*settings):
    """The rigid hawkmoth with the settings of a new case."""
    given = Uvlm().model_dump(exclude_none=True)
    uvlm = "\n".join(f"uvlm.{key}={str(value).lower()}" for key, value in given.items())
    return hawkmoth(*uvlm.splitlines(), "wing.modes=0", "time.periods=9", *settings)


def test_a_few_hundred_vortices_do_for_the_whole_wake_when_the_old_are_absorbed():
    """Beats 4 to 9, before the whole wake becomes unsteady; the neglected part is estimated."""
    cases = [
        accurate("uvlm.wake=all"),
        accurate("uvlm.wake=600"),
        accurate("uvlm.wake=200", "uvlm.old_wake=drop"),
        accurate("uvlm.wake=400", "uvlm.old_wake=drop"),
    ]
    results = taichiflap.simulate(cases)
    forces = [result.force_vertical[-1200:].mean() for result in results]
    assert forces[1] == pytest.approx(forces[0], rel=0.02)
    estimates = [taichiflap.summarise(result).wake_lost for result in results]
    assert estimates[0] == 0.0
    assert estimates[1] < 0.002
    for force, estimate in zip(forces[2:], estimates[2:], strict=True):
        error = abs(force / forces[0] - 1)
        assert estimate / 3 < error < 3 * estimate
