"""A leading edge that sheds: identities, closed forms of a starting plate, and an independent march."""

import numpy as np
import pytest
from conftest import CASES, assert_columns_agree, hawkmoth, march
from matplotlib.colors import to_hex
from oracle import UvlmOracle
from taichiflap_viewer.charts import quantities
from taichiflap_viewer.colours import LIGHT
from taichiflap_viewer.frames import Run
from taichiflap_viewer.legend import legend

import taichiflap
from taichiflap import fluids
from taichiflap.case.case import CaseError
from taichiflap.drawing import palette
from taichiflap.export.table import write_csv
from taichiflap.fluids.uvlm import long_wake, wake
from taichiflap.kernels.runtime import view
from taichiflap.march.march import March
from taichiflap.plots.result import summary, wing
from taichiflap.run import warnings

EDGE = (
    "uvlm.spacing=cosine", "uvlm.loads=vortices", "uvlm.shedding=local", "uvlm.convection=second_order",
    "uvlm.core=0.05", "uvlm.core_growth=0.3", "uvlm.crossing=pass", "uvlm.wake=all", "uvlm.merge_error=0.0",
    "uvlm.leading_edge=sheds",
)  # fmt: skip
SHORT = (*EDGE, "uvlm.panels=12", "time.periods=2", "time.steps_per_period=60")
PLATE = (
    *EDGE, "wing.modes=0", "wing.chord=1.0", "wing.span=1.0", "fluid.density=1.0", "motion.plunge.amplitude=0.0",
    "motion.pitch.amplitude_deg=0.0", "motion.frequency=0.5", "time.periods=1",
)  # fmt: skip


def broadside(step, *settings):
    """A plate of unit chord normal to a stream of unit speed from t = 0 on, for two chords of travel."""
    steps = round(2.0 / step)
    return hawkmoth(
        *PLATE, "fluid.velocity=[0.0, 1.0]", "uvlm.suction_limit=0.0", "uvlm.panels=40",
        f"time.steps_per_period={steps}", *settings,
    )  # fmt: skip


def vortices(marched):
    """Y, Z, circulation and edge of all wake vortices of a march's only case."""
    wakes = marched.groups["wake"]
    held = int(view(wakes.ring)[0, wake.COUNT])
    return view(wakes.vortex)[0, :3, :held], view(wakes.origin)[0, wake.SHED_FROM, :held]


def impulse(marched):
    """Impulse of all vortices over density and span, along Y and Z; a stream does not change its rate."""
    (y, z, gamma), _ = vortices(marched)
    bound = view(marched.groups["flow"].panel)[0, :, : marched.cases[0].uvlm.panels]
    return np.array([gamma @ z + bound[2] @ bound[1], -(gamma @ y) - bound[2] @ bound[0]])


@pytest.mark.slow
def test_no_limit_is_an_attached_edge_bit_for_bit():
    settings = (*SHORT, "wing.modes=2")
    free, _ = march(hawkmoth(*settings, "uvlm.suction_limit=1e9"))
    attached, _ = march(hawkmoth(*settings, "uvlm.leading_edge=attached", "uvlm.suction=true"))
    for name in ("q", "force", "modal_force", "circulation", "panel_circulation", "wake"):
        assert np.array_equal(getattr(free, name), getattr(attached, name)), name
    assert not free.leading_edge_sheds.any()
    np.testing.assert_allclose(free.suction_velocity[1:], attached.suction_velocity[1:], rtol=0.05, atol=0.05)


@pytest.mark.parametrize(
    "settings",
    [
        ("wing.modes=2", "uvlm.suction_limit=0.1"),
        ("wing.modes=3", "uvlm.suction_limit=0.0"),
        (
            "wing.modes=0",
            "uvlm.suction_limit=0.1",
            "wing.pivot=0.3",
            "wing.span=[[0, 0.05], [1, 0]]",
            "fluid.velocity=[2.0, 0.5]",
        ),
        ("wing.modes=1", "uvlm.suction_limit=0.05", "fluid.viscosity=1.5e-5"),
    ],
)
def test_matches_an_independent_march(settings):
    case = hawkmoth(*EDGE, "uvlm.panels=9", "time.periods=1", "time.steps_per_period=30", *settings)
    frames, _ = march(case)
    assert 0.2 < frames.leading_edge_sheds.mean() <= 1.0
    oracle = UvlmOracle(case).march(case.steps)
    for name, ours, tolerance in (
        ("q", frames.q[:, 0], 1e-9),
        ("a", frames.q[:, 2], 1e-9),
        ("force", frames.force[:, :3], 1e-9),
        ("gamma", frames.panel_circulation, 1e-6),
        ("released", frames.leading_edge_circulation[:, None], 1e-9),
    ):
        theirs = np.array([step[name] for step in oracle.history])
        assert_columns_agree(ours, theirs, tolerance)
    suction = np.array([step["suction"] for step in oracle.history])[:, 0]
    np.testing.assert_allclose(frames.suction_velocity, suction, atol=1e-9 * case.reference_speed)


@pytest.mark.parametrize(("limit", "modes"), [(0.0, 2), (0.1, 0), (0.1, 2)])
def test_the_suction_is_at_its_limit_while_the_edge_sheds_and_kelvins_sum_is_zero(limit, modes):
    case = hawkmoth(*SHORT, f"uvlm.suction_limit={limit}", f"wing.modes={modes}")
    frames, marched = march(case)
    most = limit * case.reference_speed
    sheds = frames.leading_edge_sheds == 1.0
    assert sheds.any()
    np.testing.assert_allclose(np.abs(frames.suction_velocity[sheds]), most, atol=1e-13 * case.reference_speed)
    assert np.all(np.abs(frames.suction_velocity) < most * 1.002 + 1e-12)
    (_, _, gamma), edge = vortices(marched)
    released = frames.leading_edge_circulation[-1]
    largest = np.abs(frames.circulation).max()
    assert gamma[edge == wake.LEADING].sum() == pytest.approx(released, abs=1e-13 * largest)
    assert gamma.sum() + frames.circulation[-1] == pytest.approx(0.0, abs=1e-13 * largest)
    held = np.split(np.arange(len(frames.wake_edge)), np.cumsum(frames.wake_count)[:-1])[-1]
    assert np.array_equal(frames.wake_edge[held], edge)


def test_a_plate_broadside_sheds_alike_at_both_edges():
    frames, _ = march(broadside(0.02))
    np.testing.assert_allclose(
        frames.leading_edge_circulation, -frames.trailing_edge_circulation, atol=1e-11 * frames.force[:, 0].max()
    )
    np.testing.assert_allclose(frames.circulation, 0.0, atol=1e-11)


@pytest.mark.slow
def test_a_plate_that_starts_broadside():
    """Circulation and force compared with converged values of a prototype; early growth with Brown and Michael."""
    frames, _ = march(broadside(0.005, "uvlm.core=0.02", "uvlm.core_growth=0.1"))
    at = np.rint(np.array([0.1, 0.5, 1.0, 2.0]) / 0.005).astype(int)
    np.testing.assert_allclose(np.abs(frames.leading_edge_circulation[at]), [1.18, 2.19, 3.03, 4.35], rtol=0.01)
    at = np.rint(np.array([0.2, 0.5, 1.0, 1.9]) / 0.005).astype(int)
    np.testing.assert_allclose(2.0 * frames.force[at, 0], [5.2, 4.0, 3.0, 2.2], rtol=0.02)
    early = np.array([2, 4, 6, 10])
    rolled_up = np.abs(frames.leading_edge_circulation[early]) / (0.005 * early) ** (1.0 / 3.0)
    np.testing.assert_allclose(rolled_up, np.pi * 2.0 ** (-1.0 / 3.0), rtol=0.03)


@pytest.mark.slow
def test_the_force_is_the_rate_of_impulse_of_both_sheets():
    errors = []
    for step in (0.02, 0.01):
        marched = March([broadside(step)], fluids.load("uvlm"))
        found, load = [], []
        while not marched.done:
            load.append(marched.advance(1)[0]["force"][0, 0])
            found.append(impulse(marched)[1])
        rate = -np.gradient(found, step)
        part = slice(round(0.2 / step), -2)
        errors.append(np.sqrt(np.mean((np.array(load) - rate)[part] ** 2) / np.mean(np.array(load)[part] ** 2)))
    assert errors[0] < 0.0135
    assert errors[1] < 0.6 * errors[0]


@pytest.mark.slow
def test_bits_do_not_depend_on_company_threads_or_an_interruption():
    """With a merging and an absorbing wake, in a batch with an attached case."""
    case = hawkmoth(*SHORT, "wing.modes=2", "uvlm.merge_error=1e-2", "uvlm.wake=60", "uvlm.old_wake=absorb")
    attached = hawkmoth(*SHORT, "uvlm.leading_edge=attached", "wing.modes=1", "uvlm.panels=9")
    alone, _ = march(case)
    assert alone.wake_count[-1] <= 60
    by_itself, _ = march(attached)
    for threads in (1, None):
        (ours, other), _ = march([case, attached], threads=threads, block=37)
        for name in ("q", "force", "wake", "wake_edge", "wake_birth", "suction_velocity"):
            assert np.array_equal(getattr(ours, name), getattr(alone, name)), name
        for name in ("q", "force", "wake"):
            assert np.array_equal(getattr(other, name), getattr(by_itself, name)), name
    first = March([attached, case], fluids.load("uvlm"))
    first.advance(71)
    second = March([case], fluids.load("uvlm"))
    second.restore([first.state(1)], 71)
    rest = second.advance(10**9)[0]
    assert np.array_equal(rest["force"], alone.force[71:])
    assert np.array_equal(rest["q"], alone.q[71:])


def test_merging_keeps_circulation_and_centroid_of_each_sheet():
    case = hawkmoth(*EDGE, "wing.modes=0", "uvlm.panels=12", "time.periods=2", "time.steps_per_period=200")
    plain, _ = march(case)
    merging, marched = march(case.override("uvlm.merge_error=1e-3"))
    assert merging.wake_count[-1] < 0.7 * plain.wake_count[-1]
    # Its effect on the wing is as small as it says, until the wake's own instability takes it up.
    early = slice(0, 200)
    np.testing.assert_allclose(merging.force[early, 0], plain.force[early, 0], atol=0.02 * np.abs(plain.force).max())
    (_, _, gamma), edge = vortices(marched)
    largest = np.abs(merging.circulation).max()
    for which, released in enumerate((merging.trailing_edge_circulation, merging.leading_edge_circulation)):
        assert gamma[edge == which].sum() == pytest.approx(released[-1], abs=1e-12 * largest)
    births = view(marched.groups["wake"].origin)[0, wake.SHED_AT, : len(edge)]
    for which in (0, 1):
        assert np.all(np.diff(births[edge == which]) > 0)


@pytest.mark.slow
def test_two_sheets_go_by_all_threads_and_by_the_tree(monkeypatch):
    """All threads give the same bits; the tree stays within the error that it is allowed."""
    settings = (*SHORT, "wing.modes=1", "uvlm.merge_error=1e-5")
    fused, _ = march(hawkmoth(*settings))
    monkeypatch.setattr(long_wake, "WIDE", 60)
    wide, marched = march(hawkmoth(*settings), block=50)
    assert marched.flow.first == 30
    for name in ("q", "force", "wake", "wake_edge"):
        assert np.array_equal(getattr(wide, name), getattr(fused, name)), name
    monkeypatch.setattr(long_wake, "FAR", 60)
    treed = hawkmoth(*settings, "uvlm.far_error=1e-6")
    by_tree, marched = march(treed)
    error = view(marched.groups["wake"].scalar)[0, wake.FAR_ERROR]
    assert 0.0 < error < 1e-6 * long_wake.typical_speed_of(treed)
    early = slice(0, 80)
    largest = np.abs(fused.force).max()
    np.testing.assert_allclose(by_tree.force[early], fused.force[early], atol=1e-4 * largest)
    assert not np.array_equal(by_tree.force, fused.force)


@pytest.mark.slow
@pytest.mark.parametrize("limit", [0.0, 0.1])
def test_a_light_wing_in_a_dense_fluid_stays_stable(limit):
    """Its mass ratio is 9.4, twenty times the hawkmoth's, its motion small; the tip is that of finer steps."""
    light = (
        *EDGE, "wing.modes=1", f"uvlm.suction_limit={limit}", "uvlm.panels=20", "fluid.density=24.5",
        "motion.plunge.amplitude=0.001", "motion.pitch.amplitude_deg=1.0", "time.periods=2",
    )  # fmt: skip
    coarse, _ = march(hawkmoth(*light, "time.steps_per_period=200"))
    fine, _ = march(hawkmoth(*light, "time.steps_per_period=600"))
    assert coarse.leading_edge_sheds.any()
    peak = np.abs(fine.q[:, 0, 0]).max()
    assert np.abs(coarse.q[:, 0, 0]).max() == pytest.approx(peak, rel=0.003)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (("uvlm.spacing=uniform",), 'spacing = "cosine"'),
        (("uvlm.loads=panels",), 'loads = "vortices"'),
        (("uvlm.suction=true",), "suction_limit"),
        (("uvlm.wake=4",), "at least 10"),
        (("uvlm.suction_limit=-1",), "suction_limit"),
        (("motion.plunge.amplitude=0",), "reference_speed"),
        (("fluid.viscosity=0",), "viscosity"),
    ],
)
def test_what_an_edge_that_sheds_cannot_go_with_is_refused_with_the_cure(settings, said):
    with pytest.raises(CaseError, match=said):
        hawkmoth(*SHORT, *settings)


def test_an_edge_that_sheds_has_defaults_of_its_own_which_yield_to_what_is_given():
    case = taichiflap.load_case(CASES / "plunging_foil.toml")
    made = case.override("uvlm.leading_edge=sheds").uvlm
    assert (made.panels, made.core, made.core_growth, made.crossing) == (case.uvlm.panels, 0.05, 0.3, "pass")


def test_a_plate_edge_on_to_a_stream_has_blasius_friction():
    """Both sides together 1.328 rho U^2 c Re^-1/2 a unit span, and no other force."""
    speed, viscosity = 2.0, 1.5e-5
    case = hawkmoth(
        *SHORT, "uvlm.leading_edge=attached", "wing.modes=0", "motion.plunge.amplitude=0.0", "time.periods=1",
        "motion.pitch.amplitude_deg=0.0", f"fluid.velocity=[{speed}, 0.0]", f"fluid.viscosity={viscosity}",
    )  # fmt: skip
    frames, _ = march(case)
    chord, span = case.wing.chord, case.wing.span
    expected = 1.328 * 1.225 * speed**2 * chord * span * (viscosity / (speed * chord)) ** 0.5
    np.testing.assert_allclose(frames.force[:, 1], expected, rtol=1e-12)
    np.testing.assert_allclose(frames.force[:, [0, 2]], 0.0, atol=1e-15)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (("uvlm.core=0.02",), "smaller than the largest panel"),
        (("uvlm.suction_limit=0", "fluid.velocity=[20, 0]", "motion.pitch.amplitude_deg=1"), "sheds at every angle"),
        ((), "at least 20"),
    ],
)
def test_what_separated_flow_is_not_good_for_is_warned_of(settings, said):
    assert said in " ".join(warnings.warnings(hawkmoth(*SHORT, *settings)))
    assert said not in " ".join(warnings.warnings(hawkmoth(*SHORT, *settings, "uvlm.leading_edge=attached")))


def test_two_sheets_are_told_apart_in_files_figures_and_the_viewer(tmp_path):
    case = hawkmoth(*SHORT, "wing.modes=1", "uvlm.suction_limit=0.3")
    with taichiflap.simulate(case, tmp_path / "sheds.h5") as result:
        assert result.has_sheets
        last = result.wake(-1)
        assert set(last["edge"]) == {0, 1}
        released = last["circulation"][last["edge"] == 1].sum()
        assert released == pytest.approx(result.leading_edge_circulation[-1], abs=1e-6)
        write_csv(result, tmp_path / "sheds.csv")
        header = (tmp_path / "sheds.csv").read_text().split("\n")[0]
        assert "leading_edge_sheds (1)" in header
        assert "suction_velocity (m s-1)" in header
        dots = [
            {to_hex(colour) for colour in ax.collections[0].get_facecolors()}
            for ax in wing(result, sheets=True).axes
            if ax.collections
        ]
        assert set.union(*dots) == set(palette.SHEETS)
        marked = [one for ax in summary([result]).axes for one in ax.collections]
        assert any(to_hex(one.get_facecolor()[0]) == palette.SHEETS[1] for one in marked)
        run = Run(result, "sheds")
        assert np.array_equal(run.frame(run.frames - 1).edge, last["edge"])
        assert "two sheets" in legend([run], LIGHT, None)
        assert "leading_edge_sheds" in [quantity.name for quantity in quantities([run])]
