"""Gusts: kernels compared with the formula, a uniform gust with a stream, and exact theory."""

import numpy as np
import pytest
from conftest import PAPERS_BLADES, hawkmoth, march

from taichiflap import fluids, theory
from taichiflap.case.case import CaseError
from taichiflap.fluids.navier_stokes import gust as viscous
from taichiflap.kernels.arrays import array, zeros
from taichiflap.kernels.runtime import Floats2, Ints1, start, ti, view
from taichiflap.march.stream import EDGE, carry_gust, gust_at, streams
from taichiflap.motion.gust import gust_velocity
from taichiflap.validation import gust

STREAM = ("fluid.velocity=[3.0, -1.0]", "fluid.gust_velocity=0.5", "fluid.gust_length=0.03", "fluid.gust_arrival=0.002")
SHAPES = ("sharp_edged", "one_minus_cosine", "sinusoidal")
STILL = ("wing.modes=0", "motion.plunge.amplitude=0.0", "motion.pitch.amplitude_deg=0.0")


@ti.kernel
def sample(stream: Floats2, places: Floats2, found: Floats2, count: Ints1):
    carry_gust(stream, 0, 0.01)
    for i in range(count[0]):
        found[0, i], found[1, i] = gust_at(stream, 0, places[0, i], places[1, i], stream[0, EDGE])


@pytest.mark.parametrize("shape", SHAPES)
def test_kernels_see_the_gust_of_the_formula(shape, rng):
    start()
    case = hawkmoth(f"fluid.gust={shape}", *STREAM)
    places = rng.uniform(-0.05, 0.05, (2, 200))
    found = zeros(ti.f64, 2, 200)
    sample(streams([case], [10**6]), array(places), found, np.array([200], dtype=np.int32))
    exact = gust_velocity(case.fluid, 0.01, *places)
    assert 0 < np.count_nonzero(exact[0]) < 200
    np.testing.assert_allclose(view(found), exact, atol=1e-12)
    assert np.abs(exact[0] * 3.0 - exact[1]).max() < 1e-12  # across the stream


def test_a_gust_that_covers_the_wing_is_a_stream():
    settings = ("solver=dbet", *STILL, "motion.frequency=0.1", "time.periods=1", "time.steps_per_period=100")
    stream = march(hawkmoth(*settings, "fluid.velocity=[3.0, 0.2]"))[0]
    gusty = march(
        hawkmoth(*settings, "fluid.velocity=[3.0, 0.0]", "fluid.gust=sharp_edged", "fluid.gust_velocity=0.2")
    )[0]
    np.testing.assert_allclose(gusty.force[-1], stream.force[-1], rtol=1e-6, atol=1e-12)


def test_a_gust_turns_with_its_stream():
    turn = np.radians(50.0)
    settings = ("solver=dbet", "wing.modes=2", "motion.plunge.amplitude=0.0", "time.periods=2",
                "time.steps_per_period=50", *STREAM[1:], "fluid.gust=sinusoidal")  # fmt: skip
    one = march(hawkmoth(*settings, "fluid.velocity=[3.0, 0.0]"))[0]
    turned = f"fluid.velocity=[{3.0 * np.cos(turn)}, {3.0 * np.sin(turn)}]"
    two = march(hawkmoth(*settings, turned, "motion.pitch.mean_deg=50.0"))[0]
    np.testing.assert_allclose(two.force, one.force, rtol=1e-8, atol=1e-9 * np.abs(one.force).max())
    assert (
        np.abs(one.force - march(hawkmoth(*settings, "fluid.velocity=[3.0, 0.0]", "fluid.gust=none"))[0].force).max()
        > 0
    )


@pytest.mark.parametrize("solver", ["dbet", "uvlm"])
def test_kuessner(solver):
    places = [0.5, 1.0, 1.5, 3.0, 10.0]
    error = gust.entered(solver, places) - [theory.kuessner(s) for s in places]
    assert np.abs(error).max() < {"dbet": 1e-3, "uvlm": 1.2e-2}[solver]


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["dbet", "uvlm"])
def test_sears(solver):
    for k in (0.2, 1.0):
        case = gust.sinusoidal(solver, k)
        ratio = gust.response(case, march(case)[0], k) / theory.sears(k)
        assert abs(ratio) == pytest.approx(1.0, abs=0.01)
        assert abs(np.degrees(np.angle(ratio))) < 0.5


def test_exact_functions_of_gusts():
    """Tabulated by two methods to 1e-5; Sears's limits: 1 without frequency, `1/sqrt(2 pi k)` at high ones."""
    table = {0.1: 0.141181, 1.0: 0.416695, 2.01: 0.551839, 5.0: 0.738830, 20.0: 0.931190}
    assert [theory.kuessner(s) for s in table] == pytest.approx(list(table.values()), abs=1e-5)
    assert theory.sears(0.0) == 1.0
    assert abs(theory.sears(50.0)) == pytest.approx(1 / np.sqrt(2 * np.pi * 50.0), rel=0.01)


@pytest.mark.parametrize(
    ("settings", "phrase"),
    [
        (("fluid.gust=sharp_edged",), "fluid.velocity"),
        (("fluid.gust=sinusoidal", "fluid.velocity=[1.0, 0.0]"), "fluid.gust_length"),
        (("solver=dbet", *PAPERS_BLADES, "dbet.speed=truncated", "fluid.gust=sharp_edged", STREAM[0]), "fluid.gust"),
    ],
)
def test_gusts_that_cannot_be_are_refused(settings, phrase):
    with pytest.raises(CaseError) as caught:
        fluids.check(hawkmoth(*settings))
    assert phrase in str(caught.value)


VISCOUS = (
    "solver=navier_stokes", "fluid.viscosity=4e-4", "navier_stokes.cells=64", "navier_stokes.radius=4.0",
    "navier_stokes.wall_spacing=0.02", "wing.modes=1", "motion.start_up_periods=1.0", "time.periods=1",
    "time.steps_per_period=400",
)  # fmt: skip


@ti.kernel
def profile(stream: Floats2, behind: Floats2, found: Floats2, count: Ints1):
    for i in range(count[0]):
        share, integral, slope = viscous.shape(stream, 0, behind[0, i])
        found[0, i], found[1, i], found[2, i] = share, integral, slope


@pytest.mark.parametrize("shape", SHAPES)
def test_a_viscous_flow_sees_the_gust_its_integral_and_its_slope(shape):
    start()
    case = hawkmoth(f"fluid.gust={shape}", *STREAM)
    behind = np.linspace(-0.01, 0.05, 6001)
    found = zeros(ti.f64, 3, len(behind))
    profile(streams([case], [viscous.PIECES]), array(behind[None]), found, np.array([len(behind)], dtype=np.int32))
    share, integral, slope = view(found)
    along = np.array(case.fluid.velocity) / np.hypot(*case.fluid.velocity)
    exact = gust_velocity(case.fluid, 0.002, *(-along[:, None] * behind))
    edge = case.wing.chord / viscous.PIECES if shape == "sharp_edged" else 0.0
    inside = np.abs(behind) >= 0.5 * edge
    expected = np.hypot(*exact) / 0.5 * np.sign(exact[1] * along[0])
    np.testing.assert_allclose(share[inside], expected[inside], atol=1e-9)
    width = behind[1] - behind[0]
    np.testing.assert_allclose(np.gradient(integral, width)[1:-1], share[1:-1], atol=1e-2)
    rough = np.abs(np.gradient(slope, width)) > 1e7  # the front of a sinusoid
    np.testing.assert_allclose(np.gradient(share, width)[~rough][1:-1], slope[~rough][1:-1], atol=0.02 * slope.max())
    assert integral[np.argmin(np.abs(behind + 0.005))] == 0.0


@pytest.mark.slow
def test_a_viscous_gust_that_covers_all_is_a_stream():
    """An identity: a bending wing in a stream, and in a slower one with a gust across it that makes up for it."""
    stream = march(hawkmoth(*VISCOUS, "fluid.velocity=[0.5, 0.1]"))[0]
    gusty = march(
        hawkmoth(*VISCOUS, "fluid.velocity=[0.5, 0.0]", "fluid.gust=sharp_edged", "fluid.gust_velocity=0.1",
                 "fluid.gust_arrival=-10.0")
    )[0]  # fmt: skip
    assert len(gusty.force) == 401
    np.testing.assert_allclose(gusty.force, stream.force, rtol=0, atol=1e-8 * np.abs(stream.force).max())
    np.testing.assert_allclose(gusty.q, stream.q, rtol=0, atol=1e-8 * np.abs(stream.q).max())
