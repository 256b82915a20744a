"""How long a page takes to its first picture of wing and wake, in a browser that has never been there."""

import contextlib
import io
import shutil
import statistics
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import viser
from taichiflap_viewer import Viewer

from .rows import Row

SECTION = "The first picture"
TIMES = 7
FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic"),
    *("--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"),
]

# Looks at what every turn of the page's renderer has drawn; `performance.now` counts from the navigation's start.
WATCH = """
window.__drawn = {};
const drawn = (name) => { window.__drawn[name] ??= performance.now(); };
const watch = () => {
  const scene = window.__viserMutable && window.__viserMutable.scene;
  if (!scene) { requestAnimationFrame(watch); return; }
  scene.onAfterRender = () => {
    drawn('scene');
    scene.traverse((node) => {
      if (node.geometry && node.geometry.isLineSegmentsGeometry && node.visible) drawn('lines');
      if (node.isPoints && node.visible) drawn('points');
    });
  };
};
watch();
"""


def rows(path: Path) -> Iterator[Row]:
    """A page of the viewer beside one of viser with a line and some points, by turns; the first turn does not count."""
    chromium = shutil.which("chromium")
    try:
        from playwright.sync_api import sync_playwright  # noqa: PLC0415 - not everyone has it
    except ImportError:
        chromium = None
    name = "from the start of the navigation to wing and wake"
    if chromium is None:
        yield Row(SECTION, name, None, "s", 2.0, False, "there is no chromium, or no playwright")
        return
    with contextlib.ExitStack() as stack:
        viewer = Viewer([path])
        stack.callback(viewer.stop)
        with contextlib.redirect_stdout(io.StringIO()):
            bare = viser.ViserServer(host="127.0.0.1", port=viewer.port + 1, verbose=False)
        stack.callback(bare.stop)
        line, colour = np.array([[[0, 0, 0], [1, 0, 0]]], dtype=np.float32), (0, 0, 0)
        bare.scene.add_line_segments("/line", line, colour)
        bare.scene.add_point_cloud("/points", line[0], colour)
        browser = stack.enter_context(sync_playwright()).chromium.launch(executable_path=chromium, args=FLAGS)
        addresses = {"ours": viewer.address, "bare": f"http://127.0.0.1:{bare.get_port()}"}
        taken: dict[str, list[float]] = {one: [] for one in addresses}
        for _ in range(TIMES + 1):
            for one, address in addresses.items():
                taken[one].append(_seconds(browser, address))
        browser.close()
    ours, alone = (statistics.median(seconds[1:]) for seconds in taken.values())
    note = f"of these, {alone:.2f} s for a page of viser that draws one line and two points"
    yield Row(SECTION, name, ours, "s", 2.0, False, note)


def _seconds(browser: Any, address: str) -> float:
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    context.add_init_script(WATCH)
    page = context.new_page()
    page.goto(address)
    page.wait_for_function("() => window.__drawn.lines && window.__drawn.points", timeout=60e3)
    seconds = page.evaluate("() => Math.max(window.__drawn.lines, window.__drawn.points)") / 1e3
    context.close()
    return float(seconds)
