"""Exports contain the data of the result, and open in other programs."""

import re
import shutil
import sys

import h5py
import numpy as np
import pytest
from conftest import CASES, hawkmoth
from PIL import Image
from test_cli import run

import taichiflap
from taichiflap import cli
from taichiflap.drawing import palette, scene
from taichiflap.errors import UserError
from taichiflap.export import film as animation
from taichiflap.export.formats import export
from taichiflap.results import hdf
from taichiflap.results.variables import VARIABLES


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a result of each model, and one of a run that was interrupted in three ways."""
    folder = tmp_path_factory.mktemp("exports")
    settings = ("time.periods=3", "time.steps_per_period=100", "uvlm.panels=20", "wing.modes=2")
    taichiflap.simulate(hawkmoth(*settings), folder / "lattice.h5").close()
    blades = taichiflap.load_case(CASES / "hawkmoth_dbet.toml", ("time.periods=2",))
    taichiflap.simulate(blades, folder / "blades.h5").close()
    for name, frames in (("empty", 0), ("begun", 60)):
        shutil.copy(folder / "lattice.h5", folder / f"{name}.h5")
        with h5py.File(folder / f"{name}.h5", "r+") as file:
            file["time"][frames:] = np.nan
    shutil.copy(folder / "lattice.h5", folder / "failed.h5")
    with h5py.File(folder / "failed.h5", "r+") as file:
        file["force_normal"][250:] = np.nan
    return folder


@pytest.fixture
def lattice(folder):
    """The result of UVLM."""
    with taichiflap.open_result(folder / "lattice.h5") as result:
        yield result


@pytest.fixture
def blades(folder):
    """The result of DBET."""
    with taichiflap.open_result(folder / "blades.h5") as result:
        yield result


def test_csv_reads_back_to_the_same_numbers(lattice, tmp_path):
    path = export(lattice, "csv", tmp_path)
    assert path == tmp_path / "lattice.csv"
    header, *rows = path.read_text().splitlines()
    names = header.split(",")
    columns = dict(zip(names, np.array([row.split(",") for row in rows], dtype=float).T, strict=True))
    np.testing.assert_array_equal(columns.pop("time (s)"), lattice.time)
    for name, variable in VARIABLES.items():
        if variable.field or name not in lattice.variables:
            continue
        values = getattr(lattice, name)
        if values.ndim == 1:
            np.testing.assert_array_equal(columns.pop(f"{name} ({variable.units})"), values)
        else:
            for k, column in enumerate(values.T, 1):
                np.testing.assert_array_equal(columns.pop(f"{name}_{k} ({variable.units})"), column)
    assert not columns


def test_vtkhdf_has_the_layout_and_the_values(lattice, tmp_path):
    path = export(lattice, "vtkhdf", tmp_path / "a.vtkhdf")
    with h5py.File(path) as file:
        root = file["VTKHDF"]
        assert (root.attrs["Type"], tuple(root.attrs["Version"])) == (b"PolyData", (2, 2))
        steps = root["Steps"]
        assert steps.attrs["NSteps"] == lattice.frames == 301
        np.testing.assert_array_equal(steps["Values"], lattice.time)
        assert np.all(steps["NumberOfParts"][...] == 1)
        for index in (0, 1, 99, 300):
            wake, nodes = lattice.wake(index), lattice.frame("node_position", index)
            count = len(wake["y"])
            first = steps["PointOffsets"][index]
            assert root["NumberOfPoints"][index] == count + 21
            points = root["Points"][first : first + count + 21]
            np.testing.assert_array_equal(points[:count], np.stack((wake["z"], -wake["y"], 0 * wake["y"]), axis=1))
            np.testing.assert_array_equal(points[count:, :2], np.stack((nodes[:, 1], -nodes[:, 0]), axis=1))
            np.testing.assert_array_equal(
                root["PointData/circulation"][first : first + count + 21], [*wake["circulation"], *np.zeros(21)]
            )
            begins = steps["CellDataOffsets/pressure_jump"][index]
            np.testing.assert_array_equal(
                root["CellData/pressure_jump"][begins + count : begins + count + 20],
                lattice.frame("pressure_jump", index),
            )
            ids = steps["ConnectivityIdOffsets"][index]
            np.testing.assert_array_equal(root["Vertices/Connectivity"][ids[0] : ids[0] + count], np.arange(count))
            lines = root["Lines/Connectivity"][ids[1] : ids[1] + 40].reshape(20, 2)
            np.testing.assert_array_equal(lines, count + np.stack((np.arange(20), np.arange(1, 21)), axis=1))


@pytest.mark.parametrize("name", ["lattice", "blades"])
def test_vtk_reads_what_was_written(name, request, tmp_path):
    vtk = pytest.importorskip("vtk", reason="VTK is not installed: pip install vtk")
    from vtk.util.numpy_support import vtk_to_numpy  # noqa: PLC0415

    result = request.getfixturevalue(name)
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(export(result, "vtkhdf", tmp_path / "a.vtkhdf")))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == result.frames
    for index in (0, 37, 200):
        reader.SetStep(index)
        reader.Update()
        shape = reader.GetOutput()
        wake, nodes = result.wake(index), result.frame("node_position", index)
        assert (shape.GetNumberOfVerts(), shape.GetNumberOfLines()) == (len(wake["y"]), len(nodes) - 1)
        points = vtk_to_numpy(shape.GetPoints().GetData())
        np.testing.assert_array_equal(points[:, 0], [*wake["z"], *nodes[:, 1]])
        circulation = vtk_to_numpy(shape.GetPointData().GetArray("circulation"))
        np.testing.assert_array_equal(circulation[: len(wake["y"])], wake["circulation"])


def test_a_gif_shows_a_beat_and_repeats(lattice, tmp_path):
    with Image.open(export(lattice, "gif", tmp_path / "a.gif")) as picture:
        assert (picture.n_frames, picture.info["loop"], picture.info["duration"]) == (50, 0, 50)
        frame = np.asarray(picture.convert("RGB")).astype(int)
    assert frame.min() < 60
    orange, blue = frame[..., 0] - frame[..., 2], frame[..., 2] - frame[..., 0]
    assert (orange.max() > 100, blue.max() > 100) == (True, True)


@pytest.mark.slow
def test_a_film_has_every_frame(blades, tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="imageio-ffmpeg is not installed: no film is made")
    path = export(blades, "mp4", tmp_path / "a.mp4", beats=1)
    assert ffmpeg.count_frames_and_secs(str(path)) == (100, pytest.approx(4.0, abs=0.05))
    assert [file.name for file in tmp_path.iterdir()] == ["a.mp4"]


def test_the_pace_of_a_slow_motion_is_that_of_a_fast_one_reversed():
    hover, ramp = (taichiflap.load_case(CASES / name) for name in ("hawkmoth.toml", "pitch_ramp.toml"))
    assert (hover.beat, ramp.beat) == (0.04, 5.0)
    assert scene.pace(hover, 4.0) == "100 times slower"
    assert scene.pace(hover, 0.1) == "2.5 times slower"
    assert scene.pace(ramp, 2.5) == "2 times faster"


def test_a_dark_film_has_the_dark_theme(lattice):
    light, dark = (animation.Film(lattice, 1, 1, 25, theme=theme) for theme in (palette.LIGHT, palette.DARK))
    for film, theme in ((light, palette.LIGHT), (dark, palette.DARK)):
        (picture,) = film.pictures()
        assert "#{:02x}{:02x}{:02x}".format(*picture[0, 0]) == theme.ground
        ink = np.array([int(theme.ink[k : k + 2], 16) for k in (1, 3, 5)])
        assert np.sum(np.all(picture == ink, axis=-1)) > 50


def test_a_running_file_exports_what_it_holds(lattice, tmp_path):
    """It has its final name, and only the existing frames."""
    running = tmp_path / "run.h5.part"
    shutil.copy(lattice.path, running)
    with h5py.File(running, "r+") as file:
        hdf.rewrite(file, "status", "running")
        file["time"][151:] = np.nan
    with taichiflap.open_result(tmp_path / "run.h5") as result:
        assert (result.status, result.frames) == ("running", 151)
        table = export(result, "csv", tmp_path)
        with Image.open(export(result, "gif", tmp_path, beats=1)) as picture:
            assert picture.n_frames == 50
    assert table == tmp_path / "run.csv"
    assert len(table.read_text().splitlines()) == 1 + 151


def test_a_film_draws_the_wake_in_its_colours(lattice):
    film = animation.Film(lattice, 1, 4, 25)
    assert [frame.beats for frame in film.frames] == pytest.approx([2.0, 2.25, 2.5, 2.75])
    pictures = list(film.pictures())
    left, right, bottom, top = film.shared.page
    corner = film._axes.get_window_extent()
    for frame, picture in zip(film.frames, pictures, strict=True):
        k = max(
            range(len(frame.wake)), key=lambda k, frame=frame: np.sort(np.hypot(*(frame.wake - frame.wake[k]).T))[1]
        )
        x = corner.x0 + corner.width * (frame.wake[k, 0] - left) / (right - left)
        y = picture.shape[0] - corner.y0 - corner.height * (frame.wake[k, 1] - bottom) / (top - bottom)
        seen = picture[int(y), int(x)].astype(int)
        np.testing.assert_allclose(seen, palette.colours(frame.circulation[k], film.shared.circulation), atol=6)


def test_without_its_extra_a_film_says_what_to_install(blades, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(UserError, match=re.escape('pip install "taichiflap[video]"')):
        export(blades, "mp4", tmp_path / "a.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "arguments", "phrase"),
    [
        ("absent", ["--to", "csv"], "no such file"),
        ("lattice", ["--to", "pdf"], "unknown format 'pdf'; use csv, vtkhdf, html, mp4, gif, flow.vtkhdf, nc"),
        ("lattice", ["--to", "csv", "--beats", "2"], "--beats applies to html, mp4, gif"),
        ("lattice", ["--to", "html", "--dark"], "--dark applies to mp4 and gif"),
        ("lattice", ["--to", "gif", "--beats", "0"], "must be at least 1"),
        ("lattice", ["--to", "csv", "-o", "no/such.csv"], "no is not a folder"),
        ("lattice", ["--to", "csv", "-o", "taken.csv"], "--overwrite"),
        ("empty", ["--to", "csv"], "no frames yet"),
        ("begun", ["--to", "html"], "no whole beat yet"),
        ("begun", ["--to", "gif"], "no whole beat yet"),
        ("failed", ["--to", "html"], "failed in its last beats"),
    ],
)
def test_a_mistake_gets_a_sentence_and_leaves_nothing(name, arguments, phrase, folder, tmp_path, monkeypatch):
    (tmp_path / "taken.csv").write_text("mine")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match=re.escape(phrase)):
        cli.app(["export", str(folder / f"{name}.h5"), *arguments], standalone_mode=False)
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [("taken.csv", "mine")]


def test_a_disk_that_refuses_gets_a_sentence(lattice, tmp_path, monkeypatch):
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    for kind in ("csv", "vtkhdf", "gif"):
        with pytest.raises(UserError, match="No space left on device"):
            export(lattice, kind, tmp_path / f"a.{kind}")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_the_command_as_a_user_runs_it(folder, tmp_path):
    ran = run("export", folder / "blades.h5", "--to", "csv", cwd=tmp_path)
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "blades.csv written\n", "")
    ran = run("export", folder / "blades.h5", "--to", "csv", cwd=tmp_path)
    assert (ran.returncode, ran.stderr.count("\n"), "Traceback" in ran.stderr) == (2, 1, False)
    assert run("export", folder / "blades.h5", "--to", "csv", "--overwrite", cwd=tmp_path).returncode == 0
