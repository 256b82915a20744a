"""`output.every` affects only the fields: statistics do not depend on it."""

import contextlib

import h5py
import numpy as np
import pytest
import xarray
from conftest import CASES, hawkmoth
from taichiflap_viewer.frames import Run

import taichiflap
from taichiflap.drawing import scene
from taichiflap.export import page, table, vtkhdf
from taichiflap.results import checkpoint
from taichiflap.results.reader import ResultError
from taichiflap.results.variables import VARIABLES
from taichiflap.run import blocks

SHORT = ("time.periods=3", "time.steps_per_period=100", "uvlm.panels=8", "uvlm.wake=60", "dbet.elements=12")


def short(solver, every, *settings):
    return hawkmoth(*SHORT, f"solver={solver}", f"output.every={every}", *settings)


@pytest.mark.parametrize("solver", ["uvlm", "dbet"])
def test_statistics_do_not_depend_on_what_is_stored(solver):
    whole = taichiflap.summarise(taichiflap.simulate(short(solver, 1)))
    for every in (3, 50, 200):
        assert taichiflap.summarise(taichiflap.simulate(short(solver, every))) == whole, every


def test_the_numbers_of_coarse_frames():
    """The hawkmoth's blades, eight beats of 200 steps: the numbers that go with every step stored."""
    for every in (50, 200):
        summary = taichiflap.summarise(
            taichiflap.simulate(
                hawkmoth("solver=dbet", "dbet.added_mass=true", "time.periods=8", f"output.every={every}")
            )
        )
        assert summary.tip_peak.mean == pytest.approx(7.613e-3, rel=1e-3)
        assert summary.power.mean == pytest.approx(42.44e-3, rel=1e-3)
        assert summary.force_vertical.mean == pytest.approx(3.082e-3, rel=1e-3)


@pytest.mark.parametrize("settings", [("output.every=3", "time.periods=1"), ("output.every=1000", "time.periods=1")])
def test_a_complete_run_has_statistics(settings):
    found = taichiflap.summarise(taichiflap.simulate(hawkmoth(*SHORT, *settings)))
    assert found.beats == 1
    assert found == taichiflap.summarise(taichiflap.simulate(hawkmoth(*SHORT, *settings, "output.every=1")))


def test_a_motion_that_does_not_repeat_has_statistics_too():
    ramp = taichiflap.load_case(CASES / "pitch_ramp.toml", ("uvlm.panels=6", "time.step=0.05"))
    assert ramp.steps % 7
    thinned = taichiflap.summarise(taichiflap.simulate(ramp.override("output.every=7")))
    assert thinned is not None
    assert thinned == taichiflap.summarise(taichiflap.simulate(ramp))


@pytest.mark.parametrize("solver", ["uvlm", "dbet"])
def test_the_frames_are_those_of_the_whole_run_and_the_last_is_among_them(solver):
    whole, thinned = taichiflap.simulate(short(solver, 1)), taichiflap.simulate(short(solver, 7))
    steps = [*range(0, 300, 7), 300]
    assert thinned.frames == len(steps) == len(thinned.field_time)
    assert (thinned.steps, whole.frames, whole.steps) == (301, 301, 301)
    np.testing.assert_array_equal(thinned.field_time, whole.field_time[steps])
    for name in whole.variables:
        expected = getattr(whole, name)
        if VARIABLES.get(name, VARIABLES["plunge"]).field:
            expected = expected[steps]
        np.testing.assert_array_equal(getattr(thinned, name), expected, err_msg=name)
        np.testing.assert_array_equal(thinned.frame(name, -2), whole.frame(name, 294), err_msg=name)
    for frame, step in enumerate(steps):
        for name, values in whole.wake(step).items():
            np.testing.assert_array_equal(thinned.wake(frame)[name], values)


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_xarray_opens_both_axes(tmp_path, engine):
    path = tmp_path / "run.h5"
    with taichiflap.simulate(short("uvlm", 7), path) as result:
        ours = result.to_xarray()
        described = {name: result.describe(name) for name in ours.data_vars}
    with xarray.open_dataset(path, engine=engine) as theirs:
        sizes = {"time": 301, "field_time": 44, "mode": 1, "node": 9, "panel": 8, "component": 2}
        assert dict(theirs.sizes) == sizes
        for name, values in theirs.data_vars.items():
            assert values.dims == ours[name].dims == described[name].dimensions, name
        assert theirs.force_z.dims == ("time",)
        assert theirs.pressure_jump.dims == ("field_time", "panel")
        assert theirs.field_time.values[-1] == theirs.time.values[-1] == pytest.approx(0.12)
    with xarray.open_dataset(path, engine=engine, group="wake") as wake:
        assert wake["count"].dims == ("field_time",)
        assert int(wake["count"].sum()) == wake.sizes["vortex"]


def test_a_resumed_run_has_the_same_statistics(tmp_path, monkeypatch):
    case = short("uvlm", 7)
    whole = taichiflap.simulate(case)
    monkeypatch.setattr(blocks, "BLOCK_STEPS", 45)
    monkeypatch.setattr(checkpoint, "SECONDS", 0.0)
    stops = []

    def interrupt(done, total):
        stops.append(done)
        if len(stops) % 2 and done < total:
            raise KeyboardInterrupt

    path = tmp_path / "run.h5"
    for _ in range(9):
        if not path.exists():
            with contextlib.suppress(KeyboardInterrupt):
                taichiflap.simulate(case, path, progress=interrupt, resume=True).close()
    assert stops == sorted(set(stops)), "a part began at the start instead of where the one before had stopped"
    with taichiflap.open_result(path) as result:
        assert taichiflap.summarise(result) == taichiflap.summarise(whole)
        for name in whole.variables:
            np.testing.assert_array_equal(getattr(result, name), getattr(whole, name), err_msg=name)


def test_a_sweep_has_the_same_statistics(tmp_path):
    """A sweep marches without fields, and keeps its series at every step."""
    vary = {"wing.youngs_modulus": [5e9, 8e9]}
    for every in (1, 50):
        found = taichiflap.sweep(short("dbet", every), vary, tmp_path / f"{every}.h5")
        alone = taichiflap.summarise(taichiflap.simulate(short("dbet", 1, "wing.youngs_modulus=8e9")))
        assert float(found.force_vertical_mean[1]) == alone.force_vertical.mean
        assert float(found.tip_peak_mean[1]) == alone.tip_peak.mean


def test_figures_films_and_tables_of_thinned_fields(tmp_path):
    with taichiflap.simulate(short("uvlm", 7), tmp_path / "run.h5") as result:
        assert scene.last_steps(result) == slice(200, 301)
        assert scene.last_beats(result).tolist() == list(range(29, 44))
        frame = scene.frame(result, 43)
        assert (frame.beats, frame.force[0]) == (pytest.approx(3.0), result.force_z[-1])
        table.write_csv(result, tmp_path / "run.csv")
        rows = (tmp_path / "run.csv").read_text().splitlines()
        assert len(rows) == 302
        assert "field_time" not in rows[0]
        vtkhdf.write_vtkhdf(result, tmp_path / "run.vtkhdf")
        assert page.write_html(result, tmp_path / "run.html", 1) == 14


def test_the_viewer_tells_the_time_of_the_last_frame(tmp_path):
    taichiflap.simulate(short("uvlm", 70), tmp_path / "run.h5").close()
    run = Run(taichiflap.open_result(tmp_path / "run.h5"), "run")
    assert [run.turns(index) for index in range(run.frames)] == [0.0, 0.7, 1.4, 2.1, 2.8, 3.0]
    assert (run.beats, run.beat_of(5), run.index_at(3.0), run.index_at(2.85), run.index_at(2.2)) == (
        3,
        (3, 1.0),
        5,
        4,
        3,
    )
    times, values = run.series("force_z", 200, 300, 1000)
    np.testing.assert_array_equal(values, run.result.force_z[200:])
    assert times[-1] == 3.0
    run.close()


def test_files_of_the_first_format_open_where_no_step_is_missing(tmp_path):
    for every in (1, 7):
        taichiflap.simulate(short("dbet", every), tmp_path / f"{every}.h5").close()
        with h5py.File(tmp_path / f"{every}.h5", "r+") as file:
            file.attrs.modify("taichiflap_format", 1)
    with taichiflap.open_result(tmp_path / "1.h5") as result:
        assert result.steps == 301
    with pytest.raises(ResultError, match=r"7\.h5: written by an older taichiflap with output.every = 7"):
        taichiflap.open_result(tmp_path / "7.h5")
