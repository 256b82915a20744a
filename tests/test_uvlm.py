"""Vortex lattice: exact steady circulation, Kelvin's theorem, an independent march, the ring buffer of the wake."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import assert_columns_agree, hawkmoth, march
from oracle import UvlmOracle, velocity

from taichiflap import fluids
from taichiflap.fluids.uvlm import long_wake, merging, wake
from taichiflap.fluids.uvlm.lattice import TOTAL
from taichiflap.kernels.runtime import Floats2, Floats3, start, ti
from taichiflap.kernels.runtime import view as numpy_view
from taichiflap.march.march import March

ACCURATE = (
    "uvlm.spacing=cosine", "uvlm.loads=vortices", "uvlm.shedding=local", "uvlm.convection=second_order",
    "uvlm.core=0.02", "uvlm.core_growth=0.1",
)  # fmt: skip
SHORT = ("time.periods=1", "time.steps_per_period=30")


@pytest.mark.parametrize(
    "settings",
    [
        ("wing.modes=2", "uvlm.panels=7", "uvlm.wake=12", "uvlm.core=0.03"),
        ("wing.modes=1", "uvlm.panels=9", "uvlm.wake=all", "uvlm.shedding=local", "uvlm.core=0.05"),
        ("wing.modes=0", "uvlm.panels=1", "uvlm.wake=5", "uvlm.shedding=local", "fluid.velocity=[1.0, -0.5]"),
        (
            "wing.modes=3",
            "uvlm.panels=16",
            "uvlm.wake=1",
            "fluid.velocity=[0.0, 3.0]",
            "wing.youngs_modulus=9e9",
        ),
        (
            "wing.modes=2",
            "uvlm.panels=10",
            "uvlm.wake=20",
            "wing.span=[[0, 0.05], [0.5, 0.06], [1, 0]]",
            "wing.thickness=[[0, 60e-6], [1, 20e-6]]",
        ),
        ("wing.modes=0", "uvlm.panels=6", "uvlm.wake=9", "wing.pivot=0.3", "wing.span=[[0, 0.05], [1, 0]]"),
        (
            "wing.modes=0",
            "uvlm.panels=8",
            *ACCURATE,
            "uvlm.suction=true",
            "wing.pivot=0.3",
            "wing.span=[[0, 0.05], [1, 0]]",
        ),
        ("wing.modes=2", "uvlm.panels=8", *ACCURATE, "wing.span=[[0, 0.05], [0.5, 0.06], [1, 0]]"),
        ("wing.modes=8", "uvlm.panels=20", "uvlm.wake=8", "motion.pitch.mean_deg=20.0"),
        ("wing.modes=2", "uvlm.panels=9", "uvlm.wake=20", *ACCURATE, "uvlm.suction=true"),
        ("wing.modes=3", "uvlm.panels=12", "uvlm.wake=all", *ACCURATE, "uvlm.spacing=uniform", "uvlm.suction=true"),
        ("wing.modes=1", "uvlm.panels=10", "uvlm.wake=9", "uvlm.spacing=cosine", "uvlm.core_growth=0.2"),
        ("wing.modes=0", "uvlm.panels=1", *ACCURATE, "fluid.velocity=[2.0, 0.5]"),
    ],
)
def test_matches_an_independent_march(settings):
    case = hawkmoth(*SHORT, *settings)
    frames, _ = march(case)
    oracle = UvlmOracle(case).march(case.steps)
    for name, ours, tolerance in (
        ("q", frames.q[:, 0], 1e-9),
        ("a", frames.q[:, 2], 1e-9),
        ("force", frames.force[:, :3], 1e-9),
        ("gamma", frames.panel_circulation, 1e-6),
    ):
        theirs = np.array([step[name] for step in oracle.history])
        assert_columns_agree(ours, theirs, tolerance)
    wakes = np.concatenate([step["wake"] for step in oracle.history]).T
    np.testing.assert_allclose(frames.wake, wakes, rtol=1e-6, atol=1e-8)


def plate(alpha_deg, panels, *settings):
    """A fixed plate at an angle in a stream; the new vortex is so far behind that the flow is steady at once."""
    speed = 4.0
    alpha = np.radians(alpha_deg)
    case = hawkmoth(
        "wing.modes=0", "motion.plunge.amplitude=0.0", "motion.pitch.amplitude_deg=0.0", "time.periods=1",
        "time.steps_per_period=4", "wing.chord=0.02", f"uvlm.panels={panels}", "uvlm.wake=1",
        f"fluid.velocity=[{speed * np.cos(alpha)}, {speed * np.sin(alpha)}]", *settings,
    )  # fmt: skip
    marched = March([case], fluids.load("uvlm"))
    numpy_view(marched.groups["wake"].scalar)[:, wake.DISTANCE] = 1e14
    return marched.advance(1)[0], speed, case


LATTICES = [("uniform", "panels"), ("uniform", "vortices"), ("cosine", "vortices")]


@pytest.mark.parametrize(("spacing", "loads"), LATTICES)
@pytest.mark.parametrize("panels", [1, 2, 5, 50])
@pytest.mark.parametrize("alpha_deg", [-40.0, 5.0])
def test_steady_plate_lifts_2_pi_sin_alpha(spacing, loads, panels, alpha_deg):
    frames, speed, case = plate(alpha_deg, panels, f"uvlm.spacing={spacing}", f"uvlm.loads={loads}")
    lift_coefficient = -2.0 * frames["circulation"][0] / (speed * case.wing.chord)
    assert lift_coefficient == pytest.approx(2 * np.pi * np.sin(np.radians(alpha_deg)), rel=1e-10)
    normal = frames["force"][0, 0] / (0.5 * 1.225 * speed**2 * case.wing.chord * case.wing.span)
    expected = 2 * np.pi * np.sin(np.radians(alpha_deg)) * np.cos(np.radians(alpha_deg))
    assert normal == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("spacing", ["uniform", "cosine"])
@pytest.mark.parametrize("panels", [2, 3, 20])
def test_a_steady_plate_with_suction_has_no_drag(spacing, panels):
    alpha = np.radians(20.0)
    frames, speed, case = plate(20.0, panels, f"uvlm.spacing={spacing}", "uvlm.loads=vortices", "uvlm.suction=true")
    normal, axial, moment = frames["force"][0, :3] / (0.5 * 1.225 * speed**2 * case.wing.chord * case.wing.span)
    assert axial * np.cos(alpha) + normal * np.sin(alpha) == pytest.approx(0.0, abs=1e-10)
    assert axial == pytest.approx(-2 * np.pi * np.sin(alpha) ** 2, rel=1e-10)
    assert moment / normal == pytest.approx(case.wing.chord / 4, rel=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("settings", [(), ACCURATE])
def test_no_penetration_of_the_deformed_camber_line(settings):
    case = hawkmoth(*SHORT, "wing.modes=2", "uvlm.panels=12", "uvlm.wake=20", "uvlm.core=0.02", *settings)
    oracle = UvlmOracle(case).march(25)
    sources = np.vstack((oracle.bound, np.zeros((0, 3))))
    induced = velocity(oracle.controls, sources) + velocity(oracle.controls, oracle.wake)
    through = np.sum((induced - oracle.control_velocity(oracle.v)) * oracle.normal, axis=1)
    ours = march(case)[0]
    np.testing.assert_allclose(ours.panel_circulation[25], oracle.bound[:, 2], rtol=1e-5)
    assert np.abs(through).max() < 1e-10 * np.abs(oracle.control_velocity(oracle.v)).max()


@pytest.mark.slow
@pytest.mark.parametrize("settings", [(), ("uvlm.wake=all", "uvlm.shedding=local"), ("uvlm.wake=7",)])
def test_kelvins_sum_is_zero_at_every_step(settings):
    case = hawkmoth("time.periods=2", "wing.modes=2", "uvlm.panels=20", *settings)
    marched = March([case], fluids.load("uvlm"))
    wakes, flow = marched.groups["wake"], marched.groups["flow"]
    worst = largest = 0.0
    while not marched.done:
        marched.advance(1)
        held = int(numpy_view(wakes.ring)[0, wake.COUNT])
        shed = numpy_view(wakes.vortex)[0, 2, :held].sum() + numpy_view(wakes.scalar)[0, wake.DROPPED]
        worst = max(worst, abs(shed + numpy_view(flow.scalar)[0, TOTAL]))
        largest = max(largest, abs(numpy_view(flow.scalar)[0, TOTAL]))
    assert largest > 0.05
    assert worst < 1e-12 * largest


@pytest.fixture(autouse=True, scope="module")
def started():
    start()


@ti.kernel
def convect_once(
    wakes: wake.Wake, bound: Floats3, stream: Floats2, count: ti.i32, n: ti.i32, step: ti.f64,
    single: ti.template(),
):  # fmt: skip
    for i in range(1):
        wake.convect(wakes, bound, count, stream, 0, n, step, single, False)


@pytest.mark.parametrize("core", [0.0, 0.3])
@pytest.mark.parametrize("convection", ["euler", "second_order"])
@pytest.mark.parametrize(("precision", "digits"), [("double", 1e-12), ("single", 3e-6)])
def test_convection_matches_the_oracle(rng, core, convection, precision, digits):
    case = hawkmoth(
        "uvlm.wake=21", f"uvlm.core={core}", f"uvlm.convection={convection}", "wing.chord=1.0",
        f"uvlm.precision={precision}",
    )  # fmt: skip
    wakes = wake.allocate([case])
    vortices, bound = rng.normal(size=(4, 21)), rng.normal(size=(4, 8))
    vortices[3], bound[3] = core**2, 0.0
    numpy_view(wakes.vortex)[0, :4, :21] = vortices
    numpy_view(wakes.ring)[0] = (21, 21, 4, 3, 0, 0, 0)
    earlier = rng.normal(size=(2, 21))
    numpy_view(wakes.vortex)[0, wake.BEFORE :, :21] = earlier
    numpy_view(wakes.origin)[0, wake.SHED_AT, :21] = [6, *range(-14, 6)]
    stream = [0.3, -0.2]
    convect_once(wakes, bound[None], np.array([[*stream, *[0.0] * 9]]), 5, 7, 0.1, precision == "single")
    sources = np.hstack((vortices, bound[:, :5])).T
    now = velocity(vortices[:2].T, sources, vortices[3]) + stream
    step = 0.1 * now
    if convection == "second_order":
        step[1:] += 0.05 * (now - earlier.T)[1:]
    moved = numpy_view(wakes.vortex)[0, :2, :21].T - vortices[:2].T
    np.testing.assert_allclose(moved, step, atol=digits * np.abs(step).max() + 1e-15)
    assert precision == "double" or np.abs(moved - step).max() > 1e-9 * np.abs(step).max()


@pytest.mark.slow
def test_a_march_in_single_precision_is_itself_in_any_company_and_near_the_double(monkeypatch):
    settings = ("uvlm.wake=90", "time.periods=1", "uvlm.panels=9", "uvlm.core=0.02")
    double, single = hawkmoth(*settings), hawkmoth(*settings, "uvlm.precision=single")
    exact, _ = march(double)
    alone, _ = march(single)
    assert not np.array_equal(alone.force, exact.force)
    # Later the wake, which is chaotic, makes more of it.
    np.testing.assert_allclose(alone.force[:100], exact.force[:100], atol=1e-5 * np.abs(exact.force).max())
    together, _ = march([double, single])
    np.testing.assert_array_equal(together[0].force, exact.force)
    np.testing.assert_array_equal(together[1].force, alone.force)
    monkeypatch.setattr(long_wake, "WIDE", 60)
    wide, _ = march(single, threads=2)
    np.testing.assert_array_equal(wide.force, alone.force)


def test_a_core_grows_with_the_way_moved():
    case = hawkmoth("uvlm.core=0.5", "uvlm.core_growth=0.25", "wing.chord=1.0", "uvlm.wake=8")
    wakes = wake.allocate([case])
    shed_once(wakes, 0, 0.0, 0.0)
    cores = []
    for n in range(1, 5):
        convect_once(wakes, np.zeros((1, 4, 8)), np.array([[3.0, 4.0, *[0.0] * 9]]), 0, n, 0.12, False)
        cores.append(np.sqrt(numpy_view(wakes.vortex)[0, 3, 0]))
    assert cores == pytest.approx([0.15, 0.3, 0.45, 0.5])


@ti.kernel
def shed_once(wakes: wake.Wake, n: ti.i32, y: ti.f64, z: ti.f64):
    for i in range(1):
        wake.shed(wakes, 0, n, wake.TRAILING, y, z)


def test_a_full_ring_gives_up_its_oldest():
    case = hawkmoth("uvlm.wake=3")
    wakes = wake.allocate([case])
    for n in range(5):
        shed_once(wakes, n, float(n), -float(n))
        youngest = numpy_view(wakes.ring)[0, wake.YOUNGEST]
        numpy_view(wakes.vortex)[0, 2, youngest] = 10.0**n
    keep, count, oldest, *_ = numpy_view(wakes.ring)[0]
    order = (oldest + np.arange(count)) % keep
    assert numpy_view(wakes.origin)[0, wake.SHED_AT, order].tolist() == [2, 3, 4]
    assert numpy_view(wakes.vortex)[0, 0, order].tolist() == [2.0, 3.0, 4.0]
    assert numpy_view(wakes.scalar)[0, wake.DROPPED] == 11.0


def test_the_kernel_takes_fewer_than_forty_arrays():
    """Taichi allows 64."""
    marched = March([hawkmoth(*SHORT)], fluids.load("uvlm"))
    launch = 1
    assert launch + sum(len(group.items) for _, group in marched._batch.items) < 40


def test_wake_of_frames_runs_from_the_oldest_to_the_youngest():
    case = hawkmoth(*SHORT, "uvlm.wake=10", "uvlm.panels=4")
    frames, _ = march(case)
    ends = np.cumsum(frames.wake_count)
    assert frames.wake_count.tolist() == [min(n + 1, 10) for n in range(31)]
    assert frames.wake_birth[ends[-2] :].tolist() == list(range(21, 31))


ABSORBING = SimpleNamespace(absorbing=True, listing=False, shortening=False)


@ti.kernel
def make_room_once(wakes: wake.Wake, y: ti.f64, z: ti.f64):
    for i in range(1):
        merging.make_room(wakes, 0, 1, y, z, ABSORBING)


def absorbing(rng, count, *settings):
    """A full ring of random vortices of both signs, rotated so that the oldest is in the middle of the array."""
    case = hawkmoth(f"uvlm.wake={count}", "uvlm.old_wake=absorb", "wing.chord=1.0", "uvlm.absorb_beyond=0.0", *settings)
    wakes = wake.allocate([case])
    vortices = np.zeros((5, count))
    vortices[:3] = rng.normal(size=(3, count))
    numpy_view(wakes.vortex)[0, :5, :count] = vortices
    numpy_view(wakes.origin)[0, wake.SHED_AT, :count] = np.roll(np.arange(count), 4)
    numpy_view(wakes.ring)[0] = (count, count, 4, 3, 0, 0, 0)
    return wakes, vortices


def moments(vortices):
    y, z, gamma = vortices[:3]
    return np.array([gamma.sum(), gamma @ y, gamma @ z])


@pytest.mark.parametrize("count", [8, 40])
def test_absorbing_keeps_circulation_and_impulse(rng, count):
    for _ in range(20):
        wakes, before = absorbing(rng, count)
        make_room_once(wakes, 6.0, 8.0)
        after = numpy_view(wakes.vortex)[0, :, :count].copy()
        oldest = numpy_view(wakes.ring)[0, wake.OLDEST]
        assert after[2, oldest] == 0.0
        np.testing.assert_allclose(moments(after), moments(before), atol=1e-13 * count)
        births = np.roll(numpy_view(wakes.origin)[0, wake.SHED_AT, :count], -oldest)[1:]
        assert np.all(np.diff(births) > 0)
        target = np.array([[6.0, 8.0]])
        change = velocity(target, before[:3].T)[0] - velocity(target, after[:3].T)[0]
        np.testing.assert_allclose(numpy_view(wakes.scalar)[0, :2], change, atol=1e-14 * count)


def test_vortices_that_cancel_are_not_thrown_far(rng):
    """Opposite neighbours whose sum nearly vanishes: their centroid is far outside."""
    wakes, _ = absorbing(rng, 6)
    vortices = numpy_view(wakes.vortex)
    vortices[0, :3, :6] = np.array([[0, 1, 2, 3, 4, 5], [0, 0.1, 0, 0.1, 0, 0.1], [1, -1, 1, -1 - 1e-9, 1, -1]], float)
    before = vortices[0, :, :6].copy()
    make_room_once(wakes, 30.0, 40.0)
    after = vortices[0, :, :6]
    np.testing.assert_allclose(moments(after), moments(before), atol=1e-12)
    assert np.abs(after[:2]).max() <= 7.0


def test_near_vortices_are_absorbed_last(rng):
    wakes, _ = absorbing(rng, 30, "uvlm.absorb_beyond=50.0")
    vortices = numpy_view(wakes.vortex)
    order = (4 + np.arange(30)) % 30
    vortices[0, 0, order[5:9]] += 100.0
    make_room_once(wakes, 0.0, 0.0)
    births = np.roll(numpy_view(wakes.origin)[0, wake.SHED_AT, :30], -4)[1:]
    gone = set(range(30)) - set(births.tolist())
    assert gone <= {5, 6, 7, 8}


def test_what_is_dropped_is_estimated_by_the_velocity_it_induced(rng):
    wakes, before = absorbing(rng, 8, "uvlm.old_wake=drop")
    make_room_once(wakes, 3.0, -2.0)
    expected = velocity(np.array([[3.0, -2.0]]), before[:3, [4]].T)[0]
    np.testing.assert_allclose(numpy_view(wakes.scalar)[0, :2], expected, rtol=1e-12)


@pytest.mark.parametrize(("crossing", "sign"), [("reflect", -1.0), ("pass", 1.0)])
def test_a_vortex_that_meets_the_wing(crossing, sign):
    """One that was below the wing is now above it."""
    case = hawkmoth(
        "wing.modes=0", "motion.plunge.phase_deg=0.0", "motion.pitch.amplitude_deg=0.0", "time.periods=1",
        f"uvlm.crossing={crossing}", *ACCURATE, "uvlm.core=0.5",
    )  # fmt: skip
    marched = March([case], fluids.load("uvlm"))
    marched.advance(1)
    wakes = marched.groups["wake"]
    numpy_view(wakes.vortex)[0, :5, 0] = 0.01, 1e-4, 1e-9, 0.0, -1e-5
    marched.advance(1)
    assert numpy_view(wakes.ring)[0, wake.CROSSINGS] == 1
    assert sign * numpy_view(wakes.vortex)[0, wake.HEIGHT, 0] > 0.0
    assert sign * (numpy_view(wakes.vortex)[0, 1, 0] - marched.motion[0, 1, 0]) > 0.0


def test_a_kernel_that_holds_more_gives_the_same_bits():
    plain = hawkmoth("time.periods=1", "time.steps_per_period=40", "uvlm.panels=9")
    accurate = plain.override("uvlm.loads=vortices", "uvlm.spacing=cosine", "uvlm.suction=true")
    alone, _ = march(plain)
    (together, _), _ = march([plain, accurate])
    for name, values in vars(alone).items():
        np.testing.assert_array_equal(getattr(together, name), values, err_msg=name)
