"""Long work: `make endurance` prints the memory, and the sum of all circulation.

    python tests/endurance.py [march | study | viewer [MINUTES]]

A thousand beats of the hawkmoth, ten thousand cases in one process, and ten browsers that come and go for half an hour.
Each part is a process of its own. Exit code 1 when something grew, drifted or failed.
"""

import contextlib
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import msgspec
import numpy as np
import psutil
import viser
from conftest import hawkmoth
from test_viewer import CAMERA
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

import taichiflap
from taichiflap import fluids
from taichiflap.fluids.uvlm import wake
from taichiflap.fluids.uvlm.lattice import TOTAL
from taichiflap.kernels.runtime import view
from taichiflap.march.march import March

DRIFT = 1e-10
"""Of Kelvin's sum, as a share of the largest bound circulation."""
GROWTH = 0.02
"""Of the memory, once it has settled."""
BEATS, CASES_IN_ONE, BROWSERS = 1000, 10_000, 10


def memory(process=None):
    """Resident memory, MB."""
    return (process or psutil.Process()).memory_info().rss / 1e6


def march(*settings):
    """A thousand beats, one block per beat: the sum of all circulation stays zero, and memory does not grow."""
    case = hawkmoth(f"time.periods={BEATS}", "output.every=200", *settings)
    marched = March([case], fluids.load("uvlm"))
    vortices, flow = marched.groups["wake"], marched.groups["flow"]
    drift = largest = settled = 0.0
    began = time.monotonic()
    for beat in range(BEATS):
        marched.advance(case.steps // BEATS)
        held = int(view(vortices.ring)[0, wake.COUNT])
        bound = view(flow.scalar)[0, TOTAL]
        shed = view(vortices.vortex)[0, 2, :held].sum() + view(vortices.scalar)[0, wake.DROPPED]
        drift, largest = max(drift, abs(shed + bound)), max(largest, abs(bound))
        if beat == BEATS // 10:
            settled = memory()
    failed = marched.failures()[0]
    print(
        f"{BEATS} beats ({', '.join(settings) or 'as shipped'}): Kelvin's sum {drift / largest:.1e} of the largest "
        f"circulation, {settled:.1f} MB after {BEATS // 10} beats, {memory():.1f} MB at the end, "
        f"{time.monotonic() - began:.0f} s{'' if failed < 0 else f', FAILED at step {failed}'}",
        flush=True,
    )
    return failed < 0 and drift < DRIFT * largest and memory() < (1.0 + GROWTH) * settled


def study():
    """Ten thousand cases of a sweep in one process."""
    settled, began = [], time.monotonic()

    def look(done, *_):
        if done > CASES_IN_ONE / 10:
            settled.append(memory())

    case = hawkmoth("solver=dbet", "time.periods=2")
    with tempfile.TemporaryDirectory() as folder:
        vary = {"fluid.density": f"1:2:{CASES_IN_ONE}"}
        found = taichiflap.sweep(case, vary, Path(folder) / "map.h5", metrics=["power_mean"], progress=look)
    complete = int((found.status == 1).sum())
    parts = [max(part) for part in np.array_split(settled, 5)]
    print(
        f"{complete} cases in one process: after the first tenth at most "
        f"{', '.join(f'{one:.1f}' for one in parts)} MB in each fifth, {time.monotonic() - began:.0f} s",
        flush=True,
    )
    return complete == CASES_IN_ONE and parts[4] < (1.0 + GROWTH) * parts[1]


def browse(port, until, rng, trouble):
    """A browser that connects for some seconds, disconnects, and reconnects."""
    while time.monotonic() < until:
        leave = min(until, time.monotonic() + rng.uniform(1.0, 20.0))
        try:
            protocol = f"viser-v{viser.__version__}"
            with connect(f"ws://127.0.0.1:{port}", subprotocols=[protocol], max_size=None) as page:
                page.send(msgspec.msgpack.encode(CAMERA))
                while time.monotonic() < leave:
                    with contextlib.suppress(TimeoutError):
                        page.recv(timeout=1.0)
        except (OSError, WebSocketException) as error:
            trouble.append(repr(error))
        time.sleep(rng.uniform(0.0, 2.0))


def viewer(minutes=30.0):
    """Ten browsers connect and disconnect: the viewer's memory does not grow, and there are no errors."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.h5"
        taichiflap.simulate(hawkmoth(), path).close()
        command = [sys.executable, "-m", "taichiflap", "view", "--no-browser", "--port", "18080", str(path)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            said = ""
            while "http" not in said:
                said = process.stdout.readline()
            port = int(said.split()[0].rpartition(":")[2])
            until, trouble = time.monotonic() + 60.0 * minutes, []
            crowd = [
                threading.Thread(target=browse, args=(port, until, random.Random(i), trouble)) for i in range(BROWSERS)
            ]
            for one in crowd:
                one.start()
            seen = []
            while time.monotonic() < until:
                time.sleep(60.0 * minutes / 100)
                seen.append(memory(psutil.Process(process.pid)))
            for one in crowd:
                one.join()
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=60)
    quarters = [float(np.mean(part)) for part in np.array_split(seen, 4)]
    print(
        f"{BROWSERS} browsers that came and went for {minutes:g} minutes: mean memory in each quarter "
        f"{', '.join(f'{one:.1f}' for one in quarters)} MB; {len(trouble)} broken connections {trouble[:3]}; "
        f"stderr {said.strip()[-500:]!r}",
        flush=True,
    )
    return not trouble and not said.strip() and quarters[3] < (1.0 + GROWTH) * quarters[1]


PARTS = {
    "march": lambda: all([march(), march("uvlm.old_wake=absorb", "uvlm.wake=600")]),
    "study": study,
    "viewer": lambda minutes=30.0: viewer(float(minutes)),
}

if __name__ == "__main__":
    if sys.argv[1:]:
        sys.exit(not PARTS[sys.argv[1]](*sys.argv[2:]))
    sys.exit(max([subprocess.run([sys.executable, __file__, part], check=False).returncode for part in PARTS]))
