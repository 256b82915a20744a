"""The scene in a real browser: headless Chromium shows what the file holds, and the controls of the scene act."""

import io
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from browsing import (
    CHARTS,
    MARKS,
    NODE,
    PORT,
    PROPS,
    STORE,
    choose,
    floats,
    go_to,
    pixels_of,
    shows_all,
    stop,
    wait_for_frame,
    wait_until,
)
from conftest import hawkmoth
from matplotlib.image import imread
from taichiflap_viewer import Viewer
from taichiflap_viewer.colours import DARK, LIGHT, RUNS, linear, rgb

import taichiflap

pytestmark = MARKS


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


def test_a_double_click_shows_the_streak_line_of_its_point(serve, look):
    viewer = serve("uvlm")
    page = look(viewer.address, query="&frame=250&layers=streaks&points=1.5,-0.5")
    wait_for_frame(page, viewer, 250)
    page.wait_for_function(f"() => ({NODE.format('/streaks')} || {{}}).effectiveVisibility")
    page.mouse.dblclick(640, 300)
    page.wait_for_function("() => /points=1.5,-0.5,[-0-9.]+,[-0-9.]+/.test(location.search)")
    (session,) = viewer.sessions
    points = session.playback.points
    page.wait_for_function(f"count => {PROPS.format('/streaks')}.points.length === 6 * count", arg=(2 + 2) * 199)
    lines = floats(page, "/streaks").reshape(4, -1, 2, 3)
    # Each begins at its point, and goes on where it ends.
    np.testing.assert_allclose(lines[2:, 0, 0][:, [0, 2]], points, atol=1e-5)
    np.testing.assert_allclose(lines[:, 1:20, 0], lines[:, :19, 1], atol=1e-6)
    page.get_by_label("Streak lines", exact=True).click()
    page.wait_for_function(f"() => !({NODE.format('/streaks')}).effectiveVisibility")
    wait_until(page, lambda: session.playback.points == ())


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
    """Tests the private parts of viser that lock the rotation."""
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


def test_a_shorter_result_leaves_the_charts_of_the_longer_one(serve, look):
    """It has no values in the last beat, for which uPlot would find no range."""
    page = look(serve("dbet", "short").address)
    page.wait_for_function(f"() => {CHARTS}.length > 3 && {CHARTS}.every(chart => {shows_all('chart')})")


def test_a_navier_stokes_run_opens_with_its_vorticity_and_turns_to_the_wings_frame(tmp_path, look):
    settings = ("solver=navier_stokes", "fluid.viscosity=4e-4", "time.periods=1", "time.steps_per_period=400",
                "navier_stokes.cells=64", "navier_stokes.radius=4.0", "output.every=20",
                "motion.start_up_periods=1.0")  # fmt: skip
    taichiflap.simulate(hawkmoth(*settings), tmp_path / "ns.h5").close()
    viewer = Viewer([tmp_path / "ns.h5"], port=PORT)
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
