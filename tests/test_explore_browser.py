"""Maps, explore and notebooks in a real browser."""

import contextlib
import functools
import http.server
import socket
import threading

import numpy as np
import pytest
from browsing import CHARTS, MARKS, NODE, PORT, PROPS, SECONDS, choose, floats, pixels_of, stop, wait_until
from conftest import CASES, hawkmoth
from taichiflap_viewer.colours import METRIC
from taichiflap_viewer.explore.viewer import Explorer
from taichiflap_viewer.maps.scene import HEIGHT, WIDTH
from taichiflap_viewer.maps.viewer import MapViewer

import taichiflap
from taichiflap.metrics.pareto import pareto_front

pytestmark = MARKS


@pytest.fixture(scope="module")
def sheet(tmp_path_factory):
    """A small map of blade elements: the file, what it varies, and the lift (mN) and power (mW) that it holds."""
    case = hawkmoth("solver=dbet", "time.periods=2", "time.steps_per_period=40", "dbet.elements=8")
    vary = {"wing.youngs_modulus": [10e9, 20e9, 40e9], "motion.pitch.amplitude_deg": [10.0, 20.0, 30.0, 40.0]}
    path = tmp_path_factory.mktemp("map") / "map.h5"
    found = taichiflap.sweep(case, vary, path, metrics=["force_vertical_mean", "power_mean"])
    return path, vary, 1e3 * found.force_vertical_mean.values, 1e3 * found.power_mean.values


@pytest.fixture
def mapped(sheet):
    """A viewer of it."""
    viewer = MapViewer(sheet[0], port=PORT)
    yield viewer
    viewer.stop()


def spot_of(page, session, across, up):
    """Position on the page of a point of a map's picture."""
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


def test_a_notebook_shows_the_viewer_or_a_picture_where_there_is_none(browser, recorded, tmp_path):
    with contextlib.ExitStack() as stack:
        viewer = stack.enter_context(stack.enter_context(taichiflap.open_result(recorded("dbet"))).view())
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
    explorer = Explorer(CASES / "hawkmoth_dbet.toml", small, threads=1, port=PORT)
    try:
        page = look(explorer.address, query="&frame=70&set=wing.thickness=5e-05")
        (session,) = explorer.sessions
        wait_until(page, lambda: session.run.case.wing.thickness == 5e-05 and session.playback.frame == 70)
        page.get_by_text("wing.thickness=5e-05").first.wait_for()
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


@contextlib.contextmanager
def served(folder):
    """The address of a folder's files."""
    handler = functools.partial(QuietHandler, directory=folder)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Serves files without log messages."""

    def log_message(self, *_):
        pass
