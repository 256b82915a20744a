"""The result file: other people's readers, streaming, crashes, and refusals in one sentence."""

import subprocess
import sys

import h5py
import numpy as np
import pytest
import xarray
from conftest import CASES, hawkmoth

import taichiflap
from taichiflap import results, run
from taichiflap.variables import VARIABLES

SHORT = ("time.periods=2", "uvlm.panels=10", "uvlm.wake=50", "wing.modes=2")


@pytest.fixture(scope="module")
def uvlm_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("uvlm") / "hawkmoth.h5"
    taichiflap.simulate(hawkmoth(*SHORT), path).close()
    return path


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_xarray_opens_it_with_no_code_of_ours(uvlm_file, engine):
    with xarray.open_dataset(uvlm_file, engine=engine) as dataset:
        assert dict(dataset.sizes) == {"time": 401, "mode": 2, "node": 11, "panel": 10, "component": 2}
        assert dataset.time.values[-1] == pytest.approx(0.08)
        assert dataset.component.values.tolist() == ["Y", "Z"]
        for name, variable in dataset.data_vars.items():
            assert variable.dims == VARIABLES[name].dimensions
            assert variable.attrs["units"] == VARIABLES[name].units
            assert variable.attrs["long_name"]
        assert dataset.tip_deflection.sel(time=0.04, method="nearest") != 0.0
        assert dataset.attrs["status"] == "complete"
        assert dataset.attrs["Conventions"] == "CF-1.11"
    with xarray.open_dataset(uvlm_file, engine=engine, group="wake") as wake:
        assert int(wake["count"].sum()) == wake.sizes["vortex"] == len(wake.birth)
        assert wake["count"].attrs["sample_dimension"] == "vortex"
    with xarray.open_dataset(uvlm_file, engine=engine, group="modes") as modes:
        assert modes.frequency.values.tolist() == pytest.approx([79.96, 501.1], abs=0.02)


@pytest.mark.parametrize("settings", [("wing.modes=0",), ("solver=dbet",), ("solver=dbet", "wing.modes=0")])
def test_rigid_wings_and_blade_elements_open_too(tmp_path, settings):
    path = tmp_path / "run.h5"
    taichiflap.simulate(hawkmoth("time.periods=1", *settings), path).close()
    with xarray.open_dataset(path, engine="h5netcdf") as dataset:
        assert dataset.sizes["time"] == 201
        assert ("q" in dataset) == ("wing.modes=0" not in settings)


def test_every_variable_has_its_frames_and_its_meaning(uvlm_file):
    with taichiflap.open_result(uvlm_file) as result:
        assert len(result.file["wake/y"]) == result.file["wake/count"][...].sum()
        assert set(result.variables) == {"time", *VARIABLES} - {"shear"}
        for name in result.variables:
            assert len(getattr(result, name)) == result.frames == 401
            assert np.isfinite(getattr(result, name)).all()


def test_forces_agree_with_each_other(uvlm_file):
    with taichiflap.open_result(uvlm_file) as r:
        sine, cosine = np.sin(r.pitch), np.cos(r.pitch)
        np.testing.assert_allclose(r.force_y * cosine + r.force_z * sine, r.force_axial, atol=1e-15)
        np.testing.assert_allclose(r.force_z * cosine - r.force_y * sine, r.force_normal, atol=1e-15)
        np.testing.assert_array_equal(r.force_vertical, -r.force_y)
        np.testing.assert_array_equal(r.power, r.power_aerodynamic + r.power_inertial)
        tip = r.node_position[:, -1] - np.stack((0 * r.plunge, r.plunge), axis=1)
        along_normal = tip[:, 1] * cosine - tip[:, 0] * sine
        np.testing.assert_allclose(along_normal, r.tip_deflection, atol=1e-8)
        np.testing.assert_allclose(r.panel_circulation.sum(axis=1), r.circulation, rtol=1e-4, atol=1e-7)


def test_wake_of_a_frame(uvlm_file):
    with taichiflap.open_result(uvlm_file) as result:
        assert result.wake(0)["birth"].tolist() == [0]
        assert result.wake(-1)["birth"].tolist() == list(range(351, 401))
        np.testing.assert_array_equal(result.frame("node_position", 7), result.node_position[7])
        fields = result.wake(-1)
        assert all(len(values) == 50 for values in fields.values())


def test_in_memory_and_on_disk_are_the_same(uvlm_file):
    in_memory = taichiflap.simulate(hawkmoth(*SHORT))
    with taichiflap.open_result(uvlm_file) as on_disk:
        assert in_memory.case == on_disk.case
        for name in on_disk.variables:
            np.testing.assert_array_equal(getattr(in_memory, name), getattr(on_disk, name))


def test_no_bit_depends_on_where_the_blocks_end(monkeypatch):
    whole = taichiflap.simulate(hawkmoth(*SHORT))
    monkeypatch.setattr(run, "BLOCK_STEPS", 13)
    in_pieces = taichiflap.simulate(hawkmoth(*SHORT))
    for name in whole.variables:
        np.testing.assert_array_equal(getattr(whole, name), getattr(in_pieces, name), err_msg=name)
    for index in (0, 57, 400):
        for name, values in whole.wake(index).items():
            np.testing.assert_array_equal(values, in_pieces.wake(index)[name])


def test_a_batch_gives_a_result_each(tmp_path):
    cases = [hawkmoth("time.periods=1", f"fluid.density={rho}", "output.every=10") for rho in (1.0, 1.3)]
    paths = [tmp_path / "a.h5", tmp_path / "b.h5"]
    for case, path, result in zip(cases, paths, taichiflap.simulate(cases, paths), strict=True):
        assert result.case == case
        assert result.path == path
        assert result.frames == 21
        np.testing.assert_array_equal(result.force_y, taichiflap.simulate(case).force_y)


def test_cases_of_two_solvers_do_not_mix():
    with pytest.raises(ValueError, match="one solver"):
        taichiflap.simulate([hawkmoth(), hawkmoth("solver=dbet")])


def test_to_xarray(uvlm_file):
    with taichiflap.open_result(uvlm_file) as result:
        dataset = result.to_xarray()
        np.testing.assert_array_equal(dataset.force_vertical, result.force_vertical)
        assert dataset.power.attrs["units"] == "W"
        assert dataset.node_position.sel(component="Z").dims == ("time", "node")


def test_an_unknown_variable_lists_the_known(uvlm_file):
    with taichiflap.open_result(uvlm_file) as result, pytest.raises(AttributeError, match="tip_deflection"):
        result.tip  # noqa: B018


KILLED = """
import os, signal, sys
sys.path.insert(0, {tests!r})
from conftest import hawkmoth
import taichiflap
def progress(done, total):
    if done >= 300:
        os.kill(os.getpid(), signal.SIGKILL)
taichiflap.simulate(hawkmoth("time.periods=15"), {path!r}, progress=progress)
"""


def test_a_killed_run_leaves_its_frames_readable(tmp_path):
    path = tmp_path / "run.h5"
    script = KILLED.format(tests=str(CASES.parent / "tests"), path=str(path))
    killed = subprocess.run([sys.executable, "-c", script], capture_output=True, check=False)
    assert killed.returncode == -9, killed.stderr
    assert not path.exists()
    with taichiflap.open_result(path) as result:
        assert result.status == "running"
        assert result.frames >= run.BLOCK_STEPS
        whole = taichiflap.simulate(hawkmoth("time.periods=15"))
        np.testing.assert_array_equal(result.force_y, whole.force_y[: result.frames])
        assert len(result.wake(-1)["y"]) == 200


def test_an_interrupted_run_is_closed_and_readable(tmp_path):
    path = tmp_path / "run.h5"

    def interrupt(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        taichiflap.simulate(hawkmoth(), path, progress=interrupt)
    with taichiflap.open_result(path) as result:
        assert result.frames == run.BLOCK_STEPS


def test_a_diverged_case_keeps_its_frames_and_says_why(tmp_path):
    spinning = ("wing.youngs_modulus=1.0", "motion.pitch.amplitude_deg=360.0", "motion.frequency=100.0")
    case = hawkmoth("solver=dbet", *spinning, "fluid.density=0.0", "time.periods=60")
    with taichiflap.simulate(case, tmp_path / "run.h5") as result:
        assert result.status == "failed"
        assert f"step {result.frames}" in result.attributes["reason"]
        assert np.isfinite(result.q).all()


def test_an_existing_result_is_not_overwritten(tmp_path):
    path = tmp_path / "run.h5"
    path.write_bytes(b"precious")
    with pytest.raises(taichiflap.ResultError, match="exists already; --overwrite"):
        taichiflap.simulate(hawkmoth("time.periods=1"), path)
    assert path.read_bytes() == b"precious"
    taichiflap.simulate(hawkmoth("time.periods=1"), path, overwrite=True).close()
    assert taichiflap.open_result(path).status == "complete"


def damaged_files(folder, good):
    whole = good.read_bytes()
    with h5py.File(folder / "foreign.h5", "w") as foreign:
        foreign["x"] = 1
    with h5py.File(folder / "newer.h5", "w") as newer:
        newer.attrs["taichiflap_format"] = results.FORMAT + 1
    (folder / "text.h5").write_text("hello")
    (folder / "empty.h5").write_bytes(b"")
    (folder / "cut.h5").write_bytes(whole[: len(whole) // 3])
    (folder / "folder.h5").mkdir()
    return {
        "foreign.h5": "not a result of taichiflap",
        "newer.h5": "written by a newer taichiflap",
        "text.h5": "not a readable result file",
        "empty.h5": "not a readable result file",
        "cut.h5": "not a readable result file",
        "folder.h5": "is a directory",
        "absent.h5": "no such file",
    }


def test_damaged_and_foreign_files_are_refused_in_a_sentence(tmp_path, uvlm_file):
    for name, phrase in damaged_files(tmp_path, uvlm_file).items():
        with pytest.raises(taichiflap.ResultError) as caught:
            taichiflap.open_result(tmp_path / name)
        message = str(caught.value)
        assert phrase in message, name
        assert message.startswith(str(tmp_path / name))
        assert "\n" not in message


@pytest.mark.parametrize("name", ["nowhere/run.h5", "."])
def test_a_place_that_cannot_be_written_is_refused(tmp_path, name):
    with pytest.raises(taichiflap.ResultError, match=r"cannot be created|is a directory"):
        taichiflap.simulate(hawkmoth("time.periods=1"), tmp_path / name)
