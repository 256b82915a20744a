"""Exports: what is in them is what is in the result, and they open where they are meant to."""

import base64
import getpass
import json
import re
import shutil
import socket
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from conftest import CASES, hawkmoth
from PIL import Image
from test_cli import run

import taichiflap
from taichiflap import animation, cli, palette, player, scene
from taichiflap.errors import UserError
from taichiflap.export import export
from taichiflap.variables import VARIABLES

CHROMIUM = shutil.which("chromium")
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip
TITLE = '<b>"$title" & </script>'


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a result of each model, and one of a run that has been cut short in three ways."""
    folder = tmp_path_factory.mktemp("exports")
    settings = ("time.periods=3", "time.steps_per_period=100", "uvlm.panels=20", "wing.modes=2")
    taichiflap.simulate(hawkmoth(*settings, f"title='{TITLE}'"), folder / "lattice.h5").close()
    blades = taichiflap.load_case(CASES / "hawkmoth_dbet.toml", ("time.periods=2",))
    taichiflap.simulate(blades, folder / "blades.h5").close()
    for name, frames in (("empty", 0), ("begun", 60)):
        shutil.copy(folder / "lattice.h5", folder / f"{name}.h5")
        with h5py.File(folder / f"{name}.h5", "r+") as file:
            file["time"].resize(frames, axis=0)
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
        if variable.single or name not in lattice.variables:
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


def embedded(path):
    """The data that a page carries."""
    return json.loads(re.search(r'id="data">(.*?)</script>', path.read_text(), re.DOTALL)[1])


def unpacked(packed):
    """Numbers of a page, and the error that their steps allow."""
    whole = np.frombuffer(base64.b64decode(packed["data"]), "<i2")
    return packed["offset"] + packed["scale"] * whole, 0.501 * packed["scale"]


def test_a_page_carries_the_results_numbers(lattice, tmp_path):
    path = export(lattice, "html", tmp_path / "a.html", beats=2)
    data = embedded(path)
    indices = scene.last_beats(lattice, 2)[:-1]
    assert (len(indices), data["first"], data["per_beat"]) == (200, 1.0, 100.0)
    wakes = [lattice.wake(i) for i in indices]
    assert data["counts"] == [len(wake["y"]) for wake in wakes]
    nodes = lattice.node_position[indices]
    expected = {
        "wing": np.stack((nodes[..., 1], -nodes[..., 0]), axis=-1),
        "wake": np.concatenate([np.stack((wake["z"], -wake["y"]), axis=1) for wake in wakes]),
        "circulation": np.concatenate([wake["circulation"] for wake in wakes]),
        "force": np.stack((lattice.force_z[indices], lattice.force_vertical[indices]), axis=1),
        "tip": lattice.tip_deflection[indices],
        "lift": lattice.force_vertical[indices],
    }
    for name, values in expected.items():
        ours, error = unpacked(data[name])
        np.testing.assert_allclose(ours, values.ravel(), rtol=0, atol=error, err_msg=name)
    assert unpacked(data["wake"])[1] < 1e-4 * lattice.case.wing.chord


def test_a_page_names_no_machine_and_reaches_for_nothing(lattice, tmp_path):
    page = export(lattice, "html", tmp_path / "a.html").read_text()
    # A short name, such as `vm`, may occur in base64 by chance.
    names = [name for name in (socket.gethostname(), getpass.getuser()) if len(name) > 5]
    for word in (str(tmp_path.parent), str(Path.home()), str(CASES), *names, "http:", "https:", "src="):
        assert word not in page
    assert "&lt;b&gt;" in page
    assert page.count("</script>") == 2


def test_a_page_takes_fewer_frames_or_beats_when_it_must(lattice, tmp_path, monkeypatch):
    frames = {}
    for budget in (7_000_000, 100_000, 30_000):
        monkeypatch.setattr(player, "BUDGET", budget)
        path = export(lattice, "html", tmp_path / f"{budget}.html", beats=3)
        data = embedded(path)
        frames[budget] = (len(data["counts"]), data["per_beat"])
        assert path.stat().st_size < 1.4 * budget + 30_000
    assert frames[7_000_000] == (300, 100.0)
    assert frames[100_000][0] < 300
    assert frames[30_000][1] >= player.FEWEST
    monkeypatch.setattr(player, "BUDGET", 1000)
    with pytest.raises(UserError, match="does not fit in 10 MB"):
        export(lattice, "html", tmp_path / "none.html")


@pytest.fixture(scope="module")
def browser():
    """Headless Chromium."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: the page is not played")
    if not CHROMIUM:
        pytest.skip("chromium is not installed: the page is not played; apt-get install chromium")
    with api.sync_playwright() as running:
        chromium = running.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture
def opened(browser, tmp_path):
    """Opens the page of a result, with the network off; any error on the page fails the test."""
    problems, contexts = [], []

    def open_page(result, scheme="light", size=(1280, 720)):
        path = export(result, "html", tmp_path / f"{result.path.stem}.html", beats=2, overwrite=True)
        context = browser.new_context(color_scheme=scheme, viewport={"width": size[0], "height": size[1]}, offline=True)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: problems.append(str(error)))
        page.on("console", lambda message: problems.extend([message.text] * (message.type == "error")))
        page.on("request", lambda request: problems.extend([request.url] * (not request.url.startswith("file:"))))
        page.goto(path.as_uri())
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert not problems


PIXELS = """([x, y]) => {
  const m = view(), at = [m.x + m.scale * x, m.y - m.scale * y].map((p) => Math.floor(p * devicePixelRatio));
  return [...pen.getImageData(...at, 1, 1).data];
}"""


def wait_until(page, condition):
    """Wait for a condition on the page, asked from outside: the page itself allows no evaluation of strings."""
    for _ in range(500):
        if page.evaluate(condition):
            return
        page.wait_for_timeout(20)
    raise AssertionError(f"never came true: {condition}")


@pytest.mark.parametrize(("scheme", "theme"), [("light", palette.LIGHT), ("dark", palette.DARK)])
def test_wing_and_wake_have_the_legends_colours(scheme, theme, opened, lattice):
    page = opened(lattice, scheme)
    page.evaluate("show(150)")
    frame = scene.frame(lattice, int(scene.last_beats(lattice, 2)[150]))
    limit = embedded(Path(page.url.removeprefix("file://")))["limit"]
    strong = np.argsort(-np.abs(frame.circulation))
    alone = [
        k for k in strong
        if np.sort(np.hypot(*(frame.wake - frame.wake[k]).T))[1] > 0.002
        and np.hypot(*(frame.wing - frame.wake[k]).T).min() > 0.006
    ][:12]  # fmt: skip
    assert len(alone) >= 5
    for k in alone:
        seen = page.evaluate(PIXELS, frame.wake[k].tolist())[:3]
        np.testing.assert_allclose(seen, palette.colours(frame.circulation[k], limit, theme), atol=3)
    ink = page.evaluate(PIXELS, frame.wing[5].tolist())[:3]
    assert "#{:02x}{:02x}{:02x}".format(*ink) == theme.ink
    ends = page.evaluate("[0, 256].map((x) => [...element('bar').getContext('2d').getImageData(x, 0, 1, 1).data])")
    np.testing.assert_array_equal(np.array(ends)[:, :3], palette.table(theme)[[0, -1]])
    assert f"{limit:g}" in page.inner_text("#ticks")
    assert "m²/s" in page.inner_text("#legend")


def test_a_page_plays_pauses_and_seeks(opened, lattice):
    page = opened(lattice)
    wait_until(page, "now > 5")
    page.click("#play")
    held = page.evaluate("now")
    page.wait_for_timeout(100)
    assert page.evaluate("now") == held
    before = page.evaluate("stage.toDataURL()")
    page.fill("#slider", "150")
    assert page.inner_text("#clock") == "beat 3, t/T = 0.50"
    assert page.evaluate("stage.toDataURL()") != before
    index = int(scene.last_beats(lattice, 2)[150])
    assert f"tip {1e3 * lattice.tip_deflection[index]:.2f} mm" in page.inner_text("#readout")
    page.click("#next")
    assert page.evaluate("Math.floor(now)") == 151
    page.select_option("#speed", "8")
    assert page.inner_text("#slower") == "200 times slower than life"
    page.click("#play")
    wait_until(page, "now > 155")
    assert page.title() == TITLE


def test_zoom_keeps_the_point_under_the_pointer(opened, lattice):
    page = opened(lattice)
    page.click("#play")
    where = """(() => { const m = view(), top = stage.getBoundingClientRect().top;
      return [(300 - m.x) / m.scale, (300 - top - m.y) / m.scale, m.scale]; })()"""
    before = page.evaluate(where)
    page.mouse.move(300, 300)
    page.mouse.wheel(0, -400)
    wait_until(page, f"view().scale > 1.2 * {before[2]}")
    np.testing.assert_allclose(page.evaluate(where)[:2], before[:2], atol=1e-6)
    page.click("#reset")
    np.testing.assert_allclose(page.evaluate(where), before)


def test_blades_play_without_a_wake_and_say_so(opened, blades):
    page = opened(blades, size=(420, 760))
    wait_until(page, "now > 2")
    assert "blade elements have no wake" in page.inner_text("header")
    assert not page.is_visible("#legend")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_a_gif_shows_a_beat_and_repeats(lattice, tmp_path):
    with Image.open(export(lattice, "gif", tmp_path / "a.gif")) as picture:
        assert (picture.n_frames, picture.info["loop"], picture.info["duration"]) == (50, 0, 50)
        frame = np.asarray(picture.convert("RGB")).astype(int)
    assert frame.min() < 60
    orange, blue = frame[..., 0] - frame[..., 2], frame[..., 2] - frame[..., 0]
    assert (orange.max() > 100, blue.max() > 100) == (True, True)


def test_a_film_has_every_frame(blades, tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="imageio-ffmpeg is not installed: no film is made")
    path = export(blades, "mp4", tmp_path / "a.mp4", beats=1)
    assert ffmpeg.count_frames_and_secs(str(path)) == (100, pytest.approx(4.0, abs=0.05))
    assert [file.name for file in tmp_path.iterdir()] == ["a.mp4"]


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
        ("lattice", ["--to", "pdf"], "no format 'pdf'; there are csv, vtkhdf, html, mp4, gif"),
        ("lattice", ["--to", "csv", "--beats", "2"], "--beats is for html, mp4, gif"),
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


def test_the_command_as_a_user_runs_it(folder, tmp_path):
    ran = run("export", folder / "blades.h5", "--to", "csv", cwd=tmp_path)
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "blades.csv written\n", "")
    ran = run("export", folder / "blades.h5", "--to", "csv", cwd=tmp_path)
    assert (ran.returncode, ran.stderr.count("\n"), "Traceback" in ran.stderr) == (2, 1, False)
    assert run("export", folder / "blades.h5", "--to", "csv", "--overwrite", cwd=tmp_path).returncode == 0
