"""A wing in strips: one strip is its section, many approximate the integral over the span."""

import numpy as np
import pytest
from conftest import CASES, hawkmoth

import taichiflap
from taichiflap.studies import strips as study

SHORT = ("time.periods=2", "time.steps_per_period=80")


def moth(*settings):
    return taichiflap.load_case(CASES / "measured_moth.toml", (*SHORT, *settings))


def test_one_strip_is_the_section_at_its_middle_bit_for_bit():
    case = moth("motion.measured.radius_share=0.5")
    found = study.strips(case, 1)
    with taichiflap.simulate(case) as result:
        for name in study.SERIES:
            np.testing.assert_array_equal(found.total[name], getattr(result, name))
    assert found.strips[0].radius == pytest.approx(0.5 * case.wing.span)


def test_means_are_those_of_a_summary_when_a_run_ends_within_a_beat():
    document = hawkmoth("solver=dbet").to_dict()
    document["time"] = {"duration": 0.11, "step": 3e-4}  # 2.75 beats of 133 1/3 steps
    case = taichiflap.case.parse_case(document)
    found = study.strips(case, 1, at=0.5)
    with taichiflap.simulate(case) as result:
        summary = taichiflap.summarise(result)
    assert found.beats == summary.beats == 1
    for name in study.SERIES:
        assert found.means[name] == pytest.approx(getattr(summary, name).mean, rel=1e-12)
    assert found.power_positive == pytest.approx(summary.power_positive.mean, rel=1e-12)


@pytest.mark.parametrize("wing", ["even", "measured"])
def test_strips_that_move_alike_are_the_whole_section(wing):
    """In pure pitch the radius does not matter: the sum of any number of strips is the section."""
    case = hawkmoth("solver=dbet", *SHORT, "motion.plunge.amplitude=0.0", "motion.pitch.amplitude_deg=30")
    if wing == "measured":
        document = case.to_dict()
        for name in ("thickness", "density", "youngs_modulus"):
            del document["wing"][name]
        document["wing"] |= {"mass_per_length": 2e-3, "flexural_rigidity": 6.5e-6, "point_masses": [[0.5, 2e-6]]}
        case = taichiflap.case.parse_case(document)
    found = study.strips(case, 4, at=0.5)
    with taichiflap.simulate(case) as result:
        for name in study.SERIES:
            whole = getattr(result, name)
            np.testing.assert_allclose(found.total[name], whole, atol=1e-10 * np.abs(whole).max())


def test_forces_go_with_the_square_of_the_radius_and_their_sum_with_its_mean_square():
    """A plate at a constant angle of attack without added mass: quasi-steady, so exact."""
    case = hawkmoth("solver=dbet", *SHORT, "wing.modes=0", "dbet.added_mass=false", "motion.pitch.amplitude_deg=0.0",
                    "motion.pitch.mean_deg=30", "motion.plunge.harmonics=[[3, 0.001, 20.0]]")  # fmt: skip
    found = study.strips(case, 8, at=0.5)
    radii = np.array([one.radius for one in found.strips])
    powers = np.array([one.means["power_aerodynamic"] for one in found.strips])
    np.testing.assert_allclose(powers / powers[-1], (radii / radii[-1]) ** 3, rtol=1e-10)
    with taichiflap.simulate(case) as result:
        # Midpoints: the mean square over the span, 1/3 less 1/(12 n^2), over that at mid-span; and so the mean cube.
        square, cube = 4.0 * (1 / 3 - 1 / (12 * 64)), 8.0 * (1 / 4 - 1 / (8 * 64))
        for name, factor in (("force_z", square), ("force_vertical", square), ("power_aerodynamic", cube)):
            whole = factor * getattr(result, name)
            np.testing.assert_allclose(found.total[name], whole, atol=1e-10 * np.abs(whole).max())


def test_a_planform_narrows_the_chord_and_the_root_stands_off():
    cases, middles = study.sections(moth(), 4, root=0.2, planform=study.read_planform("0:0.5,0.6:1,1:0.2"))
    np.testing.assert_allclose(middles, 0.048 * np.array([0.3, 0.5, 0.7, 0.9]))
    np.testing.assert_allclose([one.wing.chord / 0.018 for one in cases], [0.75, 11 / 12, 0.8, 0.4])
    assert all(one.wing.span == pytest.approx(0.048 * 0.2) for one in cases)
    assert [one.motion.measured.radius for one in cases] == pytest.approx(middles)


@pytest.mark.parametrize(
    ("case", "keys", "phrase"),
    [
        (hawkmoth(), {}, "--at is missing: give the share of the span"),
        (moth(), {"at": 0.5}, "measured angles have their own radius"),
        (hawkmoth(), {"at": 1.5}, "--at 1.5: give a share of the span"),
        (hawkmoth(), {"at": 0.5, "root": 1.0}, "--root 1: give a share of the span"),
        (hawkmoth(), {"at": 0.5, "planform": [(0.5, 1.0), (0.2, 1.0)]}, "--planform: give SHARE:CHORD pairs"),
        (hawkmoth("wing.span=[[0, 0.05], [1, 0.02]]"), {"at": 0.5}, "wing.span is a table"),
    ],
)
def test_wings_that_are_no_strips_are_refused(case, keys, phrase):
    with pytest.raises(study.StripsError, match=phrase):
        study.strips(case, 3, **keys)


def test_the_sums_are_written_and_told(tmp_path):
    found = study.strips(moth(), 3)
    found.write(tmp_path / "sums.csv")
    rows = np.loadtxt(tmp_path / "sums.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(rows[:, 3], found.total["force_vertical"])
    said = "\n".join(study.lines(found))
    assert f"{1e3 * found.means['force_vertical']:.4g} mN, sum of 3 strips" in said
    assert "tip vortex" in said
