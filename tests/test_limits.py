"""Warnings outside the models' validity: unaccounted energy, deflection, force, a stream from behind."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import CASES, hawkmoth, march

import taichiflap
from taichiflap.case.case import parse_case
from taichiflap.commands.map_summary import map_lines
from taichiflap.maps import file as maps
from taichiflap.maps.design import design
from taichiflap.maps.outcome import Outcome
from taichiflap.march.series import Series
from taichiflap.metrics.beats import whole_beats
from taichiflap.metrics.names import METRICS
from taichiflap.metrics.summary import summarise
from taichiflap.plots import maps as pictures
from taichiflap.run import limits
from taichiflap.run.retry import finer_helps
from taichiflap.run.warnings import outcome, too_bent, unbalanced, warnings


def series(case):
    """The series of a case, marched step by step without a file."""
    frames, marched = march(case)
    found = Series.of(case, marched.sections[0], marched.motion[0], vars(frames))
    names = found.variables
    return SimpleNamespace(case=case, variables=names, **{name: getattr(found, name)[0] for name in names})


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["dbet", "uvlm"])
@pytest.mark.parametrize("stream", [[0.0, 0.0], [1.0, 0.3]])
def test_the_energy_left_over_is_the_error_of_the_step(solver, stream):
    """It falls with the square of the step; the power into the wing is the rate of its energy."""

    def left(steps):
        run = series(
            hawkmoth(
                f"solver={solver}", f"fluid.velocity={stream}", "wing.modes=2", "time.periods=3", "uvlm.panels=10",
                "uvlm.core=0.02", f"time.steps_per_period={steps}", "wing.damping_ratio=[0.05, 0.2]",
            )
        )  # fmt: skip
        beats = whole_beats(run.case, run.time).after(2)
        rate = np.gradient(run.energy, run.time)
        error = np.abs(rate - run.power_net)[beats.frames][1:-1].max() / np.abs(run.power_net).max()
        return summarise(run, beats).energy_residual, error

    (coarse, rough), (fine, smooth) = left(200), left(800)
    assert fine < coarse / 8 < 1e-3
    # At a single moment a vortex that is shed, or an element that stalls, is an event of a step.
    assert smooth < min(rough, 0.01)


def test_the_energy_of_a_rigid_wing_closes_by_itself():
    case = hawkmoth("solver=dbet", "wing.modes=0", "time.periods=2")
    assert summarise(series(case)).energy_residual < 1e-3


@pytest.mark.slow
def test_a_run_that_leaves_energy_over_says_so_and_how_to_cure_it():
    """A soft wing with sixteen steps per beat; with twice as many, the unaccounted energy is smaller."""
    soft = (
        "wing.modes=3", "wing.youngs_modulus=3e9", "motion.pitch.amplitude_deg=30.0", "uvlm.panels=10", "uvlm.wake=all",
        "time.periods=4", "time.steps_per_period=16",
    )  # fmt: skip
    with taichiflap.simulate(hawkmoth(*soft)) as result:
        residual = taichiflap.summarise(result).energy_residual
        assert f"{100 * residual:.2g} % of the work is unaccounted for" in result.attributes["warnings"]
    with taichiflap.simulate(hawkmoth(*soft, "time.steps_per_period=32")) as result:
        assert taichiflap.summarise(result).energy_residual < residual / 2
    case = hawkmoth(*soft)
    assert not list(unbalanced(0.03, case))
    assert not list(unbalanced(None, case))
    (sentence,) = unbalanced(0.12, case)
    assert "12 % of the work" in sentence
    assert "time.steps_per_period, for example to 32" in sentence
    document = case.to_dict() | {"time": {"duration": 0.1, "step": 1e-3}}
    assert "time.step, such as 0.0005" in next(unbalanced(0.12, parse_case(document)))


@pytest.mark.parametrize(
    ("chords", "said"), [(0.29, ""), (0.31, "exceeds 10 %"), (1.01, "is invalid"), (8.0, "deflection is 8")]
)
def test_a_tip_beyond_the_chord_is_no_tenth_off(chords, said):
    assert said in "".join(too_bent(0.02 * chords, 0.02))
    assert bool(list(too_bent(0.02 * chords, 0.02))) == bool(said)


def test_a_force_of_no_flow_is_named():
    summary = SimpleNamespace(force_coefficient_peak=41.0, energy_residual=0.0)
    assert any("is invalid" in one and "41 times" in one for one in outcome(hawkmoth(), np.zeros(3), summary))
    summary.force_coefficient_peak = 39.0
    assert not any("is invalid" in one for one in outcome(hawkmoth(), np.zeros(3), summary))


def test_blades_give_the_force_coefficient_that_they_are_given():
    """A plate that moves normal to its chord at constant speed has the normal drag coefficient."""
    document = hawkmoth("solver=dbet", "wing.modes=0", "dbet.drag_max=3.0", "dbet.attached=false").to_dict()
    document["motion"] = {"plunge": {"kind": "table", "points": [[0.0, 0.0], [0.1, 0.1], [0.2, 0.2], [1.0, 1.0]]}}
    document |= {"time": {"duration": 1.0, "step": 0.01}}
    summary = summarise(series(parse_case(document)))
    assert summary.force_coefficient_peak == pytest.approx(3.0, rel=1e-6)


@pytest.mark.parametrize(
    ("settings", "behind"),
    [
        (("fluid.velocity=[-2.0, 0.0]", "motion.pitch.mean_deg=5.0"), True),
        (("fluid.velocity=[-2.0, 0.0]", "motion.pitch.mean_deg=-175.0"), False),
        (("fluid.velocity=[0.0, -2.0]", "motion.pitch.mean_deg=70.0"), True),
        (("fluid.velocity=[0.0, 2.0]", "motion.pitch.mean_deg=70.0"), False),
        (("fluid.velocity=[0.0, 2.0]", "motion.pitch.mean_deg=0.0"), False),  # broadside: either
        (("fluid.velocity=[-2.0, 0.0]", "solver=dbet"), False),  # blades have no edge to shed from
        ((), False),
    ],
)
def test_a_stream_that_meets_the_trailing_edge_first_is_warned_of(settings, behind):
    case = hawkmoth("wing.modes=0", "motion.pitch.amplitude_deg=0.0", "motion.plunge.amplitude=0.001", *settings)
    assert any("trailing edge first" in one for one in warnings(case)) == behind


def test_a_stroke_that_sweeps_through_a_slow_stream_is_not_warned_of():
    assert not any("trailing edge first" in one for one in warnings(hawkmoth("fluid.velocity=[-0.05, 0.0]")))


@pytest.mark.parametrize("solver", ["dbet", "uvlm"])
def test_a_stroke_with_the_trailing_edge_ahead_is_warned_of(solver):
    """A wrong sign of the measured or prescribed pitch, which the forces do not show."""
    (sign,) = warnings(hawkmoth(f"solver={solver}", "motion.pitch.phase_deg=180.0"))
    assert "the trailing edge leads during 100 % of the beat; check the sign and the phase of motion.pitch" in sign
    assert not warnings(hawkmoth(f"solver={solver}"))
    moth = taichiflap.load_case(CASES / "measured_moth.toml")
    assert not warnings(moth)
    (sign,) = warnings(moth.override("motion.measured.stroke_positive=backward"))
    assert "stroke_positive" in sign


def test_numbers_that_no_model_reads_are_named():
    assert any("numbers" in one and "slope" in one for one in warnings(hawkmoth("numbers={slope=1.0}")))
    assert not any("numbers" in one for one in warnings(hawkmoth()))


KEPT = ("force_vertical_mean", "power_mean", "tip_peak_mean", "force_coefficient_peak", "energy_residual", "settled")


def filled(vary, tips, coefficients, residuals=(0.0,) * 12):
    case = hawkmoth("solver=dbet")
    planned = design(case, vary)
    sheet = maps.create(None, case, planned, {name: METRICS[name] for name in KEPT})
    rows = zip(np.arange(1.0, 13.0), np.ones(12), tips, coefficients, residuals, np.ones(12), strict=True)
    sheet.record(range(12), [Outcome(dict(zip(KEPT, map(float, row), strict=True))) for row in rows])
    return sheet


GRID = {"wing.youngs_modulus": "5e9:60e9:4", "motion.pitch.amplitude_deg": "5:25:3", "wing.span": "0.05"}


def test_maps_show_in_grey_where_the_model_does_not_hold_and_hatch_where_it_errs():
    tips = 0.02 * np.array([8.0, 1.5, 0.9, 0.5, 0.35, 0.31, 0.2, 0.2, 0.2, 0.1, 0.1, 0.1])
    coefficients = [1.0] * 11 + [41.0]
    with filled(GRID, tips, coefficients, [0.0] * 11 + [0.2]) as sheet:
        broken = [0, 1, 11]
        assert list(np.flatnonzero(limits.broken(sheet))) == broken
        assert list(np.flatnonzero(limits.bent(sheet))) == [0, 1, 2, 3, 4, 5]
        lines = "\n".join(map_lines(sheet))
        assert "in 3 of 12 cases the model is invalid" in lines
        assert "in 4 of 12 cases the tip deflection exceeds 0.3 chords" in lines
        assert "in 1 of 12 cases more than 3 % of the work is unaccounted for" in lines
        for whole in (False, True):
            ax = pictures.heat_maps(sheet, ["power_mean"], whole).axes[0]
            meshes = [one for one in ax.collections if one.get_array() is not None and one.get_array().size == 12]
            values = np.ma.filled(np.ma.asarray(meshes[-1].get_array(), float), np.nan).ravel()
            assert list(np.flatnonzero(np.isnan(values))) == ([] if whole else broken)
            (hatched,) = (one for one in ax.collections if getattr(one, "hatches", None))
            corners = meshes[-1].get_coordinates()
            for number in range(12):
                row, column = divmod(number, corners.shape[1] - 1)
                low, high = corners[row, column], corners[row + 1, column + 1]
                # Right up to the edges of the cell.
                within = [any(path.contains_point(low + share * (high - low)) for path in hatched.get_paths())
                          for share in (0.01, 0.5, 0.99)]  # fmt: skip
                assert within == [number < 6] * 3


def test_a_map_over_the_chord_goes_by_each_cases_own():
    vary = {"wing.chord": "0.01:0.12:12", "wing.span": "0.05"}
    with filled(vary, np.full(12, 0.025), np.ones(12)) as sheet:
        assert list(np.flatnonzero(limits.broken(sheet))) == [0, 1]  # 0.01 and 0.02 m
        np.testing.assert_allclose(limits.bend(sheet), 0.025 / np.linspace(0.01, 0.12, 12))


@pytest.mark.slow
def test_twice_the_steps_are_advised_where_they_help():
    """Compared with a whole run at twice the steps: for too long a step, and for a wing that always diverges."""
    rigid = hawkmoth("solver=dbet", "wing.modes=0", "time.periods=1")
    assert finer_helps(rigid, 5) is True
    soft = hawkmoth(
        "solver=dbet", "wing.modes=1", "wing.youngs_modulus=1e7", "motion.pitch.amplitude_deg=50.0", "time.periods=4",
        "time.steps_per_period=60",
    )  # fmt: skip
    with taichiflap.simulate(soft) as result:
        assert result.status == "failed"
        assert (
            "A trial with twice the steps diverged as well. May help: a larger wing.youngs_modulus"
            in (result.attributes["reason"])
        )


def test_a_result_holds_its_residual_and_what_its_coefficients_are_made_with(tmp_path):
    """As `summarise` says; NaN in a run that failed."""
    case = hawkmoth("time.periods=3", "uvlm.panels=8", "uvlm.core=0.02")
    with taichiflap.simulate(case, tmp_path / "whole.h5") as result:
        summary = taichiflap.summarise(result)
        for name in ("energy_residual", "reference_speed", "reference_area"):
            assert result.attributes[name] == getattr(summary, name)
    assert summary.reference_area == pytest.approx(0.02 * 0.05)
