"""Designs and sweeps: their points, the same bits as single runs, and survival of crashes."""

import os
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest
import xarray
from conftest import CASES, done, hawkmoth

import taichiflap
from taichiflap.case.case import parse_case
from taichiflap.commands import progress
from taichiflap.errors import UserError
from taichiflap.kernels.arrays import Spare
from taichiflap.maps import file as maps
from taichiflap.maps import layout, outcome
from taichiflap.maps.design import design, read_vary
from taichiflap.metrics import names as quantities
from taichiflap.metrics import summary as metrics
from taichiflap.results import hdf
from taichiflap.studies import batch
from taichiflap.studies.sweep import fill, prepare

pytestmark = pytest.mark.slow

SHORT = ("time.periods=2", "time.steps_per_period=40", "uvlm.panels=8", "dbet.elements=8")
SPINNING = ("motion.pitch.amplitude_deg=360.0", "motion.frequency=100.0", "fluid.density=0.0", "time.periods=60")


@pytest.fixture(scope="module")
def case():
    return hawkmoth(*SHORT)


def same_bits(first, second):
    np.testing.assert_array_equal(np.float64(first).view(np.int64), np.float64(second).view(np.int64))


def test_a_range_is_even_or_even_in_its_logarithm(case):
    made = design(case, read_vary(["wing.youngs_modulus=5e9:60e9:4:log", "motion.pitch.amplitude_deg=5:45:41"]))
    modulus, pitch = (np.array(axis.values) for axis in made.axes)
    np.testing.assert_allclose(modulus[1:] / modulus[:-1], 12 ** (1 / 3))
    assert (modulus[0], modulus[-1]) == (5e9, 60e9)
    np.testing.assert_allclose(pitch, np.arange(5.0, 46.0))
    assert (made.shape, made.size) == ((4, 41), 164)
    assert made.point(42) == {"wing.youngs_modulus": modulus[1], "motion.pitch.amplitude_deg": pitch[1]}
    assert made.case(case, 42).motion.pitch.amplitude_deg == 6.0


@pytest.mark.parametrize(
    ("spec", "values"),
    [
        ("solver=dbet,uvlm", ["dbet", "uvlm"]),
        ('uvlm.wake=10,"all"', ["10", "all"]),
        ("fluid.velocity=[0.0, 0.0],[1.0, 0.5]", ["[0.0, 0.0]", "[1.0, 0.5]"]),
        ("uvlm.suction=true,false", ["true", "false"]),
        ("uvlm.panels=10:160:5:log", [10, 20, 40, 80, 160]),
        ("wing.chord=1,2", [1.0, 2.0]),
    ],
)
def test_any_key_varies_in_its_own_type(case, spec, values):
    made = design(case, read_vary([spec]))
    assert list(made.axes[0].values) == values
    assert [type(value) for value in made.axes[0].values] == [type(value) for value in values]
    key = spec.partition("=")[0]
    taken = [eval(f"one.{key}", {"one": made.case(case, i)}) for i in range(made.size)]
    assert [str(value).strip('"').lower().replace("(", "[").replace(")", "]") for value in taken] == list(
        map(str, values)
    )


@pytest.mark.parametrize("sample", ["sobol:64", "lhs:50"])
def test_a_sample_fills_its_ranges_evenly(case, sample):
    vary = {"wing.youngs_modulus": "1e9:1e11:log", "wing.modes": "0:3", "solver": "dbet,uvlm"}
    made = design(case, vary, sample, seed=7)
    assert made == design(case, vary, sample, seed=7) != design(case, vary, sample, seed=8)
    count = int(sample.partition(":")[2])
    assert made.shape == (count,)
    modulus = np.log10([made.point(i)["wing.youngs_modulus"] for i in range(count)])
    # One point in each of N equal slices: what defines a Latin hypercube, and Sobol's first N = 2^m points too.
    assert sorted(np.floor((modulus - 9.0) / 2.0 * count).astype(int)) == list(range(count))
    assert {made.point(i)["wing.modes"] for i in range(count)} == {0, 1, 2, 3}
    assert [made.point(i)["solver"] for i in range(count)].count("uvlm") == count // 2


MISTAKES = [
    (["wing.chrod=1:2:3"], {}, "wing.chrod: unknown key; did you mean wing.chord?"),
    (["wing.chord=-1:2:3"], {}, "wing.chord = -1.0: must be a number > 0"),
    (["wing.chord=1:1:3"], {}, "the range is empty"),
    (["wing.chord=1:2:0"], {}, "0 values; give at least 2"),
    (["wing.chord=1:2"], {}, "the number of values is missing; write a:b:n, or add --sample"),
    (["wing.chord=1:2:3:4"], {}, "write a:b:n"),
    (["wing.chord=a:b:3"], {}, "with plain numbers"),
    (["wing.chord=1:inf:3"], {}, "finite"),
    (["wing.chord=0:1:3:log"], {}, "both ends of a log range must be above zero"),
    (["wing.chord=1,1"], {}, "a value is repeated"),
    (["wing.modes=0:2:9"], {}, "fewer whole numbers than values"),
    (["wing.chord"], {}, "write KEY=a:b:n"),
    (["wing.chord=1,2", "wing.chord=3,4"], {}, "is given twice"),
    (["wing.chord=1:2:1000000000000"], {}, "the limit is 10,000,000 cases"),
    (["wing.chord=1:2:10000", "wing.span=1:2:10000"], {}, "100,000,000 cases; the limit is"),
    (["wing.chord=1:2"], {"sample": "sobol:100"}, "power of two; use 64 or 128"),
    (["wing.chord=1:2"], {"sample": "halton:8"}, "write sobol:N or lhs:N"),
    (["wing.chord=1:2:3"], {"sample": "lhs:8"}, "give only the range"),
    (["solver=dbet,navier"], {}, 'solver = "navier": must be "uvlm" or "dbet"'),
    ([], {}, "no key varies"),
]


@pytest.mark.parametrize(("vary", "more", "sentence"), MISTAKES, ids=[m[2] for m in MISTAKES])
def test_a_design_that_cannot_be_is_refused_in_a_sentence(case, vary, more, sentence):
    with pytest.raises(UserError) as refused:
        design(case, read_vary(vary), **more)
    assert sentence in str(refused.value)
    assert "\n" not in str(refused.value)


def test_metrics_are_those_of_the_result_of_a_single_run(case):
    sheet = taichiflap.sweep(case, {"solver": ["dbet", "uvlm"], "wing.youngs_modulus": "2e10:4e10:2"}, keep="series")
    for solver in ("dbet", "uvlm"):
        with taichiflap.simulate(case.override(f"solver={solver}", "wing.youngs_modulus=4e10")) as result:
            summary = taichiflap.summarise(result)
            here = sheet.sel({"solver": solver, "wing.youngs_modulus": 4e10})
            same_bits(here.force_vertical_mean, summary.force_vertical.mean)
            same_bits(here.tip_peak_spread, summary.tip_peak.spread)
            same_bits(here.force_normal_phase, summary.force_normal_phase)
            same_bits(here.lift_per_power, summary.force_vertical.mean / summary.power.mean)
            kept = [name for name in quantities.SERIES if name in result.variables and name in sheet]
            assert {"force_y", "force_z", "moment", "power", "tip_deflection", "energy"} <= set(kept)
            for name in kept:
                same_bits(here[name], getattr(result, name))
            same_bits(here.time, result.time)


def test_harmonics_are_those_of_a_known_series(case):
    time = np.arange(1, 2001) / (25.0 * 500)
    turn = 2 * np.pi * 25.0 * time
    known = 3.0 + 2.0 * np.cos(turn + 0.5) + 0.25 * np.cos(3 * turn - 1.0)
    series = {name: np.zeros_like(time) for name in quantities.SERIES} | {"force_normal": known}
    run = SimpleNamespace(case=case, variables=list(series), time=time, **series)
    (found,) = quantities.measure([metrics.Alone(run)], quantities.choose([]))
    for name, value in {
        "force_normal_mean": 3.0,
        "force_normal_harmonic_1": 2.0,
        "force_normal_harmonic_1_phase": np.degrees(0.5),
        "force_normal_harmonic_2": 0.0,
        "force_normal_harmonic_3": 0.25,
        "force_normal_harmonic_3_phase": np.degrees(-1.0),
    }.items():
        assert found[name] == pytest.approx(value, abs=1e-12), name


def test_a_motion_that_does_not_repeat_has_means_and_no_harmonics():
    case = parse_case(
        {
            "solver": "dbet",
            "wing": hawkmoth().to_dict()["wing"],
            "motion": {"plunge": {"kind": "table", "points": [[0.0, 0.0], [0.02, 0.01], [0.03, 0.02], [0.05, 0.02]]}},
            "time": {"duration": 0.05, "step": 1e-3},
        }
    )
    sheet = taichiflap.sweep(case, {"time.step": "1e-3,5e-4"})
    assert (sheet.status == outcome.COMPLETE).all()
    with taichiflap.simulate(case) as result:
        same_bits(sheet.force_vertical_mean[0], taichiflap.summarise(result).force_vertical.mean)
    assert "force_normal_harmonic_1" not in sheet


def test_names_of_metrics_in_any_order_of_words():
    assert quantities.resolve("vertical_force_mean") == "force_vertical_mean"
    assert quantities.choose(["mean_power", "power_mean"]) == ["power_mean"]
    with pytest.raises(quantities.MetricError, match=r"did you mean force_vertical_mean\?"):
        quantities.resolve("vertical_forc_mean")


def test_a_case_gives_the_same_bits_in_batches_of_any_size_and_order(case, monkeypatch):
    vary = {"wing.modes": "0,1,3", "uvlm.wake": '10,"all"', "solver": "uvlm,dbet", "time.steps_per_period": "40,60"}
    together = taichiflap.sweep(case, vary)
    monkeypatch.setattr(batch, "BATCH_BYTES", 1)
    monkeypatch.setattr(batch, "LAUNCH_WORK", 1e4)
    alone = taichiflap.sweep(case, vary, threads=1)
    assert together.force_vertical_mean.notnull().all()
    for name in together.data_vars:
        if name != "reason":
            np.testing.assert_array_equal(together[name], alone[name], err_msg=name)


def test_batches_are_of_one_solver_and_bounded_in_memory(case, monkeypatch):
    monkeypatch.setattr(batch, "BATCH_BYTES", 2**20)
    monkeypatch.setattr(batch, "WINDOW", 128)
    planned = design(case, {"solver": "dbet,uvlm", "wing.youngs_modulus": "1e10:2e10:250"})
    seen = []
    for one in batch.batches(case, planned, np.arange(planned.size)[::-1], threads=2):
        assert len({c.solver for c in one.cases}) == 1
        assert sum(map(batch.memory, one.cases)) <= batch.BATCH_BYTES
        seen += one.numbers
    assert sorted(seen) == list(range(500))


def test_progress_goes_by_work_and_not_by_the_number_of_cases(case, monkeypatch):
    monkeypatch.setattr(batch, "BATCH_BYTES", 1)  # a batch a case, the light ones first
    told = []
    vary = {"solver": "uvlm,dbet", "uvlm.panels": "8,64", "time.periods": "1,4"}
    taichiflap.sweep(case, vary, progress=lambda *now: told.append(now))
    done, total, share = np.array(told).T
    assert set(total) == {8}
    assert np.all(np.diff(done) >= 0)
    assert np.all(np.diff(share) >= 0)
    assert (done[0], share[0], done[-1]) == (0.0, 0.0, 8.0)
    assert share[-1] == pytest.approx(1.0)
    planned = design(case, vary)
    heaviest = max(batch.work(planned.case(case, n)) for n in range(8))
    assert share[done == 7].min() == pytest.approx(1.0 - heaviest / batch.whole_work(case, planned, np.arange(8)))
    assert share[done == 7].min() < 0.4


def test_the_work_of_many_cases_is_told_from_some_of_them(case, monkeypatch):
    planned = design(case, {"uvlm.panels": "8:40:9", "wing.youngs_modulus": "1e10:2e10:80"})
    exact = sum(batch.work(planned.case(case, n)) for n in range(planned.size))
    assert batch.whole_work(case, planned, np.arange(planned.size)) == pytest.approx(exact, rel=0.1)
    monkeypatch.setattr(batch, "LOOKED_AT", 10**6)
    assert batch.whole_work(case, planned, np.arange(planned.size)) == pytest.approx(exact)


def test_a_log_tells_the_time_left_by_the_work_that_is_left(monkeypatch, capsys):
    clock = iter([0.0, 0.0, 10.0, 60.0, 61.0, 120.0])
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock))
    with progress.log("map") as tell:
        for done, share in ((100, 0.0), (400, 0.01), (700, 0.1), (701, 0.101), (1000, 0.5)):
            tell(done, 1000, share)
    assert capsys.readouterr().err.splitlines() == [
        "map: 700 of 1,000 cases, 10 a second, 9 min left",
        "map: 1,000 of 1,000 cases, 7.5 a second, 2 min left",
    ]


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_a_map_opens_in_xarray_as_it_is(case, engine, tmp_path):
    vary = {"wing.youngs_modulus": "1e10:2e10:3", "solver": "dbet,uvlm"}
    returned = taichiflap.sweep(case, vary, tmp_path / "map.h5", keep="series")
    with xarray.open_dataset(tmp_path / "map.h5", engine=engine) as opened:
        assert opened.sizes == {"wing.youngs_modulus": 3, "solver": 2, "frame": 81}
        assert opened["wing.youngs_modulus"].attrs == {"units": "Pa", "long_name": "Young's modulus"}
        assert opened.force_vertical_mean.attrs["units"] == "N"
        xarray.testing.assert_equal(opened.drop_vars("reason").load(), returned.drop_vars("reason"))
    taichiflap.sweep(case, {"wing.youngs_modulus": "1e10:2e10"}, tmp_path / "some.h5", sample="lhs:3")
    with xarray.open_dataset(tmp_path / "some.h5", engine=engine) as opened:
        assert opened.power_mean.dims == ("sample",)
        assert opened["wing.youngs_modulus"].dims == ("sample",)
        assert "wing.youngs_modulus" in opened.coords


def test_a_case_that_fails_is_recorded_with_its_reason_and_the_rest_goes_on():
    case = hawkmoth("solver=dbet", "dbet.elements=8", *SPINNING, "output.every=1000")
    vary = {"wing.youngs_modulus": [1e13, 1.0], "time.periods": [2, 60], "time.steps_per_period": [200, 90_000]}
    sheet = taichiflap.sweep(case, vary)
    assert sheet.status.values[0, 0].tolist() == [outcome.COMPLETE] * 2
    assert sheet.status.values[:, 1, 1].tolist() == [outcome.FAILED] * 2
    assert "the limit is 5000000 steps" in sheet.reason.values[0, 1, 1]
    assert np.isfinite(sheet.power_mean.values[0, 0, 1])
    assert "diverged at step" in sheet.reason.values[1, 1, 0]
    assert np.isnan(sheet.power_mean.values[1, 1, 0])


def test_only_what_is_missing_runs_again(case, tmp_path, monkeypatch):
    vary = {"wing.youngs_modulus": "1e10:2e10:8"}
    whole = taichiflap.sweep(case, vary)
    monkeypatch.setattr(batch, "BATCH_BYTES", 1)
    ran = []
    real = batch.compute

    def counted(cases, *more, **options):
        if len(ran) == 3:
            raise KeyboardInterrupt
        ran.extend(cases)
        return real(cases, *more, **options)

    monkeypatch.setattr("taichiflap.studies.runner.compute", counted)
    with pytest.raises(KeyboardInterrupt):
        taichiflap.sweep(case, vary, tmp_path / "map.h5")
    with taichiflap.open_map(tmp_path / "map.h5") as sheet:
        assert len(sheet.pending) == 5
    again = []
    monkeypatch.setattr("taichiflap.studies.runner.compute", lambda c, *m, **o: again.extend(c) or real(c, *m, **o))
    resumed = taichiflap.sweep(case, vary, tmp_path / "map.h5")
    assert len(again) == 5
    assert not set(map(repr, again)) & set(map(repr, ran))
    xarray.testing.assert_equal(resumed, whole)


def test_a_sweep_that_is_killed_loses_no_finished_batch(tmp_path):
    """The process is killed at a random moment, and the same command completes the sweep."""
    settings = ["--set=time.periods=4", "--set=uvlm.panels=20", "--threads=1"]
    command = [sys.executable, "-c", KILLED.format(batch=5), "sweep", str(CASES / "hawkmoth.toml"), *settings]
    command += ["--vary", "wing.youngs_modulus=1e10:2e10:200", "-o", "map.h5"]
    with subprocess.Popen(command, cwd=tmp_path) as process:
        until = time.monotonic() + 120
        while not done(tmp_path / "map.h5") and time.monotonic() < until:
            time.sleep(0.02)
        process.kill()
    finished = done(tmp_path / "map.h5")
    assert 0 < finished < 200
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert f"{finished} of 200 cases are done already" in ran.stdout
    assert "200 complete, 0 failed" in ran.stdout


KILLED = """
import sys
from taichiflap.studies import batch
batch.BATCH_WORK, batch.SHARES = 0.0, {batch}
from taichiflap.cli import main
main()
"""


def test_a_map_of_another_study_is_kept(case, tmp_path):
    path = tmp_path / "map.h5"
    vary = {"wing.youngs_modulus": "1e10,2e10"}
    taichiflap.sweep(case, vary, path)
    for change, sentence in (
        ({"case": case.override("wing.modes=0")}, "another case file"),
        ({"vary": {"wing.youngs_modulus": "1e10,3e10"}}, "another --vary"),
        ({"metrics": ["power_mean"]}, "other metrics"),
        ({"keep": "series"}, "another --keep"),
    ):
        with pytest.raises(maps.MapError, match=sentence):
            taichiflap.sweep(**{"case": case, "vary": vary, "output": path, **change})
    other = taichiflap.sweep(case.override("wing.modes=0"), vary, path, overwrite=True)
    assert (other.tip_peak_mean == 0).all()


def test_files_that_are_no_maps_are_refused(case, tmp_path):
    (tmp_path / "text.h5").write_text("no")
    taichiflap.simulate(case, tmp_path / "result.h5").close()
    for name, sentence in (
        ("text.h5", "not a readable map"),
        ("result.h5", "is not a taichiflap map"),
        (".", "is a directory"),
    ):
        with pytest.raises(maps.MapError, match=sentence):
            taichiflap.sweep(case, {"wing.modes": "0,1"}, tmp_path / name)
    with pytest.raises(maps.MapError, match="no such file"):
        taichiflap.open_map(tmp_path / "absent.h5")
    with pytest.raises(maps.MapError, match="cannot be created"):
        taichiflap.sweep(case, {"wing.modes": "0,1"}, tmp_path / "no" / "map.h5")
    with pytest.raises(maps.MapError, match="only series"):
        taichiflap.sweep(case, {"wing.modes": "0,1"}, keep="frames")


def test_two_studies_do_not_write_one_map(case, tmp_path):
    planned = design(case, {"wing.modes": "0,1"})
    with prepare(case, planned, tmp_path / "map.h5") as sheet:
        script = f"import taichiflap; taichiflap.open_map({str(tmp_path / 'map.h5')!r}, write=True)"
        ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
        assert "another study is writing it" in ran.stderr
        command = ["sweep", str(CASES / "hawkmoth_dbet.toml"), "--vary=wing.modes=0,1", "-o", "map.h5", "--overwrite"]
        ran = subprocess.run(
            [sys.executable, "-m", "taichiflap", *command], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert ran.returncode == 2
        assert ran.stderr.startswith(f"error: map.h5: another study is writing it (process {os.getpid()} on ")
        fill(sheet)
        assert not len(sheet.pending)


def test_a_map_has_its_name_when_it_is_laid_out_and_not_before(case, tmp_path, monkeypatch):
    """A crash in between would leave an unreadable file."""
    planned = design(case, {"wing.modes": "0,1"})

    def crash(file, *_):
        assert not (tmp_path / "map.h5").exists()
        raise KeyboardInterrupt

    monkeypatch.setattr("taichiflap.maps.layout.lay_out", crash)
    with pytest.raises(KeyboardInterrupt):
        prepare(case, planned, tmp_path / "map.h5")
    assert not list(tmp_path.iterdir())
    with pytest.raises(maps.MapError, match=r"cannot be created: .*nowhere is not a folder"):
        prepare(case, planned, tmp_path / "nowhere" / "map.h5")


def test_values_of_a_large_map_are_on_the_disk_before_their_status(case, tmp_path, monkeypatch):
    """Otherwise a power failure could keep the status and lose the values."""
    monkeypatch.setattr(maps, "MOST_IMAGE", 0)
    written, write = [], layout.Column.write
    monkeypatch.setattr(
        layout.Column, "write", lambda column, *what: (written.append(column.name), write(column, *what))
    )
    monkeypatch.setattr(hdf.Guarded, "sync", lambda _: written.append("sync"))
    kept = {"power_mean": quantities.METRICS["power_mean"]}
    with maps.create(tmp_path / "map.h5", case, design(case, {"wing.modes": "0,1"}), kept) as sheet:
        for number in range(2):
            sheet.record([number], [outcome.Outcome({"power_mean": 1.0})])
    assert written == 2 * ["power_mean", "sync", "status"]


def attempt(planned, case, number, checked):
    """A case of a design with its document, or why it cannot be."""
    try:
        made = planned.case(case, number, checked)
    except UserError as error:
        return str(error)
    return made, made.to_dict()


def test_a_table_that_was_checked_before_makes_the_same_case(case):
    """Whatever keys vary, and where two values do not fit each other: cases that share a table's values share it."""
    vary = {
        "wing.pivot": "0.0,0.3", "wing.modes": "0,2", "motion.pitch.amplitude_deg": "10.0,20", "time.periods": "1,2"
    }  # fmt: skip
    for more in ({}, {"solver": "uvlm,dbet"}, {"motion.plunge.phase_deg": "0.0,90.0"}):
        planned, checked = design(case.override("wing.pivot=0.0", "wing.modes=0"), vary | more), {}
        for number in range(planned.size):
            answers = [attempt(planned, case, number, known) for known in (None, checked)]
            assert answers[0] == answers[1]
        assert bool(checked) == ("solver" not in more)


def test_memory_that_batches_leave_each_other_changes_no_number(case):
    """A batch of long cases leaves its numbers in the memory that the next, of the same size, takes."""
    spare, names = Spare(), quantities.choose((), [case])
    first, other = ([case.override(f"fluid.density={density}", *more)] for density, more in ((2.0, ()), (1.0, ())))
    alone = batch.compute(other, names)
    batch.compute(first, names, spare=spare)
    taken = {id(one) for one in spare._arrays.values()}
    again = batch.compute(other, names, spare=spare)
    assert taken == {id(one) for one in spare._arrays.values()}
    np.testing.assert_equal([vars(one) for one in again], [vars(one) for one in alone])
