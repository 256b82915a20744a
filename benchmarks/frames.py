"""How many pictures a second a page draws while it plays stored Navier-Stokes frames, in a real browser."""

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path

from taichiflap_viewer import Viewer
from taichiflap_viewer.timeline import ALL, LAST_BEAT

from .chromium import MISSING, browser
from .rows import Row

SECTION = "Navier-Stokes in the browser"
SECONDS, SETTLING = 15.0, 5.0
SPEED = 1.0
"""Beats a second."""
LOOPS = {
    LAST_BEAT: "pictures of the stored vorticity that a page draws, the last beat in a loop",
    ALL: "pictures of the stored vorticity that a page draws, the whole run, each computed anew",
}
"""A page keeps the pictures of a beat, but not of a whole run."""

# Notes every picture of the flow that a turn of the page's renderer has drawn, and counts the turns.
WATCH = """
window.__flow = {turns: 0, pictures: 0, last: null};
const watch = () => {
  const scene = window.__viserMutable && window.__viserMutable.scene;
  if (!scene) { requestAnimationFrame(watch); return; }
  scene.onAfterRender = () => {
    const seen = window.__flow;
    seen.turns += 1;
    scene.traverseVisible((node) => {
      const map = node.material && node.material.map;
      if (map && map.image && map.uuid !== seen.last) { seen.last = map.uuid; seen.pictures += 1; }
    });
  };
};
watch();
"""


def rows(path: Path) -> Iterator[Row]:
    """One page that plays a result; the first seconds, in which pictures are prepared, do not count."""
    with contextlib.ExitStack() as stack:
        opened = stack.enter_context(browser())
        if opened is None:
            yield Row(SECTION, LOOPS[LAST_BEAT], None, "1/s", 20.0, True, MISSING)
            return
        viewer = Viewer([path])
        stack.callback(viewer.stop)
        page = opened.new_page(viewport={"width": 1280, "height": 720})
        page.add_init_script(WATCH)
        page.goto(viewer.address)
        page.wait_for_function("() => window.__flow.pictures > 0", timeout=60e3)
        playback, asked = viewer.sessions[0].session.playback, SPEED * viewer.runs[0].frames_per_beat
        for loop, name in LOOPS.items():
            playback.loop, playback.speed, playback.playing = loop, SPEED, True
            time.sleep(SETTLING)
            first, began = page.evaluate("() => ({...window.__flow})"), time.perf_counter()
            time.sleep(SECONDS)
            last, seconds = page.evaluate("() => ({...window.__flow})"), time.perf_counter() - began
            drawn, turns = ((last[one] - first[one]) / seconds for one in ("pictures", "turns"))
            note = f"of {asked:.0f} asked; {turns:.0f} turns of its renderer a second, without a graphics card"
            yield Row(SECTION, name, drawn, "1/s", 20.0 if loop == LAST_BEAT else None, True, note)
