"""`make bench-view`: the first picture, Navier-Stokes' pictures, explore, a large file, and ten browsers at once."""

import argparse
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import viser
from taichiflap_viewer import Viewer
from taichiflap_viewer.session import Session
from taichiflap_viewer.timeline import ALL

import taichiflap

from . import explore, frames, large, machine, picture
from .__main__ import printed
from .browsers import browsers
from .rows import Row
from .runs import hawkmoth, hawkmoth_ns

SERVER, FILES = "The server", "A large file"
PARTS = ("picture", "frames", "explore", "files", "server")
CLIENTS = 10
SECONDS = 10.0


def frame_times(viewer: Viewer) -> np.ndarray:
    """Processor seconds that each of the last frames takes on the server, files and charts included."""
    taken = []
    with browsers(viewer, 1):
        session = viewer.sessions[0].session
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
        yield large.resident()
        for _ in range(round(minutes)):
            time.sleep(60.0)
            yield large.resident()


def server(shipped: Path, many: Path, minutes: float) -> Iterator[Row]:
    """What browsers cost the server; playback is watched for so many minutes, if any."""
    viewer = Viewer([many])
    times = 1e3 * frame_times(viewer)
    viewer.stop()
    note = f"median {np.median(times):.2f} ms"
    yield Row(SERVER, "2,000 vortices, one frame, 95th percentile", np.percentile(times, 95), "ms", 5.0, False, note)
    for name, path in (("the shipped hawkmoth", shipped), ("2,000 vortices", many)):
        viewer = Viewer([path])
        shares, rates = zip(*(crowd(viewer) for _ in range(3)), strict=True)
        viewer.stop()
        note = f"at {min(rates):.1f} updates/s each; {min(shares):.2f} to {max(shares):.2f}"
        yield Row(SERVER, f"{CLIENTS} browsers, {name}", statistics.median(shares), "core", 0.25, False, note)
    if minutes:
        viewer = Viewer([many])
        held = list(soak(viewer, minutes))
        viewer.stop()
        note = " ".join(f"{megabytes:.0f}" for megabytes in held) + " MB"
        yield Row(SERVER, f"{CLIENTS} browsers for {minutes:g} minutes, growth", held[-1] - held[0], "MB", note=note)


def files(small: Path, big: Path) -> Iterator[Row]:
    """A large file against a small one."""
    size = large.write(big)
    cost = large.measure(small, big)
    yield Row(
        FILES,
        f"open one of {size:.2f} GB",
        cost["large"],
        "s",
        note=f"one of {small.stat().st_size / 1e6:.0f} MB: {cost['small']:.2f} s",
    )
    yield Row(FILES, f"memory for {large.LOOKS} of its frames, at most", cost["growth"], "MB", 300.0, False)


def main() -> None:
    """Rows are printed as they are measured."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=0.0, help="watch memory during so many minutes of playback")
    parser.add_argument("--only", choices=PARTS, nargs="+", default=PARTS, help="measure these parts alone")
    arguments = parser.parse_args()
    for name, value in (machine.describe() | {"viser": viser.__version__}).items():
        print(f"{name:<22}{value}")
    with tempfile.TemporaryDirectory() as folder:
        shipped, many, viscous = (Path(folder, name) for name in ("shipped.h5", "many.h5", "viscous.h5"))
        many_vortices = hawkmoth("uvlm.wake=2000", "uvlm.core=0.02")
        for case, path in ((hawkmoth(), shipped), (many_vortices, many), (hawkmoth_ns(), viscous)):
            taichiflap.simulate(case, path).close()
        parts: dict[str, Callable[[], Iterator[Row]]] = {
            "picture": lambda: picture.rows(shipped),
            "frames": lambda: frames.rows(viscous),
            "explore": explore.rows,
            "files": lambda: files(shipped, Path(folder, "large.h5")),
            "server": lambda: server(shipped, many, arguments.minutes),
        }
        for name in arguments.only:
            printed(parts[name]())


if __name__ == "__main__":
    main()
