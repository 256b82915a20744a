"""The viewer's cost: server time per frame, ten browsers at once, and memory on a large file.

No browser takes part, only their connections: ten WebSocket clients that read what the server sends and drop it.
"""

import argparse
import contextlib
import os
import platform
import subprocess
import sys
import tempfile
import threading
import time
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import viser
from taichiflap_viewer import Viewer
from taichiflap_viewer.session import Session
from taichiflap_viewer.timeline import ALL
from websockets.sync.client import connect

import taichiflap
from taichiflap.runtime import available_threads
from taichiflap.writer import Writer

CASES = Path(__file__).parent.parent / "cases"
CLIENTS = 10
SECONDS = 10.0


def resident() -> float:
    """Memory of this process, MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


@contextlib.contextmanager
def browsers(viewer: Viewer, count: int) -> Iterator[None]:
    """So many browsers, in a process of their own; inside, each has its session."""
    with subprocess.Popen([sys.executable, __file__, "browse", str(viewer.port), str(count)]) as process:
        while len(viewer.sessions) < count:
            time.sleep(0.05)
        yield
        process.terminate()
    while viewer.sessions:
        time.sleep(0.05)


def browse(port: int, count: int) -> None:
    """Connect so many browsers: each says what a page says first, and reads whatever comes."""
    camera = {
        "type": "ViewerCameraMessage", "wxyz": [1.0, 0.0, 0.0, 0.0], "position": [0.0, -50.0, 0.0],
        "fov": 0.14, "near": 0.5, "far": 4000.0, "image_height": 720, "image_width": 700,
        "look_at": [0.0, 0.0, 0.0], "up_direction": [0.0, 0.0, 1.0],
    }  # fmt: skip
    protocol: Any = f"viser-v{viser.__version__}"

    def read() -> None:
        with connect(f"ws://127.0.0.1:{port}", subprotocols=[protocol], max_size=None, compression=None) as opened:
            opened.send(msgspec.msgpack.encode(camera))
            for _ in opened:
                pass

    readers = [threading.Thread(target=read) for _ in range(count)]
    for reader in readers:
        reader.start()


def frame_times(viewer: Viewer) -> np.ndarray:
    """Processor seconds that each of the last frames takes on the server, files and charts included."""
    taken = []
    with browsers(viewer, 1):
        session = viewer.sessions[0]
        session.playback.playing = False
        last = viewer.runs[0].frames - 1
        for index in range(last - 600, last):
            session.playback.position = float(index)
            began = time.thread_time()
            session.show()
            taken.append(time.thread_time() - began)
            time.sleep(0.01)
    return np.array(taken)


def crowd(viewer: Viewer) -> tuple[float, float]:
    """Share of a processor that the server of playing browsers takes, and the updates a second that each gets."""
    shown = 0
    original = Session.show

    def counted(session: Session) -> None:
        nonlocal shown
        shown += 1
        original(session)

    Session.show = counted
    with browsers(viewer, CLIENTS):
        time.sleep(2.0)
        used, first, began = time.process_time(), shown, time.perf_counter()
        time.sleep(SECONDS)
        seconds = time.perf_counter() - began
        share = (time.process_time() - used) / seconds
        rate = (shown - first) / seconds / CLIENTS
    Session.show = original
    return share, rate


def soak(viewer: Viewer, minutes: float) -> Iterator[float]:
    """Memory, MB, at the start and after each of so many minutes in which browsers play the whole run."""
    with browsers(viewer, CLIENTS):
        for number, session in enumerate(viewer.sessions):
            session.playback.loop, session.playback.speed = ALL, 1.0
            session.playback.position = number * viewer.runs[0].frames / CLIENTS
        time.sleep(30.0)
        yield resident()
        for _ in range(round(minutes)):
            time.sleep(60.0)
            yield resident()


def large(path: Path) -> float:
    """Write a result with a wake of 20,000 vortices in each of 3,000 frames; its size, GB."""
    case = taichiflap.load_case(CASES / "hawkmoth.toml").override("uvlm.wake=20000")
    small = path.with_name("small.h5")
    rng = np.random.default_rng(1)
    with taichiflap.simulate(case, small) as result:
        section = types.SimpleNamespace(
            count=1, frequency=result.modes["frequency"], damping_ratio=result.modes["damping_ratio"],
            lam=result.modes["lambda"], psi=result.modes["psi"], shape=lambda _: result.modes["shape"],
        )  # fmt: skip
        writer = Writer(case, path, [])
        sample = {name: getattr(result, name)[:0] for name in result.variables} | {"wake_count": np.empty(0)}
        writer.lay_out(result.file["node"][...], section, sample, 20_000 * result.frames)  # type: ignore[arg-type]
        for first in range(0, result.frames, 25):
            last = min(first + 25, result.frames)
            block = {name: getattr(result, name)[first:last] for name in result.variables}
            count = last - first
            block["wake_count"] = np.full(count, 20_000)
            block["wake"] = rng.normal(0.0, 0.02, (3, count * 20_000))
            block["wake_birth"] = np.tile(np.arange(20_000), count)
            writer.append(block)
        writer.finish().close()
    return path.stat().st_size / 1e9


def rows(folder: Path, minutes: float) -> Iterator[tuple[str, str, str]]:
    """Name, figure and target of every measurement; playback is watched for so many minutes, if any."""
    case = taichiflap.load_case(CASES / "hawkmoth.toml")
    path = folder / "wake.h5"
    taichiflap.simulate(case.override("uvlm.wake=2000", "uvlm.core=0.02"), path).close()
    viewer = Viewer([path])
    times = 1e3 * frame_times(viewer)
    median, late = np.percentile(times, [50, 95])
    yield "frame of 2,000 vortices, one browser", f"{median:.2f} ms, 95th percentile {late:.2f} ms", "<= 5 ms"
    viewer.stop()
    for name, settings in (("the shipped hawkmoth", []), ("2,000 vortices", ["uvlm.wake=2000", "uvlm.core=0.02"])):
        if settings:
            shown = path
        else:
            shown = folder / "shipped.h5"
            taichiflap.simulate(case, shown).close()
        viewer = Viewer([shown])
        share, rate = crowd(viewer)
        yield f"{CLIENTS} browsers, {name}", f"{share:.2f} core at {rate:.0f} updates/s each", "<= 0.25 core at 30/s"
        viewer.stop()
    if minutes:
        viewer = Viewer([path])
        held = list(soak(viewer, minutes))
        yield (
            f"{CLIENTS} browsers for {minutes:g} minutes",
            " ".join(f"{megabytes:.0f}" for megabytes in held) + " MB",
            "flat",
        )
        viewer.stop()
    began = time.perf_counter()
    Viewer([path]).stop()
    yield "open and close a small file", f"{time.perf_counter() - began:.2f} s", ""
    size = large(folder / "large.h5")
    before, began = resident(), time.perf_counter()
    Viewer([folder / "large.h5"]).stop()
    opened = time.perf_counter() - began
    viewer = Viewer([folder / "large.h5"])
    for index in np.linspace(0, viewer.runs[0].frames - 1, 400).astype(int):
        viewer.runs[0].frame(int(index))
    yield f"open and close one of {size:.2f} GB", f"{opened:.2f} s", "as a small one"
    yield "memory for 400 of its frames", f"{resident() - before:.0f} MB more", "< 300 MB"
    viewer.stop()


def main() -> None:
    if sys.argv[1:2] == ["browse"]:
        browse(int(sys.argv[2]), int(sys.argv[3]))
        return
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=0.0, help="watch memory during so many minutes of playback")
    minutes = parser.parse_args().minutes
    print(f"{platform.processor() or platform.machine()}, {available_threads()} threads, viser {viser.__version__}")
    with tempfile.TemporaryDirectory() as folder:
        for name, figure, target in rows(Path(folder), minutes):
            print(f"{name:<40}{figure:<42}{target}", flush=True)


if __name__ == "__main__":
    main()
