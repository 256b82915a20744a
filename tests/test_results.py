"""The result file: other readers, streaming, crashes, and errors in one sentence."""

import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import xarray
from conftest import CASES, hawkmoth

import taichiflap
from taichiflap.case.case import parse_case
from taichiflap.results import checkpoint, hdf, layout, packing, reader
from taichiflap.results.variables import VARIABLES
from taichiflap.run import blocks

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


def test_a_long_table_of_motion_stays_in_the_file(tmp_path):
    """HDF5's first layout has no room for attributes over 64 kB."""
    path = tmp_path / "run.h5"
    time = np.linspace(0.0, 0.01, 4001)
    points = np.stack([time, 1e-3 * np.sin(628.0 * time) ** 2], axis=1).tolist()
    document = hawkmoth("solver=dbet", "wing.modes=0").to_dict()
    document["motion"] = {"plunge": {"kind": "table", "points": points}}
    case = parse_case(document | {"time": {"duration": 0.01, "step": 2e-4}})
    taichiflap.simulate(case, path).close()
    with taichiflap.open_result(path) as result:
        assert result.case == case
        assert len(result.file.attrs["case"]) > 2**16


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
        edge = {name for name in VARIABLES if "edge" in name} | {"suction_velocity", "lift", "thrust"}
        edge |= {"drag_coefficient", "thrust_coefficient"}
        assert set(result.variables) == {"time", *VARIABLES} - {"shear", "wake_far_error", *edge}
        for name in result.variables:
            assert len(getattr(result, name)) == result.frames == 401
            assert np.isfinite(getattr(result, name)).all()


def test_frames_can_be_read_without_all_the_others(uvlm_file):
    with taichiflap.open_result(uvlm_file) as result:
        assert result.has_wake
        np.testing.assert_array_equal(result.frame("node_position", 7), result.node_position[7])
        np.testing.assert_array_equal(result.between("q", 3, 90, 29), result.q[[3, 32, 61, 90]])
        np.testing.assert_array_equal(result.between("time", 399, 500), result.time[399:])
        chord = np.linalg.norm(result.node_position[0, -1] - result.node_position[0, 0])
        assert np.ptp(result.stations) == pytest.approx(chord, rel=1e-6)


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


@pytest.mark.parametrize(
    "settings",
    [
        SHORT,
        (*SHORT, "output.every=7", "uvlm.suction_limit=0.1"),
        ("solver=dbet", "time.periods=1", "output.every=3"),
        ("time.periods=1", "wing.modes=0", "fluid.velocity=[1.0, 0.0]"),
    ],
)
def test_a_result_in_memory_is_its_file(tmp_path, settings):
    """All properties of a result in memory, saved from memory, and written by the run."""
    case = hawkmoth(*settings)
    in_memory = taichiflap.simulate(case)
    in_memory.save(tmp_path / "saved.h5")
    taichiflap.simulate(case, tmp_path / "written.h5").close()
    assert_same(tmp_path / "saved.h5", tmp_path / "written.h5")
    with taichiflap.open_result(tmp_path / "saved.h5") as saved:
        for one in (saved, in_memory):
            assert (one.steps, one.frames, one.has_wake, one.has_sheets) == (
                case.steps + 1, case.frames(), saved.has_wake, saved.has_sheets,
            )  # fmt: skip
        assert in_memory.variables == saved.variables
        assert in_memory.attributes == saved.attributes
        assert in_memory.case == saved.case
        assert taichiflap.summarise(in_memory) == taichiflap.summarise(saved)
        assert in_memory.modes.keys() == saved.modes.keys()
        np.testing.assert_array_equal(in_memory.stations, saved.stations)
        for name in saved.variables:
            assert in_memory.describe(name) == saved.describe(name)
            np.testing.assert_array_equal(getattr(in_memory, name), getattr(saved, name))
            np.testing.assert_array_equal(in_memory.frame(name, -2), saved.frame(name, -2))
            np.testing.assert_array_equal(in_memory.between(name, 1, 40, 3), saved.between(name, 1, 40, 3))
        for index in (0, -1):
            mine, theirs = in_memory.wake(index), saved.wake(index)
            assert mine.keys() == theirs.keys()
            for name in mine:
                np.testing.assert_array_equal(mine[name], theirs[name])
        assert in_memory.to_xarray().identical(saved.to_xarray())


@pytest.fixture
def packed(tmp_path, monkeypatch):
    """The file of a finished run whose fields count as large, and one whose do not."""
    case = hawkmoth("solver=dbet", "time.periods=1", "output.every=3")
    taichiflap.simulate(case, tmp_path / "plain.h5").close()
    monkeypatch.setattr(layout, "LARGE", 100)
    taichiflap.simulate(case, tmp_path / "packed.h5").close()
    return tmp_path / "packed.h5"


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_large_fields_of_a_finished_file_are_compressed_frame_by_frame(packed, engine):
    with h5py.File(packed) as file:
        assert file["pressure_jump"].chunks == (1, 50)
        assert file["pressure_jump"].compression == "gzip"
        assert file["force_y"].chunks is None
    plain = packed.with_name("plain.h5")
    assert_same(plain, packed)
    assert sorted(one.name for one in packed.parent.iterdir()) == ["packed.h5", "plain.h5"]
    with taichiflap.open_result(plain) as one, taichiflap.open_result(packed) as other:
        assert other.to_xarray().drop_attrs().identical(one.to_xarray().drop_attrs())
        assert other.attributes.keys() == one.attributes.keys()
        np.testing.assert_array_equal(other.frame("pressure_jump", -1), one.frame("pressure_jump", -1))
        other.save(packed.with_name("copy.h5"))
    assert_same(plain, packed.with_name("copy.h5"))
    with xarray.open_dataset(packed, engine=engine) as one, xarray.open_dataset(plain, engine=engine) as other:
        assert one.drop_attrs().identical(other.drop_attrs())


def test_without_space_for_the_compressed_file_the_plain_one_is_kept(packed, monkeypatch):
    class Full(hdf.Guarded):
        def write(self, data):
            if self.tell() > 20_000:
                self.error = self.error or OSError(28, "No space left on device")
            return super().write(data)

    with taichiflap.open_result(packed) as one:
        case = one.case
    monkeypatch.setattr(packing, "hdf", SimpleNamespace(Guarded=Full, create=hdf.create))
    taichiflap.simulate(case, packed, overwrite=True).close()
    assert_same(packed.with_name("plain.h5"), packed)
    with h5py.File(packed) as file:
        assert file["pressure_jump"].chunks is None
    assert sorted(one.name for one in packed.parent.iterdir()) == ["packed.h5", "plain.h5"]


def test_a_damaged_or_missing_compressed_frame_is_refused_in_a_sentence(packed):
    with h5py.File(packed) as file:
        place, size = file["pressure_jump"].id.get_chunk_info(3)[2:4]
    content = bytearray(packed.read_bytes())
    content[place + size // 2] ^= 0xFF
    packed.write_bytes(content)
    with taichiflap.open_result(packed) as result:
        assert np.isfinite(result.frame("pressure_jump", 2)).all()
        with pytest.raises(taichiflap.ResultError, match="damaged: pressure_jump"):
            result.frame("pressure_jump", 3)
    with h5py.File(packed, "r+") as file:
        shape, kind = file["pressure_jump"].shape, file["pressure_jump"].dtype
        del file["pressure_jump"]
        file.create_dataset("pressure_jump", shape, kind, chunks=(1, 50), compression="gzip")[0] = 1.0
    with pytest.raises(taichiflap.ResultError, match="damaged: pressure_jump is truncated"):
        taichiflap.open_result(packed)


def test_a_result_in_memory_makes_no_file_and_keeps_its_numbers(tmp_path, monkeypatch):
    monkeypatch.setattr(h5py, "File", None)
    monkeypatch.setattr(tempfile, "TemporaryFile", None)
    result = taichiflap.simulate(hawkmoth("solver=dbet", "time.periods=1"))
    forces = result.force_y
    forces *= 0.0
    result.frame("node_position", 3)[...] = 0.0
    assert result.force_y.any()
    assert result.frame("node_position", 3).any()
    assert "force_y" in dir(result)
    monkeypatch.undo()
    (tmp_path / "there.h5").write_bytes(b"precious")
    with pytest.raises(taichiflap.ResultError, match="exists already"):
        result.save(tmp_path / "there.h5")
    result.close()
    with pytest.raises(taichiflap.ResultError, match="has been closed"):
        result.save(tmp_path / "closed.h5")
    assert [file.name for file in tmp_path.iterdir()] == ["there.h5"]


def test_a_result_of_a_file_is_saved_as_a_copy(tmp_path, uvlm_file):
    with taichiflap.open_result(uvlm_file) as result:
        result.save(tmp_path / "copy.h5")
        with pytest.raises(taichiflap.ResultError, match="exists already"):
            result.save(tmp_path / "copy.h5")
    assert (tmp_path / "copy.h5").read_bytes() == uvlm_file.read_bytes()
    assert [file.name for file in tmp_path.iterdir()] == ["copy.h5"]


def test_a_failed_run_in_memory_keeps_its_frames_and_can_be_saved(tmp_path):
    spinning = ("wing.youngs_modulus=1.0", "motion.pitch.amplitude_deg=360.0", "motion.frequency=100.0")
    case = hawkmoth("solver=dbet", *spinning, "fluid.density=0.0", "time.periods=60")
    result = taichiflap.simulate(case)
    assert result.status == "failed"
    assert result.steps < case.steps
    result.save(tmp_path / "run.h5")
    with taichiflap.open_result(tmp_path / "run.h5") as saved:
        assert saved.attributes == result.attributes
        np.testing.assert_array_equal(saved.q, result.q)


def test_no_bit_depends_on_where_the_blocks_end(monkeypatch):
    whole = taichiflap.simulate(hawkmoth(*SHORT))
    monkeypatch.setattr(blocks, "BLOCK_STEPS", 13)
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
    with pytest.raises(ValueError, match="one output per case"):
        taichiflap.simulate([hawkmoth(), hawkmoth()], "ab")


def test_to_xarray(uvlm_file):
    with taichiflap.open_result(uvlm_file) as result:
        dataset = result.to_xarray()
        np.testing.assert_array_equal(dataset.force_vertical, result.force_vertical)
        assert dataset.power.attrs["units"] == "W"
        assert dataset.node_position.sel(component="Z").dims == ("time", "node")


def test_an_unknown_variable_lists_the_known(uvlm_file):
    with taichiflap.open_result(uvlm_file) as result, pytest.raises(AttributeError, match="tip_deflection"):
        result.tip  # noqa: B018


BLOCK = 256

KILLED = """
import os, signal, sys
sys.path.insert(0, {tests!r})
from conftest import hawkmoth
import taichiflap
from taichiflap import run
run.BLOCK_STEPS = {block}
def progress(done, total):
    if done >= 200:
        os.kill(os.getpid(), signal.SIGKILL)
taichiflap.simulate(hawkmoth("time.periods=15"), {path!r}, progress=progress)
"""


@pytest.mark.slow
def test_a_killed_run_leaves_its_frames_readable(tmp_path):
    path = tmp_path / "run.h5"
    script = KILLED.format(tests=str(CASES.parent / "tests"), path=str(path), block=BLOCK)
    killed = subprocess.run([sys.executable, "-c", script], capture_output=True, check=False)
    assert killed.returncode == -9, killed.stderr
    assert not path.exists()
    with taichiflap.open_result(path) as result:
        assert result.status == "running"
        assert result.frames == BLOCK
        whole = taichiflap.simulate(hawkmoth("time.periods=15"))
        np.testing.assert_array_equal(result.force_y, whole.force_y[: result.frames])
        assert len(result.wake(-1)["y"]) == 200


def test_an_interrupted_run_is_closed_and_readable(tmp_path, monkeypatch):
    path = tmp_path / "run.h5"
    monkeypatch.setattr(blocks, "BLOCK_STEPS", BLOCK)

    def interrupt(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        taichiflap.simulate(hawkmoth(), path, progress=interrupt)
    with taichiflap.open_result(path) as result:
        assert result.frames == BLOCK


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
    with pytest.raises(taichiflap.ResultError, match="exists already; use --overwrite"):
        taichiflap.simulate(hawkmoth("time.periods=1"), path)
    assert path.read_bytes() == b"precious"
    taichiflap.simulate(hawkmoth("time.periods=1"), path, overwrite=True).close()
    assert taichiflap.open_result(path).status == "complete"


def damaged_files(folder, good):
    whole = good.read_bytes()
    with h5py.File(folder / "foreign.h5", "w") as foreign:
        foreign["x"] = 1
    with h5py.File(folder / "newer.h5", "w") as newer:
        newer.attrs["taichiflap_format"] = reader.FORMAT + 1
    (folder / "text.h5").write_text("hello")
    (folder / "empty.h5").write_bytes(b"")
    (folder / "cut.h5").write_bytes(whole[: len(whole) // 3])
    (folder / "folder.h5").mkdir()
    return {
        "foreign.h5": "is not a taichiflap result",
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


def test_a_resume_of_what_cannot_be_read_names_the_file(tmp_path, uvlm_file):
    left = reader.part(tmp_path / "run.h5")
    left.write_bytes(uvlm_file.read_bytes())
    with h5py.File(left, "r+") as file:
        file.attrs["case"] = file.attrs["case"].decode()
    with pytest.raises(
        taichiflap.ResultError, match=r"run\.h5\.part: cannot be resumed: case is text of variable length"
    ):
        taichiflap.simulate(hawkmoth(*SHORT), tmp_path / "run.h5", resume=True)


@pytest.mark.parametrize("name", ["nowhere/run.h5", "."])
def test_a_place_that_cannot_be_written_is_refused(tmp_path, name):
    with pytest.raises(taichiflap.ResultError, match=r"cannot be created|is a directory"):
        taichiflap.simulate(hawkmoth("time.periods=1"), tmp_path / name)


def assert_same(first, second):
    """Every array of two result files, wakes and modes included, bit for bit; NaN equals NaN."""
    with h5py.File(first, "r", locking=False) as one, h5py.File(second, "r", locking=False) as other:
        names = []
        one.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        assert len(names) > 10
        for name in names:
            assert one[name].dtype == other[name].dtype
            assert one[name][...].tobytes() == other[name][...].tobytes() or name == "component", name


@pytest.mark.parametrize("settings", [(), ("solver=dbet",), ("uvlm.wake=all", "output.every=7"), ("wing.modes=0",)])
def test_a_resumed_run_is_the_uninterrupted_one_bit_for_bit(tmp_path, monkeypatch, settings):
    case = hawkmoth(*SHORT, *settings)
    taichiflap.simulate(case, tmp_path / "whole.h5").close()
    monkeypatch.setattr(blocks, "BLOCK_STEPS", 61)
    monkeypatch.setattr(checkpoint, "SECONDS", 0.0)
    resumed_from = []

    def interrupt(done, total):
        resumed_from.append(done)
        if len(resumed_from) % 3 == 0 and done < total:
            raise KeyboardInterrupt

    path = tmp_path / "run.h5"
    with pytest.raises(KeyboardInterrupt):
        taichiflap.simulate(case, path, progress=interrupt)
    while not path.exists():
        with contextlib.suppress(KeyboardInterrupt):
            taichiflap.simulate(case, path, progress=interrupt, resume=True).close()
    # Each part went on where the one before had stopped.
    assert resumed_from == sorted(set(resumed_from))
    assert_same(tmp_path / "whole.h5", path)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["run.h5", "whole.h5"]
    with taichiflap.simulate(case, path, resume=True) as again:
        assert again.status == "complete"


def test_steps_are_on_the_disk_before_a_checkpoint_counts_on_them(tmp_path, monkeypatch):
    """Otherwise a power failure could keep the checkpoint and lose the steps."""
    path, synced, kept = tmp_path / "run.h5", [], []
    draft, sync, save = reader.part(path), os.fsync, checkpoint.save

    def note_sync(handle):
        sync(handle)
        if draft.exists() and os.path.samestat(os.fstat(handle), draft.stat()):
            with taichiflap.open_result(draft) as result:
                synced.append(result.steps)

    def note_save(place, case, state):
        save(place, case, state)
        kept.append((min(state.next_step, case.steps + 1), synced[-1]))

    monkeypatch.setattr(blocks, "BLOCK_STEPS", 61)
    monkeypatch.setattr(checkpoint, "SECONDS", 0.0)
    monkeypatch.setattr(os, "fsync", note_sync)
    monkeypatch.setattr(checkpoint, "save", note_save)
    taichiflap.simulate(hawkmoth(*SHORT, "solver=dbet"), path).close()
    assert len(kept) > 2
    assert all(needed == stored for needed, stored in kept)


def interrupted(case, path):
    """The files of an interrupted run."""

    def interrupt(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        taichiflap.simulate(case, path, progress=interrupt)


@pytest.mark.slow
def test_a_batch_resumes_cases_that_stopped_at_different_steps(tmp_path, monkeypatch):
    cases = [
        hawkmoth(*SHORT, f"fluid.density={density}", f"uvlm.panels={8 + i}") for i, density in enumerate((1, 2, 3))
    ]
    for i, case in enumerate(cases):
        taichiflap.simulate(case, tmp_path / f"whole{i}.h5").close()
    monkeypatch.setattr(blocks, "BLOCK_STEPS", 70)
    monkeypatch.setattr(checkpoint, "SECONDS", 0.0)
    paths = [tmp_path / f"run{i}.h5" for i in range(3)]
    interrupted(cases[0], paths[0])
    taichiflap.simulate(cases[1], paths[1]).close()
    for result in taichiflap.simulate(cases, paths, resume=True):
        result.close()
    for i, path in enumerate(paths):
        assert_same(tmp_path / f"whole{i}.h5", path)


@pytest.mark.slow
def test_a_lost_or_damaged_checkpoint_costs_time_alone(tmp_path, monkeypatch):
    case = hawkmoth(*SHORT)
    taichiflap.simulate(case, tmp_path / "whole.h5").close()
    monkeypatch.setattr(blocks, "BLOCK_STEPS", 100)
    monkeypatch.setattr(checkpoint, "SECONDS", 0.0)
    spoilt = (None, b"", lambda data: data[:999], lambda data: b"not a zip", lambda data: data[:-5])
    for i, spoil in enumerate(spoilt):
        path = tmp_path / f"run{i}.h5"
        interrupted(case, path)
        state = checkpoint.beside(path)
        spoiled = spoil(state.read_bytes()) if callable(spoil) else spoil
        state.unlink()
        if spoiled is not None:
            state.write_bytes(spoiled)
        taichiflap.simulate(case, path, resume=True).close()
        assert_same(tmp_path / "whole.h5", path)


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """Interrupted runs of both models, and their completed results."""
    folder = tmp_path_factory.mktemp("stopped")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocks, "BLOCK_STEPS", 100)
        patch.setattr(checkpoint, "SECONDS", 0.0)
        for solver in ("uvlm", "dbet"):
            case = hawkmoth(*SHORT, f"solver={solver}")
            interrupted(case, folder / f"{solver}.h5")
            taichiflap.simulate(case, folder / f"{solver}-whole.h5").close()
    return folder


DOCTORED = [
    ("uvlm", "next_step", -5), ("uvlm", "next_step", 0), ("uvlm", "next_step", 2**40), ("uvlm", "next_step", 402),
    ("uvlm", "solve_time", np.nan), ("uvlm", "solve_time", np.ones(3)), ("uvlm", "state.body.failed", 300),
    ("uvlm", "state.body.modes", 99), ("uvlm", "state.body.plan:0", 10**9), ("uvlm", "state.body.plan:1", 0),
    ("uvlm", "state.flow.size", 10**6), ("uvlm", "state.body.q", np.nan), ("uvlm", "state.body.q", np.zeros(3)),
    ("uvlm", "state.body.q", np.array(["text"])), ("uvlm", "state.wake.vortex", np.inf),
    *(("uvlm", f"state.wake.ring:{column}", value) for column in (0, 1, 2, 3, 6) for value in (-1, 2**31 - 1)),
    ("uvlm", "state.wake.ring:4", -7), ("uvlm", "state.wake.ring:5", -1),
    ("uvlm", "state.wake.origin:0", 10**6), ("uvlm", "state.wake.origin:0", 2),  # of the step, and of the edge
    ("dbet", "state.flow.elements", 10**9), ("dbet", "state.flow.option", 7), ("dbet", "state.extra", 1.0),
]  # fmt: skip


@pytest.mark.parametrize(("solver", "name", "value"), DOCTORED)
def test_a_doctored_checkpoint_is_not_gone_on_from(tmp_path, stopped, caplog, solver, name, value):
    """In the same process: a segmentation fault would end the tests."""
    path = tmp_path / "run.h5"
    for suffix in (".part", ".state"):
        shutil.copy(stopped / f"{solver}.h5{suffix}", tmp_path / f"run.h5{suffix}")
    with np.load(checkpoint.beside(path)) as stored:
        arrays = dict(stored)
    name, _, column = name.partition(":")
    if isinstance(value, np.ndarray) or name not in arrays:
        arrays[name] = np.asarray(value)
    else:
        arrays[name] = arrays[name].copy()
        arrays[name][(..., int(column)) if column else ...] = value
    with open(checkpoint.beside(path), "wb") as file:
        np.savez(file, **arrays)
    taichiflap.simulate(hawkmoth(*SHORT, f"solver={solver}"), path, resume=True).close()
    assert_same(stopped / f"{solver}-whole.h5", path)
    (said,) = caplog.messages
    assert said.startswith(f"{path}.state cannot be used, so the run starts from the beginning: ")


def test_only_the_same_case_is_resumed(tmp_path):
    path = tmp_path / "run.h5"
    interrupted(hawkmoth(*SHORT), path)
    other = hawkmoth(*SHORT, "fluid.density=2.0")
    with pytest.raises(taichiflap.ResultError, match=r"another case: density = 1\.225 there, density = 2\.0 here"):
        taichiflap.simulate(other, path, resume=True)
    with pytest.raises(taichiflap.ResultError, match=r"use --resume to continue it, or --overwrite to start again"):
        taichiflap.simulate(other, path)
    taichiflap.simulate(other, path, overwrite=True).close()
    with pytest.raises(taichiflap.ResultError, match=r"another case"):
        taichiflap.simulate(hawkmoth(*SHORT), path, resume=True)
    with taichiflap.open_result(path) as result:
        assert result.case == other


@pytest.mark.slow
@pytest.mark.parametrize("option", [(), ("--resume",), ("--overwrite",)])
def test_of_two_runs_on_one_file_the_second_is_refused(tmp_path, option):
    path = tmp_path / "run.h5"
    command = [sys.executable, "-m", "taichiflap", "simulate", str(CASES / "hawkmoth.toml"), "-o", str(path), *option]
    said = []

    def intrude(done, total):
        ran = subprocess.run(command, capture_output=True, text=True, check=False)
        said.append((ran.returncode, ran.stderr))

    taichiflap.simulate(hawkmoth(*SHORT), path, progress=intrude).close()
    ((code, text),) = said
    assert code == 2
    assert text.startswith(f"error: {path}: another run is writing it (process {os.getpid()} on ")


def test_two_cases_do_not_share_a_file(tmp_path):
    with pytest.raises(taichiflap.ResultError, match=r"run\.h5: is named for two results"):
        taichiflap.simulate([hawkmoth(*SHORT)] * 2, [tmp_path / "run.h5"] * 2)


def test_the_numbers_of_a_file_that_is_written_are_nan_until_they_are_known(tmp_path, monkeypatch):
    path = tmp_path / "run.h5"
    monkeypatch.setattr(blocks, "BLOCK_STEPS", 100)
    interrupted(hawkmoth(*SHORT), path)
    with xarray.open_dataset(tmp_path / "run.h5.part", engine="h5netcdf") as dataset:
        assert dataset.sizes["time"] == 401
        for name, values in dataset.variables.items():
            if values.dims[0] == "time":
                known = np.isfinite(values.values.reshape(401, -1)).all(axis=1)
                assert known.tolist() == [True] * 100 + [False] * 301, name
    with (
        taichiflap.open_result(path) as result,
        xarray.open_dataset(path.with_name("run.h5.part"), group="wake") as wake,
    ):
        assert result.frames == 100
        assert not wake["count"][100:].any()


@pytest.mark.slow
def test_kills_at_random_moments_lose_nothing():
    """A few kills of `make crash-test`, in a separate process, since it forks."""
    command = [sys.executable, str(CASES.parent / "tests" / "crash.py"), "3", "20201122"]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.count("kills of") == 3
