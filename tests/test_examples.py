"""Every example runs, reduced, and gives its number."""

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent / "examples"


def test_graded_wing():
    maps = runpy.run_path(str(EXAMPLES / "graded_wing.py"))["maps"]
    force, economy = maps("dbet", ratios=(2.0, 3.0, 3.5), falls=(1.0, 0.1))
    assert force[1, 1] == pytest.approx(1.253, rel=0.01)
    assert force[0, 0] > force[0, 1] > force[0, 2]  # softer lifts more ...
    assert economy[1].argmax() == 2  # ... but is not the most economical


def test_design_map(tmp_path):
    study = runpy.run_path(str(EXAMPLES / "design_map.py"))
    short = ("time.periods=4", "uvlm.panels=12", "time.steps_per_period=80", "uvlm.wake=80")
    chart = study["run"](tmp_path, moduli=2, pitches=3, settings=short)
    lift, power = (study["ratio"](chart, name) for name in ("force_vertical_mean", "power_mean"))
    assert lift[1, 1] == pytest.approx(1.352, rel=0.02)
    assert (lift[:, 0] > 2.5).all()  # a wing that hardly pitches: UVLM alone lifts ...
    assert power[0, 2] < 0.7 < power[1, 2]  # ... and a soft wing that pitches costs it little
    assert study["draw"](chart).axes
