"""Access to the viewer: unauthorised clients and invalid messages are refused."""

import contextlib
import gzip
import http.client
import math
import os
import re
import shutil
import socket
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import h5py
import msgspec
import numpy as np
import pytest
import taichiflap_viewer
import viser
import zstandard
from conftest import CASES, hawkmoth
from taichiflap_viewer import Viewer, door, messages
from taichiflap_viewer.door import Door
from taichiflap_viewer.frames import Run
from taichiflap_viewer.maps.viewer import MapViewer
from taichiflap_viewer.server import notice, own_addresses
from test_viewer import CAMERA
from viser import _tunnel
from viser.infra import _infra
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import taichiflap
from taichiflap.results.hdf import rewrite

# viser says so when a page leaves while it is being told something; the viewer hides it from its users.
pytestmark = pytest.mark.filterwarnings("ignore:Queued a .*:UserWarning")

PROTOCOL = f"viser-v{viser.__version__}"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two short results and a map."""
    path = tmp_path_factory.mktemp("results")
    small = ("solver=dbet", "time.periods=1", "time.steps_per_period=40", "dbet.elements=8")
    for name, modes in (("rigid", 0), ("bent", 1)):
        taichiflap.simulate(hawkmoth(*small, f"wing.modes={modes}"), path / f"{name}.h5").close()
    vary = {"motion.pitch.amplitude_deg": [10.0, 20.0, 30.0]}
    taichiflap.sweep(hawkmoth(*small), vary, path / "map.h5", metrics=["force_vertical_mean", "power_mean"])
    return path


@contextlib.contextmanager
def served(viewer):
    try:
        yield viewer
    finally:
        viewer.stop()


@pytest.fixture(scope="module", params=["result", "map", "live"])
def viewer(request, folder):
    """One viewer of each kind; access control is the same for all."""
    if request.param == "map":
        made = MapViewer(folder / "map.h5", port=18480)
    elif request.param == "result":
        made = Viewer([folder / "rigid.h5"], port=18480)
    else:
        begin(folder / "rigid.h5", folder / "live.h5.part")
        made = Viewer([folder / "live.h5"], port=18480)
        assert made.runs[0].live
    with served(made):
        yield made


def get(viewer, path, **headers):
    """Status and text of an answer."""
    asked = http.client.HTTPConnection("127.0.0.1", viewer.port, timeout=30)
    with contextlib.closing(asked):
        asked.putrequest("GET", path, skip_host="Host" in headers)
        for name, value in headers.items():
            asked.putheader(name, value)
        asked.endheaders()
        answer = asked.getresponse()
        body = answer.read()
        answered = dict(answer.getheaders())
    return answer.status, gzip.decompress(body).decode() if "Content-Encoding" in answered else body.decode(), answered


def page(viewer, path=None, protocol=PROTOCOL, **options):
    """A websocket as opened by a page."""
    path = viewer.door.path if path is None else path
    address = f"ws://127.0.0.1:{viewer.port}{path}"
    return connect(address, subprotocols=[protocol], max_size=None, proxy=None, **options)


def refused(viewer, *arguments, **options):
    with pytest.raises(InvalidStatus) as error, page(viewer, *arguments, **options):
        pass
    return error.value.response.status_code


def test_the_address_printed_opens_the_page_and_its_socket(viewer):
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/[\w-]{32}/", viewer.address)
    status, text, headers = get(viewer, viewer.door.path)
    assert status == 200
    assert "<title>taichiflap</title>" in text
    assert "frame-ancestors" in headers["Content-Security-Policy"]
    assert (headers["Referrer-Policy"], headers["Cache-Control"]) == ("no-referrer", "no-store")
    assert get(viewer, viewer.door.path + "?fixedDpr=1")[0] == 200  # and again, as a reload does
    with page(viewer) as socket_of_a_page:
        assert socket_of_a_page.recv(timeout=30)
    with page(viewer, origin=f"http://127.0.0.1:{viewer.port}") as socket_of_a_page:
        assert socket_of_a_page.recv(timeout=30)


@pytest.mark.parametrize("path", ["/", "/index.html", "/wrong/", "//", "/..%2f", "/%00", "/open/", "/open/guess"])
def test_without_the_token_nobody_comes_in(viewer, path):
    assert get(viewer, path)[0] == 403
    assert refused(viewer, path) == 403


def test_with_the_token_there_is_the_page_alone(viewer):
    for path in ("index.html", "../index.html", "..%2f..%2fetc/passwd"):
        assert get(viewer, viewer.door.path + path)[0] == 404


@pytest.mark.parametrize("host", ["evil.example", "evil.example:18480", "localhost.evil.example", "[", "", "10.1.2.3"])
def test_another_name_for_this_machine_is_refused(viewer, host):
    """DNS rebinding: another host's name with this machine's address."""
    assert get(viewer, viewer.door.path, Host=host)[0] == 403


def test_a_tunnel_may_end_at_another_port(viewer):
    for host in ("localhost:9999", "127.0.0.1:9999", "[::1]:9999", "LOCALHOST"):
        assert get(viewer, viewer.door.path, Host=host)[0] == 200


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "http://127.0.0.1:3000", "https://localhost", "null", "", "http://[", "file://"]
)
def test_the_page_of_another_site_is_refused(viewer, origin):
    assert refused(viewer, additional_headers={"Origin": origin}) == 403
    assert get(viewer, viewer.door.path, Origin=origin)[0] == 403


def test_an_invitation_is_good_once_and_for_a_while(viewer, monkeypatch):
    path = viewer.invitation.partition(str(viewer.port))[2]
    assert viewer.door.token not in path
    status, _, headers = get(viewer, path)
    assert (status, headers["Location"]) == (303, viewer.door.path)
    assert get(viewer, path)[0] == 403
    monkeypatch.setattr(door, "INVITATION_SECONDS", -1.0)
    assert get(viewer, viewer.invitation.partition(str(viewer.port))[2])[0] == 403


def test_no_token_if_asked_for_none(folder):
    with served(Viewer([folder / "rigid.h5"], port=18480, token=False)) as open_viewer:
        assert open_viewer.address == open_viewer.invitation == f"http://127.0.0.1:{open_viewer.port}/"
        assert get(open_viewer, "/")[0] == 200
        with page(open_viewer) as socket_of_a_page:
            assert socket_of_a_page.recv(timeout=30)
        assert get(open_viewer, "/", Host="evil.example")[0] == 403
        assert refused(open_viewer, origin="http://evil.example") == 403


def test_two_starts_have_two_tokens():
    assert Door("127.0.0.1").token != Door("127.0.0.1").token


def test_on_every_network_addresses_and_the_machines_name_are_let_in():
    asked = [f"{own_addresses()[0]}:80", "10.1.2.3", "[fe80::1]:8080", "localhost:1", socket.gethostname()]
    near, far = Door("127.0.0.1"), Door("0.0.0.0")
    named = Door("192.0.2.7")
    for host in asked:
        assert far._is_ours(door._name(host.lower()))
    assert [near._is_ours(door._name(host)) for host in asked[:4]] == [False, False, False, True]
    assert named._is_ours("192.0.2.7")
    for one in (near, far, named):
        assert not one._is_ours("evil.example")


def test_who_listens_on_every_network_is_told_its_real_address(folder):
    with served(Viewer([folder / "rigid.h5"], port=18480)) as one:
        assert one.far_addresses == []
        one.host = "0.0.0.0"
        assert one.far_addresses == [f"http://{host}:{one.port}{one.door.path}" for host in own_addresses()]
        assert not any(host.startswith("127.") or host == "0.0.0.0" for host in own_addresses())
        assert one.address.startswith(f"http://127.0.0.1:{one.port}/")
        one.host = "::1"
        assert one.address == f"http://[::1]:{one.port}{one.door.path}"


def test_a_viser_that_opens_its_port_in_another_way_does_not_start(folder, monkeypatch):
    monkeypatch.setattr(_infra.WebsockServer, "_background_worker", lambda self, ready: ready.release())
    monkeypatch.setattr(viser.ViserServer, "__init__", lambda self, *_, **__: None)
    with pytest.raises(RuntimeError, match="access cannot be controlled"):
        Viewer([folder / "rigid.h5"], port=18480)


def test_no_page_opens_a_tunnel_to_the_outside(viewer, monkeypatch):
    """No process is started and no name looked up; the audit of sockets covers connections."""
    asked = []
    events = {"subprocess.Popen", "os.fork", "os.posix_spawn", "socket.getaddrinfo", "socket.gethostbyname"}
    watching = threading.Event()
    watching.set()
    sys.addaudithook(lambda event, _: asked.append(event) if watching.is_set() and event in events else None)
    monkeypatch.setattr(viewer.server, "request_share_url", lambda *_: asked.append("request_share_url"))
    monkeypatch.setattr(_tunnel, "ViserTunnel", lambda *_: asked.append("ViserTunnel"))
    with page(viewer) as one:
        asked.clear()  # the look-up of this test's own connection
        for kind in ("ShareUrlRequest", "ShareUrlDisconnect"):
            one.send(msgspec.msgpack.encode({"type": kind}))
        say_hello(one)
        wait_for(lambda: viewer.sessions)
    watching.clear()
    assert asked == []
    assert viewer.server._share_tunnel is None
    handled = viewer.server._websock_server._incoming_handlers
    assert not {kind.__name__ for kind in handled} & {"ShareUrlRequest", "ShareUrlDisconnect"}


def test_a_message_too_long_closes_the_connection(viewer):
    with page(viewer) as one, contextlib.suppress(ConnectionClosed):
        one.send(b"x" * (door.LARGEST + 1))
        while True:
            one.recv(timeout=30)
    assert one.close_code == 1009


def test_no_more_pages_than_the_limit(viewer, monkeypatch):
    monkeypatch.setattr(door, "MOST", 3)
    with contextlib.ExitStack() as stack:
        for _ in range(3):
            stack.enter_context(page(viewer)).recv(timeout=30)
        assert refused(viewer) == 503
        assert get(viewer, viewer.door.path)[0] == 200
    wait_for(lambda: not viewer.server._websock_server._live_connections)
    with page(viewer) as one:
        one.recv(timeout=30)


def test_a_page_of_another_version_is_refused_and_not_printed(viewer, capsys):
    assert refused(viewer, protocol="viser-v0.0.0") == 400
    assert capsys.readouterr() == ("", "")


NONSENSE = [
    "text",
    b"",
    b"\xff\xff",
    b"\x91" * 100_000,
    *map(
        msgspec.msgpack.encode,
        [
            None, 7, [], {}, {"type": "Nonsense"}, {"type": 7}, {"type": ["ViewerCameraMessage"]},
            {"type": "ViewerCameraMessage"}, CAMERA | {"fov": "wide"}, CAMERA | {"fov": math.nan},
            CAMERA | {"position": [0.0, math.inf, 0.0]}, CAMERA | {"position": [0.0]}, CAMERA | {"image_height": 0},
            CAMERA | {"extra": 1}, CAMERA | {"image_width": -5}, {"type": "GuiUpdateMessage", "uuid": "x"},
            {"type": "GuiUpdateMessage", "uuid": 7, "updates": {"value": 1}},
            {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": 1, "removed": True}},
            {"type": "ScenePointerMessage", "event_type": "click", "ray_origin": None, "ray_direction": None,
             "screen_pos": [], "modifier": None},
            {"type": "ScenePointerMessage", "event_type": "click", "ray_origin": [0.0, 0.0, 0.0],
             "ray_direction": [math.nan, 1.0, 0.0], "screen_pos": [[0.5, 0.5]], "modifier": None},
            {"type": "FileTransferStartUpload", "source_component_uuid": "x", "transfer_uuid": "y",
             "filename": "z", "mime_type": "", "part_count": 2**40, "size_bytes": 2**60},
            {"type": "GetRenderResponseMessage", "payload": b"", "render_uuid": "x"},
        ],
    ),
]  # fmt: skip


def test_nonsense_is_dropped_without_a_word_and_the_page_goes_on(viewer, capfd):
    with page(viewer) as one:
        say_hello(one)
        wait_for(lambda: len(viewer.sessions) == 1)
        for message in NONSENSE:
            assert not messages.is_in_shape(message)
            one.send(message)
        one.ping().wait(30)
        assert len(viewer.sessions) == 1
    wait_for(lambda: not viewer.sessions)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf, 2**63, -(2**62), 1e300, "text", None, [], True, {}])
def test_controls_take_nothing_but_what_they_offer(folder, capfd, number):
    with served(Viewer([folder / "rigid.h5"], port=18480)) as one, page(one) as socket_of_a_page:
        say_hello(socket_of_a_page)
        wait_for(lambda: one.sessions)
        (session,) = one.sessions
        session.session.act("frame", 20.0)
        handles = session.client.gui._gui_input_handle_from_uuid
        before = {uuid: handle._impl.value for uuid, handle in handles.items()}
        assert len(handles) > 10
        for uuid in handles:
            message = {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": number}}
            socket_of_a_page.send(msgspec.msgpack.encode(message))
        socket_of_a_page.ping().wait(30)
        for uuid, handle in handles.items():
            now, props = handle._impl.value, handle._impl.props
            assert type(now) is type(before[uuid])
            if hasattr(props, "options"):
                assert now in props.options
            elif hasattr(props, "min") and props.min is not None:
                assert props.min <= now <= props.max
        assert 0 <= session.playback.frame < one.runs[0].frames
    assert capfd.readouterr().err == ""


def test_what_a_control_takes():
    slider = SimpleNamespace(min=0, max=40)
    for sent, taken in ((2**63, 40), (-5, 0), (7.4, 7), (math.nan, None), ("7", None), (True, None), (math.inf, 40)):
        assert messages.fitted(slider, 3, sent) == taken
    free = SimpleNamespace(min=None, max=None)
    assert messages.fitted(free, 1.0, math.inf) is None
    assert messages.fitted(free, 1.0, 5) == 5.0
    menu = SimpleNamespace(options=("a", "b"))
    assert [messages.fitted(menu, "a", sent) for sent in ("b", "c", 1, ["a"])] == ["b", None, None, None]
    assert [messages.fitted(free, False, sent) for sent in (True, 1, "yes")] == [True, None, None]
    assert [messages.fitted(free, "", sent) for sent in ("text", 1, "x" * 2**15)] == ["text", None, None]


def test_a_result_that_is_deleted_replaced_or_cut_is_told_in_a_sentence(folder, tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(taichiflap_viewer.watch, "GRACE_SECONDS", 0.0)
    path = tmp_path / "one.h5"
    for harm, sentence in (
        (path.unlink, "one.h5 has been deleted"),
        (lambda: os.replace(tmp_path / "two.h5", path), "one.h5 has been replaced"),
        (lambda: os.truncate(path, 5000), "one.h5 has been changed"),
    ):
        shutil.copy(folder / "rigid.h5", path)
        shutil.copy(folder / "bent.h5", tmp_path / "two.h5")
        with served(Viewer([path], port=18480)) as one, page(one) as socket_of_a_page:
            say_hello(socket_of_a_page)
            assert "data-notice" not in heard(socket_of_a_page, "data-head")
            harm()
            assert sentence in heard(socket_of_a_page, "data-notice")
            # Who comes now is told as well.
            with page(one) as another:
                say_hello(another)
                heard(another, "data-notice")
    assert capfd.readouterr().err == ""


def test_a_growing_result_that_becomes_another_is_not_mixed_with_it(folder, tmp_path):
    path = tmp_path / "live.h5.part"
    begin(folder / "rigid.h5", path)
    run = Run(taichiflap.open_result(tmp_path / "live.h5"), "live")
    assert (run.live, run.frames, run.trouble) == (True, 30, "")
    shutil.copy(folder / "bent.h5", tmp_path / "live.h5")
    path.unlink()
    assert run.refresh()
    assert "another result" in run.trouble
    assert run.frames == 30
    with pytest.raises(OSError, match="another result"):
        run.frame(3)
    run.close()


def test_a_map_that_is_deleted_cut_or_replaced_is_told_in_a_sentence(folder, tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(taichiflap_viewer.watch, "GRACE_SECONDS", 0.0)
    monkeypatch.setattr(taichiflap_viewer.maps.viewer, "LOOK_SECONDS", 0.05)
    path = tmp_path / "map.h5"
    for harm, sentence in (
        (path.unlink, "map.h5 has been deleted"),
        (lambda: os.truncate(path, 3000), "map.h5"),
        (lambda: os.replace(tmp_path / "other.h5", path), "map.h5 has been replaced"),
    ):
        shutil.copy(folder / "map.h5", path)
        shutil.copy(folder / "map.h5", tmp_path / "other.h5")
        with served(MapViewer(path, port=18480)) as one, page(one) as socket_of_a_page:
            say_hello(socket_of_a_page)
            heard(socket_of_a_page, "data-map")
            harm()
            assert sentence in heard(socket_of_a_page, "data-notice")
            (session,) = one.sessions
            session._dark_box.on_update  # noqa: B018 - it is there
            session._try(session._darken, True)
    assert capfd.readouterr().err == ""


def test_another_map_of_the_same_name_is_not_read_with_the_choices_of_the_first(folder, tmp_path):
    path = tmp_path / "map.h5"
    shutil.copy(folder / "map.h5", path)
    with served(MapViewer(path, port=18480)) as one, page(one) as socket_of_a_page:
        say_hello(socket_of_a_page)
        heard(socket_of_a_page, "data-map")
        case = hawkmoth("solver=dbet", "time.periods=1", "time.steps_per_period=40")
        path.unlink()
        taichiflap.sweep(case, {"wing.modes": [0, 1]}, path, metrics=["power_mean"])
        (session,) = one.sessions
        session._try(session._darken, True)
        assert "replaced by another map" in session._trouble.content


def test_a_notice_is_text():
    assert "<script>" not in notice("<script>")
    assert notice("") == ""


@pytest.mark.slow
def test_the_command_prints_its_token_and_no_token_does_without(folder):
    for option in ([], ["--no-token"]):
        command = [sys.executable, "-m", "taichiflap", "view", "--no-browser", "--port", "18490", *option]
        with subprocess.Popen([*command, folder / "rigid.h5"], cwd=CASES, text=True, stdout=subprocess.PIPE) as process:
            address = process.stdout.readline().split()[0]
            process.terminate()
        assert bool(re.fullmatch(r"http://127\.0\.0\.1:\d+/[\w-]{32}/", address)) == (not option)


def begin(complete, path):
    """The file of an unfinished run, made from a complete one."""
    shutil.copy(complete, path)
    with h5py.File(path, "r+") as file:
        rewrite(file, "status", "running")
        file["time"][30:] = np.nan


def say_hello(one):
    """Send the first messages of a page, and wait until the server has processed them."""
    one.send(msgspec.msgpack.encode(CAMERA))
    one.ping().wait(30)


def heard(one, word):
    """Messages to a page, up to one that contains this word."""
    end = time.monotonic() + 30.0
    while time.monotonic() < end:
        data = one.recv(timeout=30)
        size = int.from_bytes(data[8:16], "little")
        text = zstandard.decompress(data[16 : 16 + size]).decode(errors="replace")
        if word in text:
            return text
    raise AssertionError(f"never heard {word}")


def wait_for(condition):
    end = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)
