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
