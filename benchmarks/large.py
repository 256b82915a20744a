"""A result of a gigabyte: the cost of opening and viewing it compared with a small one, in a separate process."""

import json
import os
import subprocess
import sys
import time
import types
from pathlib import Path

import numpy as np
from taichiflap_viewer import Viewer

import taichiflap
from taichiflap.fluids.interface import WAKE
from taichiflap.results.layout import Contents
from taichiflap.results.writer import Writer

from .browsers import browsers
from .runs import hawkmoth

VORTICES = 22_000
LOOKS = 400


def resident() -> float:
    """Memory of this process, MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def write(path: Path) -> float:
    """Write 15 beats of the hawkmoth with a made-up wake of so many vortices in each frame; its size, GB."""
    case = hawkmoth(f"uvlm.wake={VORTICES}")
    rng = np.random.default_rng(1)
    with taichiflap.simulate(case) as result:
        section = types.SimpleNamespace(
            count=1, frequency=result.modes["frequency"], damping_ratio=result.modes["damping_ratio"],
            lam=result.modes["lambda"], psi=result.modes["psi"], shape=lambda _: result.modes["shape"],
        )  # fmt: skip
        writer = Writer(case, path, [])
        sample = {name: getattr(result, name)[:0] for name in result.variables}
        contents = Contents({one.name: one.variable for one in WAKE}, {}, {"vortex": VORTICES * result.frames})
        writer.lay_out(result.file["node"][...], section, sample, contents)  # type: ignore[arg-type]
        for first in range(0, result.frames, 25):
            last = min(first + 25, result.frames)
            block = {name: getattr(result, name)[first:last] for name in result.variables}
            count = last - first
            block["wake/count"] = np.full(count, VORTICES)
            made = rng.normal(0.0, 0.02, (3, count * VORTICES))
            block |= {f"wake/{name}": row for name, row in zip(("y", "z", "circulation"), made, strict=True)}
            block["wake/birth"] = np.tile(np.arange(VORTICES), count)
            writer.append(block)
        writer.finish().close()
    return path.stat().st_size / 1e9


def measure(small: Path, big: Path) -> dict[str, float]:
    """Seconds to open each, and MB that the memory grows by when many frames of the large one are looked at."""
    command = [sys.executable, "-m", __spec__.name, str(small), str(big)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def _look(small: Path, big: Path) -> dict[str, float]:
    # The first one pays for the imports.
    Viewer([small]).stop()
    seconds = {}
    for name, path in (("small", small), ("large", big)):
        before, began = resident(), time.perf_counter()
        viewer = Viewer([path])
        seconds[name] = time.perf_counter() - began
        most = before
        with browsers(viewer, 1):
            session = viewer.sessions[0].session
            session.playback.playing = False
            for index in np.linspace(0, viewer.runs[0].frames - 1, LOOKS).astype(int):
                session.playback.position = float(index)
                session.show()
                most = max(most, resident())
        viewer.stop()
    return {**seconds, "growth": most - before}


if __name__ == "__main__":
    print(json.dumps(_look(*map(Path, sys.argv[1:]))))
