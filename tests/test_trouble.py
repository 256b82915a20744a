"""Problems with the disk, the folder or the case give one sentence; no data are lost, and no private data stored."""

import contextlib
import os
import resource
import shutil
import socket
import tempfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from conftest import hawkmoth

import taichiflap
from taichiflap.commands.summary import summary_lines
from taichiflap.errors import UserError
from taichiflap.export.formats import FORMATS, export
from taichiflap.plots.result import plot
from taichiflap.results import checkpoint
from taichiflap.results.writer import WriteError
from taichiflap.run import blocks, warnings

SHORT = ("time.periods=2", "uvlm.panels=8", "uvlm.wake=50", "wing.modes=2")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "whole.h5"
    taichiflap.simulate(hawkmoth(*SHORT), path).close()
    return path


@contextlib.contextmanager
def no_room(size=1024):
    """No file may grow beyond `size`, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextlib.contextmanager
def forbidden_folder():
    """A folder that can be read but not written, even by root."""
    folder = Path(tempfile.mkdtemp(dir="/tmp"))
    folder.chmod(0o555)
    root = os.geteuid() == 0
    try:
        if root:
            os.seteuid(65534)
        yield folder
    finally:
        if root:
            os.seteuid(0)
        folder.chmod(0o755)
        folder.rmdir()


def test_a_disk_without_room_is_one_sentence_and_no_file(tmp_path):
    path = tmp_path / "run.h5"
    with no_room(), pytest.raises(UserError, match=r"run\.h5: cannot be created: File too large") as caught:
        taichiflap.simulate(hawkmoth(*SHORT), path)
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_a_disk_that_fills_up_costs_no_frame_that_was_written(tmp_path, whole, monkeypatch):
    path = tmp_path / "run.h5"
    monkeypatch.setattr(blocks, "BLOCK_STEPS", 100)
    with (
        pytest.raises(WriteError, match=r"run\.h5: cannot be written: File too large"),
        contextlib.ExitStack() as stack,
    ):
        taichiflap.simulate(hawkmoth(*SHORT), path, progress=lambda done, total: stack.enter_context(no_room()))
    with taichiflap.open_result(path) as result, taichiflap.open_result(whole) as other:
        assert (result.status, result.frames) == ("running", 100)
        np.testing.assert_array_equal(result.force_y, other.force_y[:100])
    taichiflap.simulate(hawkmoth(*SHORT), path, resume=True).close()
    with taichiflap.open_result(path) as result, taichiflap.open_result(whole) as other:
        np.testing.assert_array_equal(result.force_y, other.force_y)


@pytest.mark.parametrize("kind", ["csv", "html", "gif"])
def test_an_export_that_finds_no_room_leaves_nothing(tmp_path, whole, kind):
    with taichiflap.open_result(whole) as result, no_room(), pytest.raises(UserError, match=r"cannot be written"):
        export(result, kind, tmp_path / f"export.{kind}")
    assert not list(tmp_path.iterdir())


def test_a_folder_that_may_not_be_written_is_one_sentence(whole):
    with taichiflap.open_result(whole) as result, forbidden_folder() as folder:
        with pytest.raises(UserError, match=r"run\.h5: cannot be created: Permission denied"):
            taichiflap.simulate(hawkmoth(*SHORT), folder / "run.h5")
        with pytest.raises(UserError, match=r"run\.csv: cannot be written: Permission denied"):
            export(result, "csv", folder / "run.csv")


@pytest.mark.parametrize("seconds", [0.0, 1e9])
def test_a_folder_that_vanishes_is_one_sentence(tmp_path, monkeypatch, seconds):
    monkeypatch.setattr(checkpoint, "SECONDS", seconds)
    monkeypatch.setattr(blocks, "BLOCK_STEPS", 100)
    folder = tmp_path / "folder"
    folder.mkdir()
    with pytest.raises(WriteError, match=r"run\.h5: .*cannot be written: No such file"):
        taichiflap.simulate(
            hawkmoth(*SHORT), folder / "run.h5", progress=lambda done, total: shutil.rmtree(folder, ignore_errors=True)
        )


STILL = ("motion.plunge.amplitude=0.0", "motion.pitch.amplitude_deg=0.0")


@pytest.mark.parametrize("solver", ["uvlm", "dbet"])
@pytest.mark.parametrize(
    ("settings", "statuses"),
    [
        (("fluid.density=200.0",), {"complete", "failed"}),  # the fluid that moves with the wing: 100 times its mass
        (("motion.frequency=1000.0",), {"complete", "failed"}),
        (("uvlm.panels=1", "dbet.elements=1"), {"complete"}),
        (STILL, {"complete"}),
        (("wing.youngs_modulus=1e6", "motion.frequency=100.0"), {"complete", "failed"}),  # it folds
        (("wing.modes=10", "uvlm.panels=20"), {"complete", "failed"}),
        (("uvlm.wake=1",), {"complete"}),
    ],
)
def test_extreme_cases_end_well_or_say_why_not(solver, settings, statuses):
    short = ("time.periods=3", "time.steps_per_period=100", f"solver={solver}")
    result = taichiflap.simulate(hawkmoth("uvlm.panels=10", "uvlm.wake=60", *short, *settings))
    assert result.status in statuses
    assert ("reason" in result.attributes) == (result.status == "failed")
    for name in result.variables:
        assert np.isfinite(getattr(result, name)).all()
    text = "\n".join(summary_lines(result))
    if result.status == "failed":
        assert "twice the steps" in result.attributes["reason"]
    elif "wing.youngs_modulus=1e6" in settings:
        assert "below the flapping frequency" in result.attributes["warnings"]
    else:
        # What ran to its end is not nonsense: no mode is anywhere near where a beam ceases to be one, ...
        assert np.abs(result.tip_deflection).max() < 10.0 * result.case.wing.chord
        assert "nan" not in text
    if settings == STILL:
        assert not result.force_y.any()
        assert not result.power.any()


def told(data):
    """Text in a file that describes the machine that wrote it."""
    private = {str(Path.home()), socket.gethostname(), tempfile.gettempdir(), str(Path(__file__).parent)}
    return {text for text in private if len(text) > 3 and text.encode() in data}


@pytest.mark.slow
def test_no_file_tells_of_the_machine_that_made_it(tmp_path, whole, monkeypatch):
    case = hawkmoth(*SHORT)
    monkeypatch.setattr(checkpoint, "SECONDS", 0.0)

    def interrupt(done, total):
        raise KeyboardInterrupt

    with contextlib.suppress(KeyboardInterrupt):
        taichiflap.simulate(case, tmp_path / "run.h5", progress=interrupt)
    with taichiflap.open_result(whole) as result:
        kinds = [kind for kind in FORMATS if kind not in ("flow.vtkhdf", "nc")]  # of a vorticity that is stored
        for kind in kinds:
            export(result, kind, tmp_path / f"export.{kind}")
        plot([result], tmp_path / "figure")
    taichiflap.sweep(case.override("solver=dbet"), {"wing.modes": "0,1"}, tmp_path / "map.h5")
    written = [whole, *tmp_path.iterdir()]
    assert len(written) == 3 + len(kinds) + 4 + 1
    for file in written:
        assert not told(file.read_bytes()), file
    assert told(f"{tempfile.gettempdir()}/x".encode())


def test_what_came_of_a_case_is_looked_at_too(tmp_path, monkeypatch):
    """In the file and in the summary; the same when the run was interrupted, for the peak may lie before that."""
    monkeypatch.setattr(blocks, "BLOCK_STEPS", 100)
    monkeypatch.setattr(checkpoint, "SECONDS", 0.0)
    gentle = ("motion.plunge.amplitude=0.002", "motion.pitch.amplitude_deg=2.0", "fluid.velocity=[1.0, 0.0]")
    for name, settings, phrases in (
        ("gentle", gentle, []),
        (
            "bent",
            SHORT,
            ["peak tip deflection is 0.4", "angle of attack reaches 77 deg at high speed"],
        ),
        ("blades", (*SHORT, "solver=dbet"), ["peak tip deflection is 0.3"]),
    ):
        path = tmp_path / f"{name}.h5"
        case = hawkmoth(*SHORT, *settings)

        def interrupt(done, total):
            if done > 0.8 * total:
                raise KeyboardInterrupt

        with contextlib.suppress(KeyboardInterrupt):
            taichiflap.simulate(case, path, progress=interrupt)
        with taichiflap.simulate(case, path, resume=True) as result, taichiflap.simulate(case) as in_memory:
            said = result.attributes["warnings"]
            assert said == in_memory.attributes["warnings"]
            assert [line in "\n".join(summary_lines(result)) for line in said.splitlines()] == [True] * len(phrases)
            for line, phrase in zip(said.splitlines(), phrases, strict=True):
                assert line.startswith(phrase)
        with h5py.File(path) as plain:
            assert plain.attrs["warnings"].decode() == said


def test_a_file_as_large_as_a_disk_is_warned_of():
    long = hawkmoth("uvlm.wake=all", "time.periods=1000")
    (said,) = warnings.warnings(long)
    assert "the result file will take 400 GB; increase output.every" in said
    assert not warnings.warnings(long.override("output.every=100"))
