"""The viewer shows the values of the map file, and every point of the picture belongs to the right case."""

import numpy as np
import pytest
from conftest import hawkmoth
from taichiflap_viewer.maps.picture import Choice, Profile, held, opening, profiles, read
from taichiflap_viewer.maps.profiles import _ends
from taichiflap_viewer.maps.viewer import MapViewer

from taichiflap.maps import file as maps
from taichiflap.maps.design import design
from taichiflap.maps.file import MapError
from taichiflap.maps.labels import group, grouped
from taichiflap.maps.outcome import Outcome
from taichiflap.results.variables import Variable

KEYS = {"wing.youngs_modulus": "5e9:60e9:5:log", "motion.pitch.amplitude_deg": "5:45:3", "solver": "dbet,uvlm"}
METRICS = {"force_vertical_mean": Variable((), "N", "lift"), "power_mean": Variable((), "W", "power")}


def sheet_of(path, sample=None, fail=()):
    """A map whose lift is the number of the case in mN, and whose power decreases with it."""
    vary = KEYS if sample is None else {"wing.youngs_modulus": "5e9:60e9:log", "solver": "dbet,uvlm"}
    case = hawkmoth()
    sheet = maps.create(path, case, design(case, vary, sample), METRICS)
    numbers = range(sheet.design.size)
    sheet.record(
        numbers,
        [
            Outcome(reason="it fluttered")
            if n in fail
            else Outcome({"force_vertical_mean": 1e-3 * n, "power_mean": 1.0 - 1e-2 * n})
            for n in numbers
        ],
    )
    return sheet


def test_a_heat_map_has_every_case_in_its_cell():
    sheet = sheet_of(None, fail=[7])
    choice = opening(sheet)
    assert (choice.across, choice.up) == ("motion.pitch.amplitude_deg", "wing.youngs_modulus")
    assert [axis.key for axis in held(sheet, choice)] == ["solver"]
    for place, solver in enumerate(("dbet", "uvlm")):
        picture = read(sheet, Choice(choice.across, choice.up, choice.colour, {"solver": place}))
        for row in range(5):
            for column in range(3):
                number = picture.at((column + 0.5) / 3, (row + 0.5) / 5)
                point = sheet.design.point(number)
                assert point["solver"] == solver
                assert point["motion.pitch.amplitude_deg"] == 5.0 + 20.0 * column
                assert point["wing.youngs_modulus"] == sheet.design.axes[0].values[row]
                expected = np.nan if number == 7 else float(number)
                np.testing.assert_allclose(picture.values[row, column], expected, atol=1e-12)
        assert picture.at(1.01, 0.5) is picture.at(0.5, -0.01) is None
        assert picture.across.texts == ["5", "25", "45"]
        # Round numbers between the values of a logarithmic key, each where its own cell would be.
        assert picture.up.texts == ["5", "10", "20", "50"]
        values = np.log10([5, 10, 20, 50])
        middles = 0.1 + 0.8 * (values - np.log10(5)) / np.log10(12)
        np.testing.assert_allclose(picture.up.places, middles, atol=1e-12)
    turned = read(sheet, Choice(choice.up, choice.across, choice.colour, {"solver": 1}))
    np.testing.assert_array_equal(turned.numbers, picture.numbers.T)


@pytest.mark.parametrize("sample", [None, "sobol:32"])
def test_a_scatter_has_every_case_at_its_place(sample):
    sheet = sheet_of(None, sample, fail=[7])
    picture = read(sheet, Choice("power_mean", "force_vertical_mean", "force_vertical_mean"))
    assert held(sheet, Choice("power_mean", "force_vertical_mean", "power_mean")) == []
    there = np.isfinite(picture.points).all(axis=1)
    np.testing.assert_array_equal(np.flatnonzero(~there), [7])
    for number in picture.numbers[there]:
        assert picture.at(*picture.points[number]) == number
    # A tick lies where a point of its value would.
    shares, marks = picture.up.places, np.array(list(map(float, picture.up.texts)))
    np.testing.assert_allclose(np.interp(marks, np.arange(len(there))[there], picture.points[there, 1]), shares)
    assert np.all((picture.points[there] > 0) & (picture.points[there] < 1))
    assert picture.at(0.02, 0.02) is None


def test_each_kind_of_case_has_its_front_of_lift_against_power():
    """Lift increases and power decreases with the number of the case, so that the last of each kind dominates."""
    sheet = sheet_of(None, "sobol:32", fail=[7])
    for choice in (Choice("power_mean", "force_vertical_mean", "power_mean"),
                   Choice("force_vertical_mean", "power_mean", "power_mean")):  # fmt: skip
        kinds = [sheet.design.point(number)["solver"] for number in range(32)]
        last = {kind: number for number, kind in enumerate(kinds) if number != 7}
        assert sorted(int(number) for front in read(sheet, choice).fronts for number in front) == sorted(last.values())
    assert read(sheet, Choice("wing.youngs_modulus", "force_vertical_mean", "power_mean")).fronts == ()


def test_ticks_are_round_and_zero_has_no_sign():
    case = hawkmoth()
    sheet = maps.create(None, case, design(case, {"wing.youngs_modulus": "5e9:60e9:8"}), METRICS)
    outcomes = [Outcome({"force_vertical_mean": 1e-3 * lift, "power_mean": 1.0}) for lift in np.linspace(-4.5, 9.6, 8)]
    sheet.record(range(8), outcomes)
    picture = read(sheet, Choice("wing.youngs_modulus", "force_vertical_mean", "power_mean"))
    assert picture.up.texts == ["-4", "-2", "0", "2", "4", "6", "8"]


def test_keys_of_a_sample_are_drawn_by_logarithm_and_by_name():
    sheet = sheet_of(None, "sobol:32")
    picture = read(sheet, Choice("wing.youngs_modulus", "solver", "power_mean"))
    modulus = np.log([sheet.design.point(n)["wing.youngs_modulus"] for n in range(32)])
    share = (picture.points[:, 0] - picture.points[:, 0].min()) / np.ptp(picture.points[:, 0])
    np.testing.assert_allclose(share, (modulus - modulus.min()) / np.ptp(modulus), atol=1e-12)
    assert sorted(picture.up.texts) == ["dbet", "uvlm"]


def test_a_map_that_has_just_begun_can_be_looked_at():
    case = hawkmoth()
    sheet = maps.create(None, case, design(case, {"wing.youngs_modulus": "5e9:60e9:4"}), METRICS)
    choice = opening(sheet)
    assert (choice.across, choice.up) == ("wing.youngs_modulus", "force_vertical_mean")
    picture = read(sheet, choice)
    assert picture.limits == (0.0, 1.0)
    assert picture.at(0.5, 0.5) is None


def test_a_file_that_is_no_map_is_refused(tmp_path):
    (tmp_path / "map.h5").write_bytes(b"no")
    with pytest.raises(MapError, match="not a readable map"):
        MapViewer(tmp_path / "map.h5")


def test_contours_of_a_plane_are_its_straight_lines_at_round_values():
    case = hawkmoth()
    vary = {"wing.youngs_modulus": "10e9:20e9:6", "motion.pitch.amplitude_deg": "0:30:7"}
    sheet = maps.create(None, case, design(case, vary), METRICS)
    row, column = np.unravel_index(np.arange(42), (6, 7))
    lift = 1.0 + 0.4 * (row + 0.5) / 6 + 0.9 * (column + 0.5) / 7  # mN, of the shares up and across
    sheet.record(range(42), [Outcome({"force_vertical_mean": 1e-3 * one, "power_mean": 1.0}) for one in lift])
    picture = read(sheet, opening(sheet))
    levels = [level for level, _ in picture.contours()]
    assert levels == pytest.approx([1.2, 1.4, 1.6, 1.8, 2.0, 2.2])
    for level, lines in picture.contours():
        for line in lines:
            np.testing.assert_allclose(1.0 + 0.4 * line[:, 1] + 0.9 * line[:, 0], level, atol=1e-12)
    across, up = profiles(sheet, opening(sheet), picture, 17)
    assert (across.key, up.key) == ("motion.pitch.amplitude_deg", "wing.youngs_modulus")
    np.testing.assert_allclose(across.values, lift.reshape(6, 7)[2])
    np.testing.assert_allclose(up.values, lift.reshape(6, 7)[:, 3])
    np.testing.assert_allclose(up.places, np.linspace(10, 20, 6))


def test_a_picture_does_not_depend_on_the_order_of_the_values():
    case, found = hawkmoth(), []
    for moduli, angles in (("10e9,20e9,30e9", "0,10,30"), ("30e9,10e9,20e9", "30,10,0")):
        vary = {"wing.youngs_modulus": moduli, "motion.pitch.amplitude_deg": angles}
        sheet = maps.create(None, case, design(case, vary), METRICS)
        points = [sheet.design.point(number) for number in range(9)]
        lifts = [point["wing.youngs_modulus"] * (1.0 + point["motion.pitch.amplitude_deg"]) for point in points]
        sheet.record(range(9), [Outcome({"force_vertical_mean": one, "power_mean": 1.0}) for one in lifts])
        picture = read(sheet, opening(sheet))
        # A click opens the case whose value the cell shows.
        np.testing.assert_array_equal(picture.values, 1e3 * np.array(lifts)[picture.numbers])
        assert sheet.design.point(picture.at(0.9, 0.1)) == {
            "wing.youngs_modulus": 10e9, "motion.pitch.amplitude_deg": 30.0
        }  # fmt: skip
        lines = profiles(sheet, opening(sheet), picture, picture.at(0.5, 0.5))
        edges = [(tuple(edge.places), edge.texts) for edge in (picture.across, picture.up)]
        found.append((picture.values.tolist(), edges, [(one.places.tolist(), one.values.tolist()) for one in lines]))
    assert found[0] == found[1]


def test_menus_group_metrics_and_tell_their_units():
    sheet = sheet_of(None)
    assert grouped(["solver", "power_mean", "force_vertical_mean", "wing.youngs_modulus"], sheet) == {
        "Key: solver": "solver", "Key: Young's modulus (GPa)": "wing.youngs_modulus",
        "Forces: Mean vertical force (mN)": "force_vertical_mean", "Power: Mean power (mW)": "power_mean",
    }  # fmt: skip
    assert [group(name) for name in ("tip_peak_mean", "lift_coefficient_mean", "force_normal_harmonic_1", "beats")] == [
        "Bending", "Coefficients", "Harmonics", "Other",
    ]  # fmt: skip


def test_a_case_for_which_the_model_does_not_hold_has_no_colour():
    case = hawkmoth()
    kept = METRICS | {"tip_peak_mean": Variable((), "m", "tip")}
    sheet = maps.create(None, case, design(case, {"wing.youngs_modulus": "5e9:60e9:4"}), kept)
    tips = (0.1, 0.021, 0.019, 0.002)  # m, of a chord of 0.02
    outcomes = [
        Outcome({"force_vertical_mean": 9.0 - n, "power_mean": 1.0, "tip_peak_mean": t}) for n, t in enumerate(tips)
    ]
    sheet.record(range(4), outcomes)
    picture = read(sheet, Choice("power_mean", "force_vertical_mean", "power_mean"))
    assert list(np.isnan(picture.values)) == list(picture.broken) == [True, True, False, False]
    assert list(picture.bent) == [True, True, True, False]
    assert [list(front) for front in picture.fronts] == [[2]]


def test_a_profile_over_a_single_value_has_a_range():
    for places, ends in (([20.0], (10.0, 30.0)), ([0.0], (-0.5, 0.5)), ([1.0, 4.0], (1.0, 4.0))):
        assert _ends(Profile("key", False, np.array(places), np.array(places))) == ends
