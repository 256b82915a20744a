"""Every example runs, with reduced settings, and gives its number."""

import contextlib
import io
import json
import re
import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

import taichiflap
from taichiflap.theory import mean_thrust, wagner

pytestmark = pytest.mark.slow

EXAMPLES = Path(__file__).parent.parent / "examples"


def test_graded_wing():
    maps = runpy.run_path(str(EXAMPLES / "graded_wing.py"))["maps"]
    force, economy = maps("dbet", ratios=(2.0, 3.0, 3.5), falls=(1.0, 0.1))
    assert force[1, 1] == pytest.approx(1.253, rel=0.01)
    assert force[0, 0] > force[0, 1] > force[0, 2]  # softer lifts more ...
    assert economy[1].argmax() == 2  # ... but is not the most economical


def test_uvlm_choices():
    study = runpy.run_path(str(EXAMPLES / "uvlm_choices.py"))
    study["measure"].__globals__.update(BEATS=4, START=2)
    paper, local, accurate = (
        study["measure"](*settings)
        for settings in (((), ()), ((), study["CHANGED"]['`shedding = "local"`']), (study["ACCURATE"], ()))
    )
    assert paper[1][0][0] == pytest.approx(7.1, rel=0.05)
    assert local[1][0][0] < 0.9 * paper[1][0][0]
    assert accurate[1][0][0] == pytest.approx(local[1][0][0], rel=0.1)
    rows = {"changed": dict.fromkeys(study["CHANGED"], local)}
    rows |= {name.lower(): dict.fromkeys(study[name], accurate) for name in ("RETURNED", "REFINED")}
    checked = [(name, [0.01, 0.02, 0.03], 13.0, 13.1) for name in study["BALANCES"]]
    page = study["markdown"](study["blocks"](paper=paper, checked=checked, **rows))
    assert f"{paper[1][0][0]:.2f} ± {paper[1][0][1]:.2f}" in page
    for settings in (*study["CHANGED"].values(), *study["RETURNED"].values(), *study["REFINED"].values()):
        taichiflap.load_case(study["CASE"], settings)


def test_design_map(tmp_path):
    study = runpy.run_path(str(EXAMPLES / "design_map.py"))
    short = ("time.periods=4", "uvlm.panels=12", "time.steps_per_period=80", "uvlm.wake=80")
    chart = study["run"](tmp_path, moduli=2, pitches=3, settings=short)
    lift, power = (study["ratio"](chart, name) for name in ("force_vertical_mean", "power_mean"))
    assert lift[1, 1] == pytest.approx(1.352, rel=0.02)
    assert (lift[:, 0] > 2.5).all()  # a wing that hardly pitches: UVLM alone lifts ...
    assert power[0, 2] < 0.7 < power[1, 2]  # ... and a soft wing that pitches costs it little
    assert study["draw"](chart).axes


def test_bending_multiplies_the_hawkmoths_force():
    example = runpy.run_path(str(EXAMPLES / "flexible_and_rigid.py"))
    results = example["compute"]("time.periods=6")
    assert example["gain"](results) == pytest.approx(2.35, rel=0.02)


def test_stiffness():
    tips, economy = runpy.run_path(str(EXAMPLES / "stiffness.py"))["compute"]((15e9, 24.5e9, 60e9))
    assert tips[1] == pytest.approx(7.613e-3, rel=1e-3)
    assert (np.diff(tips) < 0.0).all()
    assert (np.diff(economy) > 0.0).all()


def test_a_sudden_start_follows_wagner():
    s, lift = runpy.run_path(str(EXAMPLES / "sudden_start.py"))["compute"](chords=3.0)
    exact = np.array([wagner(one) for one in s])
    assert np.abs(lift - exact)[s > 1.0].max() < 0.01


def test_thrust_in_forward_flight_is_garricks():
    thrust = runpy.run_path(str(EXAMPLES / "forward_flight.py"))["compute"]((0.3, 0.8))
    np.testing.assert_allclose(thrust, [mean_thrust(k, plunge=1.0) for k in (0.3, 0.8)], rtol=0.02)


def test_a_stroke_of_ones_own():
    result = runpy.run_path(str(EXAMPLES / "own_stroke.py"))["compute"]("time.periods=4")
    assert taichiflap.summarise(result).force_vertical.mean == pytest.approx(8.71e-3, rel=0.01)


def test_three_models_agree_where_they_should(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    lattice, linear, blades = (
        result.force_normal[-100:] for result in runpy.run_path(str(EXAMPLES / "three_models.py"))["compute"]()
    )
    size = np.abs(lattice).max()
    assert np.abs(linear - lattice).max() < 0.05 * size
    assert np.abs(blades - lattice).max() < 0.02 * size


def test_two_wakes_are_drawn_at_the_same_instants():
    example = runpy.run_path(str(EXAMPLES / "two_wakes.py"))
    case = taichiflap.load_case(example["shipped"].FOLDER / "hawkmoth_ns.toml", (*example["LATTICE"], "time.periods=2"))
    case = case.override("time.steps_per_period=80", "wing.modes=0")
    with taichiflap.simulate(case) as result:
        figure = example["draw"]([result, result])
        for row in (figure.axes[:4], figure.axes[4:]):
            dots = [len(ax.collections[0].get_offsets()) for ax in row]
            assert dots == [91, 111, 131, 151]  # one vortex a step, and the one at the start


def test_the_notebook_gives_the_outputs_that_it_shows(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cells = json.loads((EXAMPLES / "first_steps.ipynb").read_text(encoding="utf-8"))["cells"]
    space: dict = {}
    shown = printed = ""
    pictured = 0
    for cell in (cell for cell in cells if cell["cell_type"] == "code"):
        source = "".join(cell["source"])
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(source, space)
        printed += out.getvalue()
        shown += "".join("".join(output.get("text", "")) for output in cell["outputs"])
        for page in ("".join(output.get("data", {}).get("text/html", "")) for output in cell["outputs"]):
            if page:
                value = space[source.splitlines()[-1]]
                assert words(page) == words(value._repr_html_())
                pictured += 1
    assert space["viewer"].address.startswith("http://127.0.0.1:")
    space["viewer"].close()
    plt.close("all")
    assert "mm" in shown
    assert printed == shown
    assert pictured == 3


def words(page):
    """The text of a page without coordinates, which are exact only to round-off."""
    return re.findall(r">([^<>]+)<", page)
