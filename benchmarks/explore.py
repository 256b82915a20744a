"""Explore: from a key press on a slider to the wing's new picture in a browser, and ten browsers that drag at once."""

import contextlib
import statistics
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from taichiflap_viewer.explore.session import ExploreSession
from taichiflap_viewer.explore.viewer import Explorer

from taichiflap.case.shipped import FOLDER

from .browsers import browsers
from .chromium import MISSING, browser
from .rows import Row

SECTION = "Explore"
TARGETS = {"hawkmoth_dbet": ("DBET", 150.0), "hawkmoth": ("UVLM", 600.0)}
"""Cases, their model, and the milliseconds that a change is to take at most, five beats of it."""
PRESSES = 15
CLIENTS = 10
SECONDS, EVERY = 20.0, 0.1
"""How long the browsers drag, and how often each of them moves its slider."""

# From the key press to the first turn of the page's renderer after the wing has changed.
PRESS = """() => new Promise((done) => {
    const wing = () => window.__viserSceneTree.getState()['/wing'].message.props.points, before = wing();
    let began = null;
    addEventListener('keydown', () => { began = performance.now(); }, {capture: true, once: true});
    const look = () => {
        const now = wing();
        const moved = began !== null && now !== before && now.some((x, i) => x !== before[i]);
        if (!moved) { requestAnimationFrame(look); return; }
        requestAnimationFrame(() => done(performance.now() - began));
    };
    look();
    window.__ready = true;
})"""


def rows() -> Iterator[Row]:
    """One browser at each model, then ten of them at blade elements."""
    for name, (model, target) in TARGETS.items():
        taken, why = latency(FOLDER / f"{name}.toml")
        title = f"{model}, 5 beats, from a key press to the new picture, median"
        if taken:
            note = f"{min(taken):.0f} to {max(taken):.0f} ms"
            yield Row(SECTION, title, statistics.median(taken), "ms", target, False, note)
        else:
            yield Row(SECTION, title, None, "ms", target, False, why)
    counts, waits = crowd(FOLDER / "hawkmoth_dbet.toml")
    note = f"{min(counts)} to {max(counts)} results each in {SECONDS:g} s"
    yield Row(
        SECTION, f"{CLIENTS} browsers that drag, wait for a result, median", statistics.median(waits), "ms", note=note
    )
    yield Row(SECTION, f"{CLIENTS} browsers that drag, fewest results over most", min(counts) / max(counts), "", 0.8)


def latency(path: Path) -> tuple[list[float], str]:
    """Milliseconds of some key presses; none, and why, where there is no browser."""
    taken = []
    with contextlib.ExitStack() as stack:
        opened = stack.enter_context(browser())
        if opened is None:
            return [], MISSING
        explorer = Explorer(path)
        stack.callback(explorer.stop)
        page = opened.new_page(viewport={"width": 1280, "height": 720})
        page.goto(explorer.address)
        page.wait_for_function("() => window.__viserSceneTree && window.__viserSceneTree.getState()['/wing']")
        page.get_by_role("button", name="Pause").click()
        page.locator(".mantine-Slider-thumb").first.focus()
        for number in range(PRESSES + 1):
            page.evaluate(f"() => {{ window.__ready = false; window.__taken = ({PRESS})(); }}")
            page.wait_for_function("() => window.__ready")
            page.keyboard.press("ArrowRight")
            milliseconds = float(page.evaluate("() => window.__taken"))
            page.wait_for_timeout(300)
            if number:
                taken.append(milliseconds)
    return taken, ""


def crowd(path: Path) -> tuple[list[int], list[float]]:
    """Results that each of ten browsers gets while all drag, and the milliseconds from each wish to its result."""
    explorer = Explorer(path)
    asked: dict[int, float] = {}
    counts: dict[int, int] = {}
    waits: list[float] = []
    original = ExploreSession._arrive

    def arrive(session: ExploreSession, number: int, *answer: Any, what: str) -> None:
        original(session, number, *answer, what=what)
        if answer[0] is not None and number in asked:
            counts[id(session)] = counts.get(id(session), 0) + 1
            waits.append(1e3 * (time.perf_counter() - asked[number]))

    def drag(session: ExploreSession, seed: int) -> None:
        rng, end = np.random.default_rng(seed), time.perf_counter() + SECONDS
        while time.perf_counter() < end:
            began = time.perf_counter()
            session._change({"wing.youngs_modulus": float(rng.uniform(15e9, 40e9))}, "wing.youngs_modulus")
            asked[max(session._wishes, default=0)] = began
            time.sleep(EVERY)

    ExploreSession._arrive = arrive
    try:
        with browsers(explorer, CLIENTS):
            time.sleep(2.0)
            drags = [threading.Thread(target=drag, args=(one, seed)) for seed, one in enumerate(explorer.sessions)]
            for one in drags:
                one.start()
            for one in drags:
                one.join()
            time.sleep(1.0)
    finally:
        ExploreSession._arrive = original
        explorer.stop()
    return [counts.get(key, 0) for key in counts], waits
