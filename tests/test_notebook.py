"""Results, cases and maps in a notebook: their numbers, in well-formed HTML."""

import re
from xml.etree import ElementTree

import h5py
import numpy as np
import pytest
from conftest import CASES, hawkmoth

import taichiflap
from taichiflap.notation import prefixed
from taichiflap.notebook import svg

TITLE = "a <b> & c"


@pytest.fixture(scope="module")
def result():
    case = hawkmoth("time.periods=3", "time.steps_per_period=60", "uvlm.panels=12", f"title='{TITLE}'")
    return taichiflap.simulate(case, threads=1)


def tree(shown):
    """HTML as XML: it is well formed, titles and all."""
    return ElementTree.fromstring(shown._repr_html_())


def rows(root):
    return {one[0].text: one[1].text for one in root.iter("tr")}


def curves_of(root):
    return [one for one in root.iter() if one.tag.endswith("svg") and "wing" not in one.get("aria-label")]


def test_a_result_shows_its_numbers_its_curves_and_its_wake(result):
    root, summary = tree(result), taichiflap.summarise(result)
    assert root[0].text == TITLE
    told = rows(root)
    assert told["model"] == "UVLM"
    factor, unit = prefixed(summary.force_vertical.mean, "N")
    assert told["vertical force"] == f"{factor * summary.force_vertical.mean:.4g} {unit}"  # too few beats for an error
    tip, force, power = curves_of(root)
    low, high = (f"{1e3 * end(result.tip_deflection[-61:]):.3g}".replace("-", "−") for end in (np.min, np.max))
    assert tip.get("aria-label") == f"Tip deflection: {low} to {high} mm"
    assert force.get("aria-label").startswith("Vertical force: ")
    assert power.get("aria-label").endswith("mW")
    circles = [one for one in root.iter() if one.tag.endswith("circle")]
    assert 0 < len(circles) <= len(result.wake(-1)["y"])


def test_a_sparkline_rises_with_its_values():
    values = np.array([0.0, 1.0, -1.0, np.nan, 3.0])
    root = ElementTree.fromstring(svg.curve(values, "Lift", "mN"))
    (line,) = [one for one in root.iter() if one.tag.endswith("polyline")]
    places = np.array([[float(x) for x in pair.split(",")] for pair in line.get("points").split()])
    np.testing.assert_allclose(np.diff(places[:, 1]) / (places[0, 1] - places[1, 1]), [-1.0, 2.0, -4.0], atol=0.02)
    assert root.get("aria-label") == "Lift: −1 to 3 mN"


@pytest.mark.parametrize("name", ["hawkmoth", "plunging_foil", "graded_wing", "tabulated_stroke"])
def test_a_case_shows_its_motion(name):
    case = taichiflap.load_case(CASES / f"{name}.toml")
    root = tree(case)
    assert rows(root)["model"] == case.model
    assert [one.get("aria-label").split(":")[0] for one in curves_of(root)[:2]] == ["Plunge", "Pitch"]


@pytest.mark.slow
def test_a_map_shows_its_cells_and_the_range_of_its_metrics(tmp_path):
    vary = {"wing.youngs_modulus": [10e9, 20e9, 40e9], "motion.pitch.amplitude_deg": [10.0, 20.0]}
    case = hawkmoth("solver=dbet", "time.periods=2", "time.steps_per_period=40", "dbet.elements=8")
    lift = 1e3 * taichiflap.sweep(case, vary, tmp_path / "map.h5", threads=1).force_vertical_mean.values
    with taichiflap.open_map(tmp_path / "map.h5") as sheet:
        root = tree(sheet)
    assert len([one for one in root.iter() if one.tag.endswith("rect")]) == 6
    assert rows(root)["Mean vertical force (mN)"] == f"{lift.min():.3g} to {lift.max():.3g}"


def test_a_run_that_failed_says_why_and_has_no_numbers(tmp_path):
    path = tmp_path / "a.h5"
    taichiflap.simulate(hawkmoth("solver=dbet", "time.periods=1", "dbet.elements=8"), path, threads=1).close()
    with h5py.File(path, "r+") as file:
        file.attrs["status"] = np.bytes_(b"failed")
        file.attrs["reason"] = np.bytes_(b"step 3: the wing <left>")
    with taichiflap.open_result(path) as failed:
        told = rows(tree(failed))
    assert told["beats"] == "step 3: the wing <left>"
    assert "power" not in told


@pytest.mark.slow
def test_a_viewer_of_a_result_in_memory_has_an_address_until_it_is_closed(result):
    with result.view(height=400) as viewer:
        assert re.match(r"http://127\.0\.0\.1:\d+/\S{20,}/$", viewer.address)
        shown = viewer._repr_html_()
        assert f'data="{viewer.address}"' in shown
        assert "height:400px" in shown
        assert result._repr_html_() in shown
    assert viewer._repr_html_() == result._repr_html_()
    assert viewer._process.poll() is not None
