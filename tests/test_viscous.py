"""The Navier-Stokes model compared with exact and published viscous flows, as in the validation."""

import numpy as np
import pytest

from taichiflap.validation import separated, viscous

pytestmark = pytest.mark.slow


def errors(check):
    """Errors of a check's rows, all of which pass."""
    assert check.passed, [row for row in check.rows if not row.passed]
    return [row.error for row in check.rows]


def test_a_cylinder_that_turns_to_and_fro_has_the_friction_of_stokes():
    """The treatment of the wall alone: nothing is convected."""
    assert np.abs(errors(viscous.stokes((0.05,)))).max() < 0.1


def test_vortices_part_from_a_cylinder_as_often_as_measured():
    drag, strouhal = errors(viscous.cylinder())
    assert abs(drag) < 0.01
    assert abs(strouhal) < 0.001


def test_a_thin_plate_has_the_drag_of_its_boundary_layers():
    (error,) = errors(viscous.thin_plate())
    assert error == pytest.approx(2.9, abs=0.5)


def test_hover_and_a_ramp_follow_published_forces():
    assert np.abs(errors(separated.separated((90,)))).max() < 8.0


def test_the_rigid_hawkmoths_first_beat():
    (error,) = errors(viscous.first_beat(viscous.FIRST_BEAT[:1], 1000))
    assert abs(error) < 0.03


def test_forces_converge_with_the_grid():
    check = viscous.grids()
    assert check.passed
    coarse, *_, fine = check.charts[0].curves[0].y
    assert fine < 0.5 < 5.0 * fine < coarse * 5.0
