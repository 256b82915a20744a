"""Blade elements: an independent march, drag in all quadrants, added mass, convergence."""

import numpy as np
import pytest
from conftest import PAPERS_BLADES, assert_columns_agree, hawkmoth, march
from oracle import DbetOracle

from taichiflap import fluids
from taichiflap.kernels.runtime import view
from taichiflap.march.march import March
from taichiflap.march.state import AXIAL, NORMAL, UNSTEADY

GRADED = ("wing.span=[[0, 0.05], [0.5, 0.06], [1, 0]]", "wing.thickness=[[0, 60e-6], [1, 20e-6]]")
SHORT = ("solver=dbet", *PAPERS_BLADES, "dbet.elements=11", "time.periods=1", "time.steps_per_period=40")


@pytest.mark.parametrize(
    "settings",
    [
        ("wing.modes=3",),
        ("wing.modes=1", "dbet.added_mass=none"),
        ("wing.modes=0", "fluid.velocity=[0.3, 2.0]"),
        ("wing.modes=2", "dbet.speed=truncated", "fluid.velocity=[1.0, -0.5]", "wing.youngs_modulus=8e9"),
        (
            "wing.modes=8",
            "wing.damping_ratio=[0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]",
            "motion.pitch.mean_deg=30",
        ),
        ("wing.modes=2", *GRADED),
        ("wing.modes=0", "wing.pivot=0.3", *GRADED[:1]),
    ],
)
def test_matches_an_independent_march(settings):
    case = hawkmoth(*SHORT, *settings)
    frames, _ = march(case)
    oracle = DbetOracle(case).march(case.steps)
    for name, ours in (("q", frames.q[:, 0]), ("a", frames.q[:, 2]), ("force", frames.force)):
        theirs = np.array([step[name] for step in oracle.history])
        assert_columns_agree(ours, theirs, 1e-9)


@pytest.mark.parametrize("stream_deg", range(15, 360, 30))
def test_a_still_wing_is_dragged_along_by_any_stream(stream_deg):
    stream = 3.0 * np.array([np.cos(np.radians(stream_deg)), np.sin(np.radians(stream_deg))])
    still = hawkmoth(
        *SHORT, "wing.modes=0", "motion.plunge.amplitude=0.0", "motion.pitch.amplitude_deg=0.0",
        "dbet.lift_max=0.0", f"fluid.velocity=[{stream[0]}, {stream[1]}]",
    )  # fmt: skip
    force = march(still)[0].force[-1]
    along_chord, across = stream
    alpha = np.arctan2(across, along_chord)
    drag = 2.2 - 1.8 * np.cos(2 * alpha)
    expected = 0.5 * 1.225 * drag * 3.0 * 0.02 * 0.05 * stream
    np.testing.assert_allclose([force[AXIAL], force[NORMAL]], expected, rtol=1e-12)


def test_a_pointed_wing_feels_the_load_of_its_area():
    case = hawkmoth(*SHORT, "wing.modes=0", "motion.pitch.amplitude_deg=0.0")
    whole, pointed = (march(one)[0].force for one in (case, case.override("wing.span=[[0, 0.05], [1, 0]]")))
    np.testing.assert_allclose(pointed[:, NORMAL], 0.5 * whole[:, NORMAL], rtol=1e-12, atol=1e-18)


def test_rigid_added_mass_is_its_closed_form():
    case = hawkmoth(*SHORT, "wing.modes=0", "dbet.elements=400", "motion.pitch.amplitude_deg=0.0")
    frames, marched = march(case)
    accel = marched.motion[0, :, 2]
    mass = np.pi * 1.225 * 0.02 / 4 * 0.02 * 0.05
    np.testing.assert_allclose(frames.force[:, UNSTEADY], -mass * accel[frames.step], rtol=1e-12, atol=1e-18)


def ring_down(*settings):
    """Frames of a wing released from a bent shape in fluid at rest, blades without drag."""
    case = hawkmoth(
        "solver=dbet", *PAPERS_BLADES, "motion.plunge.amplitude=0.0", "motion.pitch.amplitude_deg=0.0",
        "dbet.lift_max=0.0", "dbet.drag_min=0.0", "dbet.drag_max=0.0", "wing.damping_ratio=0.0",
        "motion.frequency=80.0", *settings,
    )  # fmt: skip
    marched = March([case], fluids.load("dbet"))
    view(marched.body.q)[0, 0, 0] = 1e-6
    return marched.advance(case.steps + 1)[0], case


def test_wet_frequency_in_still_air():
    frames, case = ring_down("time.periods=20", "time.steps_per_period=400")
    q = frames["q"][:, 0, 0]
    crossings = np.flatnonzero((q[:-1] > 0) & (q[1:] <= 0))
    exact = crossings + q[crossings] / (q[crossings] - q[crossings + 1])
    period = np.diff(exact).mean() * case.step
    mu = np.pi * 1.225 * 0.02 / (4 * 1000 * 40e-6)
    assert 1 / period == pytest.approx(79.9582542 / np.sqrt(1 + mu), rel=1e-3)


@pytest.mark.parametrize(("modes", "coarsest"), [(1, 80), (2, 400)])
def test_coupled_solution_converges_at_second_order(modes, coarsest):
    grids = [coarsest * 2**i for i in range(3)]
    finest = coarsest * 32
    tips = {}
    for steps in (*grids, finest):
        case = hawkmoth(
            "solver=dbet", *PAPERS_BLADES, f"wing.modes={modes}", "time.periods=1", f"time.steps_per_period={steps}"
        )
        tips[steps] = march(case)[0].q[:: steps // coarsest, 0]
    errors = [np.abs(tips[steps] - tips[finest]).max() for steps in grids]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all(orders > 1.9), orders


def test_elements_converge_at_second_order():
    forces = {}
    for elements in (4, 8, 16, 256):
        case = hawkmoth(*SHORT, "wing.modes=1", f"dbet.elements={elements}")
        forces[elements] = march(case)[0].force[-1, NORMAL]
    errors = [abs(forces[e] - forces[256]) for e in (4, 8, 16)]
    assert errors[0] / errors[1] > 3.3
    assert errors[1] / errors[2] > 3.3
