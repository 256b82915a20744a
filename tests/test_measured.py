"""Measured flapping angles: their path for every definition of the angles, and invalid angles."""

import numpy as np
import pytest
from conftest import CASES, hawkmoth

import taichiflap
from taichiflap.case.case import CaseError, load_case, parse_case
from taichiflap.motion import measured as angles
from taichiflap.motion import sampling

RADIUS, FREQUENCY = 0.03, 25.0
TURNS = np.arange(40) / 40
FIELDS = ("force_y", "force_z", "moment", "power", "tip_deflection")


def beat(turns, deviation=1.0):
    """Stroke forward, deviation up, and the lean of the leading edge forward, degrees."""
    w = 2 * np.pi * np.asarray(turns)
    return (
        5.0 + 38.0 * np.cos(w) + 2.0 * np.sin(3 * w),
        deviation * (3.0 + 6.0 * np.sin(2 * w + 0.5)),
        -40.0 * np.sin(w - 0.1) + 4.0 * np.sin(3 * w),
    )


def case_of(rows, folder=None, **keys):
    document = hawkmoth("solver=dbet", "wing.modes=1", "time.periods=2", "time.steps_per_period=100").to_dict()
    given = {"time": "periods", "rotation_from": "normal", "radius": RADIUS} | keys
    if rows is not None:
        given["angles_deg"] = [list(map(float, row)) for row in rows]
    document["motion"] = {"frequency": FREQUENCY, "measured": {k: v for k, v in given.items() if v is not None}}
    return parse_case(document, folder=folder) if folder else parse_case(document)


def rows_of(turns=TURNS, **keys):
    return np.column_stack((turns, *beat(turns, **keys)))


def moved(case):
    return sampling.sample(case.motion, TURNS / FREQUENCY)


def assert_same(one, other, share=1e-10):
    here, there = moved(one), moved(other)
    size = np.maximum(np.abs(there).max(axis=0), np.abs(here).max(axis=0)) + 1e-300
    np.testing.assert_allclose(here / size, there / size, atol=share)


def test_without_deviation_it_is_plunge_and_pitch_bit_for_bit():
    case = case_of(rows_of(deviation=0.0))
    assert case.motion.surge == hawkmoth().motion.surge
    document = case.to_dict()
    document["motion"] = {
        "frequency": FREQUENCY,
        "plunge": case.motion.plunge.model_dump(mode="json"),
        "pitch": case.motion.pitch.model_dump(mode="json"),
    }
    with taichiflap.simulate(case) as one, taichiflap.simulate(parse_case(document)) as other:
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    stroke, _, lean = beat(TURNS)
    np.testing.assert_allclose(moved(case)[:, sampling.PLUNGE], np.radians(stroke) * RADIUS, atol=1e-12)
    np.testing.assert_allclose(np.degrees(moved(case)[:, sampling.PITCH]), -lean, atol=1e-9)


@pytest.mark.parametrize("solver", ["dbet", "uvlm"])
@pytest.mark.parametrize("plane", [35.0, -90.0])
def test_another_stroke_plane_turns_the_forces(solver, plane):
    """The same angles relative to a stroke plane that is inclined forward."""
    flat = case_of(rows_of()).override(f"solver={solver}", "uvlm.panels=10", "uvlm.core=0.2", "time.periods=1")
    steep = flat.override(f"motion.measured.stroke_plane_deg={plane}")
    with taichiflap.simulate(flat) as one, taichiflap.simulate(steep) as other:
        turn = np.radians(plane)
        up, forward = -one.force_y, one.force_z
        size = np.abs(forward).max()
        turned_up = np.cos(turn) * up - np.sin(turn) * forward
        turned_forward = np.sin(turn) * up + np.cos(turn) * forward
        np.testing.assert_allclose(-other.force_y, turned_up, atol=1e-9 * size)
        np.testing.assert_allclose(other.force_z, turned_forward, atol=1e-9 * size)
        np.testing.assert_allclose(other.power, one.power, atol=1e-9 * np.abs(one.power).max())


def test_the_stroke_reverses_when_it_does_in_any_plane():
    flat = case_of(rows_of(deviation=0.5))
    found = sampling.reversals(flat.motion.model_copy(), 0.0, 0.2, 1e-4)
    assert len(found) == 10
    for plane in (30.0, 90.0, -120.0):
        steep = flat.override(f"motion.measured.stroke_plane_deg={plane}")
        np.testing.assert_allclose(sampling.reversals(steep.motion, 0.0, 0.2, 1e-4), found, rtol=1e-9)
    surging = hawkmoth("motion.plunge.amplitude=0.0", "motion.surge={amplitude=0.02, phase_deg=90.0}")
    there = sampling.reversals(surging.motion, 0.0, 0.2, 1e-4)
    np.testing.assert_allclose(there, sampling.reversals(hawkmoth().motion, 0.0, 0.2, 1e-4), atol=1e-12)


def test_the_path_is_that_of_the_vectors():
    """An independent sum of vectors in (forward, up), for a left wing too."""
    stroke, deviation, lean = (np.radians(angle) for angle in beat(TURNS))
    tilt = np.radians(25.0)
    forward = RADIUS * (stroke * np.cos(tilt) + deviation * np.sin(tilt))
    up = RADIUS * (deviation * np.cos(tilt) - stroke * np.sin(tilt))
    edge = np.sin(lean + tilt), np.cos(lean + tilt)  # where the leading edge points: forward, up
    for side, sign in (("right", 1.0), ("left", -1.0)):
        found = moved(case_of(rows_of(), stroke_plane_deg=25.0, side=side))
        np.testing.assert_allclose(sign * found[:, sampling.PLUNGE], forward, atol=1e-12)
        np.testing.assert_allclose(-found[:, sampling.SURGE], up, atol=1e-12)
        pitch = found[:, sampling.PITCH]
        np.testing.assert_allclose(-sign * np.sin(pitch), edge[0], atol=1e-10)
        np.testing.assert_allclose(np.cos(pitch), edge[1], atol=1e-10)


def test_conventions_are_of_one_motion():
    stroke, deviation, lean = beat(TURNS)
    case = case_of(rows_of())
    plane = np.column_stack((TURNS, stroke, deviation, 90.0 - lean))
    assert_same(case_of(plane, rotation_from="plane"), case)
    other = np.column_stack((TURNS, -stroke, -deviation, lean))
    assert_same(case_of(other, stroke_positive="backward", deviation_positive="down"), case)
    milliseconds = np.column_stack((1e3 * TURNS / FREQUENCY, stroke, deviation, lean))
    assert_same(case_of(milliseconds, time="ms"), case)
    assert_same(case_of(rows_of(), radius=None, radius_share=RADIUS / 0.05), case)


def test_a_geometric_angle_of_attack_turns_with_the_stroke():
    turns = np.arange(80) / 80
    stroke, lean = 40.0 * np.cos(2 * np.pi * turns), -45.0 * np.sin(2 * np.pi * turns)
    attack = 90.0 - np.abs(lean)
    rows = np.column_stack((turns, stroke, 0 * stroke, lean))
    assert_same(
        case_of(np.column_stack((turns, stroke, 0 * stroke, attack)), rotation_from="attack"), case_of(rows), 1e-8
    )


def test_beats_are_averaged_and_their_noise_and_spread_told():
    turns = np.arange(240) / 60.0
    size = np.array([0.97, 1.0, 1.03, 1.0])[turns.astype(int)]
    rng = np.random.default_rng(3)
    rows = np.column_stack((turns, *(size * angle + 0.3 * rng.standard_normal(240) for angle in beat(turns))))
    case = case_of(rows)
    found = angles.fits(case.motion.measured, FREQUENCY)
    for fit, exact in zip(found.values(), beat(TURNS), strict=True):
        swing = np.std(exact + 0.0)
        assert 0.25 < fit.series.residual < 0.3 + 0.03 * (np.abs(exact).max())
        assert fit.spread == pytest.approx(np.std([0.97, 1, 1.03, 1], ddof=1) * np.sqrt(np.mean(exact**2)), abs=0.2)
        assert swing > 10 * fit.spread or fit.spread < 0.5
    np.testing.assert_allclose(moved(case)[:, sampling.PLUNGE], RADIUS * np.radians(beat(TURNS)[0]), atol=2e-4)
    assert angles.fits(case_of(rows_of()).motion.measured, FREQUENCY)["stroke"].spread is None


TABLE = "t (ms),stroke (deg),deviation (deg),rotation (deg)\n"


def text_of(rows, scale=1e3 / FREQUENCY):
    return "".join(f"{scale * t:.9g}," + ",".join(f"{v:.9g}" for v in angles_) + "\n" for t, *angles_ in rows)


@pytest.mark.parametrize(
    ("content", "keys"),
    [
        (TABLE + text_of(rows_of()), {}),
        ("rotation;stroke;time_s;deviation\n" + "".join(
            f"{r:.9f};{s:.9f};{t / FREQUENCY:.9f};{d:.9f}\n" for t, s, d, r in rows_of()
        ), {}),
        (text_of(rows_of()), {"time": "ms"}),
        ("a,b,c,d\n" + text_of(rows_of(), 1.0), {"time": "periods", "stroke": 2, "deviation": "c", "rotation": "d"}),
        ("rotation angle;deviation angle;stroke angle;t [ms]\n" + "".join(
            f"{r:.9f};{d:.9f};{s:.9f};{1e3 * t / FREQUENCY:.9f}\n" for t, s, d, r in rows_of()
        ), {}),
        ("t_ms,phi_rad,theta_rad,alpha_rad\n" + text_of(
            np.column_stack((TURNS, *np.radians(np.array(beat(TURNS)))))
        ), {}),
    ],
)  # fmt: skip
def test_angles_are_read_from_a_file(content, keys, tmp_path):
    (tmp_path / "moth.csv").write_text(content)
    case = case_of(None, tmp_path, **{"file": "moth.csv", "time": None} | keys)
    assert_same(case, case_of(rows_of()), 1e-7)
    assert parse_case(case.to_dict()) == case
    assert case.override("motion.measured.radius=0.06").motion.plunge.harmonics[0][1] == pytest.approx(
        2 * case.motion.plunge.harmonics[0][1]
    )


def test_a_table_of_stroke_and_rotation_has_no_deviation(tmp_path):
    (tmp_path / "moth.csv").write_text("".join(f"{t},{s},{r}\n" for t, s, _, r in rows_of()))
    case = case_of(None, tmp_path, file="moth.csv")
    assert_same(case, case_of(rows_of(deviation=0.0)))


STEP = np.where(TURNS >= 0.5, 70.0, 0.0)
BEATS = np.arange(160) / 40
RAMP = np.column_stack((TURNS, beat(TURNS)[0], 20.0 * TURNS, beat(TURNS)[2]))


@pytest.mark.parametrize(
    ("rows", "keys", "phrase"),
    [
        (rows_of() + [0, 1, 0, 0] * STEP[:, None], {}, "stroke jumps from"),
        (np.where(np.arange(4) == 3, rows_of() % 360, rows_of()), {}, "the angle was wrapped: add or subtract 360 deg"),
        (RAMP, {}, "deviation begins with 0 deg but ends the beat with 19.5"),
        (rows_of(BEATS) + np.outer(BEATS, [0, 0, 5, 0]), {}, "deviation has a mean that drifts from"),
        (np.column_stack((1.07 * BEATS, *beat(BEATS))), {}, "4 beats have unequal lengths: at 25 Hz"),
        (np.column_stack((1.07 * BEATS, *beat(BEATS))), {}, "they look like 23.3"),
        (np.column_stack((BEATS + 0.2 * np.sin(2 * BEATS), *beat(BEATS))), {}, "give beats of equal length"),
        (rows_of() * [1 / FREQUENCY, 1, 1, 1], {}, 'they look like s: give time = "s"'),
        (rows_of(), {"time": "s"}, 'they look like periods: give time = "periods"'),
        (rows_of()[:20], {}, "0.5 of a beat"),
        (rows_of()[:1], {}, "has a single point; give at least one beat with 8 points"),
        (rows_of(), {"smooth": 25}, "smooth = 25: 40 points resolve at most 19 harmonics"),
        (rows_of(), {"radius": 0}, "motion.measured.radius = 0: must be a number > 0"),
        (rows_of(), {"radius": None}, "give either radius (m) or radius_share (of wing.span)"),
        (rows_of(), {"radius_share": 0.5}, "give either radius (m) or radius_share"),
        (rows_of(), {"rotation_from": None}, "motion.measured.rotation_from: missing"),
        (rows_of()[::-1], {}, "times must increase"),
        (None, {}, "has no angles"),
        (rows_of() - [0, 0, 0, 60], {"rotation_from": "attack"}, "where it must pass 90 deg"),
    ],
)  # fmt: skip
def test_angles_that_cannot_be_are_refused_in_a_sentence(rows, keys, phrase):
    with pytest.raises(CaseError) as caught:
        case_of(rows, **keys)
    (problem,) = caught.value.problems
    assert problem.startswith("motion.measured")
    assert phrase in problem


def test_missing_and_doubled_columns_are_named(tmp_path):
    (tmp_path / "moth.csv").write_text("t,phi,theta\n" + text_of(rows_of()[:, :3], 1.0))
    with pytest.raises(CaseError, match=r"which column is rotation; its columns are 1: t, 2: phi, 3: theta"):
        case_of(None, tmp_path, file="moth.csv")
    (tmp_path / "both.csv").write_text("t,phi_left,phi_right,theta,alpha\n0,1,2,3,4\n")
    with pytest.raises(CaseError, match=r'several columns may be stroke: column 2 \("phi_left"\), column 3'):
        case_of(None, tmp_path, file="both.csv")
    with pytest.raises(CaseError, match="the same column is used twice"):
        case_of(None, tmp_path, file="moth.csv", rotation="theta", deviation="theta")
    with pytest.raises(CaseError, match="give either plunge, pitch and surge or measured"):
        case_of(rows_of()).override("motion.plunge.amplitude=0.01")


def test_the_shipped_moth_flies():
    case = load_case(CASES / "measured_moth.toml")
    fits = angles.fits(case.motion.measured, case.motion.frequency)
    assert all(0.3 < fit.series.residual < 0.7 for fit in fits.values())  # it was made with a noise of 0.4 degrees
    swept = taichiflap.sweep(case, {"motion.measured.stroke_plane_deg": [0.0, 20.0]}, metrics=["force_vertical_mean"])
    assert np.ptp(swept["force_vertical_mean"].values) > 1e-4
