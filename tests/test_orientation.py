"""Orientation of pictures: the stream to the right, lift up, and nothing mirrored."""

import numpy as np
import pytest
from conftest import hawkmoth

import taichiflap
from taichiflap.drawing import scene
from taichiflap.drawing.orientation import Orientation
from taichiflap.metrics.summary import in_stream

STREAMS = [(0.0, 0.0), (2.0, 0.0), (0.0, 1.5), (1.0, -2.0), (-3.0, 0.5)]


@pytest.mark.parametrize("stream", STREAMS)
def test_a_picture_is_turned_and_not_mirrored(stream, rng):
    case = hawkmoth(f"fluid.velocity={list(stream)}")
    page = Orientation.of(case)
    y, z = rng.normal(size=(2, 40))
    places = page.on_page(y, z)
    np.testing.assert_allclose(np.hypot(*places.T), np.hypot(y, z), rtol=1e-12)
    np.testing.assert_allclose(page.off_page(places), (y, z), atol=1e-12)
    e_y, e_z = page.on_page(1.0, 0.0), page.on_page(0.0, 1.0)
    assert e_y[0] * e_z[1] - e_y[1] * e_z[0] == pytest.approx(1.0)
    if any(stream):
        np.testing.assert_allclose(page.on_page(*stream), (np.hypot(*stream), 0.0), atol=1e-12)
        lift, thrust = in_stream(case, y, z)
        np.testing.assert_allclose(places, np.stack((-thrust, lift), axis=1), atol=1e-12)
    else:
        np.testing.assert_array_equal(places, np.stack((z, -y), axis=1))


def test_pictures_of_a_stream_show_it_to_the_right_and_the_stroke_across_it():
    settings = ("time.periods=1", "time.steps_per_period=40", "wing.modes=0", "solver=dbet", "fluid.velocity=[2.0, 0]")
    with taichiflap.simulate(hawkmoth(*settings)) as result:
        frames = scene.last_beats(result)
        low, high = scene.stroke(result, frames)
        assert low[0] == high[0] == 0.0
        assert (low[1], high[1]) == pytest.approx((result.plunge.min(), result.plunge.max()))
        lift, thrust = in_stream(result.case, result.force_y[17], result.force_z[17])
        np.testing.assert_allclose(scene.frame(result, 17).force, (-thrust, lift))
        assert scene.stream(result.case) == "U = 2 m/s"


def test_a_pivot_that_stays_has_no_stroke():
    small = ("time.periods=1", "time.steps_per_period=40", "wing.modes=0", "solver=dbet")
    with taichiflap.simulate(hawkmoth(*small, "motion.plunge.amplitude=0")) as result:
        assert scene.stroke(result, scene.last_beats(result)) is None
        assert scene.stream(result.case) == ""
