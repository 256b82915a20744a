"""Timeline, charts and connections in a real browser: every page goes its own way through a run."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from browsing import CHARTS, MARKS, NODE, PROPS, choose, floats, go_to, shows_all, stop, wait_for_frame, wait_until
from conftest import CASES
from test_cli import frames_in

import taichiflap

pytestmark = MARKS


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
    """They would be missing if the page laid out a chart before its width was known; a theme redraws all."""
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
