"""The offline page of a result: its numbers, its safety, and playback in a real browser without a network."""

import base64
import getpass
import json
import re
import shutil
import socket
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES, hawkmoth

import taichiflap
from taichiflap.drawing import palette, scene
from taichiflap.errors import UserError
from taichiflap.export import page as player
from taichiflap.export.formats import export

pytestmark = pytest.mark.slow

CHROMIUM = shutil.which("chromium")
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip
TITLE = '<b>"$title" & </script>'


@pytest.fixture(scope="module")
def lattice(tmp_path_factory):
    """A UVLM result in a file, with a title that contains HTML."""
    case = hawkmoth("time.periods=3", "time.steps_per_period=100", "uvlm.panels=20", f"title='{TITLE}'")
    return taichiflap.simulate(case, tmp_path_factory.mktemp("pages") / "lattice.h5")


@pytest.fixture(scope="module")
def blades(tmp_path_factory):
    """A result of DBET, in a file."""
    case = taichiflap.load_case(CASES / "hawkmoth_dbet.toml", ("time.periods=2",))
    return taichiflap.simulate(case, tmp_path_factory.mktemp("pages") / "blades.h5")


def embedded(path):
    """The data that a page carries."""
    return json.loads(re.search(r'id="data">(.*?)</script>', path.read_text(), re.DOTALL)[1])


def unpacked(packed):
    """Numbers of a page, and their quantisation error."""
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


def test_in_a_stream_a_page_tells_the_lift(tmp_path):
    result = taichiflap.simulate(hawkmoth("solver=dbet", "time.periods=2", "fluid.velocity=[3.0, 0.0]"))
    data = embedded(export(result, "html", tmp_path / "a.html", beats=1))
    assert data["lift_name"] == "lift"
    lift, error = unpacked(data["lift"])
    np.testing.assert_allclose(lift, result.lift[scene.last_beats(result)[:-1]][::2], atol=error)


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
    with pytest.raises(UserError, match="exceeds the limit of 10 MB"):
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
    """Wait for a condition on the page, evaluated from outside, since the page forbids evaluation of strings."""
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
    np.testing.assert_array_equal(np.array(ends)[:, :3], palette.table(theme.anchors)[[0, -1]])
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
    line = page.locator("#line").bounding_box()
    spot = lambda frame: (line["x"] + 12 + (line["width"] - 24) * frame / 199, line["y"] + 30)  # noqa: E731
    page.mouse.click(*spot(150))
    assert page.inner_text("#clock") == "beat 3, t/T = 0.50"
    assert page.evaluate("stage.toDataURL()") != before
    index = int(scene.last_beats(lattice, 2)[150])
    assert f"tip {1e3 * lattice.tip_deflection[index]:.2f} mm".replace("-", "−") in page.inner_text("#readout")
    page.click("#forth")
    assert page.evaluate("Math.floor(now)") == 151
    # Reversals of the plunge cos 2 pi t: twice a beat; and the keys of the viewer's timeline.
    assert page.evaluate("run.reversals") == [0, 50, 100, 150]
    page.click("#previous")
    assert page.evaluate("Math.floor(now)") == 150
    for key, frame in (("ArrowRight", 151), ("Shift+ArrowLeft", 141), ("PageUp", 41), ("End", 199), ("Home", 0)):
        page.keyboard.press(key)
        assert page.evaluate("Math.floor(now)") == frame
    page.keyboard.down("Shift")
    page.mouse.move(*spot(40))
    page.mouse.down()
    page.mouse.move(*spot(90), steps=3)
    page.mouse.up()
    page.keyboard.up("Shift")
    assert page.input_value("#loop") == "range"
    np.testing.assert_allclose(page.evaluate("loop"), (40, 90), atol=1)
    page.keyboard.press(" ")
    wait_until(page, "playing && now > 45 && now < 91")
    page.keyboard.press(" ")
    page.select_option("#loop", "all")
    page.mouse.click(*spot(150))
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
    assert "the model has no wake" in page.inner_text("header")
    assert not page.is_visible("#legend")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
