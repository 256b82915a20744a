"""The viewer in a real browser: headless Chromium sees what the file holds, and its controls act.

Conditions are waited for, never times. The scene that a page holds is read from viser's own store on `window`.
"""

import contextlib
import functools
import http.server
import io
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import CASES, hawkmoth
from matplotlib.image import imread
from taichiflap_viewer import Viewer
from taichiflap_viewer.colours import DARK, LIGHT, METRIC, RUNS, linear, rgb
from taichiflap_viewer.explore.viewer import Explorer
from taichiflap_viewer.maps.scene import HEIGHT, WIDTH
from taichiflap_viewer.maps.viewer import MapViewer
from test_cli import frames_in

import taichiflap
from taichiflap.metrics.pareto import pareto_front

CHROMIUM = shutil.which("chromium")
FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic"),
    *("--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"),
]
SECONDS = 40.0

pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="NO BROWSER TESTED: there is no chromium"),
    pytest.mark.slow,
]

NODE = "window.__viserSceneTree && window.__viserSceneTree.getState()['{}']"
STORE = "window.__viserSceneTree.getState()"
PROPS = f"({NODE}).message.props"
CHARTS = "Object.values(window.__viserTestpoints.uplots).map(one => one.chart)"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two beats of the hawkmoth by each model, and of one with three modes."""
    path = tmp_path_factory.mktemp("results")
    for name, settings in (("uvlm", []), ("dbet", ["solver=dbet"]), ("modes", ["wing.modes=3", "uvlm.wake=40"])):
        taichiflap.simulate(hawkmoth("time.periods=2", *settings), path / f"{name}.h5").close()
    return path


@pytest.fixture(scope="module")
def browser():
    sync = pytest.importorskip("playwright.sync_api", reason="NO BROWSER TESTED: playwright is not installed")
    with sync.sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield opened
        opened.close()


@pytest.fixture
def serve(folder):
    """Start viewers; they stop with the test."""
    with contextlib.ExitStack() as stack:

        def start(*names, port=18080):
            viewer = Viewer([folder / f"{name}.h5" for name in names], port=port)
            stack.callback(viewer.stop)
            return viewer

        yield start


@pytest.fixture
def look(browser):
    """Open pages; a page error fails the test at its end."""
    errors = []
    contexts = []

    def open_page(address, context=None, node="/wing", text="Reset view", query="", **options):
        if context is None:
            context = browser.new_context(**{"viewport": {"width": 1280, "height": 720}} | options)
            contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(1e3 * SECONDS)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("console", lambda message: message.type == "error" and errors.append(message.text))
        page.goto(f"{address}?fixedDpr=1{query}")
        page.wait_for_function(f"() => {NODE.format(node)}")
        page.get_by_text(text, exact=True).wait_for(state="attached")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert errors == []


def floats(page, name, prop="points"):
    return np.array(page.evaluate(f"() => Array.from({PROPS.format(name)}.{prop})"))


def wait_for_frame(page, viewer, index):
    """Until a page shows a frame: the time that it tells, and its wing."""
    number, part = viewer.runs[0].beat_of(index)
    text = f"beat {number}   t/T = {part:.3f}"
    page.wait_for_function(f"() => {PROPS.format('/time')}.text.startsWith({text!r})")


def go_to(page, viewer, index):
    """Type a frame into the box beside the timeline."""
    box = page.get_by_label("Frame", exact=True)
    box.fill(str(index))
    box.press("Enter")
    wait_for_frame(page, viewer, index)


def shows_all(chart):
    """In the page: whether a chart's axes take in its whole curve, and not much more."""
    times, x, y = f"{chart}.data[0]", f"{chart}.scales.x", f"{chart}.scales.y"
    curve = f"Array.from({chart}.data[1]).filter(v => !isNaN(v))"
    spread = f"Math.max(...{curve}) - Math.min(...{curve})"
    return (
        f"(Math.abs({x}.min - {times}[0]) < 1e-6 && Math.abs({x}.max - {times}.at(-1)) < 1e-6"
        f" && {y}.min <= Math.min(...{curve}) && {y}.max >= Math.max(...{curve})"
        f" && {y}.max - {y}.min < 2 * ({spread}))"
    )


def stop(page):
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="Play", exact=True).wait_for()


def choose(page, label, option):
    page.get_by_label(label, exact=True).first.click()
    page.locator("[data-combobox-option]:visible").get_by_text(option, exact=True).click()


def test_wing_and_wake_are_the_files(serve, look):
    viewer = serve("uvlm")
    page = look(viewer.address)
    stop(page)
    result, chord = viewer.runs[0].result, viewer.runs[0].chord
    for index in (400, 137, 250):
        go_to(page, viewer, index)
        wing = floats(page, "/wing").reshape(-1, 2, 3)
        nodes = result.frame("node_position", index)
        np.testing.assert_allclose(wing[:, 0, 0], nodes[:-1, 1] / chord, atol=1e-6)
        np.testing.assert_allclose(wing[:, 1, 2], -nodes[1:, 0] / chord, atol=1e-6)
        points, wake = floats(page, "/wake").reshape(-1, 3), result.wake(index)
        np.testing.assert_allclose(points[:, 0], wake["z"] / chord, atol=1e-5)
        np.testing.assert_allclose(points[:, 2], -wake["y"] / chord, atol=1e-5)
        ranges = viewer.runs[0].ranges
        colours = LIGHT.circulation.symmetric(wake["circulation"], ranges.circulation)
        np.testing.assert_array_equal(floats(page, "/wake", "colors").reshape(-1, 3), colours)
        pressure = linear(LIGHT.pressure.symmetric(result.frame("pressure_jump", index), ranges.pressure))
        np.testing.assert_array_equal(floats(page, "/wing", "colors").reshape(-1, 2, 3)[:, 0], pressure)


def test_the_canvas_has_the_colours_of_the_legend(serve, look):
    viewer = serve("uvlm")
    page = look(viewer.address)
    stop(page)
    go_to(page, viewer, 350)
    run = viewer.runs[0]
    frame = run.frame(350)
    extremes = np.array([frame.circulation.min(), frame.circulation.max()])
    for theme in (LIGHT, DARK):
        wanted = [
            *theme.circulation.symmetric(extremes, run.ranges.circulation),
            theme.pressure.symmetric(frame.pressure, run.ranges.pressure)[len(frame.pressure) // 2],
            theme.force,
        ]
        for colour in wanted:
            wait_until(page, lambda colour=colour: pixels_of(page, colour) > 4)
        page.get_by_label("Dark", exact=True).click()
    legend = page.locator("[data-legend]")
    assert "Pa" in legend.inner_text()
    assert "m²/s" in legend.inner_text()
    assert rgb(LIGHT.circulation.stops[0]) == tuple(LIGHT.circulation.table[0])


def test_the_timeline_acts(serve, look):
    viewer = serve("uvlm")
    page = look(viewer.address)
    seen = page.evaluate(f"() => {PROPS.format('/time')}.text")
    page.wait_for_function(f"text => {PROPS.format('/time')}.text !== text", arg=seen)
    stop(page)
    go_to(page, viewer, 130)
    page.get_by_role("button", name="next", exact=True).click()
    wait_for_frame(page, viewer, 200)
    page.get_by_role("button", name="previous", exact=True).click()
    wait_for_frame(page, viewer, 100)
    for key, frame in (("ArrowRight", 101), ("ArrowLeft", 100), ("Shift+ArrowRight", 110), ("Shift+ArrowLeft", 100),
                       ("End", 400), ("ArrowRight", 400), ("Home", 0)):  # fmt: skip
        page.keyboard.press(key)
        wait_for_frame(page, viewer, frame)
    page.wait_for_function("() => location.search.includes('frame=0')")
    page.locator("#tf-line").focus()
    page.keyboard.press(" ")
    page.get_by_role("button", name="Pause").wait_for()
    page.keyboard.press(" ")
    page.get_by_role("button", name="Play", exact=True).wait_for()
    line = page.locator("#tf-line").bounding_box()

    def spot(frame):
        return line["x"] + 12 + (line["width"] - 24) * frame / 400, line["y"] + 30

    page.mouse.move(*spot(120))
    page.mouse.down()
    for frame in range(120, 260, 10):
        page.mouse.move(*spot(frame))
    page.mouse.up()
    (session,) = viewer.sessions
    wait_until(page, lambda: abs(session.playback.frame - 250) <= 1)
    wait_for_frame(page, viewer, session.playback.frame)
    page.keyboard.down("Shift")
    page.mouse.move(*spot(80))
    page.mouse.down()
    page.mouse.move(*spot(160), steps=3)
    page.mouse.up()
    page.keyboard.up("Shift")
    wait_until(page, lambda: session.playback.loop == "range")
    np.testing.assert_allclose(session.playback.range, (80, 160), atol=1)
    page.get_by_label("Loop").select_option("whole run")
    page.get_by_label("Speed").select_option("2 beats a second")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function(f"() => {PROPS.format('/time')}.text.startsWith('beat 1 ')")
    stop(page)
    over = page.locator(".u-over").first.bounding_box()
    page.mouse.click(over["x"] + 0.25 * over["width"], over["y"] + 20)
    wait_until(page, lambda: abs(session.playback.frame - 250) <= 2)
    page.mouse.move(over["x"] + 0.5 * over["width"], over["y"] + 20)
    page.wait_for_function("() => document.getElementById('tf-tip').innerText.startsWith('t/T = 1.50')")


def test_a_link_leads_to_its_frame(serve, look):
    viewer = serve("dbet")
    page = look(viewer.address, query="&frame=137")
    wait_for_frame(page, viewer, 137)
    page.get_by_role("button", name="Play", exact=True).wait_for()
    page.reload()
    page.wait_for_function(f"() => {NODE.format('/time')}")
    wait_for_frame(page, viewer, 137)


def test_the_camera_saves_what_is_seen(serve, look):
    viewer = serve("uvlm")
    page = look(viewer.address)
    stop(page)
    go_to(page, viewer, 250)
    canvas, saved = page.locator("canvas").first.bounding_box(), {}
    for kind in ("PNG", "SVG"):
        with page.expect_download() as download:
            page.locator("#tf-camera").get_by_role("button", name=kind).click()
        assert download.value.suggested_filename == f"taichiflap-250.{kind.lower()}"
        saved[kind] = Path(download.value.path()).read_bytes()
    picture = imread(io.BytesIO(saved["PNG"]))
    assert picture.shape[:2] == pytest.approx((canvas["height"], canvas["width"]), abs=1)
    force = np.abs(np.round(255.0 * picture[..., :3]) - LIGHT.force).sum(axis=-1) < 8
    assert force.sum() > 4
    root = ElementTree.fromstring(saved["SVG"])
    circles = [one for one in root.iter() if one.tag.endswith("circle")]
    wake = viewer.runs[0].result.wake(250)["circulation"]
    assert len(circles) == len(wake)
    colours = LIGHT.circulation.symmetric(wake, viewer.runs[0].ranges.circulation)
    assert {one.get("fill") for one in circles} == {"#{:02x}{:02x}{:02x}".format(*one) for one in colours}
    strokes = [one.get("stroke") for one in root.iter() if one.tag.endswith("path")]
    assert strokes.count("#{:02x}{:02x}{:02x}".format(*LIGHT.force)) == 3
    assert any(one.text.startswith("beat 2") for one in root.iter() if one.tag.endswith("text"))


def test_layers_background_and_theme_act(serve, look):
    viewer = serve("uvlm")
    page = look(viewer.address)
    stop(page)
    go_to(page, viewer, 400)
    wake = f"() => {NODE.format('/wake')}.effectiveVisibility"
    page.get_by_label("Wake", exact=True).click()
    page.wait_for_function(f"() => !({wake})()")
    page.get_by_label("Wake", exact=True).click()
    page.wait_for_function(wake)
    choose(page, "Background", "vorticity")
    page.wait_for_function(f"() => {NODE.format('/field/400/picture')}")
    page.get_by_text("Flow: vorticity, 1/s").wait_for()
    page.mouse.move(640, 250)
    page.wait_for_function("() => /speed .* m.s[^]*vorticity .* 1.s/.test(document.getElementById('tf-tip').innerText)")
    choose(page, "Background", "none")
    page.wait_for_function(f"() => !({NODE.format('/field/400/picture')})")
    assert page.locator(".tabler-icon-share").count() == 0
    inks = "ink => { let seen = false; window.__viserMutable.scene.traverse(node => { if (node.material && " + (
        "node.material.fragmentShader && node.material.fragmentShader.includes(`vec4(${ink}, a)`)) seen = true; });"
        " return seen; }"
    )
    light = floats(page, "/wake", "colors")
    page.get_by_label("Dark", exact=True).click()
    page.wait_for_function("() => document.documentElement.dataset.mantineColorScheme === 'dark'")
    page.wait_for_function(f"old => Array.from({PROPS.format('/wake')}.colors).join() !== old", arg=",".join(
        str(int(value)) for value in light))  # fmt: skip
    # Guards the private way in which labels get the theme's colour.
    page.wait_for_function(inks, arg=", ".join(f"{part / 255.0:.3f}" for part in DARK.ink))


WITH_ITS_FRAME = """async count => {
    const seen = [];
    while (seen.filter(one => one[1]).length < count) {
        await new Promise(requestAnimationFrame);
        const nodes = window.__viserSceneTree.getState();
        const shown = Object.keys(nodes).filter(
            name => name.endsWith('/picture') && nodes[name].effectiveVisibility);
        seen.push([nodes['/time'].message.props.text, shown.join()]);
    }
    return seen;
}"""
"""In the page: at each of its frames, the time that the scene tells, and which pictures of the flow are visible, until
some frames have had one."""


def test_a_picture_of_the_flow_is_shown_with_its_own_frame_or_not_at_all(serve, look):
    viewer = serve("uvlm")
    page = look(viewer.address)
    choose(page, "Background", "vorticity")
    page.wait_for_function(f"() => Object.keys({STORE}).filter(name => name.endsWith('/picture')).length > 12")
    for speed in ("1/4 beat a second", "1 beat a second"):
        page.get_by_label("Speed").select_option(speed)
        seen = page.evaluate(WITH_ITS_FRAME, 12)
        frames = {}
        for text, shown in seen:
            if shown:
                index = int(shown.split("/")[2])
                number, part = viewer.runs[0].beat_of(index)
                assert text.startswith(f"beat {number}   t/T = {part:.3f}")
                frames[index] = True
        assert len(frames) > 2
    stop(page)
    for index in (203, 317):
        go_to(page, viewer, index)
        page.wait_for_function(f"() => ({NODE.format(f'/field/{index}/picture')} || {{}}).effectiveVisibility")


def test_a_theme_is_changed_while_playing_without_a_word_in_the_console(serve, look):
    viewer = serve("uvlm")
    page = look(viewer.address)
    choose(page, "Background", "speed")
    for scheme in ("dark", "light"):
        page.get_by_label("Dark", exact=True).click()
        page.wait_for_function(f"() => document.documentElement.dataset.mantineColorScheme === '{scheme}'")
    stop(page)


def test_a_narrow_window_has_its_controls_below_the_scene(serve, look):
    viewer = serve("uvlm")
    page = look(viewer.address, viewport={"width": 480, "height": 800})
    chart = page.locator(".u-over").first.bounding_box()
    assert chart["y"] + chart["height"] < page.get_by_text("Scene", exact=True).bounding_box()["y"] < 800
    button = page.get_by_role("button", name="Pause")
    sheet = """document.querySelector('[style*="position: fixed"][style*="20em"]')"""
    page.wait_for_function(f"() => {sheet} && {sheet}.getBoundingClientRect().width === 480")
    assert button.bounding_box()["y"] > 0.55 * 800


AT_REST = """async () => {
    const place = () => window.__viserMutable.camera.position.toArray();
    for (let before = place(); ; before = place()) {
        await new Promise(later => setTimeout(later, 500));
        if (place().every((x, i) => x === before[i])) return before;
    }
}"""
"""Where the camera stands once it has been fitted to the window."""


def test_the_view_pans_and_zooms_but_does_not_turn(serve, look):
    """Guards the private way in which rotation is locked."""
    viewer = serve("uvlm")
    page = look(viewer.address)
    stop(page)
    pose = "() => window.__viserMutable.camera.{}.toArray()"
    page.wait_for_function("() => window.__viserMutable.cameraControl.azimuthRotateSpeed === 0")
    before, turned = page.evaluate(AT_REST), page.evaluate(pose.format("quaternion"))
    moved = "old => Math.hypot(...window.__viserMutable.camera.position.toArray().map((x, i) => x - old[i]))"
    page.mouse.move(700, 400)
    page.mouse.down()
    page.mouse.move(800, 350, steps=4)
    page.mouse.up()
    page.wait_for_function(f"old => ({moved})(old) > 0.05", arg=before)
    page.keyboard.press("ArrowLeft")
    page.mouse.wheel(0, 200)
    zoomed = "old => Math.abs(window.__viserMutable.cameraControl.distance / old - 1) > 0.02"
    page.wait_for_function(zoomed, arg=before[0])
    np.testing.assert_allclose(page.evaluate(pose.format("quaternion")), turned, atol=1e-6)
    page.get_by_text("Reset view", exact=True).click()
    page.wait_for_function(f"old => ({moved})(old) < 1e-2", arg=before)


def test_charts_move_with_the_scene(serve, look):
    viewer = serve("modes")
    page = look(viewer.address)
    stop(page)
    for title in ("Tip deflection, mm", "Vertical force, mN", "Mechanical power, mW", "Modal amplitudes"):
        page.get_by_text(title).first.wait_for()
    go_to(page, viewer, 300)
    charts = "Object.values(window.__viserTestpoints.uplots).map(u => u.chart.data.map(d => Array.from(d)))"
    here = "d => d[0].some((x, i) => Math.abs(x - 1.5) < 1e-9 && !isNaN(d[2][i]))"
    page.wait_for_function(f"() => {charts}.filter(d => d.length === 3).every({here})")
    data = page.evaluate(f"() => {charts}.find(d => d.length === 3)")
    times, tip, dot = (np.array(values, dtype=float) for values in data)
    result = viewer.runs[0].result
    np.testing.assert_allclose(tip, 1e3 * result.tip_deflection[200:401], rtol=1e-12)
    assert times[np.flatnonzero(~np.isnan(dot))] == pytest.approx([1.5])
    choose(page, "Show", "whole run")
    page.wait_for_function(f"() => {charts}.every(d => d[0][0] === 0)")
    page.wait_for_function(f"() => {CHARTS}.every(c => {shows_all('c')})")
    choose(page, "Show", "last beat")
    page.wait_for_function(f"() => {CHARTS}.every(c => c.scales.x.min === 1 && {shows_all('c')})")


def test_the_charts_axes_have_numbers(serve, look):
    """They are missing where the page has laid a chart out before it knew its width; a theme draws all anew."""
    viewer = serve("uvlm")
    page = look(viewer.address)
    numbered = f"() => {CHARTS}.length === 4 && {CHARTS}.every(c => c.axes.every(a => (a._values || []).length > 1))"
    page.wait_for_function(numbered)
    told = "c => c.axes[0]._splits.map((x, i) => [x, Number(c.axes[0]._values[i])])"
    for places, numbers in np.array(page.evaluate(f"() => {CHARTS}.map({told})")).transpose(0, 2, 1):
        np.testing.assert_allclose(places, numbers)
        assert (places[0], places[-1]) == (1.0, 2.0)
    page.get_by_label("Dark", exact=True).click()
    page.wait_for_function("() => document.documentElement.dataset.mantineColorScheme === 'dark'")
    page.wait_for_function(numbered)
    # It is playing: a page that is sent new data meanwhile must not lose the curves from its axes.
    page.wait_for_function(f"() => {CHARTS}.length === 4 && {CHARTS}.every(c => {shows_all('c')})")
    before = page.evaluate(f"() => {CHARTS}.map(c => c.data[2].findIndex(v => !isNaN(v)))")
    page.wait_for_function(
        f"old => {CHARTS}.every((c, i) => c.data[2].findIndex(v => !isNaN(v)) !== old[i])", arg=before
    )
    assert page.evaluate(f"() => {CHARTS}.every(c => {shows_all('c')})")


def test_dbet_says_that_it_has_no_wake(serve, look):
    viewer = serve("dbet")
    page = look(viewer.address)
    stop(page)
    assert page.evaluate(f"() => !({NODE.format('/wake')})")
    assert "no wake" in page.locator("[data-legend]").inner_text()
    go_to(page, viewer, 330)
    load = floats(page, "/load").reshape(-1, 3, 2, 3)
    tips = load[:, 0, 1] - load[:, 0, 0]
    assert len(tips) == 13
    assert page.get_by_label("Wake", exact=True).is_disabled()
    for name in ("/load", "/velocity"):
        assert page.evaluate(f"() => {NODE.format(name)}.effectiveVisibility")


def test_two_results_lie_over_each_other(serve, look):
    viewer = serve("uvlm", "dbet")
    page = look(viewer.address)
    stop(page)
    go_to(page, viewer, 250)
    for name, run, colour in zip(("/wing", "/second/wing"), viewer.runs, RUNS, strict=True):
        wing = floats(page, name).reshape(-1, 2, 3)
        np.testing.assert_allclose(wing[:, 0, 0], run.result.frame("node_position", 250)[:-1, 1] / run.chord, atol=1e-6)
        np.testing.assert_array_equal(floats(page, name, "colors")[:3], linear(np.array(rgb(colour), dtype=np.uint8)))
    table = page.locator("[data-differences]").inner_text()
    for word in ("uvlm", "dbet", "Vertical force, mean", "phase", "peak"):
        assert word in table


def test_two_browsers_play_on_their_own(serve, look):
    viewer = serve("uvlm")
    first, second = look(viewer.address), look(viewer.address)
    stop(first)
    stop(second)
    go_to(first, viewer, 120)
    go_to(second, viewer, 280)
    first.get_by_label("Wake", exact=True).click()
    first.wait_for_function(f"() => !({NODE.format('/wake')}.effectiveVisibility)")
    assert second.evaluate(f"() => {NODE.format('/wake')}.effectiveVisibility")
    wait_for_frame(first, viewer, 120)


def test_a_dropped_connection_comes_back_to_its_frame(serve, look):
    viewer = serve("uvlm")
    with Wire(viewer.port) as wire:
        page = look(viewer.address.replace(str(viewer.port), str(wire.port)))
        stop(page)
        go_to(page, viewer, 222)
        page.get_by_label("Force", exact=True).click()
        page.wait_for_function(f"() => !({NODE.format('/force')}.effectiveVisibility)")
        (before,) = viewer.sessions
        wire.cut()
        wait_until(page, lambda: viewer.sessions and viewer.sessions[0] is not before)
        page.wait_for_function(f"() => {NODE.format('/wake')}")
        wait_for_frame(page, viewer, 222)
        page.get_by_role("button", name="Play", exact=True).wait_for()
        assert not page.evaluate(f"() => {NODE.format('/force')}.effectiveVisibility")


def test_simulate_shows_a_run_while_it_computes(tmp_path, look):
    """`simulate --view` as a user runs it; the page follows to the last frame of the complete file."""
    path = tmp_path / "live.h5"
    command = [sys.executable, "-m", "taichiflap", "simulate", "hawkmoth.toml", "-o", path, "--threads", "1", "--view"]
    # Long enough for a viewer to start beside it on a machine that is busy.
    settings = ["time.periods=7", "uvlm.wake=1600", "time.steps_per_period=400", "uvlm.core=0.05"]
    arguments = [part for setting in settings for part in ("--set", setting)]
    with subprocess.Popen(
        [*command, *arguments], cwd=CASES, env={**os.environ, "BROWSER": "true"}, text=True, start_new_session=True,
        stdout=subprocess.PIPE,
    ) as running:  # fmt: skip
        try:
            # Held up once its viewer is there, lest it end before the page opens.
            children = Path(f"/proc/{running.pid}/task").glob
            while not (frames_in(path) and any(task.read_text() for task in children("*/children"))):
                assert running.poll() is None
            os.kill(running.pid, signal.SIGSTOP)
            line = ""
            while "Ctrl-C" not in line:
                line = running.stdout.readline()
                assert line
            page = look(line.split()[0])
            page.locator("[data-head]").get_by_text("running").wait_for()
            os.kill(running.pid, signal.SIGCONT)
            page.wait_for_function(f"() => {PROPS.format('/time')}.text.includes('beat 7   t/T = 1.000')")
            page.wait_for_function("() => !document.querySelector('[data-head]').innerText.includes('running')")
            page.wait_for_function(f"() => {CHARTS}.every(c => c.scales.x.min === 6 && {shows_all('c')})")
            with taichiflap.open_result(path) as result:
                assert (result.status, result.frames) == ("complete", 2801)
                wake, chord = floats(page, "/wake").reshape(-1, 3), result.case.wing.chord
                np.testing.assert_allclose(wake[:, 0], result.wake(2800)["z"] / chord, atol=1e-4)
            assert running.poll() is None
        finally:
            os.killpg(running.pid, signal.SIGCONT)
            os.killpg(running.pid, signal.SIGINT)
        assert running.wait(30.0) == 0


@pytest.fixture(scope="module")
def sheet(folder):
    """A small map of blade elements: the file, what it varies, and the lift (mN) and power (mW) that it holds."""
    case = hawkmoth("solver=dbet", "time.periods=2", "time.steps_per_period=40", "dbet.elements=8")
    vary = {"wing.youngs_modulus": [10e9, 20e9, 40e9], "motion.pitch.amplitude_deg": [10.0, 20.0, 30.0, 40.0]}
    path = folder / "map.h5"
    found = taichiflap.sweep(case, vary, path, metrics=["force_vertical_mean", "power_mean"])
    return path, vary, 1e3 * found.force_vertical_mean.values, 1e3 * found.power_mean.values


@pytest.fixture
def mapped(sheet):
    """A viewer of it."""
    viewer = MapViewer(sheet[0], port=18080)
    yield viewer
    viewer.stop()


def spot_of(page, session, across, up):
    """Where on the page a place of a map's picture is."""
    seen, canvas = session.client.camera, page.locator("canvas").first.bounding_box()
    scale = canvas["height"] / (2 * np.tan(seen.fov / 2) * -seen.position[1])
    x, z = across * WIDTH - seen.look_at[0], up * HEIGHT - seen.look_at[2]
    return canvas["x"] + canvas["width"] / 2 + scale * x, canvas["y"] + canvas["height"] / 2 - scale * z


def test_a_map_tells_the_case_under_the_cursor_and_its_address_is_a_link(mapped, sheet, look):
    _, vary, lift, _ = sheet
    page = look(mapped.address, node="/map/cells", text="Across", query="&colour=power_mean&view=5,3,90")
    page.get_by_text("Mean power, mW").wait_for()
    wait_until(page, lambda: np.allclose(mapped.sessions[0].client.camera.position, (5.0, -90.0, 3.0)))
    choose(page, "Colour", "Forces: Mean vertical force (mN)")
    page.wait_for_function("() => !location.search.includes('colour') && location.search.includes('view=5,3,90')")
    page.mouse.move(*spot_of(page, mapped.sessions[0], 2.5 / 4, 0.5 / 3))
    text = f"Mean vertical force = {lift[0, 2]:.4g} mN"
    page.wait_for_function("text => document.getElementById('tf-tip').innerText.includes(text)", arg=text)
    # The metric through that cell, along either key.
    page.wait_for_function(f"() => {CHARTS}.length === 2")
    across, up = page.evaluate(f"() => {CHARTS}.map(chart => chart.data.map(one => Array.from(one)))")
    np.testing.assert_allclose(across, (vary["motion.pitch.amplitude_deg"], lift[0]))
    np.testing.assert_allclose(up, (np.array([10.0, 20.0, 40.0]), lift[:, 2]))


def test_a_click_on_a_map_computes_its_case_and_lands_among_its_sliders(mapped, sheet, look):
    path, _, lift, power = sheet
    page = look(mapped.address, node="/map/cells", text="Across")
    legend = page.locator("[data-legend]")
    for number in (lift.min(), lift.max()):
        assert f"{number:.3g}" in legend.inner_text()
    assert "Mean vertical force, mN" in legend.inner_text()
    for metric, of in ((lift.min(), 0), (lift.max(), -1)):
        assert np.count_nonzero(lift == metric) == 1
        wait_until(page, lambda of=of: pixels_of(page, METRIC.table[of], 330, 980) > 4)
    page.get_by_label("Dark", exact=True).click()
    page.wait_for_function("() => document.documentElement.dataset.mantineColorScheme === 'dark'")
    session = mapped.sessions[0]
    page.mouse.click(*spot_of(page, session, 2.5 / 4, 0.5 / 3))
    page.wait_for_function(f"() => {NODE.format('/wing')}")
    page.locator("[data-case]").get_by_text("motion.pitch.amplitude_deg = 30").wait_for()
    page.get_by_text("Plunge amplitude, mm", exact=True).wait_for()
    shown = session._case.run
    assert (shown.case.wing.youngs_modulus, shown.case.motion.pitch.amplitude_deg) == (10e9, 30.0)
    assert 1e3 * taichiflap.summarise(shown.result).force_vertical.mean == lift[0, 2]
    page.get_by_role("button", name="Back to the map").click()
    page.wait_for_function(f"() => {NODE.format('/map/cells')} && !({NODE.format('/wing')})")
    choose(page, "Across", "Power: Mean power (mW)")
    page.wait_for_function(f"() => {NODE.format('/map/points')}")
    points = floats(page, "/map/points").reshape(-1, 3)
    share = (points[:, 0] - points[:, 0].min()) / np.ptp(points[:, 0])
    np.testing.assert_allclose(share, (power.ravel() - power.min()) / np.ptp(power), atol=1e-5)
    choose(page, "Up", "Forces: Mean vertical force (mN)")
    page.wait_for_function(f"() => {NODE.format('/map/front/0')}")
    line = floats(page, "/map/front/0").reshape(-1, 2, 3)
    points = floats(page, "/map/points").reshape(-1, 3)
    front = pareto_front(power.ravel(), lift.ravel())
    np.testing.assert_allclose(line[:, 0, [0, 2]], points[front[:-1]][:, [0, 2]], atol=1e-6)
    np.testing.assert_allclose(line[-1, 1, [0, 2]], points[front[-1]][[0, 2]], atol=1e-6)
    assert "Pareto front" in legend.inner_text()
    assert [one.name[:2] for one in (path.parent / "map-cases").iterdir()] == ["2-"]


@contextlib.contextmanager
def served(folder):
    """The address of a folder's files."""
    handler = functools.partial(QuietHandler, directory=folder)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Files, and no word about it."""

    def log_message(self, *_):
        pass


def test_a_notebook_shows_the_viewer_or_a_picture_where_there_is_none(browser, folder, tmp_path):
    with contextlib.ExitStack() as stack:
        viewer = stack.enter_context(stack.enter_context(taichiflap.open_result(folder / "dbet.h5")).view())
        living = viewer._repr_html_()
        with socket.create_server(("127.0.0.1", 0)) as nobody:
            gone = living.replace(viewer.address, f"http://127.0.0.1:{nobody.getsockname()[1]}/")
        context = browser.new_context()
        page = context.new_page()
        page.set_default_timeout(1e3 * SECONDS)
        (tmp_path / "notebook.html").write_text(f"<meta charset=utf-8><body>{living}{gone}")
        page.goto(stack.enter_context(served(tmp_path)) + "/notebook.html")
        inside = []
        wait_until(page, lambda: inside.extend(one for one in page.frames if one.url == viewer.address) or inside)
        inside[0].wait_for_function(f"() => {NODE.format('/wing')}")
        page.locator("object").nth(1).get_by_text("vertical force", exact=True).wait_for()
        assert not page.locator("object").first.get_by_text("vertical force", exact=True).is_visible()
        context.close()


def test_charts_are_chosen_and_a_result_is_explored_and_come_back_to(serve, look):
    viewer = serve("dbet")
    page = look(viewer.address)
    stop(page)
    page.get_by_text("Choose charts").click()
    page.get_by_label("Vertical force", exact=True).click()
    page.wait_for_function("() => location.search.includes('charts=tip_deflection,force_normal,power')")
    page.get_by_label("Pitch angle of the undeformed chord", exact=True).click()
    page.wait_for_function("() => location.search.includes('power,pitch')")
    pitch = viewer.runs[0].result.pitch[200:401]
    page.wait_for_function(
        f"pitch => {CHARTS}.some(c => c.data[1].every((one, i) => Math.abs(one - pitch[i]) < 1e-12))",
        arg=pitch.tolist(),
    )
    page.get_by_role("button", name="Explore this case").click()
    page.get_by_text("Plunge amplitude, mm", exact=True).wait_for()
    page.get_by_role("button", name="Back to the result").click()
    page.get_by_role("button", name="Explore this case").wait_for()
    page.get_by_text("Pitch angle of the undeformed chord", exact=False).first.wait_for()


def test_a_slider_is_moved_and_the_wing_answers(look):
    small = ("time.periods=2", "time.steps_per_period=40", "dbet.elements=20")
    explorer = Explorer(CASES / "hawkmoth_dbet.toml", small, threads=1, port=18080)
    try:
        page = look(explorer.address)
        stop(page)
        (session,) = explorer.sessions
        numbers, wing = page.locator("[data-differences]").inner_text(), floats(page, "/wing")
        label = page.get_by_text("Young's modulus, GPa", exact=True)
        assert label.count() == 1
        page.locator(".mantine-Slider-thumb").first.focus()
        for _ in range(3):
            page.keyboard.press("ArrowRight")
        page.wait_for_function("old => document.querySelector('[data-differences]').innerText !== old", arg=numbers)
        page.wait_for_function(
            f"old => {{ const now = Array.from({PROPS.format('/wing')}.points);"
            " return now.length !== old.length || now.some((x, i) => x !== old[i]); }",
            arg=wing.tolist(),
        )
        wait_until(page, lambda: session.run.case == session.case.resolved())
        assert session.case.wing.youngs_modulus > 24.5e9
        # The pinned wing stays where it was.
        ghost = floats(page, "/pinned/wing").reshape(-1, 2, 3)
        frame = explorer.run.frame(explorer.run.index_at(session.run.turns(session.playback.frame)))
        np.testing.assert_allclose(ghost[:, 0, 0], frame.nodes[:-1, 0], atol=1e-6)
        box = page.locator(".mantine-TextInput-input").last
        box.fill("added mass")
        page.get_by_text("Added mass", exact=True).wait_for()
        with page.expect_download() as saved:
            page.get_by_role("button", name="Save case").click()
        assert taichiflap.load_case(saved.value.path()).wing == session.case.wing
        with page.expect_download() as kept:
            page.get_by_role("button", name="Keep result").click()
        with taichiflap.open_result(kept.value.path()) as result:
            assert result.case.wing == session.case.wing
    finally:
        explorer.stop()


def pixels_of(page, colour, left=500, right=980):
    """Number of pixels of the scene, no legend in it, of a colour that nobody could tell from this one."""
    clip = {"x": left, "y": 0, "width": right - left, "height": 720}
    picture = np.round(255.0 * imread(io.BytesIO(page.screenshot(clip=clip)))[..., :3])
    return int(np.sum(np.abs(picture - colour).sum(axis=-1) < 8))


def wait_until(page, condition):
    """Poll the server's side while the page goes on."""
    for _ in range(int(SECONDS / 0.05)):
        if condition():
            return
        page.wait_for_timeout(50)
    raise AssertionError("waited in vain")


class Wire:
    """A connection to the viewer that can be cut: a forwarder of bytes."""

    def __init__(self, target):
        self.target = target
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.ends = []
        self.thread = threading.Thread(target=self._accept, daemon=True)
        self.thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.listener.shutdown(socket.SHUT_RDWR)
        self.thread.join()
        self.listener.close()
        self.cut()

    def cut(self):
        for end in self.ends:
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            end.close()
        self.ends.clear()

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                near, _ = self.listener.accept()
                far = socket.create_connection(("127.0.0.1", self.target))
                self.ends += [near, far]
                for source, sink in ((near, far), (far, near)):
                    threading.Thread(target=self._pump, args=(source, sink), daemon=True).start()

    @staticmethod
    def _pump(source, sink):
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                sink.sendall(data)
        with contextlib.suppress(OSError):
            sink.shutdown(socket.SHUT_RDWR)


def test_a_navier_stokes_run_opens_with_its_vorticity_and_turns_to_the_wings_frame(tmp_path, look):
    settings = ("solver=navier_stokes", "fluid.viscosity=4e-4", "time.periods=1", "time.steps_per_period=400",
                "navier_stokes.cells=64", "navier_stokes.radius=4.0", "output.every=20",
                "motion.start_up_periods=1.0")  # fmt: skip
    taichiflap.simulate(hawkmoth(*settings), tmp_path / "ns.h5").close()
    viewer = Viewer([tmp_path / "ns.h5"], port=18190)
    try:
        page = look(viewer.address)
        stop(page)
        page.get_by_text("Flow: vorticity, 1/s").wait_for()
        page.wait_for_function(f"() => Object.keys({STORE}).some(name => name.endsWith('/picture'))")
        run = viewer.runs[0]
        page.get_by_label("Wing's frame", exact=True).click()
        chord = run.frame(0).from_wing.chord
        page.wait_for_function(
            f"([x]) => Math.abs({PROPS.format('/wing')}.points[0] - x) < 1e-3", arg=[float(chord[0, 0])]
        )
        page.get_by_label("Streamlines", exact=True).click()
        page.wait_for_function(f"() => Object.keys({STORE}).some(name => name.endsWith('/picture'))")
        choose(page, "Background", "speed")
        page.get_by_text("Flow: speed, m/s").wait_for()
    finally:
        viewer.stop()
