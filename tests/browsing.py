"""What tests of the viewer in a real browser share: how they read a page and act on it.

Conditions are waited for, never times. The scene that a page holds is read from viser's own store on `window`.
"""

import io
import os
import shutil

import numpy as np
import pytest
from matplotlib.image import imread

CHROMIUM = shutil.which("chromium")
FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic"),
    *("--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"),
]
SECONDS = 40.0
PORT = 18080 + 100 * int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
"""Where a search for a free port begins, in each worker elsewhere."""

MARKS = [
    pytest.mark.skipif(CHROMIUM is None, reason="NO BROWSER TESTED: there is no chromium"),
    pytest.mark.slow,
]

NODE = "window.__viserSceneTree && window.__viserSceneTree.getState()['{}']"
STORE = "window.__viserSceneTree.getState()"
PROPS = f"({NODE}).message.props"
CHARTS = "Object.values(window.__viserTestpoints.uplots).map(one => one.chart)"


def floats(page, name, prop="points"):
    return np.array(page.evaluate(f"() => Array.from({PROPS.format(name)}.{prop})"))


def wait_for_frame(page, viewer, index):
    """Wait until a page shows a frame: its time and its wing."""
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
    """Whether a chart's axes in the page fit its curve."""
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


def pixels_of(page, colour, left=500, right=980):
    """Number of pixels of the scene, without its legend, of nearly this colour."""
    clip = {"x": left, "y": 0, "width": right - left, "height": 720}
    picture = np.round(255.0 * imread(io.BytesIO(page.screenshot(clip=clip)))[..., :3])
    return int(np.sum(np.abs(picture - colour).sum(axis=-1) < 8))


def wait_until(page, condition):
    """Poll the server until a condition holds, while the page runs."""
    for _ in range(int(SECONDS / 0.05)):
        if condition():
            return
        page.wait_for_timeout(50)
    raise AssertionError("waited in vain")
