"""The viewer without a browser: frames, playback, colours, comparison, flow, and errors at the start."""

import contextlib
import itertools
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from unittest.mock import MagicMock
from urllib.parse import urlsplit

import h5py
import msgspec
import numpy as np
import pytest
import viser
import zstandard
from conftest import CASES, hawkmoth
from taichiflap_viewer import Viewer, ViewError, app, camera, charts, compare, field, server, timeline, wire
from taichiflap_viewer.background import Background
from taichiflap_viewer.clock import Clock
from taichiflap_viewer.colours import DARK, LIGHT, linear
from taichiflap_viewer.field import NONE, VORTICITY
from taichiflap_viewer.frames import Run
from taichiflap_viewer.scene import default_layers
from taichiflap_viewer.session import Session, opening
from taichiflap_viewer.stage import set_up
from taichiflap_viewer.timeline import Playback
from websockets.sync.client import connect

import taichiflap
from taichiflap import fluids, open_result
from taichiflap.case.case import parse_case
from taichiflap.fluids.uvlm.stations import stations
from taichiflap.metrics.summary import Statistic
from taichiflap.results.reader import ResultError, part
from taichiflap.results.writer import Writer
from taichiflap.run import blocks

CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": [1.0, 0.0, 0.0, 0.0], "position": [0.0, -50.0, 0.0],
    "fov": 0.14, "near": 0.5, "far": 4000.0, "image_height": 720, "image_width": 700,
    "look_at": [0.0, 0.0, 0.0], "up_direction": [0.0, 0.0, 1.0],
}  # fmt: skip
"""What a page says first."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two beats of the hawkmoth by each model, and of one with three modes."""
    path = tmp_path_factory.mktemp("results")
    for name, settings in (("uvlm", []), ("dbet", ["solver=dbet"]), ("modes", ["wing.modes=3"])):
        taichiflap.simulate(hawkmoth("time.periods=2", *settings), path / f"{name}.h5").close()
    return path


@pytest.fixture
def run(folder):
    opened = Run(open_result(folder / "uvlm.h5"), "uvlm")
    yield opened
    opened.close()


def test_a_frame_is_the_files_in_chords_with_lift_upwards(run):
    frame, chord = run.frame(250), run.chord
    nodes, wake = run.result.node_position[250], run.result.wake(250)
    np.testing.assert_allclose(frame.nodes, np.stack((nodes[:, 1], -nodes[:, 0]), axis=1) / chord, rtol=1e-6)
    np.testing.assert_allclose(frame.wake, np.stack((wake["z"], -wake["y"]), axis=1) / chord, rtol=1e-6)
    np.testing.assert_array_equal(frame.circulation, wake["circulation"])
    np.testing.assert_array_equal(frame.force, [run.result.force_z[250], run.result.force_vertical[250]])


def test_velocity_of_the_nodes_is_that_of_their_positions(run):
    before, now, after = (run.frame(index) for index in (249, 250, 251))
    measured = (after.nodes - before.nodes) * run.chord / (2.0 * run.case.step)
    assert np.abs(now.velocity - measured).max() < 0.01 * np.abs(measured).max()


def test_a_wing_that_pivots_behind_its_leading_edge():
    case = hawkmoth("time.periods=1", "wing.modes=0", "wing.pivot=0.3", "solver=dbet")
    run = Run(taichiflap.simulate(case), "pivot")
    before, now, after = (run.frame(index) for index in (49, 50, 51))
    np.testing.assert_allclose(now.chord, now.nodes[[0, -1]], atol=1e-6)
    measured = (after.nodes - before.nodes) * run.chord / (2.0 * case.step)
    assert np.abs(now.velocity - measured).max() < 0.01 * np.abs(measured).max()
    run.close()


def test_frames_are_read_one_at_a_time(run, monkeypatch):
    monkeypatch.setattr(type(run.result), "__getattr__", lambda self, name: pytest.fail(f"{name} was read whole"))
    assert run.frame(17).index == 17


def test_curves_that_are_damaged_are_left_out_and_the_rest_is_shown(folder, tmp_path):
    shutil.copy(folder / "modes.h5", tmp_path / "damaged.h5")
    with h5py.File(tmp_path / "damaged.h5", "r+") as file:
        file["power"][300], file["q"][300, 1] = 1e200, np.nan
    damaged, sound = (
        Run(open_result(tmp_path / "damaged.h5"), "damaged"),
        Run(open_result(folder / "modes.h5"), "sound"),
    )
    for name in ("power", "q", "tip_deflection"):
        (times, values), (expected_times, expected) = (one.series(name, 200, 400, 101) for one in (damaged, sound))
        np.testing.assert_array_equal(times, expected_times)
        np.testing.assert_array_equal(values, expected if name == "tip_deflection" else np.full_like(expected, np.nan))
    np.testing.assert_array_equal(damaged.frame(299).nodes, sound.frame(299).nodes)
    with pytest.raises(OSError, match="frame 300 cannot be read"):
        damaged.frame(300)
    for one in (damaged, sound):
        one.close()


def test_a_motion_that_does_not_repeat_opens_and_plays(tmp_path):
    case = taichiflap.load_case(CASES / "pitch_ramp.toml", ("uvlm.panels=10",))
    taichiflap.simulate(case, tmp_path / "ramp.h5").close()
    ramp = Run(taichiflap.open_result(tmp_path / "ramp.h5"), "ramp")
    assert (ramp.beats, ramp.frames_per_beat, ramp.reversals(), ramp.half_stroke(3)) == (1, case.steps, [], "")
    assert ramp.when(ramp.frames - 1) == "t = 5000 ms"
    playback = timeline.Playback(position=0.0, playing=True)
    timeline.advance(ramp, playback, 2.0)
    assert playback.frame == int(0.5 * case.steps)
    ramp.close()


def test_beats_and_half_strokes(run):
    assert run.beat_of(0) == (1, 0.0)
    assert run.beat_of(200) == (2, 0.0)
    assert run.beat_of(400) == (2, 1.0)
    assert list(run.reversals()) == [0, 100, 200, 300, 400]
    assert (run.half_stroke(50), run.half_stroke(150)) == ("half-stroke to the left", "half-stroke to the right")
    assert run.frame(51).nodes[0, 0] < run.frame(49).nodes[0, 0]


def test_the_newest_frame_of_a_beat_that_is_not_over_is_in_that_beat(run, monkeypatch):
    for frames, told in ((401, (2, 1.0)), (331, (2, 0.65)), (201, (1, 1.0)), (1, (1, 0.0))):
        monkeypatch.setattr(run, "frames", frames)
        assert run.beat_of(frames - 1) == pytest.approx(told)


def test_playback_goes_round_its_loop(run):
    playback = opening([run])
    assert (playback.frame, playback.playing) == (400, True)
    playback.speed = 1.0
    timeline.advance(run, playback, 0.5)
    assert playback.frame == 300
    timeline.advance(run, playback, 0.75)
    assert playback.frame == 250
    playback.loop = timeline.ALL
    timeline.advance(run, playback, 1.0)
    assert playback.frame == 50
    timeline.step(run, playback, -1)
    assert (playback.frame, playback.playing) == (49, False)
    assert timeline.next_reversal(run, playback, forward=True) == 100
    assert timeline.next_reversal(run, playback, forward=False) == 0


def test_colours_are_symmetric_and_keep_off_the_background():
    for theme in (LIGHT, DARK):
        for colours in (theme.circulation, theme.pressure):
            low, middle, high = colours.symmetric(np.array([-9.0, 0.0, 9.0]), 2.0).astype(int)
            np.testing.assert_array_equal([low, high], [colours.table[0], colours.table[-1]])
            assert np.abs(middle - theme.background).max() > 25
    np.testing.assert_array_equal(linear(np.array([0, 188, 255], dtype=np.uint8)), [0, 128, 255])


def test_the_flow_is_the_solvers_and_its_vorticity_holds_the_circulation(run):
    fields = field.Fields(run)
    flow = fields.ask(300).result()
    fields.close()
    frame = run.frame(300)
    left, bottom, right, top = flow.box * run.chord
    cell = (right - left) * (top - bottom) / flow.vorticity.size
    inside = np.all((frame.wake > flow.box[:2]) & (frame.wake < flow.box[2:]), axis=1)
    total = frame.circulation[inside].sum() + run.result.circulation[300]
    scale = np.abs(frame.circulation).sum()
    assert abs(flow.vorticity.sum() * cell - total) < 0.05 * scale
    strongest = frame.wake[np.argmax(np.abs(frame.circulation))]
    place = ((strongest - flow.box[:2]) / (flow.box[2:] - flow.box[:2]) * flow.vorticity.shape[::-1]).astype(int)
    assert np.sign(flow.vorticity[place[1], place[0]]) == np.sign(
        frame.circulation[np.argmax(np.abs(frame.circulation))]
    )


@pytest.mark.parametrize("spacing", ["cosine", "uniform"])
def test_bound_vortices_stand_where_the_lattice_has_them(spacing):
    settings = ("time.periods=1", "time.steps_per_period=40", "wing.modes=0", "wing.pivot=0.2", "uvlm.panels=12")
    result = taichiflap.simulate(hawkmoth(*settings, f"uvlm.spacing={spacing}"))
    at = stations(result.case)
    for index in (7, 31):
        pitch, plunge = result.pitch[index], result.plunge[index]
        y, z, circulation = fluids.load("uvlm").vortices(result, index)[:, : result.case.uvlm.panels]
        np.testing.assert_allclose(y, at.vortex * np.cos(pitch), atol=1e-8)
        np.testing.assert_allclose(z, plunge + at.vortex * np.sin(pitch), atol=1e-8)
        np.testing.assert_array_equal(circulation, result.panel_circulation[index])


def test_a_table_that_starts_up_is_not_drawn_beyond_its_end(tmp_path):
    """A spline is meaningless beyond its last point; the drawn motion comes from the file."""
    table = {"kind": "table", "points": [[0.0, 0.0], [0.01, 0.002], [0.02, 0.015], [0.03, 0.02], [0.04, 0.03]]}
    motion = {"plunge": table, "pitch": {"kind": "ramp", "start": 0.0, "ramp": 0.02, "amplitude_deg": 30.0,
              "smoothing": 500.0}, "start_up": 0.03}  # fmt: skip
    surge = {"kind": "table", "points": [[0.0, 0.0], [0.01, 0.01], [0.02, 0.005], [0.03, 0.0], [0.04, -0.01]]}
    document = hawkmoth("wing.modes=0", "solver=dbet").to_dict()
    document |= {"motion": motion | {"surge": surge}, "time": {"duration": 0.04, "step": 0.0004}}
    result = taichiflap.simulate(parse_case(document))
    run = Run(result, "table")
    chosen = [result.plunge.argmin(), result.plunge.argmax()]
    ends = np.stack((result.plunge[chosen], -result.surge[chosen]), axis=1) / run.chord
    np.testing.assert_allclose(run.path, ends, atol=1e-9)
    for index in (0, 40, run.frames - 1):
        frame = run.frame(index)
        np.testing.assert_allclose(frame.chord, frame.nodes[[0, -1]], atol=1e-6)
    before, now, after = (run.frame(index) for index in (49, 50, 51))
    measured = (after.nodes - before.nodes) * run.chord / (2.0 * run.case.step)
    assert np.abs(now.velocity - measured).max() < 0.01 * np.abs(measured).max()
    assert run.half_stroke(run.frames - 1) == run.half_stroke(run.frames - 2)
    run.close()


def test_differences_are_those_of_the_summaries(folder, run):
    other = Run(open_result(folder / "dbet.h5"), "dbet")
    found = {one.name: one for one in compare.differences(run, other)}
    first, second = run.summary(), other.summary()
    vertical = found["vertical force, mean"]
    assert (vertical.first, vertical.second) == (1e3 * first.force_vertical.mean, 1e3 * second.force_vertical.mean)
    assert vertical.relative == pytest.approx(100.0 * (vertical.second / vertical.first - 1.0))
    phase = found["normal force, phase"]
    turn = phase.second - phase.first - (second.force_normal_phase - first.force_normal_phase)
    assert turn % 360.0 == pytest.approx(0.0, abs=1e-9) or turn % 360.0 == pytest.approx(360.0)
    assert abs(phase.second - phase.first) <= 180.0
    assert "against" in list(compare.text(run, other))[2]
    other.close()


def test_a_growing_file_is_followed_to_its_final_name(tmp_path, run):
    result = run.result
    writer = _begun(run, tmp_path / "run.h5")
    blocks = [_block(result, *span) for span in ((0, 100), (100, 220), (220, 401))]
    writer.append(blocks[0])
    script = (
        "import sys; from taichiflap import open_result; from taichiflap_viewer.frames import Run\n"
        "run = Run(open_result(sys.argv[1]), 'run'); print(run.frames, run.status, flush=True)\n"
        "while run.live:\n"
        "    input(); run.refresh()\n"
        "    print(run.frames, run.status, run.frame(run.frames - 1).wake.shape[0], flush=True)\n"
    )
    command = [sys.executable, "-c", script, str(tmp_path / "run.h5")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as reader:
        assert reader.stdout.readline() == "100 running\n"
        writer.append(blocks[1])
        print(file=reader.stdin, flush=True)
        assert reader.stdout.readline() == f"220 running {len(result.wake(219)['y'])}\n"
        writer.append(blocks[2])
        writer.finish().close()
        print(file=reader.stdin, flush=True)
        assert reader.stdout.readline() == f"401 complete {len(result.wake(400)['y'])}\n"


def test_a_run_is_followed_to_the_newest_frame_whose_picture_is_there(run, monkeypatch):
    """Else the next frame comes before the picture of the last, and a page that follows never shows one."""
    session, asked = Session.__new__(Session), []
    session.run, session.playback = run, Playback(position=30.0, follow=True, background=VORTICITY)
    session.playback.layers = default_layers(run)
    session.background = Background(None, None, None, None)
    session.background._pictures.update({20: None, 41: None})
    monkeypatch.setattr(Run, "live", True)
    assert session._newest() == 41
    session.playback.position = 60.0
    assert session._newest() == 60
    session.playback.background = NONE
    assert session._newest() == run.frames - 1
    session.playback.background = VORTICITY
    monkeypatch.setattr(Run, "live", False)
    assert session._newest() == run.frames - 1
    # The picture of the newest frame is asked for with the one that is shown.
    session.actors, session.theme, session.stage, session.bar = [], None, MagicMock(), MagicMock()
    session.charts, session.panel, session._cursor, session._beside = MagicMock(), MagicMock(), None, 0.0
    session.streak_lines, session.runs = MagicMock(), [run]
    monkeypatch.setattr(session.background, "show", lambda wanted, index, theme, coming: asked.append((index, coming)))
    session._show(41)
    assert asked == [(41, [run.frames - 1])]


def test_a_growing_run_tells_how_far_it_is_and_how_long_it_takes(run, monkeypatch):
    monkeypatch.setattr(run, "steps", 101)
    monkeypatch.setattr(run, "_first_seen", (1, time.monotonic() - 20.0))
    assert run.progress == "25 %, 60 s left"
    monkeypatch.setattr(run, "_first_seen", (1, time.monotonic() - 200.0))
    assert run.progress == "25 %, 10 min left"
    monkeypatch.setattr(run, "_first_seen", (100, time.monotonic() - 20.0))
    assert run.progress == "25 %"


def test_a_half_written_block_is_not_shown(tmp_path, run):
    """Only frames with all variables count."""
    result = run.result
    writer = _begun(run, tmp_path / "run.h5")
    writer.append(_block(result, 0, 100))
    writer._put("tip_deflection", 100, result.tip_deflection[100:120])
    writer._put("wake/count", 100, np.full(20, 7))
    writer.abandon()
    with open_result(tmp_path / "run.h5") as half:
        assert (half.frames, len(half.time), len(half.tip_deflection)) == (100, 100, 100)
        np.testing.assert_array_equal(half.wake(99)["y"], result.wake(99)["y"])


def test_an_empty_leftover_gets_one_sentence(tmp_path, run, monkeypatch):
    monkeypatch.setattr("taichiflap_viewer.app.BEGIN_SECONDS", -1.0)
    _begun(run, tmp_path / "run.h5").abandon()
    assert part(tmp_path / "run.h5").exists()
    with pytest.raises(ResultError, match="has no frame yet"):
        Viewer([tmp_path / "run.h5"])


def test_too_many_files_and_no_such_port_get_one_sentence(folder):
    with pytest.raises(ViewError, match="one result, or two"):
        Viewer([folder / "uvlm.h5"] * 3)
    with pytest.raises(ViewError, match="no such port"):
        Viewer([folder / "uvlm.h5"], port=70000)
    with pytest.raises(ViewError, match="cannot listen at 203"):
        Viewer([folder / "uvlm.h5"], host="203.0.113.1")


def test_a_taken_port_gives_way_and_only_this_machine_is_served(folder):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        viewer = Viewer([folder / "uvlm.h5"], port=port)
        try:
            assert viewer.port > port
            assert viewer.address == f"http://127.0.0.1:{viewer.port}{viewer.door.path}"
            with socket.create_server(("127.0.0.2", viewer.port)):
                pass  # every address would include this one
        finally:
            viewer.stop()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["missing.h5", "foreign.h5", "truncated.h5"])
def test_a_file_that_cannot_be_shown_gets_one_sentence_and_code_2(folder, tmp_path, name):
    if name == "foreign.h5":
        (tmp_path / name).write_text("no HDF5")
    if name == "truncated.h5":
        (tmp_path / name).write_bytes((folder / "uvlm.h5").read_bytes()[:4000])
    command = [sys.executable, "-m", "taichiflap", "view", "--no-browser", str(tmp_path / name)]
    ran = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert ran.returncode == 2
    assert ran.stderr.startswith(f"error: {tmp_path / name}: ")
    assert len(ran.stderr.splitlines()) == 1


def test_the_rotation_lock_says_so_where_viser_has_changed():
    """The lock uses a private name of viser; a version without it has no lock, but works otherwise."""
    assert hasattr(viser._messages, "RunJavascriptMessage")

    class Client:
        """A browser's handle in a viser without the way in."""

    assert camera.lock_rotation(Client()) is False


def test_a_frame_is_one_message_a_node_and_drawn_once_for_all(folder, monkeypatch):
    """Tests the use of private parts of viser, which makes many browsers cheap."""
    viewer = Viewer([folder / "uvlm.h5"])
    try:
        run, layers, wakes = viewer.runs[0], opening(viewer.runs).layers, []
        shown = {"/wing": {"points", "colors"}, "/wake": {"points", "colors"}, "/ghost": {"points"}}
        shown["/force"] = {"points"}
        for _ in range(2):
            _, (actor,) = set_up(viewer.server.scene, viewer.runs, LIGHT)
            actor.show(249, layers)
            with monkeypatch.context() as patched:
                sent = []
                patched.setattr(viewer.server._websock_server, "queue_message", sent.append)
                actor.show(250, layers)
            assert len(sent) == len(shown)
            assert {message.name: set(message.updates) for message in sent} == shown
            wakes += [message.updates["points"] for message in sent if message.name == "/wake"]
        assert wakes[0] is wakes[1]
        assert (wakes[0].dtype, len(wakes[0])) == (np.float32, len(run.frame(250).wake))
    finally:
        viewer.stop()


def test_a_message_is_packed_as_viser_packs_it(folder):
    """Tests our packing of messages, for nodes of the scene and for charts."""
    viewer = Viewer([folder / "uvlm.h5"])
    try:
        gui, socket_server = viewer.server.gui, viewer.server._websock_server
        points = np.arange(6, dtype=np.float32).reshape(2, 3)
        label, chart = viewer.server.scene.add_label("/label", ""), gui.add_uplot((points[0],) * 2, ({}, {}))
        with pytest.MonkeyPatch.context() as patched:
            sent = []
            patched.setattr(socket_server, "queue_message", sent.append)
            wire.send(label, text="beat 1", points=points)
            wire.send(chart, data=(points[0], points[1]))
        for message in sent:
            (kind,) = type(message).__bases__
            packed, own = [], []
            assert message.as_serializable_dict(packed) == kind(**vars(message)).as_serializable_dict(own)
            assert [part.tobytes() for part in packed] == [part.tobytes() for part in own]
            assert packed
    finally:
        viewer.stop()


def test_without_the_private_way_values_go_through_the_handle():
    class Handle:
        """A node's handle in a viser without the way in."""

    handle = Handle()
    wire.send(handle, text="beat 1", visible=True)
    assert (handle.text, handle.visible) == ("beat 1", True)


@contextlib.contextmanager
def _page(viewer):
    """The socket of a page that has told its camera."""
    protocol = f"viser-v{viser.__version__}"
    with connect(f"ws://127.0.0.1:{viewer.port}{viewer.door.path}", subprotocols=[protocol], max_size=None) as page:
        page.send(msgspec.msgpack.encode(CAMERA))
        yield page


def _until(condition):
    """Wait until a condition of the server holds."""
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


def _said(page):
    """The next message to a page."""
    data = page.recv(timeout=30.0)
    return zstandard.decompress(data[16 : 16 + int.from_bytes(data[8:16], "little")])


def test_a_page_gets_its_controls_before_it_has_told_its_name(folder, monkeypatch):
    """This saves a round trip before the page is complete, and playback starts only then."""
    told = threading.Event()
    monkeypatch.setattr(app, "_browser", lambda client: told.wait(30.0) and "a name")
    viewer = Viewer([folder / "dbet.h5"])
    try:
        with _page(viewer) as page:
            while b"Reset view" not in _said(page):
                pass
            (session,) = viewer.sessions
            before = session.playback.position
            session.tick(0.1)
            assert session.playback.position == before
            told.set()
            while session.playback.position == before:
                page.recv(timeout=30.0)
    finally:
        told.set()
        viewer.stop()


def test_a_browser_that_leaves_while_its_session_is_made_leaves_none(folder, monkeypatch):
    viewer = Viewer([folder / "dbet.h5"])
    client = type("Client", (), {"client_id": 7})()
    monkeypatch.setattr(app, "Visit", lambda *_: viewer._disconnect(client))
    try:
        viewer._connect(client)
        assert (viewer.sessions, viewer._gone, viewer._dropped) == ([], set(), {})
    finally:
        viewer.stop()


def test_browsers_that_never_come_back_are_forgotten(folder):
    viewer = Viewer([folder / "dbet.h5"])
    try:
        viewer._dropped = {"gone": [(-1e9, opening(viewer.runs))], "late": [(-1e9, None), (time.monotonic(), None)]}
        viewer._forget()
        assert {name: len(places) for name, places in viewer._dropped.items()} == {"late": 1}
    finally:
        viewer.stop()


def test_a_narrow_window_has_the_scene_above_the_controls(run):
    width, height = 480.0, 800.0
    (x, away, z), _ = camera.home(run.box, width, height)
    scale = -away * 2.0 * np.tan(camera.FIELD_OF_VIEW / 2.0) / height
    left, bottom, right, top = run.box
    assert (z - bottom) / scale < height / 2.0 - camera.SHEET * height
    assert (top - z) / scale < height / 2.0
    assert max(right - x, x - left) / scale < width / 2.0


@pytest.fixture
def command(tmp_path):
    """Start commands that serve until they are interrupted, without opening a browser."""
    started = []

    def start(*arguments):
        process = subprocess.Popen(
            [sys.executable, "-m", "taichiflap", *map(str, arguments)],
            cwd=tmp_path, env={**os.environ, "BROWSER": "true"}, text=True, start_new_session=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        started.append(process)
        return process

    yield start
    for process in started:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def test_in_a_stream_charts_and_differences_are_of_lift_and_thrust(tmp_path):
    settings = (
        "time.periods=2",
        "time.steps_per_period=40",
        "wing.modes=0",
        "solver=dbet",
        "fluid.velocity=[1.0, 0.5]",
    )
    result = taichiflap.simulate(hawkmoth(*settings), tmp_path / "stream.h5")
    run = Run(result, "stream")
    shown = {one.name: one for one in charts.quantities([run])}
    assert list(shown) == ["plunge", "lift", "thrust", "power"]  # a wing that does not bend
    times, lift = run.curve("lift", 0, run.steps - 1, 241)
    _, thrust = run.curve("thrust", 0, run.steps - 1, 241)
    np.testing.assert_allclose(lift**2 + thrust**2, result.force_y**2 + result.force_z**2)
    assert len(times) == run.frames
    # The stream runs to the right, and lift is what points up.
    np.testing.assert_allclose(run.page.on_page(1.0, 0.5), [np.hypot(1.0, 0.5), 0.0], atol=1e-12)
    for index in (30, 57):
        np.testing.assert_allclose(run.frame(index).force, [-thrust[index], lift[index]], rtol=1e-9)
    assert {run.half_stroke(30), run.half_stroke(50)} == {"upstroke", "downstroke"}
    names = [one.name for one in compare.differences(run, run)]
    assert names[:2] == ["lift, mean", "thrust, mean"]
    summary = taichiflap.summarise(result)
    assert compare.differences(run, run)[1].first == pytest.approx(1e3 * summary.thrust.mean)
    run.close()


@pytest.mark.slow
def test_view_says_which_port_it_takes_and_what_differs(folder, command):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        process = command("view", folder / "uvlm.h5", folder / "dbet.h5", "--port", port, "--no-browser")
        lines = []
        while not lines or "Ctrl-C" not in lines[-1]:
            lines.append(process.stdout.readline())
        assert lines[-2] == f"port {port} is taken\n"
        assert lines[-1].startswith("http://127.0.0.1:")
        assert any(line.startswith("vertical force, mean, mN") for line in lines)
    os.killpg(process.pid, signal.SIGINT)
    assert process.wait(30.0) == 0
    process = command("view", *[folder / "uvlm.h5"] * 3)
    assert process.wait(60.0) == 2
    assert process.stderr.read() == "error: view shows one result, or two compared, not 3\n"


@pytest.mark.slow
def test_a_run_that_fails_keeps_its_viewer(command):
    """Its frames until the failure are shown; the exit code follows when the viewer is closed."""
    spinning = ("wing.youngs_modulus=1.0", "motion.pitch.amplitude_deg=360.0", "motion.frequency=100.0")
    settings = [part for one in (*spinning, "fluid.density=0.0", "time.periods=60") for part in ("--set", one)]
    process = command("simulate", CASES / "hawkmoth_dbet.toml", *settings, "--view")
    line = ""
    while "Ctrl-C" not in line:
        line = process.stdout.readline()
        assert line, process.stderr.read()
    while "diverged" not in process.stderr.readline():
        assert process.poll() is None
    place = urlsplit(line.split()[0])
    with socket.create_connection((place.hostname, place.port), timeout=30.0):
        assert process.poll() is None
    os.killpg(process.pid, signal.SIGINT)
    assert process.wait(30.0) == 1


class _Section:
    """The elastic modes of a result, as its writer wants them."""

    def __init__(self, result):
        self.modes = result.modes
        self.count = len(self.modes["frequency"])
        self.frequency, self.damping_ratio = self.modes["frequency"], self.modes["damping_ratio"]
        self.lam, self.psi = self.modes["lambda"], self.modes["psi"]

    def shape(self, nodes):
        return self.modes["shape"]


def _begun(run, path):
    """A writer of a run like this one, laid out and without frames yet."""
    result = run.result
    writer = Writer(run.case, path, [])
    contents = blocks._contents(fluids.load(run.case.solver), run.case)
    writer.lay_out(result.file["node"][...], _Section(result), _block(result, 0, 1), contents)
    return writer


def _block(result, first, last):
    block = {name: getattr(result, name)[first:last] for name in result.variables}
    wakes = [result.wake(index) for index in range(first, last)]
    block["wake/count"] = np.array([len(wake["y"]) for wake in wakes])
    block |= {f"wake/{name}": np.concatenate([wake[name] for wake in wakes]) for name in wakes[0]}
    return block


def test_a_difference_of_means_has_a_standard_error():
    one, other = Statistic(2.0, 0.1, 0.03), Statistic(2.2, 0.1, 0.04)
    assert compare._error(one, other) == pytest.approx(100.0 * 0.05 / 2.0)
    assert compare._error(one, Statistic(2.2, 0.1, None)) is None
    assert compare.Difference("power, mean", "W", 2.0, 2.2, 10.0, 2.5).change == "+10.0 ± 2.5 %"
    assert compare.Difference("power, mean", "W", 2.0, 2.2, 10.0, 1e-6).change == "+10.0 %"


@pytest.fixture(scope="module")
def kinds(folder):
    """Files by kind of result: with and without a wake, of two sheets, and with a stored flow, in seconds."""
    edge = (
        "uvlm.spacing=cosine", "uvlm.loads=vortices", "uvlm.shedding=local", "uvlm.convection=second_order",
        "uvlm.core=0.05", "uvlm.core_growth=0.3", "uvlm.crossing=pass", "uvlm.leading_edge=sheds", "uvlm.panels=8",
    )  # fmt: skip
    ramp = (
        "solver=navier_stokes", "fluid.viscosity=1e-3", "navier_stokes.cells=64", "navier_stokes.radius=4.0",
        "time.duration=0.1", "time.step=0.0025", "output.every=10",
    )  # fmt: skip
    cases = {
        "sheds": hawkmoth("time.periods=1", "time.steps_per_period=40", *edge),
        "viscous": taichiflap.load_case(CASES / "pitch_ramp.toml", ramp),
    }
    for name, case in cases.items():
        taichiflap.simulate(case, folder / f"{name}.h5").close()
    return {name: folder / f"{name}.h5" for name in ("dbet", "uvlm", *cases)}


@pytest.mark.slow
def test_any_two_results_are_compared(kinds, capfd):
    for pair in itertools.combinations_with_replacement(kinds, 2):
        viewer = Viewer([kinds[name] for name in pair])
        try:
            with _page(viewer):
                _until(lambda viewer=viewer: viewer.sessions and viewer.sessions[0].session._started)
                shown = viewer.sessions[0].session.charts
                for one in shown.quantities:
                    assert len(shown._data(one, 0)) == len(shown._series(one)), (pair, one)
                # The ramp of 0.1 s has no period: its charts are over ms, those of the others over beats.
                last, label = shown._data(one, 0)[0][-1], shown._series(one)[0]["label"]
                assert (round(last, 6), label) == (
                    (100.0, "t, ms") if pair[0] == "viscous" else (viewer.runs[0].beats, "t/T")
                ), pair
                disabled = {name for name, box in viewer.sessions[0].session.panel.layers.items() if box.disabled}
                assert ("wake" in disabled, "sheets" in disabled) == (
                    not {"uvlm", "sheds"} & {*pair}, "sheds" not in pair,
                )  # fmt: skip
        finally:
            viewer.stop()
    assert "Traceback" not in capfd.readouterr().err


def test_results_without_a_period_are_compared_at_the_same_time():
    short, long = (taichiflap.load_case(CASES / "pitch_ramp.toml", [f"time.duration={end}"]) for end in (4.0, 8.0))
    assert Clock(long).beats_at(Clock(short), 0.5) == pytest.approx(0.25)
    assert Clock(hawkmoth("motion.frequency=50.0")).beats_at(Clock(hawkmoth()), 0.5) == 0.5


def test_a_picture_that_failed_is_tried_again(run, monkeypatch):
    fields = field.Fields(run, warm=False)
    try:
        with monkeypatch.context() as patched:
            patched.setattr(run, "flow_field", lambda _: 1 / 0)
            assert fields.ask(0).exception()
            assert fields.streaks.ask(0).exception() is None
        assert fields.ask(0).result().vorticity.any()
    finally:
        fields.close()


def test_a_page_that_cannot_be_built_says_so_and_others_play_on(folder, monkeypatch, capfd):
    def fail(*_):
        raise ZeroDivisionError("one page alone")

    viewer = Viewer([folder / "dbet.h5"])
    try:
        with _page(viewer):
            _until(lambda: viewer.sessions)
            (well,) = viewer.sessions
            monkeypatch.setattr(app, "Visit", fail)
            with _page(viewer) as page:
                while server.UNBUILT.encode() not in _said(page):
                    pass
            monkeypatch.setattr(type(well), "tick", fail)
            _until(lambda: viewer._printed)
            monkeypatch.undo()
            before = well.playback.position
            _until(lambda: well.playback.position != before)
    finally:
        viewer.stop()
    # By viser, and once for all ticks.
    assert capfd.readouterr().err.count("ZeroDivisionError: one page alone") == 2
