"""How long a page takes to its first picture of wing and wake, in a browser that has never been there."""

import contextlib
import io
import statistics
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import viser
from taichiflap_viewer import Viewer

from .chromium import MISSING, browser
from .rows import Row

SECTION = "The first picture"
TIMES = 7

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
    name = "from the start of the navigation to wing and wake"
    with contextlib.ExitStack() as stack:
        opened = stack.enter_context(browser())
        if opened is None:
            yield Row(SECTION, name, None, "s", 2.0, False, MISSING)
            return
        viewer = Viewer([path])
        stack.callback(viewer.stop)
        with contextlib.redirect_stdout(io.StringIO()):
            bare = viser.ViserServer(host="127.0.0.1", port=viewer.port + 1, verbose=False)
        stack.callback(bare.stop)
        line, colour = np.array([[[0, 0, 0], [1, 0, 0]]], dtype=np.float32), (0, 0, 0)
        bare.scene.add_line_segments("/line", line, colour)
        bare.scene.add_point_cloud("/points", line[0], colour)
        addresses = {"ours": viewer.address, "bare": f"http://127.0.0.1:{bare.get_port()}"}
        taken: dict[str, list[float]] = {one: [] for one in addresses}
        for _ in range(TIMES + 1):
            for one, address in addresses.items():
                taken[one].append(_seconds(opened, address))
    ours, alone = (statistics.median(seconds[1:]) for seconds in taken.values())
    note = f"of these, {alone:.2f} s for a page of viser that draws one line and two points"
    yield Row(SECTION, name, ours, "s", 2.0, False, note)


def _seconds(opened: Any, address: str) -> float:
    context = opened.new_context(viewport={"width": 1280, "height": 720})
    context.add_init_script(WATCH)
    page = context.new_page()
    page.goto(address)
    page.wait_for_function("() => window.__drawn.lines && window.__drawn.points", timeout=60e3)
    seconds = page.evaluate("() => Math.max(window.__drawn.lines, window.__drawn.points)") / 1e3
    context.close()
    return float(seconds)
