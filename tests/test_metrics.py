"""Statistics of synthetic and of real runs."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import CASES, hawkmoth

import taichiflap
from taichiflap.case.case import parse_case
from taichiflap.commands import summary as report
from taichiflap.march.reference import reference
from taichiflap.metrics import names as quantities
from taichiflap.metrics import summary as metrics
from taichiflap.metrics import waves
from taichiflap.metrics.beats import settled_beats, whole_beats
from taichiflap.metrics.similarity import Similarity
from taichiflap.metrics.uncertainty import standard_errors
from taichiflap.metrics.unsettled import unsettled
from taichiflap.motion import sampling
from taichiflap.results.variables import VARIABLES


def synthetic(case, **series):
    """A result-like object with the given functions of time."""
    time = case.step * np.arange(0, case.steps + 1, case.output.every)
    names = (
        "tip_deflection", "force_normal", "force_vertical", "force_vertical_normal", "power", "power_aerodynamic",
        "power_inertial", "force_y", "force_z", "force_axial", "moment",
    )  # fmt: skip
    values = {name: series.get(name, np.zeros_like)(time) for name in names}
    return SimpleNamespace(case=case, time=time, variables=tuple(values), **values)


def beat(t):
    return np.ceil(np.round(t * 25.0, 9))


def test_a_run_that_drifts_is_not_settled_and_half_of_it_is_kept():
    case = hawkmoth("time.periods=12")
    summary = metrics.summarise(
        synthetic(case, force_y=lambda t: -beat(t), force_vertical=beat, power=lambda t: np.sin(50 * np.pi * t))
    )
    assert summary.beats == 6
    assert summary.force_vertical.mean == pytest.approx(9.5)
    assert summary.force_vertical.spread == pytest.approx(np.std([7, 8, 9, 10, 11, 12]))
    rms = np.sqrt(np.mean(np.square([10, 11, 12])))
    assert summary.force_drift == pytest.approx(5.0 / rms)
    assert not summary.settled
    assert summary.power.mean == pytest.approx(0.0, abs=1e-12)
    assert summary.power_positive.mean == pytest.approx(1 / np.pi, rel=1e-3)


@pytest.mark.parametrize("disturbed", range(7))
def test_beats_that_the_start_disturbs_are_dropped_and_no_others(disturbed, rng):
    case = hawkmoth("time.periods=14")
    noise = 1e-3 * rng.standard_normal(15)

    def force(t):
        n = beat(t)
        return 1.0 + noise[n.astype(int)] + np.where((n <= disturbed) & (n > 0), 0.5 ** np.maximum(n, 1.0), 0.0)

    result = synthetic(case, force_z=force)
    beats = settled_beats(result)
    assert 0 <= 14 - len(beats) - disturbed <= 2
    summary = metrics.summarise(result)
    assert summary.settled
    assert summary.beats == len(beats)


@pytest.mark.parametrize("count", [2, 3, 8, 15, 40])
@pytest.mark.parametrize("offset", [0.0, 1e3])
@pytest.mark.parametrize("start", [0.3, 1.0, 20.0])
def test_the_beats_that_are_kept_have_the_least_standard_error(count, offset, start, rng):
    case = hawkmoth(f"time.periods={count}", "time.steps_per_period=8")
    fade = 0.6 ** np.arange(count + 1)
    y, z = offset + rng.standard_normal((2, count + 1)) * 0.1 + rng.standard_normal((2, 1)) * start * fade
    found = settled_beats(
        synthetic(case, force_y=lambda t: y[beat(t).astype(int)], force_z=lambda t: z[beat(t).astype(int)])
    )
    kept = [np.array([y[1 + n :], z[1 + n :]]) for n in range(count // 2 + 1)]
    errors = [np.sum(np.var(forces, axis=1)) / forces.shape[1] for forces in kept]
    assert len(found) == count - int(np.argmin(errors))


def test_differences_of_a_millionth_disturb_no_beat_and_of_a_ten_thousandth_they_do(rng):
    case = hawkmoth("time.periods=12", "time.steps_per_period=8")
    noise = rng.standard_normal((2, 13))
    fade = 0.3 ** np.arange(13)

    def kept(size, start):
        y, z = 5.0 * (1.0 + size * noise + start * fade)
        return len(
            settled_beats(
                synthetic(case, force_y=lambda t: y[beat(t).astype(int)], force_z=lambda t: z[beat(t).astype(int)])
            )
        )

    assert kept(1e-7, 0.0) == 12
    assert kept(0.0, 1e-7) == 12
    assert kept(1e-6, 1e-4) < 12


@pytest.mark.parametrize(("count", "size"), [(3000, 0.1), (10_000, 1.0 / 3.0)])
def test_a_run_that_repeats_to_the_digit_keeps_all_its_beats_however_many(count, size):
    case = hawkmoth(f"time.periods={count}", "time.steps_per_period=4")
    made = synthetic(case, force_y=lambda t: np.full_like(t, size), force_z=lambda t: np.full_like(t, -0.7))
    assert len(settled_beats(made)) == count


def test_a_run_without_frames_has_no_beats():
    assert len(whole_beats(hawkmoth(), np.zeros(0))) == 0


def test_every_quantity_has_the_units_of_what_it_is_taken_of():
    units = {name: one.units for name, one in quantities.METRICS.items()}
    for name in metrics.MEANS:
        assert units[f"{name}_mean"] == units[f"{name}_spread"] == units[f"{name}_error"] == VARIABLES[name].units
    for name in metrics.WAVING:
        assert units[f"{name}_harmonic_2"] == VARIABLES[name].units
    assert {units[f"{name}_mean"] for name in ("lift", "thrust", "force_normal_peak")} == {"N"}
    assert (units["tip_peak_mean"], units["lift_per_power"], units["force_normal_phase"]) == ("m", "N W-1", "degree")
    assert set(units.values()) <= {"1", "N", "N m", "m", "W", "N W-1", "degree", "m s-1", "m2"}


def test_two_beats_are_too_few_to_call_settled():
    assert metrics.summarise(synthetic(hawkmoth("time.periods=2"), force_y=np.ones_like)).settled is False
    assert metrics.summarise(synthetic(hawkmoth("time.periods=3"), force_y=np.ones_like)).settled is True
    assert metrics.summarise(synthetic(hawkmoth("time.periods=6"), force_y=np.ones_like)).settled is True


def test_drift_and_spread_of_few_beats():
    """Two beats have a trend and a deviation; one beat has neither."""
    case = hawkmoth("time.periods=2")
    two = synthetic(case, force_y=lambda t: 3.0 * beat(t), force_z=lambda t: 7.0 + 4.0 * beat(t))
    beats = whole_beats(case, two.time)
    size = np.sqrt(6.0**2 + 15.0**2)
    summary = metrics.summarise(two, beats)
    assert (summary.force_drift, summary.force_spread) == pytest.approx((5.0 / size, 2.5 / size))
    last = metrics.summarise(two, beats.after(1))
    assert (last.beats, last.force_drift, last.force_spread) == (1, 0.0, 0.0)
    unloaded = metrics.summarise(synthetic(case), beats)
    assert (unloaded.force_drift, unloaded.force_spread) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("forces", "words"),
    [
        (lambda t: 10.0 + 0.1 * beat(t), "not yet periodic"),
        (lambda t: 10.0 + np.where(beat(t) % 2 == 0, 0.5, -0.5), "do not repeat"),
        (lambda t: 10.0 + np.sin(50 * np.pi * t), ""),
    ],
)
def test_a_run_that_has_not_settled_is_warned_about(forces, words):
    summary = metrics.summarise(synthetic(hawkmoth("time.periods=12"), force_z=forces))
    said = unsettled(summary)
    assert bool(said) == bool(words)
    assert words in said


def test_a_motion_that_does_not_repeat_is_summarised_over_the_whole_run():
    document = hawkmoth().to_dict()
    pitch = {"kind": "ramp", "start": 0.2, "ramp": 0.1, "smoothing": 50.0, "amplitude_deg": 45.0}
    document |= {"motion": {"pitch": pitch}, "time": {"duration": 1.0, "step": 0.01}}
    case = parse_case(document)
    summary = metrics.summarise(
        synthetic(case, force_vertical=lambda t: t, tip_deflection=lambda t: t * (1.5 - t), force_y=lambda t: t)
    )
    assert (summary.beats, summary.settled, summary.force_normal_phase) == (1, None, None)
    assert summary.force_vertical.mean == pytest.approx(0.505)
    assert summary.tip_peak_time * case.beat == pytest.approx(0.75)
    lines = "\n".join(report._statistics(case, summary))
    made = synthetic(case, tip_deflection=lambda t: t)
    assert metrics.summarise(made).tip_peak_time == 1.0  # at its end, which is no beginning
    assert "over the whole run" in lines
    assert "t = 0.75 s" in lines
    assert unsettled(summary) == ""


@pytest.mark.parametrize("every", [1, 3, 7])
@pytest.mark.parametrize(("lag", "phase"), [(0.0, 0.0), (30.0, -30.0), (200.0, 160.0)])
def test_phase_of_the_first_harmonic_to_the_stroke(lag, phase, every):
    case = hawkmoth("time.periods=14", f"output.every={every}", "motion.plunge.phase_deg=90.0")

    def force(t):
        stroke = 50 * np.pi * t + np.pi / 2
        return 3.0 * np.sin(stroke - np.radians(lag)) + np.sin(3 * stroke)

    tolerance = 1e-9 if every == 1 else 1.5
    summary = metrics.summarise(synthetic(case, force_normal=force))
    assert summary.force_normal_phase == pytest.approx(phase, abs=tolerance)


@pytest.mark.parametrize(
    "settings",
    [
        ("motion.plunge.phase_deg=37.0",),
        ("motion.plunge={kind='triangle', sharpness=0.9, amplitude=0.02, phase_deg=-100.0, mean=0.3}",),
    ],
)
@pytest.mark.parametrize("lead", [-120.0, 0.0, 75.0, 180.0])
def test_a_force_that_goes_with_the_plunge_leads_it_by_its_lead(settings, lead):
    case = hawkmoth("time.periods=2", *settings)
    times = case.step * np.arange(case.steps + 1) + lead / 360.0 * case.beat
    plunge = sampling.sample(case.motion, times)[:, sampling.PLUNGE]
    found = metrics.summarise(synthetic(case, force_normal=lambda t: 40.0 * plunge)).force_normal_phase
    assert (abs(found) if lead == 180.0 else found) == pytest.approx(lead, abs=1e-6)


def test_a_force_that_goes_with_a_growing_plunge_is_in_phase_with_it():
    case = hawkmoth("time.periods=2", "motion.start_up_periods=4.0", "motion.plunge.phase_deg=20.0")
    plunge = sampling.sample(case.motion, case.step * np.arange(case.steps + 1))[:, sampling.PLUNGE]
    made = synthetic(case, force_normal=lambda t: 40.0 * plunge)
    for beats in (whole_beats(case, made.time).after(1), whole_beats(case, made.time[:201])):
        assert metrics.summarise(made, beats).force_normal_phase == pytest.approx(0.0, abs=0.5)


def test_without_a_first_harmonic_of_the_plunge_the_phase_is_to_the_pitch():
    case = hawkmoth(
        "time.periods=4",
        "motion.plunge={amplitude=0.0, mean=0.1, harmonics=[[2, 0.02, 10.0]]}",
        "motion.pitch.phase_deg=50.0",
    )
    summary = metrics.summarise(synthetic(case, force_normal=lambda t: np.sin(50 * np.pi * t + np.radians(70.0))))
    assert summary.force_normal_phase == pytest.approx(20.0)


def test_harmonics_are_recovered_exactly():
    case = hawkmoth()
    time = case.step * np.arange(1, 401)
    values = 2.0 * np.cos(50 * np.pi * time + 0.3) + 0.5 * np.cos(150 * np.pi * time - 1.0) + 7.0
    assert waves.harmonic(case, time, values) == pytest.approx(2.0 * np.exp(0.3j))
    assert waves.harmonic(case, time, values, 3) == pytest.approx(0.5 * np.exp(-1j))


def test_harmonics_of_a_summary_are_those_of_its_settled_beats():
    def swing(t):
        return np.where(t > 0.041, 3e-3 + 2e-3 * np.cos(50 * np.pi * t + 0.3) + 1e-3 * np.sin(100 * np.pi * t), 1.0)

    case = hawkmoth("time.periods=4")
    made = synthetic(case, tip_deflection=swing, force_normal=lambda t: np.sin(150 * np.pi * t))
    found = metrics.summarise(made, whole_beats(case, made.time).after(2)).harmonics
    np.testing.assert_allclose(found["tip_deflection"], [2e-3 * np.exp(0.3j), -1e-3j, 0.0], atol=1e-15)
    np.testing.assert_allclose(found["force_normal"], [0.0, 0.0, -1j], atol=1e-12)
    np.testing.assert_allclose(found["force_vertical"], 0.0)


def test_a_summary_tells_of_the_wake_what_the_run_had_come_to_at_its_end():
    made = synthetic(hawkmoth("time.periods=2"))
    bare = metrics.summarise(made)
    assert (bare.wake_lost, bare.wake_far_error, bare.wake_crossings) == (None, None, None)
    made.variables += ("wake_far_error", "wake_crossings")
    made.wake_far_error, made.wake_crossings = 1e-6 * made.time, np.arange(len(made.time))
    summary = metrics.summarise(made)
    assert (summary.wake_far_error, summary.wake_crossings) == (pytest.approx(1e-6 * 0.08), 400)


def test_peak_and_its_time_after_reversal():
    case = hawkmoth("motion.plunge.phase_deg=0.0", "time.periods=14")
    made = synthetic(case, tip_deflection=lambda t: -0.001 - 0.006 * np.cos(50 * np.pi * (t - 0.012)))
    summary = metrics.summarise(made)
    assert summary.tip_peak.mean == pytest.approx(0.007)
    assert summary.tip_peak_time == pytest.approx(0.3)
    assert summary.tip_peak_after_reversal == pytest.approx(0.05)


@pytest.mark.parametrize("frequency", [25.0, 30.0, 33.3, 110.0, 235.7])
def test_a_peak_at_the_end_of_the_last_beat_is_at_time_0(frequency):
    """Also just before it, where round-off decides the position of the frame."""
    case = hawkmoth(f"motion.frequency={frequency}", "time.periods=7", "time.steps_per_period=21")
    made = synthetic(case)
    made.tip_deflection[-1] = 1.0
    for end in (made.time[-1], np.nextafter(7.0 / frequency, 0.0), 7.0 / frequency):
        made.time[-1] = end
        assert metrics.summarise(made).tip_peak_time == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("beats", "after"), [(0.0, 0.0), (0.115, 0.115), (0.5, 0.0), (7.63, 0.13)])
def test_reversal_of_the_papers_stroke_is_at_0_and_a_half(beats, after):
    assert waves.after_reversal(hawkmoth(), beats) == pytest.approx(after)


def test_reversals_a_few_steps_apart_are_told_apart():
    """For any number of steps per beat, and any length of a non-periodic run."""
    quick = hawkmoth("time.steps_per_period=20", "motion.plunge.harmonics=[[25, 0.02, 5.0]]")
    points = [[0.0, 0.0], [49.9, 0.1], [50.0, 0.1], [50.05, 0.099], [50.1, 0.1], [50.2, 0.1], [100.0, 0.2]]
    document = hawkmoth().to_dict() | {"time": {"duration": 100.0, "step": 0.001}}
    document["motion"] = {"plunge": {"kind": "table", "points": points}, "pitch": {"amplitude_deg": 0.0}}
    for case, least in ((quick, 50), (parse_case(document), 5)):
        beats = np.linspace(0.0, 1.0, 50_001)
        rising = sampling.sample(case.motion, beats * case.beat)[:, sampling.PLUNGE_RATE] > 0.0
        expected = beats[np.flatnonzero(rising[1:] != rising[:-1])]
        assert len(expected) >= least
        np.testing.assert_allclose(waves.reversals(case, 0.0, 1.0), expected, rtol=0, atol=2.1e-5)
        for turn, other in pairwise(expected):
            assert waves.after_reversal(case, 0.5 * (turn + other)) == pytest.approx(0.5 * (other - turn), abs=4e-5)


@pytest.mark.parametrize("phase", [0.0, 37.0, 90.0, -200.0])
@pytest.mark.parametrize(
    "plunge",
    [
        "{amplitude=0.02, phase_deg=%g}",
        "{kind='triangle', sharpness=0.9, amplitude=0.02, phase_deg=%g, mean=0.3}",
        "{kind='trapezoid', sharpness=3.0, amplitude=0.02, phase_deg=%g}",
    ],
)
def test_reversals_are_the_zeros_of_the_plunge_velocity(plunge, phase):
    case = hawkmoth(f"motion.plunge={plunge % phase}")
    expected = (0.25 - phase / 360.0) % 0.5 + 0.5 * np.arange(7)
    found = waves.reversals(case, 0.0, 3.2)
    np.testing.assert_allclose(found, expected[: len(found)], atol=1e-12)
    assert 6 <= len(found) <= 7


def test_a_start_up_moves_the_first_reversals_and_no_later_ones():
    plain, grown = (waves.reversals(hawkmoth(*s), 0.0, 5.0) for s in ((), ("motion.start_up_periods=2.0",)))
    np.testing.assert_allclose(grown[-6:], plain[-6:], atol=1e-12)
    early = grown[(grown > 0.1) & (grown < 0.9)]
    assert np.abs(early[:, None] - plain).min() > 0.01


def test_no_summary_before_the_first_beat_is_whole():
    case = hawkmoth()
    time = case.step * np.arange(150)
    assert metrics.summarise(SimpleNamespace(case=case, time=time)) is None


@pytest.mark.slow
def test_a_still_wing_has_no_phase():
    case = hawkmoth("motion.plunge.amplitude=0.0", "motion.pitch.amplitude_deg=0.0", "time.periods=2")
    summary = metrics.summarise(taichiflap.simulate(case))
    assert summary.force_normal_phase is None
    assert summary.tip_peak_after_reversal is None
    assert summary.tip_peak.mean == 0.0


@pytest.mark.parametrize("angle", [0.0, 0.7, 3.0])
def test_lift_and_thrust_turn_with_the_stream(angle):
    cosine, sine = float(np.cos(angle)), float(np.sin(angle))
    case = hawkmoth("time.periods=4", f"fluid.velocity=[{2.0 * cosine!r}, {2.0 * sine!r}]")
    force = (-0.5, 3.0)  # against a stream along Y, and across it
    made = synthetic(
        case,
        force_y=lambda t: np.full_like(t, force[0] * cosine - force[1] * sine),
        force_z=lambda t: np.full_like(t, force[0] * sine + force[1] * cosine),
    )
    summary = metrics.summarise(made)
    assert summary.thrust.mean == pytest.approx(0.5)
    assert summary.lift.mean == pytest.approx(3.0)
    area = case.wing.chord * case.wing.span
    scale = 0.5 * 1.225 * 4.0 * area
    assert (summary.reference_speed, summary.reference_area) == pytest.approx((2.0, area))
    assert summary.lift_coefficient.mean == pytest.approx(3.0 / scale)
    assert summary.thrust_coefficient.mean == -summary.drag_coefficient.mean == pytest.approx(0.5 / scale)
    lines = " ".join(report._statistics(case, summary))
    assert f"C_L {3.0 / scale:.4g}, C_D {-0.5 / scale:.4g}, C_T {0.5 / scale:.4g}" in lines
    assert summary.propulsive_efficiency is None  # its power is nothing


def test_the_propulsive_efficiency_is_the_thrusts_share_of_the_power():
    """Thrust times the stream's speed over the power, and so C_T over C_P."""
    case = hawkmoth("time.periods=4", "fluid.velocity=[2.0, 0.0]")
    summary = metrics.summarise(
        synthetic(case, force_y=lambda t: np.full_like(t, -0.3), power=lambda t: np.full_like(t, 1.5))
    )
    assert summary.propulsive_efficiency == pytest.approx(0.3 * 2.0 / 1.5)
    ratio = summary.thrust_coefficient.mean / summary.power_coefficient.mean
    assert summary.propulsive_efficiency == pytest.approx(ratio)


def test_without_a_stream_there_is_no_lift_across_it_and_coefficients_go_by_the_motion():
    case = hawkmoth("time.periods=4", "motion.pitch.amplitude_deg=0.0")
    summary = metrics.summarise(synthetic(case, force_z=np.ones_like, force_vertical=lambda t: np.full_like(t, 0.02)))
    assert summary.lift is summary.thrust is summary.drag_coefficient is summary.propulsive_efficiency is None
    speed = 0.02 * 2.0 * np.pi * 25.0 / np.sqrt(2.0)  # of a sine, root mean square
    assert summary.reference_speed == pytest.approx(speed)
    assert summary.lift_coefficient.mean == pytest.approx(0.02 / (0.5 * 1.225 * speed**2 * 0.02 * 0.05))


def test_the_reference_point_is_the_middle_of_the_chord():
    """Of a wing that only pitches it moves on a circle about the pivot; at the pivot itself it rests."""
    turning = np.radians(15.0) * 2.0 * np.pi * 25.0 / np.sqrt(2.0)
    for pivot in (0.0, 0.25, 1.0):
        case = hawkmoth("wing.modes=0", f"wing.pivot={pivot}", "motion.plunge.amplitude=0.0", "time.periods=4")
        assert reference(case).speed == pytest.approx(abs(0.5 - pivot) * 0.02 * turning)
    still = hawkmoth("wing.modes=0", "wing.pivot=0.5", "motion.plunge.amplitude=0.0", "time.periods=4")
    assert reference(still).speed == 0.0
    assert metrics.summarise(synthetic(still)).lift_coefficient is None


def test_in_hover_similarity_is_that_of_the_stroke():
    """A sinusoidal plunge of 20 mm at 25 Hz without pitch: every number by hand."""
    case = hawkmoth("time.periods=4", "motion.pitch.amplitude_deg=0.0", "fluid.viscosity=1.5e-5", "body.mass=1.6e-3")
    made = synthetic(case, force_vertical=lambda t: np.full_like(t, 0.006))
    summary = metrics.summarise(made)
    speed = 0.02 * 2.0 * np.pi * 25.0 / np.sqrt(2.0)
    assert summary.reynolds == pytest.approx(speed * 0.02 / 1.5e-5)
    assert summary.reduced_frequency == pytest.approx(np.pi * 25.0 * 0.02 / speed)
    assert summary.pivot_speed == pytest.approx(4.0 * 0.02 * 25.0, rel=1e-4)
    assert (summary.angle_of_attack_mean, summary.angle_of_attack_rms) == pytest.approx((90.0, 90.0))
    assert summary.lift_over_weight == pytest.approx(2 * 0.006 / (1.6e-3 * 9.80665))
    assert summary.strouhal is summary.wing_tip_speed is None
    lines = " ".join(report._statistics(case, summary))
    assert "Re 2.96e+03, k 0.707" in lines
    assert "lift over weight" in lines
    assert "2 wings under 1.6 g" in lines


def test_in_hover_the_angle_of_attack_is_a_right_angle_less_the_pitch():
    """Pitch in phase with the stroke's velocity: cosine for cosine, so that it is largest where the wing is fastest."""
    case = hawkmoth(
        "time.periods=4", "motion.plunge.phase_deg=0.0", "motion.pitch={amplitude_deg=40.0, phase_deg=-90.0}"
    )
    summary = metrics.summarise(synthetic(case))
    phase = 2.0 * np.pi * (np.arange(512) + 0.5) / 512
    angle = 90.0 - 40.0 * np.abs(np.cos(phase))[np.abs(np.cos(phase)) > 0.05]
    assert summary.angle_of_attack_mean == pytest.approx(angle.mean(), abs=1e-9)
    assert summary.angle_of_attack_rms == pytest.approx(np.sqrt(np.mean(angle**2)), abs=1e-9)


@pytest.mark.parametrize("heading", [0.0, 1.1])
def test_in_a_stream_similarity_is_that_of_the_stream(heading):
    """St counts what the trailing edge travels across the stream, pitch and bending included."""
    stream = [2.0 * float(np.cos(heading)), 2.0 * float(np.sin(heading))]
    case = hawkmoth(
        "time.periods=4", f"fluid.velocity={stream}", "motion.pitch.amplitude_deg=0.0", "motion.plunge.phase_deg=0.0",
    )  # fmt: skip
    summary = metrics.summarise(synthetic(case, tip_deflection=lambda t: 0.005 * np.sin(50.0 * np.pi * t)))
    assert summary.reduced_frequency == pytest.approx(np.pi * 25.0 * 0.02 / 2.0)
    # Across a stream along Y is Z, which the bent edge moves by 25 mm to either side.
    assert summary.strouhal == pytest.approx(25.0 * 0.05 * abs(np.cos(heading)) / 2.0, rel=1e-3)
    assert summary.reynolds is None


def test_the_wings_tip_is_as_much_faster_as_it_is_further_out():
    case = taichiflap.load_case(CASES / "measured_moth.toml")
    found = Similarity.of(case)
    assert found.wing_tip_speed == pytest.approx(found.pivot_speed / 0.6)
    moved = sampling.sample(case.motion, case.beat * np.linspace(5.0, 6.0, 2001))
    travelled = np.hypot(*np.diff(moved[:, [sampling.PLUNGE, sampling.SURGE]], axis=0).T).sum()
    assert found.pivot_speed == pytest.approx(travelled * 26.0, rel=1e-4)


@pytest.mark.parametrize("settings", [(), ("fluid.velocity=[2.0, 0.5]",)])
def test_coefficients_over_time_have_the_means_of_the_summary(settings):
    case = hawkmoth("solver=dbet", "time.periods=4", "time.steps_per_period=100", *settings)
    with taichiflap.simulate(case) as result:
        beats = settled_beats(result)
        summary = metrics.summarise(result, beats)
        names = ["lift_coefficient", "power_coefficient"]
        names += ["drag_coefficient", "thrust_coefficient"] if settings else []
        for name in names:
            assert getattr(result, name)[beats.frames].mean() == pytest.approx(getattr(summary, name).mean)
        assert ("thrust_coefficient" in result.variables) == bool(settings)
        scale = reference(case)
        np.testing.assert_allclose(result.power_coefficient * scale.power, result.power, rtol=1e-12, atol=1e-15)
        assert 0.0 <= result.angle_of_attack.min() <= result.angle_of_attack.max() <= np.pi


@pytest.mark.parametrize("pivot", [0.0, 0.3, 0.8])
@pytest.mark.parametrize("stream", [(0.0, 0.0), (1.5, -0.5)])
def test_what_a_pivoted_wing_lost_goes_by_the_speed_of_its_own_middle(pivot, stream):
    """Against the speed of the middle from its positions, by differences."""
    case = hawkmoth(
        "wing.modes=0", f"wing.pivot={pivot}", f"fluid.velocity={list(stream)}", "time.periods=4",
        "time.steps_per_period=4000", "motion.pitch.phase_deg=50.0", "motion.pitch.amplitude_deg=40.0",
    )  # fmt: skip
    made = synthetic(case)
    moved = sampling.sample(case.motion, made.time)
    arm = (0.5 - pivot) * case.wing.chord
    y, z = arm * np.cos(moved[:, sampling.PITCH]), moved[:, sampling.PLUNGE] + arm * np.sin(moved[:, sampling.PITCH])
    speeds = [np.gradient(place, made.time) - along for place, along in zip((y, z), stream, strict=True)]
    made.wake_lost, made.variables = np.full_like(made.time, 0.2), (*made.variables, "wake_lost")
    expected = 0.2 / np.sqrt(np.mean(speeds[0] ** 2 + speeds[1] ** 2))
    assert metrics.summarise(made, whole_beats(case, made.time)).wake_lost == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(
    ("settings", "lacking", "having"),
    [
        ((), ("lift_mean", "thrust_mean", "propulsive_efficiency", "drag_coefficient_mean"), ("power_mean",)),
        ((), ("strouhal", "reynolds", "lift_over_weight"), ("reduced_frequency", "pivot_speed")),
        (("fluid.velocity=[1.0, 0.0]",), (), ("lift_mean", "thrust_mean", "propulsive_efficiency")),
        (("fluid.density=0.0",), ("lift_coefficient_mean", "power_coefficient_spread"), ("power_mean",)),
    ],
)
def test_metrics_that_a_case_cannot_have_are_not_offered(settings, lacking, having):
    case = hawkmoth(*settings)
    offered = quantities.choose((), [case])
    assert set(having) <= set(offered)
    assert not set(lacking) & set(offered)
    for name in lacking:
        with pytest.raises(quantities.MetricError, match=f"metric {name}: not defined (in hover|where|without)"):
            quantities.choose([name], [case])
        # It is offered where another case of the study has it.
        other = hawkmoth("fluid.velocity=[1.0, 0.0]", "fluid.viscosity=1.5e-5", "body.mass=1.6e-3")
        assert name in quantities.choose((), [case, other])


def test_what_is_defined_nowhere_in_a_summary_is_not_offered_and_the_rest_is():
    """Every offered metric has a value in some run of the case, and no other has."""
    for settings in ((), ("fluid.velocity=[1.0, 0.5]",), ("fluid.density=0.0",)):
        case = hawkmoth("time.periods=4", *settings)
        made = synthetic(case, **dict.fromkeys(("power", "force_y", "force_z", "tip_deflection"), np.cos))
        (values,) = quantities.measure([metrics.Alone(made)], list(quantities.METRICS))
        known = {name for name, value in values.items() if np.isfinite(value)}
        assert known <= set(quantities.choose((), [case]))


def test_lift_per_power_is_of_the_lift_in_a_stream_and_of_the_vertical_force_in_hover():
    forces = {"force_z": lambda t: np.full_like(t, 3.0), "force_vertical": lambda t: np.full_like(t, 5.0)}
    for settings, lift in ((("fluid.velocity=[2.0, 0.0]",), 3.0), ((), 5.0)):
        made = synthetic(hawkmoth("time.periods=4", *settings), power=lambda t: np.full_like(t, 0.5), **forces)
        (found,) = quantities.measure([metrics.Alone(made)], ["lift_per_power"])
        assert found["lift_per_power"] == pytest.approx(lift / 0.5)


@pytest.mark.parametrize("every", [1, 3, 7, 130])
def test_beats_are_the_frames_after_their_start_up_to_their_end(every, rng):
    case = hawkmoth("time.periods=6", f"output.every={every}")
    time = case.step * np.arange(0, case.steps + 1, every)
    numbers = np.ceil(np.round(time / case.beat, 9))
    found = [numbers == n for n in range(1, int(np.round(time[-1] / case.beat, 9)) + 1) if np.any(numbers == n)]
    beats, values = whole_beats(case, time), rng.standard_normal((2, len(time)))
    assert len(beats) == len(found)
    np.testing.assert_allclose(beats.means(values), np.transpose([values[:, beat].mean(axis=1) for beat in found]))
    np.testing.assert_array_equal(beats.peaks(values[0]), [np.abs(values[0, beat]).max() for beat in found])
    np.testing.assert_array_equal(time[beats.last], time[found[-1]])
    np.testing.assert_array_equal(time[beats.after(1).frames], time[np.any(found[1:], axis=0)])


@pytest.mark.parametrize("sharpness", [0.1, 3.0, 10.0, 30.0])
def test_reversals_of_ever_squarer_strokes_are_found_to_round_off(sharpness):
    plunge = f"{{kind='trapezoid', sharpness={sharpness}, amplitude=0.02, phase_deg=17.0}}"
    case = hawkmoth(f"motion.plunge={plunge}", "motion.start_up_periods=0.5")
    found = waves.reversals(case, 1.0, 3.0)
    np.testing.assert_allclose(found, (0.25 - 17.0 / 360.0) + 0.5 * np.arange(2, 6), atol=1e-12)


def test_what_the_wake_lost_is_a_share_of_the_speed_of_the_wings_middle():
    """Over the beats that are asked for alone, of a wing that plunges and pitches in a stream of 3 and 4 m/s."""
    case = hawkmoth("time.periods=4", "time.steps_per_period=2000", "fluid.velocity=[3.0, 4.0]")
    made = synthetic(case, force_y=np.ones_like)
    moved = sampling.sample(case.motion, made.time)
    made.plunge, made.pitch = moved[:, sampling.PLUNGE], moved[:, sampling.PITCH]
    made.wake_lost = np.where(made.time <= 0.08, 100.0, 0.5)
    made.variables = (*made.variables, "wake_lost")
    beats = whole_beats(case, made.time).after(2)
    rates = 0.02 * 2.0 * np.pi * 25.0, 0.5 * case.wing.chord * np.radians(15.0) * 2.0 * np.pi * 25.0
    speed = np.sqrt(25.0 + 0.5 * rates[0] ** 2 + 0.5 * rates[1] ** 2)
    # The gradient at the last frame is one-sided.
    assert metrics.summarise(made, beats).wake_lost == pytest.approx(0.5 / speed, rel=1e-4)
    document = hawkmoth().to_dict() | {"time": {"duration": 1.0, "step": 0.01}}
    document["fluid"] = {"velocity": [5.0, 2.0]}
    travel = {"kind": "table", "points": [[0.0, 1.0], [0.3, -2.0], [0.6, -5.0], [1.0, -9.0]]}  # -10 m/s
    document["motion"] = {"plunge": travel, "pitch": {"amplitude_deg": 0.0}}
    made = synthetic(parse_case(document), force_y=np.ones_like)
    made.plunge, made.pitch = 1.0 - 10.0 * made.time, np.zeros_like(made.time)
    made.wake_lost, made.variables = 2.6 * np.ones_like(made.time), (*made.variables, "wake_lost")
    assert metrics.summarise(made).wake_lost == pytest.approx(2.6 / 13.0)
    still = hawkmoth("time.periods=4", "motion.plunge.amplitude=0.0", "motion.pitch.amplitude_deg=0.0")
    made = synthetic(still)
    made.plunge = made.pitch = np.zeros_like(made.time)
    made.wake_lost, made.variables = np.ones_like(made.time), (*made.variables, "wake_lost")
    assert metrics.summarise(made).wake_lost == 0.0


@pytest.mark.parametrize("correlation", [0.0, 0.3, 0.5, 0.7])
@pytest.mark.parametrize(("beats", "covered"), [(10, 0.80), (20, 0.86), (60, 0.90)])
def test_a_standard_error_covers_the_mean_of_beats_that_depend_on_each_other(correlation, beats, covered):
    noise = np.random.default_rng(20261127).standard_normal((4000, beats))
    values = noise.copy()
    for n in range(1, beats):
        values[:, n] = correlation * values[:, n - 1] + np.sqrt(1.0 - correlation**2) * noise[:, n]
    inside = np.abs(values.mean(axis=1)) < 2.0 * standard_errors(values)
    assert covered < inside.mean() < 0.98
    if correlation == 0.7:  # as if beats were independent
        naive = 2.0 * values.std(axis=1, ddof=1) / np.sqrt(beats)
        assert np.mean(np.abs(values.mean(axis=1)) < naive) < 0.65


def test_a_standard_error_takes_ten_beats():
    values = np.random.default_rng(1).standard_normal((2, 10))
    assert np.isfinite(standard_errors(values)).all()
    assert np.isnan(standard_errors(values[:, :9])).all()
    assert standard_errors(np.ones((1, 12))) == 0.0
