"""Prescribed motion: values, and derivatives exact to round-off, for every kind on random parameters."""

import numpy as np
import pytest
from conftest import hawkmoth, march
from hypothesis import given, settings
from hypothesis import strategies as st

import taichiflap
from taichiflap.case.case import parse_case
from taichiflap.motion import sampling, waveforms

STEP = 1e-30
TIMES = np.linspace(0.0, 1.7, 83)
EVERYWHERE = np.linspace(-1.0, 4.0, 2501)


def numbers(least, most):
    return st.floats(least, most, allow_nan=False, allow_subnormal=False)


def formula(name, **arguments):
    return st.fixed_dictionaries(arguments).map(lambda chosen: (name, chosen))


WAVE = {"frequency": numbers(0.1, 50), "amplitude": numbers(0.01, 2), "phase": numbers(-6, 6), "mean": numbers(-2, 2)}
TERMS = st.lists(st.tuples(st.integers(1, 9), numbers(-1, 1), numbers(-6, 6)), max_size=4)
KINDS = st.one_of(
    formula("harmonic", **WAVE, harmonics=TERMS),
    formula("triangle", **WAVE, sharpness=st.one_of(st.just(0.0), numbers(1e-9, 0.99))),
    formula("trapezoid", **WAVE, sharpness=st.one_of(st.just(0.0), numbers(1e-6, 40))),
    formula(
        "ramp",
        initial=numbers(-1, 1),
        amplitude=numbers(0.01, 2),
        start=numbers(-0.2, 1),
        ramp=numbers(0.05, 1),
        hold=st.one_of(st.none(), numbers(0, 1)),
        smoothing=numbers(20, 1e3),
    ),
    formula("start_up", duration=numbers(0.05, 3)),
)


def assert_derivatives(function, tolerance):
    """Columns 0 and 1 differentiated by a complex step are columns 1 and 2, to a share of the largest anywhere."""
    exact, stepped = function(TIMES), function(TIMES + 1j * STEP)
    scales = np.maximum(np.abs(exact).max(axis=0), np.abs(function(EVERYWHERE)).max(axis=0))
    for order in (0, 1):
        scale = scales[order + 1]
        np.testing.assert_allclose(stepped.imag[:, order] / STEP, exact[:, order + 1], atol=tolerance * scale, rtol=0)


@settings(max_examples=300, deadline=None)
@given(KINDS)
def test_derivatives_of_every_formula_match_the_complex_step(chosen):
    name, arguments = chosen
    # Near the corners of a sharp wave a derivative loses as many digits as the angle has lost to round-off.
    assert_derivatives(lambda t: getattr(waveforms, name)(t, **arguments), 3e-11)


@settings(max_examples=50, deadline=None)
@given(KINDS, numbers(0.1, 2.0))
def test_the_product_rule_holds_for_a_start_up(chosen, duration):
    name, arguments = chosen

    def grown(t):
        return waveforms.product(waveforms.start_up(t, duration), getattr(waveforms, name)(t, **arguments))

    assert_derivatives(grown, 3e-11)


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.tuples(numbers(0.05, 1.0), numbers(-1, 1)), min_size=5, max_size=12),
    st.booleans(),
    numbers(0.2, 30.0),
)
def test_a_table_passes_through_its_points_smoothly(gaps, periodic, frequency):
    times = np.cumsum([gap for gap, _ in gaps])
    times = (times - times[0]) / (times[-1] - times[0] + 0.1)
    points = tuple(zip(times.tolist(), (value for _, value in gaps), strict=True))
    rate = frequency if periodic else 1.0
    found = waveforms.table(times / rate, points=points, frequency=frequency if periodic else None)
    np.testing.assert_allclose(found[:, 0], [value for _, value in points], atol=1e-9)

    def at(t):
        return waveforms.table(np.asarray(t) / rate, points=points, frequency=frequency if periodic else None)

    # A cubic between knots: the five-point rule is exact.
    middle, h = 0.5 * (times[1:] + times[:-1]), 0.1 * np.diff(times)
    for order in (0, 1):
        values = [at(middle + k * h)[:, order] for k in (-2, -1, 1, 2)]
        slope = rate * (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * h)
        scale = np.abs(at(np.concatenate((times, middle)))[:, order + 1]).max()
        np.testing.assert_allclose(slope, at(middle)[:, order + 1], atol=1e-10 * scale + 1e-9)
    # At the knots, and at the seam of a period, value, rate and acceleration go on.
    knots = np.append(times, 1.0) if periodic else times[1:-1]
    tiny = 1e-9
    jump = np.abs(at(knots + tiny) - at(knots - tiny)).max(axis=0)
    size = np.abs(at(np.linspace(0, times[-1], 200))).max(axis=0)
    assert np.all(jump <= 1e-4 * size + 1e-9)
    if periodic:
        np.testing.assert_allclose(at(times + 3.0), at(times), atol=1e-8 * size.max() + 1e-9)


def test_a_straight_table_moves_at_constant_velocity():
    points = tuple((0.1 * n, 0.3 - 0.25 * n) for n in range(8))
    found = waveforms.table(np.linspace(0, 0.7, 31), points=points)
    np.testing.assert_allclose(found[:, 1], -2.5, rtol=1e-13)
    np.testing.assert_allclose(found[:, 2], 0.0, atol=1e-11)


def test_a_sine_in_a_table_is_a_sine():
    turns = np.arange(200) / 200
    points = tuple(zip(turns.tolist(), np.sin(2 * np.pi * turns).tolist(), strict=True))
    exact = waveforms.harmonic(TIMES, frequency=3.0, amplitude=1.0, phase=0.0, mean=0.0)
    np.testing.assert_allclose(
        waveforms.table(TIMES, points=points, frequency=3.0) / np.abs(exact).max(axis=0),
        exact / np.abs(exact).max(axis=0),
        atol=1e-4,
    )


@pytest.mark.parametrize("kind", ["triangle", "trapezoid"])
def test_a_blunt_wave_is_a_sine_and_a_sharp_one_its_namesake(kind):
    arguments = {"frequency": 2.0, "amplitude": 0.3, "phase": 0.4, "mean": 0.1}
    wave, sine = getattr(waveforms, kind), waveforms.harmonic(TIMES, **arguments)
    np.testing.assert_array_equal(wave(TIMES, sharpness=0.0, **arguments), sine)
    np.testing.assert_allclose(wave(TIMES, sharpness=1e-5, **arguments), sine, rtol=1e-8, atol=1e-8)
    turn = (2.0 * TIMES + 0.4 / (2 * np.pi)) % 1.0
    if kind == "triangle":
        sharp = 0.1 - 0.3 * (1.0 - np.abs(4.0 * ((turn - 0.25) % 1.0 - 0.5)))
        np.testing.assert_allclose(wave(TIMES, sharpness=1 - 1e-9, **arguments)[:, 0], sharp, atol=1e-4)
    else:
        away = np.abs(np.sin(2 * np.pi * turn)) > 0.2
        square = 0.1 + 0.3 * np.sign(np.sin(2 * np.pi * turn))
        np.testing.assert_allclose(wave(TIMES, sharpness=100.0, **arguments)[away, 0], square[away], atol=1e-9)


def test_a_ramp_rises_holds_and_returns():
    times = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.5])
    arguments = {"initial": 0.2, "amplitude": -0.7, "start": 0.75, "ramp": 0.5, "smoothing": 200.0}
    back = waveforms.ramp(times, hold=0.5, **arguments)
    stay = waveforms.ramp(times, hold=None, **arguments)
    np.testing.assert_allclose(back[:, 0], [0.2, 0.2, -0.15, -0.5, -0.15, 0.2, 0.2], atol=1e-12)
    np.testing.assert_allclose(stay[:, 0], [0.2, 0.2, -0.15, -0.5, -0.5, -0.5, -0.5], atol=1e-12)
    assert back[2, 1] == pytest.approx(-0.7 / 0.5)
    # However round its corners, a ramp that returns reaches its amplitude: Eldredge's formula is over its maximum.
    round_one = waveforms.ramp(np.linspace(0, 4, 4001), hold=0.5, **arguments | {"smoothing": 2.0})
    assert np.abs(round_one[:, 0] - 0.2).max() == pytest.approx(0.7)


def test_a_start_up_goes_from_rest_to_the_full_motion():
    case = hawkmoth("motion.start_up_periods=2.0", "motion.pitch.mean_deg=20.0")
    plain = hawkmoth("motion.pitch.mean_deg=20.0")
    times = np.array([0.0, 0.08, 0.0801, 0.3])
    grown, full = sampling.sample(case.motion, times), sampling.sample(plain.motion, times)
    np.testing.assert_array_equal(grown[0], 0.0)
    np.testing.assert_allclose(grown[1:], full[1:], rtol=1e-13, atol=1e-12)
    seconds = hawkmoth("motion.start_up=0.08", "motion.pitch.mean_deg=20.0")
    np.testing.assert_array_equal(sampling.sample(seconds.motion, TIMES), sampling.sample(case.motion, TIMES))


def test_the_keys_of_every_kind_reach_its_formula():
    tables = {
        "plunge": [[0.0, 0.0], [0.3, 0.01], [0.6, -0.01], [0.9, 0.02]],
        "pitch": [[0, 0], [0.3, 10.0], [0.6, -10], [1.0, 0]],
    }
    case = hawkmoth(
        f"motion.plunge={{kind='table', periodic=true, points={tables['plunge']}}}",
        "motion.pitch={kind='ramp', start=0.1, ramp=0.2, hold=0.3, smoothing=50.0, amplitude_deg=45, initial_deg=5}",
    )
    moved = sampling.sample(case.motion, TIMES)
    np.testing.assert_array_equal(
        moved[:, :3], waveforms.table(TIMES, points=tuple(map(tuple, tables["plunge"])), frequency=25.0)
    )
    pitch = waveforms.ramp(
        TIMES, initial=np.radians(5), amplitude=np.radians(45), start=0.1, ramp=0.2, hold=0.3, smoothing=50.0
    )
    np.testing.assert_allclose(moved[:, 3:6], pitch, rtol=1e-14, atol=1e-14)
    fourier = hawkmoth("motion.pitch={amplitude_deg=10.0, mean_deg=3.0, harmonics_deg=[[2, 5.0, 90.0]]}")
    expected = np.radians(3 + 10 * np.sin(50 * np.pi * TIMES) + 5 * np.cos(100 * np.pi * TIMES))
    np.testing.assert_allclose(sampling.sample(fourier.motion, TIMES)[:, sampling.PITCH], expected, atol=1e-12)


def test_the_papers_stroke_starts_at_reversal_with_the_chord_upright():
    z, z_rate, _, theta, theta_rate, *_ = sampling.sample(hawkmoth().motion, np.array([0.0]))[0]
    assert z == 0.02
    assert abs(z_rate) < 1e-14
    assert theta == 0.0
    np.testing.assert_allclose(theta_rate, np.radians(15.0) * 2 * np.pi * 25.0)


@pytest.mark.parametrize("solver", ["uvlm", "dbet"])
def test_a_wing_that_moves_through_still_air_feels_what_it_feels_in_a_stream(solver):
    """Galilean invariance, with a bent, pitching and shedding wing."""
    document = hawkmoth(f"solver={solver}", "uvlm.panels=12", "wing.modes=2").to_dict()
    document["motion"] = {"frequency": 25.0, "pitch": {"amplitude_deg": 15.0, "mean_deg": 50.0}}
    document["time"] = {"duration": 0.06, "step": 4e-4}
    travel = {"kind": "table", "points": [[0.0, 0.1], [0.02, 0.04], [0.04, -0.02], [0.06, -0.08]]}  # -3 m/s
    document["fluid"] = {"velocity": [0.7, -1.0]}
    moving = parse_case({**document, "motion": document["motion"] | {"plunge": travel}})
    document["fluid"] = {"velocity": [0.7, 2.0]}
    (one, other), _ = march([moving, parse_case(document)])
    size = np.abs(one.force).max()
    assert size > 1e-4
    np.testing.assert_allclose(one.force, other.force, atol=1e-9 * size)
    np.testing.assert_allclose(one.q, other.q, atol=1e-9 * np.abs(one.q).max())


@pytest.mark.parametrize("solver", ["uvlm", "dbet"])
def test_surge_through_still_air_is_a_stream_along_y(solver):
    document = hawkmoth(f"solver={solver}", "uvlm.panels=12", "wing.modes=2").to_dict()
    document["motion"] = {"frequency": 25.0, "pitch": {"amplitude_deg": 15.0, "mean_deg": 50.0}}
    document["time"] = {"duration": 0.06, "step": 4e-4}
    travel = {"kind": "table", "points": [[0.0, 0.1], [0.02, 0.04], [0.04, -0.02], [0.06, -0.08]]}  # -3 m/s
    document["fluid"] = {"velocity": [-1.0, 0.7]}
    moving = parse_case({**document, "motion": document["motion"] | {"surge": travel}})
    document["fluid"] = {"velocity": [2.0, 0.7]}
    (one, other), _ = march([moving, parse_case(document)])
    size = np.abs(one.force).max()
    assert size > 1e-4
    np.testing.assert_allclose(one.force, other.force, atol=1e-9 * size)
    np.testing.assert_allclose(one.q, other.q, atol=1e-9 * np.abs(one.q).max())


@pytest.mark.parametrize("solver", ["uvlm", "dbet"])
@pytest.mark.parametrize("turn_deg", [30.0, 90.0])
def test_a_turned_stroke_gives_turned_forces(solver, turn_deg):
    """The same stroke in a plane turned by an angle, partly or wholly surge: only the inertial frame has turned."""
    common = (
        f"solver={solver}", "uvlm.panels=12", "uvlm.spacing=cosine", "uvlm.loads=vortices", "uvlm.suction=true",
        "uvlm.core=0.05", "wing.modes=2", "time.periods=1", "time.steps_per_period=100", "fluid.velocity=[0, 0]",
    )  # fmt: skip
    turn = np.radians(turn_deg)
    plain = hawkmoth(*common)
    turned = hawkmoth(
        *common, f"motion.plunge.amplitude={0.02 * np.cos(turn)}", f"motion.pitch.mean_deg={turn_deg}",
        f"motion.surge={{amplitude={0.02 * np.sin(turn)}, phase_deg=-90.0}}",
    )  # fmt: skip
    one, other = (taichiflap.simulate(case) for case in (plain, turned))
    size = np.abs(one.force_z).max()
    for name in ("force_normal", "force_axial"):
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), atol=1e-9 * size)
    for name in ("tip_deflection", "moment", "power", "power_inertial"):
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), atol=1e-9 * np.ptp(getattr(one, name)))
    along_y = np.cos(turn) * one.force_y - np.sin(turn) * one.force_z
    along_z = np.sin(turn) * one.force_y + np.cos(turn) * one.force_z
    np.testing.assert_allclose(other.force_y, along_y, atol=1e-9 * size)
    np.testing.assert_allclose(other.force_z, along_z, atol=1e-9 * size)
    y, z = np.moveaxis(one.node_position, 2, 0)
    expected = np.stack((np.cos(turn) * y - np.sin(turn) * z, np.sin(turn) * y + np.cos(turn) * z), axis=2)
    np.testing.assert_allclose(other.node_position, expected, atol=1e-8)


def test_reversals_of_a_stretch_are_those_inside_it_and_at_its_ends():
    """The hawkmoth reverses at every half of its 40 ms; where a stretch ends just there, that is one of its own."""
    stroke, half = hawkmoth().motion, 0.02
    for first, last, expected in (
        (0.0, 3.0, [0, 1, 2, 3]),
        (1.0, 2.0, [1, 2]),
        (1.1, 2.9, [2]),
        (1.1, 1.9, []),
        (1.00001, 1.99999, []),
        (7.0, 7.0, [7]),
    ):
        found = sampling.reversals(stroke, first * half, last * half, half / 50)
        np.testing.assert_allclose(found, half * np.array(expected), rtol=0, atol=1e-12 * half)
    # Steps that meet the reversals, and steps of no round number.
    for step in (0.25, 0.4, 1.0 / 3.0, 0.77):
        found = sampling.reversals(stroke, 0.0, 10.0 * half, step * half)
        np.testing.assert_allclose(found, half * np.arange(11), rtol=0, atol=1e-12 * half)


def test_a_reversal_in_a_corner_is_found_by_halving():
    """A table's velocity has kinks: where the slope vanishes on one side, Newton's step leads nowhere."""
    points = [[0.0, 0.0], [0.1, 1.0], [0.2, 1.0001], [0.3, 1.0], [1.0, 0.0]]
    text = ", ".join(f"[{t}, {0.01 * z}]" for t, z in points)
    stroke = hawkmoth(
        f"motion.plunge={{kind='table', points=[{text}], periodic=false}}", "motion.frequency=1.0", "time.periods=1"
    ).motion
    times = np.linspace(0.0, 1.0, 200_001)
    rate = sampling.sample(stroke, times)[:, 1]
    (turns,) = np.nonzero((rate[1:] > 0.0) != (rate[:-1] > 0.0))
    found = sampling.reversals(stroke, 0.0, 1.0, 0.01)
    inner = found[(found > 1e-6) & (found < 1.0 - 1e-6)]
    expected = times[turns][(times[turns] > 1e-4) & (times[turns] < 1.0 - 1e-4)]
    assert len(expected)
    np.testing.assert_allclose(inner, expected, rtol=0, atol=1e-5)


def plunging(text):
    return hawkmoth(f"motion.plunge={text}").motion


def test_reversals_of_a_stroke_that_grows_are_where_its_velocity_changes_sign():
    stroke = hawkmoth("motion.start_up_periods=3.0", "motion.plunge.mean=0.01").motion
    times = np.linspace(0.0, 0.2, 40_001)
    rising = sampling.sample(stroke, times)[:, sampling.PLUNGE_RATE] > 0.0
    (turns,) = np.nonzero(rising[1:] != rising[:-1])
    found = sampling.reversals(stroke, 1e-4, 0.2 - 1e-4, 1e-4)
    inside = turns[(turns > 20) & (turns < 39_980)]
    np.testing.assert_allclose(found, times[inside], rtol=0, atol=1.01 * times[1])
    rates = sampling.sample(stroke, found)[:, sampling.PLUNGE_RATE]
    np.testing.assert_allclose(rates, 0.0, atol=1e-12)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_wing_that_stops_before_it_returns_reverses_when_it_stops(sense):
    """From 0.3 s to 0.7 it stands still, and up to there its velocity is constant: Newton's step leads nowhere."""
    ramp = "start=0.1, ramp=0.2, hold=0.4, smoothing=1e6"
    stroke = plunging(f"{{kind='ramp', {ramp}, amplitude={sense * 0.01}}}")
    (found,) = sampling.reversals(stroke, 0.0, 1.0, 0.047)
    assert found == pytest.approx(0.3, abs=1e-3)
    (other,) = sampling.reversals(plunging(f"{{kind='ramp', {ramp}, amplitude={sense * -0.01}}}"), 0.0, 1.0, 0.047)
    assert other == found


def test_a_corner_without_an_acceleration_before_or_behind_it_is_found():
    stroke = plunging("{kind='ramp', start=0.1, ramp=0.2, hold=0.0, smoothing=1e4, amplitude=0.01}")
    (found,) = sampling.reversals(stroke, 0.0, 1.0, 0.047)
    assert found == pytest.approx(0.3, abs=1e-9)


def test_a_smooth_reversal_takes_few_looks_at_the_motion(monkeypatch):
    """Newton's method doubles its digits; one that always halved would look fifty times."""
    looks = []

    def counted(*arguments, axis=sampling.sample_axis):
        looks.append(arguments)
        return axis(*arguments)

    monkeypatch.setattr(sampling, "sample_axis", counted)
    found = sampling.reversals(plunging("{amplitude=0.02, phase_deg=23.4}"), 0.0, 0.4, 1e-3)
    np.testing.assert_allclose(found % 0.02, (0.25 - 23.4 / 360.0) * 0.04, rtol=1e-12)
    assert len(looks) <= 8


def test_reversals_that_are_found_are_kept_from_change():
    found = sampling.reversals(hawkmoth().motion, 0.0, 0.4, 1e-3)
    with pytest.raises(ValueError, match="read-only"):
        found += 1.0


def test_a_start_up_is_the_smoothest_step_of_its_degree():
    """The integral of `140 x^3 (1 - x)^3`: at rest before, at its end after, and odd about the middle."""
    step = np.polynomial.Polynomial([0.0, 1.0])
    rise = (140.0 * step**3 * (1.0 - step) ** 3).integ()
    x = np.linspace(-0.5, 1.5, 81)
    found = waveforms.start_up(0.3 * x, 0.3)
    inside = (x > 0.0) & (x < 1.0)
    np.testing.assert_allclose(found[inside, 0], rise(x[inside]), atol=1e-14)
    np.testing.assert_array_equal(found[x <= 0.0], 0.0)
    np.testing.assert_allclose(found[x >= 1.0], [[1.0, 0.0, 0.0]] * np.sum(x >= 1.0), atol=1e-12)
    np.testing.assert_allclose(found[:, 0] + found[::-1, 0], 1.0, atol=1e-14)


@pytest.mark.parametrize("begin", [0.0, 0.3])
def test_a_table_that_closes_its_period_is_the_same_as_one_that_leaves_it_to_us(begin):
    open_one = tuple((begin + t, value) for t, value in ((0.0, 0.1), (0.2, -0.4), (0.55, 0.7), (0.9, 0.2)))
    closed = (*open_one, (begin + 1.0, 0.1))
    one, other = (waveforms.table(TIMES, points=points, frequency=2.0) for points in (open_one, closed))
    np.testing.assert_array_equal(one, other)


def test_typical_speed_of_motions_whose_speed_is_known():
    times = np.arange(4000) * 0.04 / 4000
    still = "motion.plunge.amplitude=0.0", "motion.pitch.amplitude_deg=0.0"
    omega = 2.0 * np.pi * 25.0
    plunging = hawkmoth(still[1]).motion
    assert sampling.typical_speed(plunging, 0.02, (0.0, 0.0), times) == pytest.approx(0.02 * omega / np.sqrt(2.0))
    pitching = hawkmoth(still[0]).motion
    rate = np.radians(15.0) * omega / np.sqrt(2.0)
    assert sampling.typical_speed(pitching, 0.03, (0.0, 0.0), times) == pytest.approx(0.03 * rate)
    assert sampling.typical_speed(hawkmoth(*still).motion, 0.02, (3.0, -4.0), times) == pytest.approx(5.0)
    # Along Y the stream meets a plunging wing across its motion, along Z with it and against it in turn.
    for stream in ((2.0, 0.0), (0.0, 2.0)):
        squared = sampling.typical_speed(plunging, 0.02, stream, times) ** 2
        assert squared == pytest.approx(4.0 + (0.02 * omega) ** 2 / 2.0)
    # Velocity of the trailing edge from its position, turning and plunging in a stream.
    whole, behind = hawkmoth("motion.pitch.mean_deg=20.0").motion, 0.015
    moved = sampling.sample(whole, times)
    edge = np.stack((behind * np.cos(moved[:, 3]), moved[:, 0] + behind * np.sin(moved[:, 3])))
    moving = (np.roll(edge, -1, axis=1) - np.roll(edge, 1, axis=1)) / (2.0 * times[1]) - np.array([[0.7], [-0.3]])
    # Over a whole beat the edge comes back, and the stream's sign cannot be told.
    for part in (slice(0, 1300), slice(1300, 2900)):
        measured = np.sqrt(np.mean(np.sum(moving[:, part] ** 2, axis=0)))
        assert sampling.typical_speed(whole, behind, (0.7, -0.3), times[part]) == pytest.approx(measured, rel=1e-5)


def test_times_may_be_whole_numbers_in_a_list():
    motion = hawkmoth("motion.frequency=0.3").motion
    np.testing.assert_array_equal(sampling.sample(motion, [0, 1, 2]), sampling.sample(motion, np.arange(3.0)))
