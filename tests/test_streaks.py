"""Streak lines: exact in a uniform flow whose velocity is linear in time, and the same however a frame is reached."""

from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pytest
from taichiflap_viewer.streak_lines import GAP, lines
from taichiflap_viewer.streaks import OFF, STEPS, Streaks

from taichiflap.drawing.orientation import Orientation

CHORD, BEAT, PER_BEAT = 0.02, 0.04, 40
POINT = (1.5, -0.25)


class Uniform:
    """A run about a wing at rest, in a flow of velocity (1 + 20 t, -0.5) m/s."""

    frames_per_beat, chord, page = PER_BEAT, CHORD, Orientation()
    case = SimpleNamespace(beat=BEAT)

    def turns(self, index):
        return index / PER_BEAT

    def frame(self, index):
        return SimpleNamespace(nodes=np.array([[0.0, 0.0], [1.0, 0.0]]), axes=np.eye(2))

    def velocity(self, index):
        along = 1.0 + 20.0 * index * BEAT / PER_BEAT
        return lambda points: np.stack((np.full(points.shape[1:], along), np.full(points.shape[1:], -0.5)))


@pytest.fixture
def streaks():
    with ThreadPoolExecutor(1) as pool:
        yield Streaks(Uniform(), pool)


@pytest.mark.parametrize("index", [7, 65])
def test_particles_are_where_a_uniform_flow_has_carried_them(streaks, index):
    found = streaks.ask(index, (POINT,)).result()
    now, count = index * BEAT / PER_BEAT, found.shape[-1]
    assert count >= STEPS
    released = now - BEAT / count * np.arange(count)
    moved = np.stack(((now - released) + 10.0 * (now**2 - released**2), -0.5 * (now - released)))
    sources = Uniform.page.off_page(CHORD * np.array([[-OFF, 0.0], [1.0 + OFF, 0.0], POINT]))
    expected = np.where(released >= -1e-12, sources[..., None] + moved[:, None], np.nan)
    np.testing.assert_allclose(found, expected, atol=1e-14)


def test_a_frame_is_the_same_however_it_is_reached(streaks):
    there = [streaks.ask(index, (POINT,)).result() for index in (90, 91, 93)]
    with ThreadPoolExecutor(1) as pool:
        again = Streaks(Uniform(), pool)
        np.testing.assert_array_equal(again.ask(93, (POINT,)).result(), there[2])
        np.testing.assert_array_equal(again.ask(91, (POINT,)).result(), there[1])


def test_a_line_is_interrupted_where_its_particles_are_far_apart():
    places = np.array([[[0.0, 0.0], [0.1, 0.0], [0.1, 2.0 * GAP], [np.nan, np.nan]]])
    starts, ends = np.moveaxis(lines(places)[..., [0, 2]], 1, 0)
    np.testing.assert_allclose(ends - starts, [[0.1, 0.0], [0.0, 0.0], [0.0, 0.0]], atol=1e-7)
