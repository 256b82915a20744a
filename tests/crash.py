"""SIGKILL at random moments of runs and exports: `make crash-test` prints what became of the files.

After every kill each file must open with plain h5py, a resumed run must equal the uninterrupted one in every bit, and
an export must be whole or absent.
"""

import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py

ROOT = Path(__file__).parent.parent
SETTINGS = ("uvlm.panels=20", "uvlm.wake=300", "time.periods=40", "output.every=2")
FORMATS = ("csv", "vtkhdf", "html")

RUN = """
import sys
from taichiflap import checkpoint, load_case, run, simulate
run.BLOCK_STEPS, checkpoint.SECONDS = 150, 0.0
print("begun", flush=True)
simulate(load_case(sys.argv[1], sys.argv[3:]), sys.argv[2], resume=True).close()
"""
EXPORT = """
import sys
from pathlib import Path
from taichiflap import open_result
from taichiflap.export import export
print("begun", flush=True)
for kind in sys.argv[3:]:
    export(open_result(sys.argv[1]), kind, Path(sys.argv[2], "export." + kind), overwrite=True)
"""


def start(script, *arguments):
    """A process of its own, up to where its work begins."""
    command = [sys.executable, "-c", script, *map(str, arguments)]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begun\n"
    return process


def completes(script, *arguments):
    """Let the work end by itself; the seconds that it took."""
    began = time.perf_counter()
    with start(script, *arguments) as process:
        process.wait()
    assert process.returncode == 0
    return time.perf_counter() - began


def killed(script, arguments, delay):
    """Whether the work was still going on after `delay` seconds, when it was killed."""
    with start(script, *arguments) as process:
        time.sleep(delay)
        process.kill()
    return process.returncode == -9


def arrays(path):
    """Every array of an HDF5 file, as bytes, by plain h5py."""
    found = {}
    with h5py.File(path, "r") as file:

        def visit(name, item):
            if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu":
                found[name] = item[...].tobytes()

        file.visititems(visit)
    return found


def crash_runs(kills, rng, folder):
    """Kill one run again and again at random moments, each time resumed, until `kills` kills have hit."""
    case = ROOT / "cases" / "hawkmoth.toml"
    whole = folder / "whole.h5"
    completes(RUN, case, whole, *SETTINGS)
    seconds = completes(RUN, case, folder / "timed.h5", *SETTINGS)
    expected, hits, runs = arrays(whole), 0, 0
    path = folder / "run.h5"
    while hits < kills:
        hits += killed(RUN, (case, path, *SETTINGS), rng.uniform(0.0, 0.7 * seconds))
        for left in (path, path.with_name("run.h5.part")):
            if left.exists():
                assert len(arrays(left)) == len(expected), left
        if rng.random() < 0.3 and hits < kills and not path.exists():
            continue  # a run that is killed once more before it is through
        completes(RUN, case, path, *SETTINGS)
        assert arrays(path) == expected
        for left in folder.glob(".run.h5*"):
            left.unlink()  # a draft that had no name yet
        assert not list(folder.glob("run.h5.*"))
        path.unlink()
        runs += 1
    return runs


def crash_exports(kills, rng, folder):
    """Kill exports at random moments: each file is as it was, or the new one, whole."""
    whole = folder / "whole.h5"
    completes(EXPORT, whole, folder, *FORMATS)
    seconds = completes(EXPORT, whole, folder, *FORMATS)
    expected = {kind: content(folder / f"export.{kind}") for kind in FORMATS}
    hits = 0
    while hits < kills:
        for kind in FORMATS:
            (folder / f"export.{kind}").unlink(missing_ok=True)
        hits += killed(EXPORT, (whole, folder, *FORMATS), rng.uniform(0.0, seconds))
        for kind in FORMATS:
            path = folder / f"export.{kind}"
            assert not path.exists() or content(path) == expected[kind], path
        for left in folder.glob(".export.*"):
            left.unlink()


def content(path):
    """What must be equal: the bytes, or of an HDF5 file its arrays."""
    return arrays(path) if path.suffix == ".vtkhdf" else path.read_bytes()


def main(kills=100, seed=None):
    """Run the test and print its figures."""
    seed = random.randrange(2**31) if seed is None else seed
    print(f"seed {seed}")
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        half = kills // 2
        runs = crash_runs(kills - half, rng, folder)
        print(f"{kills - half} kills of runs: every file readable, {runs} resumed runs equal to the bit", flush=True)
        crash_exports(half, rng, folder)
        print(f"{half} kills of exports: every file whole or absent", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
