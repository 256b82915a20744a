"""Points of a tabulated motion from files, and its units of time."""

import numpy as np
import pytest
from conftest import hawkmoth

import taichiflap
from taichiflap.case.case import CaseError, load_case, parse_case
from taichiflap.case.columns import read_columns
from taichiflap.case.tabulated import _points

ROWS = [[0.0, 0.0, 5.0], [0.25, 0.01, 6.0], [0.5, 0.0, 7.5], [0.75, -0.01, 6.0]]
RAMP = {"kind": "ramp", "start": 0.2, "ramp": 0.1, "smoothing": 50.0, "amplitude_deg": 45.0}


def read_points(path, which):
    """Rows of the time column and another column."""
    return _points("plunge", {"column": which}, read_columns(path))["points"]


@pytest.mark.parametrize(
    ("separator", "head"), [(",", "t,z,theta\n"), (" ; ", "# a comment\n\n"), ("\t", "\ufefftime\tz\n"), ("  ", "")]
)
def test_columns_of_numbers_are_read(separator, head, tmp_path):
    file = tmp_path / "stroke.txt"
    file.write_text(head + "\n".join(separator.join(map(str, row)) for row in ROWS) + "  # the end\n", encoding="utf-8")
    assert read_points(file, 2) == [row[:2] for row in ROWS]
    assert read_points(file, 3) == [[row[0], row[2]] for row in ROWS]


def test_between_semicolons_a_comma_is_a_decimal_point(tmp_path):
    file = tmp_path / "stroke.csv"
    file.write_text("Zeit;Hub\n0;0\n0,25; 0,01\n0,5;-1,5e-3\n")
    assert read_points(file, 2) == [[0.0, 0.0], [0.25, 0.01], [0.5, -0.0015]]


def test_the_points_of_a_file_beside_the_case_end_up_in_the_result(tmp_path):
    (tmp_path / "stroke.csv").write_text("\n".join(f"{t},{z}" for t, z, _ in ROWS))
    table = "plunge = { kind = 'table', periodic = true, file = 'stroke.csv' }"
    text = hawkmoth("solver=dbet", "time.periods=1").to_toml()
    before, _, after = text.partition("[motion.plunge]")
    file = tmp_path / "case.toml"
    file.write_text(
        before.replace("frequency = 25.0", f"frequency = 25.0\n{table}")
        + "[motion.pitch]"
        + after.partition("[motion.pitch]")[2]
    )
    case = load_case(file)
    (tmp_path / "stroke.csv").unlink()
    taichiflap.simulate(case, tmp_path / "run.h5").close()
    with taichiflap.open_result(tmp_path / "run.h5") as result:
        assert result.case == case
        assert result.case.motion.plunge.points == tuple((t, z) for t, z, _ in ROWS)
        assert result.plunge[50] == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("content", "column", "phrase"),
    [
        (None, 2, "no such file"),
        (b"0 1\n1 2\n2 3\n3 4\n", 3, "line 1 has no column 3"),
        (b"0 1\n1 b\n", 2, "line 2 has no number"),
        (b"t,z\n0,0\n0,5,0,01\n1,0\n", 2, "line 3 has 4 columns but the first line has 2"),
        (b"\xff\xfe", 2, "not a text file"),
        (b"0 1\n1 2\n", 2, "has 2 points"),
        (b"0 1\n1 2\n1 3\n2 3\n", 2, "times must increase"),
        (b"0 1\n0.1 2\n0.2 3\n1 3\n", 2, "begins with 1 and ends with 3"),
        (b"0 1\n1 2\n2 3\n3 3\n", 2, "fractions of the period"),
    ],
)
def test_a_bad_file_of_points_is_named(content, column, phrase, tmp_path):
    if content is not None:
        (tmp_path / "stroke.csv").write_bytes(content)
    document = hawkmoth().to_dict()
    document["motion"]["plunge"] = {"kind": "table", "periodic": True, "file": "stroke.csv", "column": column}
    with pytest.raises(CaseError) as caught:
        parse_case(document, folder=tmp_path)
    (problem,) = caught.value.problems
    assert problem.startswith("motion.plunge")
    assert phrase in problem


def test_a_table_that_does_not_repeat_must_cover_the_run():
    document = hawkmoth().to_dict() | {"time": {"duration": 0.8, "step": 0.01}}
    document["motion"] = {"plunge": {"kind": "table", "points": [row[:2] for row in ROWS]}}
    with pytest.raises(
        CaseError, match=r"motion.plunge: its points cover 0 to 0.75 s but the case runs from 0 to 0.8 s"
    ):
        parse_case(document)
    document["time"]["duration"] = 0.75
    assert parse_case(document).steps == 75


@pytest.mark.parametrize(
    ("motion", "time", "phrase"),
    [
        ({"pitch": RAMP}, {}, "motion.frequency: missing; give a number"),
        ({"pitch": RAMP}, {"duration": 1.0}, "time.step: missing; give a number"),
        ({"pitch": RAMP}, {"step": 0.1}, "time.duration: missing; give a number"),
        ({"pitch": RAMP}, {"duration": 1.0, "step": 0.1, "periods": 3}, "mixes periods and seconds"),
        ({"plunge": {"amplitude": 0.1}}, {"duration": 1.0, "step": 0.1}, "motion.frequency: missing; give a number"),
        ({"start_up_periods": 1.0}, {"duration": 1.0, "step": 0.1}, "motion.frequency: missing"),
        ({}, {"duration": 1.0, "step": "auto"}, "needs a moving wing or a stream"),
        ({"pitch": RAMP}, {"duration": 1.0, "step": "quick"}, 'time.step = "quick": must be a number'),
        ({"pitch": RAMP, "start_up": 1.0, "start_up_periods": 2.0, "frequency": 1.0}, {}, "give either start_up"),
        (
            {"pitch": RAMP},
            {"duration": 1e6, "step": 1e-3},
            "time.duration / time.step = 1000000000; the limit is 5000000",
        ),
    ],
)
def test_time_is_counted_one_way(motion, time, phrase):
    with pytest.raises(CaseError) as caught:
        parse_case(hawkmoth().to_dict() | {"motion": motion, "time": time})
    assert phrase in "\n".join(caught.value.problems)


@pytest.mark.parametrize("panels", [10, 40])
def test_an_automatic_step_spaces_the_wake_like_the_panels(panels):
    """In a stream the speed of the trailing edge is the stream's, and vortices are a panel apart."""
    document = hawkmoth("wing.modes=0").to_dict() | {"fluid": {"density": 1.0, "velocity": [3.0, 0.0]}}
    document |= {"motion": {"pitch": {"mean_deg": -0.01}}, "time": {"duration": 0.02, "step": "auto"}}
    document["uvlm"] = {"panels": panels}
    case = parse_case(document)
    assert case.step == pytest.approx(0.02 / panels / 3.0, rel=0.02)
    result = taichiflap.simulate(case)
    assert result.case.time.step == case.step == result.time[1]
    wake = result.wake(-1)
    np.testing.assert_allclose(-np.diff(wake["y"][:-1]), 0.02 / panels, rtol=0.02)
    flapping = hawkmoth("time.steps_per_period=auto")
    assert flapping.resolved().time.steps_per_period == flapping.steps // 15 == 230
