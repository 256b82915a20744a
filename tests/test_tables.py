"""Tables of motion in many formats are read, warned of or rejected; and the curves through their points."""

import numpy as np
import pytest
from conftest import hawkmoth

import taichiflap
from taichiflap.case.case import CaseError, load_case, parse_case
from taichiflap.motion import fourier, sampling
from taichiflap.run import tables, warnings

TURNS = np.arange(41) / 40
PITCH = 15.0 * np.sin(2 * np.pi * TURNS)
PLUNGE = 0.02 * np.cos(2 * np.pi * TURNS)
BEAT = 0.04
"""Of the hawkmoth, s."""


def rows(values=PITCH, times=TURNS, separator=",", digits=6):
    return "\n".join(f"{t:.9g}{separator}{v:.{digits}f}" for t, v in zip(times, values, strict=True)) + "\n"


def commas(text):
    return text.replace(".", ",")


def case_with(folder, content, name="pitch", encoding="utf-8", settings=(), **keys):
    """The hawkmoth by DBET with a periodic table in a file for one of its motions."""
    folder.joinpath("table.txt").write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
    document = hawkmoth("solver=dbet", "wing.modes=0", "time.periods=2", "time.steps_per_period=100").to_dict()
    document["motion"][name] = {"kind": "table", "periodic": True, "file": "table.txt"} | keys
    return parse_case(document, folder=folder).override(*settings)


def moved(case, column):
    return sampling.sample(case.motion, BEAT * TURNS)[:, column]


HEADED = "t,theta\n" + rows()
READ = {
    "percent comments": ("% one beat\n%t/T  theta (deg)\n" + rows(separator="  "), {}),
    "semicolon comments": ("; one beat\n" + rows(separator=" "), {}),
    "slashes and bangs": ("// made by hand\n! again\n" + rows(separator=" "), {}),
    "a comment behind a line": (rows(separator=" ").replace("\n", " % start\n", 1), {}),
    "a row of units": ("time,pitch\n-,deg\n" + rows(), {}),
    "a title, names and units": ("Stroke of the third moth\nt,theta\n-,deg\n" + rows(), {"column": "theta"}),
    "a row of units in brackets": ("time;pitch\n[-];[°]\n" + rows(separator=";"), {}),
    "Unicode minus": (rows().replace("-", "\u2212"), {}),
    "narrow spaces": (rows(separator="\u202f"), {}),
    "an index and names": (
        ",t,theta\n" + "".join(f"{n},{line}\n" for n, line in enumerate(rows().splitlines())),
        {},
    ),
    "an index and no names": (
        "".join(f"{n} {line}\n" for n, line in enumerate(rows(separator=" ").splitlines())),
        {"time_column": 2},
    ),
    "time last": ("theta;Zeit\n" + rows(TURNS, PITCH, ";"), {"column": "theta"}),
    "UTF-16": (("t\ttheta\n" + rows(separator="\t")).encode("utf-16"), {}),
    "UTF-16 without a mark": (rows(separator="\t").encode("utf-16-le"), {}),
    "Latin-1": ("t;pitch (°)\n" + rows(separator=";"), {"encoding": "latin-1"}),
    "Fortran D": ("\n".join(f" {t:.6f}D+00  {v / 10:.7f}D+01" for t, v in zip(TURNS, PITCH, strict=True)), {}),
    "quotes": ('"time","pitch, deg"\n' + "".join(f'"{t}","{v:.6f}"\n' for t, v in zip(TURNS, PITCH, strict=True)), {}),
    "quoted decimal commas": (
        '"t","pitch"\n"' + commas(rows(separator='"SEP"')).replace("SEP", ",").replace("\n", '"\n"')[:-1],
        {},
    ),
    "decimal commas and tabs": ("t (-)\tpitch (deg)\n" + commas(rows(separator="\t")), {}),
    "decimal commas and spaces": ("t pitch\n" + commas(rows(separator="   ")), {}),
    "decimal commas, comma and space": (commas(rows(separator="; ")).replace(";", ","), {}),
    "decimal commas and semicolons": (commas(rows(separator=" ;")), {}),
    "a spreadsheet's word on its separator": ("sep=;\nt;theta\n" + rows(separator=";"), {}),
    "a separator at the end of numbers": (
        "time (ms);theta (rad)\n" + rows(np.radians(PITCH), 1e3 * BEAT * TURNS, ";", 9).replace("\n", ";\n"), {}
    ),
    "big-endian UTF-16": (b"\xfe\xff" + rows(separator=";").encode("utf-16-be"), {}),
    "whole numbers beside decimal commas": ("t, theta\n" + "".join(
        f"{1e3 * BEAT * t:.0f}, {v:.6f}\n".replace(".", ",") for t, v in zip(TURNS, PITCH, strict=True)
    ), {"time": "ms"}),
    "the value first": ("theta;t\n" + rows(TURNS, PITCH, ";"), {}),
    "tabs after commas": (rows(separator=",\t"), {}),
    "Windows lines and a last comma": (rows().replace("\n", ",\r\n"), {}),
    "seconds by key": (rows(times=BEAT * TURNS), {"time": "s"}),
    "milliseconds by key": (rows(times=1e3 * BEAT * TURNS), {"time": "ms"}),
    "seconds by name": ("time (s),pitch (deg)\n" + rows(times=BEAT * TURNS), {}),
    "milliseconds by name": ("time_ms;pitch\n" + rows(times=1e3 * BEAT * TURNS, separator=";"), {}),
    "radians by key": (rows(np.radians(PITCH), digits=9), {"unit": "rad"}),
    "radians by name": ("t,theta_rad\n" + rows(np.radians(PITCH), digits=9), {}),
    "radians by a unit in brackets": ("t [s],theta [rad]\n" + rows(np.radians(PITCH), BEAT * TURNS, digits=9), {}),
    "degrees by key, whatever the name": ("t,theta_rad\n" + rows(), {"unit": "deg"}),
    "a column by name": ("t,dev (deg),rot (deg)\n" + "".join(
        f"{t},{-v},{v:.6f}\n" for t, v in zip(TURNS, PITCH, strict=True)
    ), {"column": "rot"}),
    "a last point a hair before the seam": (rows(times=np.append(TURNS[:-1], 0.99999)), {}),
    "a last point an ulp behind": (rows(times=TURNS).replace("\n1,", "\n1.0000000000000002,"), {}),
    "ends within round-off": (rows(PITCH + 3.7e-15 * TURNS, digits=20), {}),
    "without the last point": (rows(PITCH[:-1], TURNS[:-1]), {}),
}  # fmt: skip


@pytest.mark.parametrize("kind", READ)
def test_a_table_is_read_right(kind, tmp_path):
    content, keys = READ[kind]
    case = case_with(tmp_path, content, **keys)
    np.testing.assert_allclose(np.degrees(moved(case, sampling.PITCH)), PITCH, atol=2e-5)
    accel = sampling.sample(case.motion, BEAT * TURNS)[:, sampling.PITCH_ACCEL]
    np.testing.assert_allclose(np.degrees(accel), -((2 * np.pi / BEAT) ** 2) * PITCH, atol=0.01 * 15 * 157**2)
    assert not list(tables.warnings(case))
    assert case == parse_case(case.to_dict())  # what a result holds needs no file


def test_millimetres_and_millimetres_by_name(tmp_path):
    for content, keys in (("t,Z (mm)\n", {}), ("t,Z [millimeters]\n", {}), ("", {"unit": "mm"})):
        case = case_with(tmp_path, content + rows(1e3 * PLUNGE), "plunge", **keys)
        np.testing.assert_allclose(moved(case, sampling.PLUNGE), PLUNGE, atol=1e-8)


REFUSED = {
    "seconds": (rows(times=BEAT * TURNS), {}, 'they look like s: give time = "s"'),
    "milliseconds": (rows(times=1e3 * BEAT * TURNS), {}, 'they look like ms: give time = "ms"'),
    "periods that are called seconds": ("t (s),pitch\n" + rows(), {}, 'give time = "periods"'),
    "percent": (rows(times=100 * TURNS), {"time": "periods"}, "they look like percent of the period: divide"),
    "degrees of phase": (rows(times=360 * TURNS), {}, "they look like degrees of phase"),
    "two beats": (rows(np.tile(PITCH[:-1], 2), np.arange(80) / 40), {}, "they look like 2 beats"),
    "rows": (rows(PITCH[:31], range(31)), {}, "they look like row numbers: set time_column"),
    "ends apart": (rows(PITCH + 0.5 * TURNS), {}, "begins with 0 and ends with 0.5; make them equal, or smooth"),
    "commas for everything": (commas("t,theta\n0.00,0.10\n0.25,0.30\n0.50,0.10\n0.75,-0.30\n"), {}, "with semicolons"),
    "the same without names": (commas("0.00,0.10\n0.25,0.30\n0.50,0.10\n0.75,-0.30\n"), {}, "with semicolons"),
    "whole numbers for everything": ("0,1,5,2\n1,2,5,3\n2,3,5,1\n3,4,5,0\n", {"periodic": False}, "they may be "
    "decimals"),
    "a point and a comma": ("0.00 1,0\n0.25 2,0\n0.50 1,5\n0.75 1,2\n", {}, "use one separator"),
    "points and commas": ("0.00;1,0\n0.25;2,0\n0.50;1,5\n0.75;1,2\n", {}, "use one decimal sign"),
    "an empty cell": ("t,a\n0,1\n0.25,\n0.5,2\n0.75,1\n", {}, "line 3 has no number in column 2: nothing"),
    "not a number": ("t,a\n0,1\n0.25,nan\n0.5,2\n0.75,1\n", {}, "line 3 has no number in column 2: nan"),
    "no such name": (HEADED, {"column": "thata"}, 'has no column "thata"; did you mean theta?'),
    "a name without names": (rows(), {"column": "theta"}, "its columns have no names"),
    "the time's column": (HEADED, {"column": "t"}, 'column 1 ("t") is the time'),
    "a plunge for a pitch": ("time,plunge,pitch\n" + rows(separator=",1,"), {}, 'column 2 ("plunge") is not the pitch'),
    "metres for a pitch": ("t,Z (m)\n" + rows(), {}, "is in m, which is not an angle"),
    "an unknown unit": (HEADED, {"unit": "grad"}, 'unit = "grad" is not an angle; give deg or rad'),
    "microseconds": ("t (us),theta\n" + rows(), {}, "has times in us; give them in s, ms or periods"),
    "microseconds with a micro sign": ("t (\u00b5s),theta\n" + rows(), {}, "has times in \u00b5s"),
    "frames": ("t (frames),theta\n" + rows(), {}, "has times in frames"),
    "a column of frames": ("frame,theta\n" + rows(), {}, 'column 1 ("frame") has times in frame'),
    "a rate": ("t,theta (rad/s)\n" + rows(), {}, "is in rad/s, which is not an angle in a supported unit"),
    "times for a pitch": ("t (s),t (ms),pitch\n" + rows(separator=",1,"), {}, "is in ms, which is not an angle"),
    "two columns of a name": ("t,pitch_left,pitch_right\n" + rows(separator=",1,"), {"column": "pitch"},
        'has several columns "pitch": column 2 ("pitch_left"), column 3 ("pitch_right")'),
    "periods of a run": ("t/T,theta\n" + rows(), {"periodic": False}, "cover 0 to 0.04 s but the case runs from 0 to "
    "0.08 s; give more points, or make it periodic"),
    "names with spaces between spaces": ("time (ms)  pitch angle (rad)\n" + rows(separator="  "), {}, "3 names for 2"),
    "beyond the period": (rows(times=1.02 * TURNS), {}, "1.02 periods instead of about one"),
    "a spreadsheet": (b"PK\x03\x04 and more", {}, "a spreadsheet, not a text file; save its columns as CSV"),
    "a binary file": (b"\x00\x01\x02\x03", {}, "not a text file"),
    "words for headings": ("Stroke\nof the\nthird moth\nt,theta\n" + rows(), {}, "line 4 holds no numbers: t,theta"),
    "time_column 0": (rows(), {"time_column": 0}, "time_column = 0: must be a name or a whole number >= 1"),
    "too many harmonics": (rows(), {"smooth": 30}, "smooth = 30: 41 points resolve at most 20 harmonics"),
    "two ways to smooth": (rows(), {"smooth": 8, "smooth_error_deg": 0.1}, "give either smooth or smooth_error"),
    "smooth without a period": (rows(), {"smooth": 8, "periodic": False}, "smooth and smooth_error need a periodic "
    "table"),
}  # fmt: skip


def test_micrometres_are_not_metres(tmp_path):
    for unit in ("\u00b5m", "\u03bcm", "um"):
        with pytest.raises(CaseError, match=f"is in {unit}, which is not a length in a supported unit"):
            case_with(tmp_path, f"t,Z ({unit})\n" + rows(1e6 * PLUNGE), "plunge")


@pytest.mark.parametrize("kind", REFUSED)
def test_a_table_that_cannot_be_right_is_refused(kind, tmp_path):
    content, keys, phrase = REFUSED[kind]
    with pytest.raises(CaseError) as caught:
        case_with(tmp_path, content, **keys)
    (problem,) = caught.value.problems
    assert problem.startswith("motion.pitch")
    assert phrase in problem


RANDOM = np.random.default_rng(2)
MANY = np.arange(200) / 200
HOLE = range(8, 24)
CLOSE = np.sort(np.append(TURNS, 0.40003))
WARNED = {
    "half a beat": ("pitch", rows(PITCH[:21], TURNS[:21]), {}, "without points between 0.5 and 1 of the period"),
    "a hole": ("pitch", rows(np.delete(PITCH, HOLE), np.delete(TURNS, HOLE)), {}, "between 0.175 and 0.6"),
    "radians": ("pitch", rows(np.radians(PITCH)), {}, "stays below 0.262 deg while the wing travels 2 chords"),
    "degrees for a plunge": ("plunge", rows(3e3 * PLUNGE), {}, "6e+03 chords; lengths are in m: if its values are "
    "millimetres"),
    "noise": ("pitch", rows(PITCH + 0.3 * RANDOM.standard_normal(41) * (TURNS % 1 > 0)), {}, "smooth = 8"),
    "few digits": ("plunge", rows(0.02 * np.cos(2 * np.pi * MANY), MANY, digits=4), {}, "noisy, rounded or too close"),
    "points too close": (
        "plunge",
        rows(0.02 * np.cos(2 * np.pi * CLOSE), CLOSE, digits=4),
        {},
        "noisy, rounded or too close",
    ),
    "nothing but zeros": ("pitch", rows(0 * PITCH), {}, "whose values are all 0; check its column"),
    "too few harmonics": ("pitch", rows(np.sign(PITCH).round()), {"smooth": 1}, "give a larger smooth"),
    "milliseconds of a run": ("pitch", rows(times=80 * TURNS), {"periodic": False}, 'give time = "ms"'),
    "periods of a run": ("pitch", rows(times=2 * TURNS), {"periodic": False}, 'give time = "periods"'),
}  # fmt: skip


@pytest.mark.parametrize("kind", WARNED)
def test_a_table_that_is_hardly_meant_is_warned_of(kind, tmp_path):
    name, content, keys, phrase = WARNED[kind]
    case = case_with(tmp_path, content, name, **keys)
    assert phrase in "\n".join(warnings.warnings(case))


def test_sharp_waves_are_not_taken_for_noise():
    for points in (12, 20, 40, 200):
        turns = np.arange(points) / points
        for wave in (np.tanh(3 * np.sin(2 * np.pi * turns)), np.arcsin(0.99 * np.cos(2 * np.pi * turns))):
            ratio, _ = tables.roughness(tuple(zip(turns.tolist(), wave.tolist(), strict=True)), 25.0)
            assert ratio < 2.0
    corner = tuple((0.01 * n, 1.0 * max(0, n - 30)) for n in range(60))
    assert tables.roughness(corner, None)[0] < 6.0
    noisy = tuple((t, v + 1e-2 * RANDOM.standard_normal()) for t, v in corner)
    assert tables.roughness(tuple((t, np.sin(t) + 1e-3 * RANDOM.standard_normal()) for t, _ in noisy), None)[0] > 8.0


@pytest.mark.parametrize("key", ["smooth", "smooth_error_deg"])
def test_a_smoothed_table_of_harmonics_is_these_harmonics(key, tmp_path):
    """For exact points the curve and its derivatives are exact; for noisy ones the error is that of the noise."""

    def beat(t):
        return 5.0 + 20 * np.sin(2 * np.pi * t + 0.3) + 4 * np.sin(6 * np.pi * t - 1.0)

    times = np.sort(np.random.default_rng(0).random(60))
    case = case_with(tmp_path, rows(beat(times), times, digits=12), **{key: 4 if key == "smooth" else 1e-4})
    harmonic = hawkmoth(
        "solver=dbet", "wing.modes=0", "time.periods=2", "time.steps_per_period=100",
        "motion.pitch={amplitude_deg=20, phase_deg=17.188733853924695, mean_deg=5, "
        "harmonics_deg=[[3, 4.0, -57.29577951308232]]}",
    )  # fmt: skip
    here, there = (sampling.sample(one.motion, np.linspace(0, 0.08, 301)) for one in (case, harmonic))
    scale = np.abs(there).max(axis=0) + 1e-12
    np.testing.assert_allclose(here / scale, there / scale, atol=1e-6)
    noise = 0.2 * np.random.default_rng(1).standard_normal(60)
    points = tuple(zip(times.tolist(), (beat(times) + noise).tolist(), strict=True))
    found = fourier.series(points, 4)
    assert found.residual == pytest.approx(0.2 * np.sqrt(51 / 60), rel=0.15)
    assert not found.blind


def test_a_tolerance_takes_no_more_harmonics_than_it_needs(tmp_path, monkeypatch):
    """The most that many points resolve would take a matrix of as many rows and columns."""
    fitted = []
    fit = fourier._fit
    monkeypatch.setattr(fourier, "_fit", lambda points, harmonics: fitted.append(harmonics) or fit(points, harmonics))
    turns = np.arange(500) / 500
    points = tuple(zip(turns.tolist(), np.sin(4 * np.pi * turns).tolist(), strict=True))
    assert len(fourier.series(points, None, 1e-6).terms) == 2
    assert max(fitted) == 2


def test_a_tolerance_takes_the_fewest_harmonics_that_meet_it():
    noise = np.random.default_rng(4).standard_normal(30)
    points = tuple(zip((np.arange(30) / 30).tolist(), noise.tolist(), strict=True))
    residuals = [fourier.series(points, n).residual for n in range(1, 15)]
    for n, residual in enumerate(residuals, 1):
        assert len(fourier.series(points, None, 1.0001 * residual).terms) == n
    assert len(fourier.series(points, None, 1e-9).terms) == 14  # the most that there are
    assert len(fourier.series(points[:4], None, 1e-9).terms) == 1


def test_ends_that_differ_are_smoothed_together(tmp_path):
    case = case_with(tmp_path, rows(PITCH + 0.5 * TURNS), smooth=5)
    np.testing.assert_allclose(np.degrees(moved(case, sampling.PITCH)), PITCH + 0.25, atol=0.4)


COLUMNS = "t,b1,b2,rad_rad\n" + "".join(
    f"{t},{v:.6f},{2 * v:.6f},{np.radians(v):.9f}\n" for t, v in zip(TURNS, PITCH, strict=True)
)


def peak(case):
    return np.degrees(np.abs(moved(case, sampling.PITCH)).max())


def test_a_changed_column_or_file_is_read_again(tmp_path):
    case = case_with(tmp_path, COLUMNS)
    (tmp_path / "other.csv").write_text(rows(3 * PITCH))
    assert peak(case) == pytest.approx(15)
    assert peak(case.override("motion.pitch.column=3")) == pytest.approx(30)
    assert peak(case.override("motion.pitch.column=b2")) == pytest.approx(30)
    assert peak(case.override("wing.modes=1").changed({"motion.pitch.column": 3})) == pytest.approx(30)
    assert peak(case.override("motion.pitch.file=other.csv")) == pytest.approx(45)
    assert peak(case.override("motion.pitch.column=4")) == pytest.approx(15)
    assert peak(case.override("motion.pitch.column=4", "motion.pitch.unit=deg")) == pytest.approx(
        np.radians(15), rel=1e-5
    )
    assert peak(case.override("motion.pitch.smooth=3").override("motion.pitch.column=3")) == pytest.approx(30)
    with pytest.raises(CaseError, match="line 2 has no column 7"):
        case.override("motion.pitch.column=7")
    with pytest.raises(CaseError, match=r"motion.pitch.column = 3: no file is named; give file"):
        parse_case(case.to_dict()).override("motion.pitch.column=3")


def test_a_sweep_over_columns_reads_each(tmp_path):
    case_with(tmp_path, COLUMNS)
    document = hawkmoth("solver=dbet", "wing.modes=0", "time.periods=2", "time.steps_per_period=100").to_toml()
    before, _, after = document.partition("[motion.pitch]")
    table = '[motion.pitch]\nkind = "table"\nperiodic = true\nfile = "table.txt"\n'
    (tmp_path / "case.toml").write_text(before + table + "[motion.surge]" + after.partition("[motion.surge]")[2])
    case = load_case(tmp_path / "case.toml")
    file = tmp_path / "map.h5"
    swept = taichiflap.sweep(case, {"motion.pitch.column": [2, 3]}, file, metrics=["force_vertical_mean"])
    found = swept["force_vertical_mean"].values
    for column, force in zip((2, 3), found, strict=True):
        with taichiflap.simulate(load_case(tmp_path / "case.toml", [f"motion.pitch.column={column}"])) as result:
            assert taichiflap.summarise(result).force_vertical.mean == pytest.approx(force, rel=1e-12)
    assert found[1] > 1.5 * found[0] > 0.0
