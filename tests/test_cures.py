"""The cure that a message names: once it is applied, the case is valid."""

import math
import os
import re
import tomllib

import pytest
from conftest import CASES, hawkmoth

from taichiflap.case.case import CaseError, load_case, parse_case

GOOD = tomllib.loads((CASES / "hawkmoth.toml").read_text())
STILL = {"motion.plunge": None, "motion.pitch": None, "uvlm": {}}
RAMP = {"kind": "ramp", "amplitude_deg": -45.0, "start": 0.1, "ramp": 0.3, "smoothing": 100.0}
IN_SECONDS = {
    "motion.frequency": None,
    "motion.plunge": None,
    "motion.pitch": RAMP,
    "time": {"duration": 1.0, "step": 0.01},
}
WAVE = [[n / 8, 5.0 * math.sin(math.tau * n / 8)] for n in range(9)]
TABLE = {"kind": "table", "periodic": True}
NAVIER_STOKES = {"solver": "navier_stokes", "fluid.viscosity": 1.5e-5}
SHEDS = {"uvlm": {"leading_edge": "sheds"}}
GUST = {"fluid.gust": "sinusoidal", "fluid.gust_velocity": 0.1}


def changed(*changes):
    """The hawkmoth with some keys changed, or taken out where the value is None."""
    document = tomllib.loads((CASES / "hawkmoth.toml").read_text())
    for change in changes:
        for key, value in change.items():
            *tables, last = key.split(".")
            table = document
            for name in tables:
                table = table.setdefault(name, {})
            table[last] = value
            if value is None:
                del table[last]
    return parse_case(document)


@pytest.mark.parametrize(
    ("wrong", "phrase", "cure"),
    [
        ({"motion.frequency": None}, "motion.frequency: missing; give a number > 0", {"motion.frequency": 25.0}),
        (
            {"motion.frequency": None, "motion.plunge": None, "motion.pitch": RAMP},
            "for a non-periodic motion give time.duration and time.step instead of periods",
            {"time": {"duration": 1.0, "step": 0.01}},
        ),
        ({"motion.plunge": {"file": "stroke.csv"}}, 'it belongs to kind = "table"',
         {"motion.plunge": TABLE | {"points": WAVE}}),
        ({"motion.pitch.sharpness": 0.5}, 'it belongs to kind = "triangle" or "trapezoid"',
         {"motion.pitch.kind": "triangle"}),
        ({"motion.start_up": 0.1, "motion.start_up_periods": 1.0}, "give either start_up or",
         {"motion.start_up": None}),
        ({"time": {"periods": 3, "duration": 1.0, "step": 0.01}}, "mixes periods and seconds", {"time.periods": None}),
        ({"time": {"duration": 1.0}}, "time.step: missing; give a number", {"time.step": 1e-3}),
        ({"time": {"duration": 0.1, "step": 0.5}}, "give a shorter step", {"time.step": 0.1}),
        (STILL | {"time.steps_per_period": "auto"}, "give the time step as a number", {"time.steps_per_period": 200}),
        ({"time.steps_per_period": 900_000}, "the limit is 5000000 steps", {"time.periods": 5}),
        ({"wing.pivot": 0.25}, "set wing.modes = 0", {"wing.modes": 0}),
        ({"wing.pivot": 0.25}, "or leave pivot out", {"wing.pivot": None}),
        ({"wing.modes": 3, "wing.damping_ratio": [0.1]}, "give one number, or one per mode",
         {"wing.damping_ratio": 0.1}),
        ({"wing.span": [[0.0, 0.05], [0.5, 0.04]]}, "run from s = 0 to s = 1",
         {"wing.span": [[0.0, 0.05], [1.0, 0.04]]}),
        ({"wing.thickness": [[0.0, 0.0], [1.0, 4e-5]]}, "give a small number instead",
         {"wing.thickness": [[0.0, 1e-9], [1.0, 4e-5]]}),
        ({"wing.chord": 1e-31}, "wing.chord = 100e-33: 1e-31 is too small; give at least 1e-30", {"wing.chord": 1e-30}),
        ({"fluid.density": 1e-31}, "or 0 if the key may be 0", {"fluid.density": 0.0}),
        (GUST | {"fluid.gust_length": 0.1}, "a gust needs a free stream; set velocity", {"fluid.velocity": [1.0, 0.0]}),
        (GUST | {"fluid.velocity": [1.0, 0.0]}, "needs a length; set gust_length", {"fluid.gust_length": 0.1}),
        ({"dbet.stall_deg": [45.0, 20.0]}, "first angle must be smaller", {"dbet.stall_deg": [20.0, 45.0]}),
        (SHEDS | {"uvlm.spacing": "uniform"}, 'give spacing = "cosine"', {"uvlm.spacing": "cosine"}),
        (SHEDS | {"uvlm.loads": "panels"}, 'give loads = "vortices"', {"uvlm.loads": "vortices"}),
        (SHEDS | {"uvlm.suction": True}, "leave it out", {"uvlm.suction": None}),
        (SHEDS | {"uvlm.wake": 5}, "give at least 10", {"uvlm.wake": 10}),
        (STILL | SHEDS, "uvlm.reference_speed: missing; give a number", {"uvlm.reference_speed": 1.0}),
        ({"uvlm": {"far_error": 1e-3, "precision": "single"}}, "give far_error = 0", {"uvlm.far_error": 0.0}),
        ({"uvlm": {"far_error": 1e-3, "precision": "single"}}, 'or precision = "double"', {"uvlm.precision": "double"}),
        ({"solver": "navier_stokes"}, "fluid.viscosity: missing; give a number", {"fluid.viscosity": 1.5e-5}),
        (NAVIER_STOKES | {"wing.span": [[0.0, 0.05], [1.0, 0.04]]}, "give a number", {"wing.span": 0.05}),
        (NAVIER_STOKES | {"navier_stokes.thickness": 0.01}, "give 0.02 or leave it out",
         {"navier_stokes.thickness": 0.02}),
        (NAVIER_STOKES | {"navier_stokes.cells": 100}, "the nearest such number is 96", {"navier_stokes.cells": 96}),
        ({"motion.pitch": TABLE | {"points_deg": WAVE[:3]}}, "has 3 points; give at least 4",
         {"motion.pitch": TABLE | {"points_deg": WAVE}}),
        ({"motion.pitch": TABLE | {"points_deg": [[0.04 * t, v] for t, v in WAVE]}}, 'give time = "s"',
         {"motion.pitch.time": "s"}),
        ({"motion.pitch": TABLE | {"points_deg": [[40.0 * t, v] for t, v in WAVE]}}, 'give time = "ms"',
         {"motion.pitch.time": "ms"}),
        ({"motion.pitch": TABLE | {"points_deg": [[t, v + t] for t, v in WAVE]}}, "smooth the points: smooth = 4",
         {"motion.pitch.smooth": 4}),
        (IN_SECONDS | {"motion.plunge": {"kind": "table", "points": WAVE, "time": "periods"}},
         'time = "periods" needs motion.frequency', {"motion.frequency": 1.0}),
        (IN_SECONDS | {"motion.plunge": {"kind": "table", "time": "ms", "points": [[1e3 * t, v] for t, v in WAVE[:8]]}},
         "cover 0 to 0.875 s but the case runs from 0 to 1 s; give more points", {"time.duration": 0.8}),
    ],
)  # fmt: skip
def test_a_cure_cures(wrong, phrase, cure):
    with pytest.raises(CaseError) as refused:
        changed(wrong)
    (problem,) = refused.value.problems
    assert phrase in problem
    changed(wrong, cure)


@pytest.mark.parametrize("ramp", [0.1, 0.3, 0.7, 1.9635, 1 / 3e3])
def test_the_least_smoothing_that_a_message_names_is_accepted(ramp):
    wrong = IN_SECONDS | {"motion.pitch": RAMP | {"ramp": ramp, "smoothing": 0.5 / ramp}}
    with pytest.raises(CaseError) as refused:
        changed(wrong)
    least = float(re.search(r"give >= (\S+)$", str(refused.value))[1])
    changed(wrong, {"motion.pitch.smoothing": least})


def test_a_broken_link_is_no_misspelt_name(tmp_path):
    (tmp_path / "case.toml").symlink_to("nowhere")
    with pytest.raises(CaseError, match=r"case\.toml: is a broken link$"):
        load_case(tmp_path / "case.toml")


def test_a_path_is_a_word_without_quotes():
    with pytest.raises(CaseError, match=r'motion\.pitch\.file = "data/stroke\.csv": no such file beside the case'):
        hawkmoth("motion.pitch={kind = 'table'}", "motion.pitch.file=data/stroke.csv")


def test_a_single_setting_needs_no_list():
    assert load_case(CASES / "hawkmoth.toml", "wing.modes=0") == hawkmoth("wing.modes=0")


def test_a_case_without_times_can_be_overridden_to_seconds():
    document = tomllib.loads((CASES / "hawkmoth.toml").read_text())
    del document["time"]
    case = parse_case(document).override("time.duration=1.0", "time.step=0.25")
    assert (case.steps, case.step) == (4, 0.25)
    assert case.override("time.step=0.5").steps == 2


@pytest.mark.parametrize(
    ("value", "phrase"),
    [
        (".02", "needs digits on both sides of the point, as in 0.5"),
        ("-2.e-3", "needs digits on both sides of the point, as in 0.5"),
        ("0.02\ny = 3", "is not a number"),
        ("a b", "is not a number"),
        ("", "is not a number"),
    ],
)
def test_a_value_that_is_no_toml_is_refused(value, phrase):
    with pytest.raises(CaseError) as refused:
        hawkmoth(f"wing.chord={value}")
    assert phrase in str(refused.value)


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="counts open files as Linux lists them")
def test_a_folder_in_place_of_a_case_is_closed_again(tmp_path):
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(3):
        with pytest.raises(CaseError, match="cannot be read: Is a directory"):
            load_case(tmp_path)
    assert len(os.listdir("/proc/self/fd")) == before
