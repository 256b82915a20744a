"""SIGKILL at random moments of runs, sweeps and exports: `make crash-test` prints the state of the files.

After every kill each file must open with plain h5py, what is taken up again must equal the uninterrupted one in every
bit, and an export must be whole or absent. Every process is a fork of this one, which has imported all, but not
started Taichi; what takes up is one process for all.
"""

import collections
import contextlib
import multiprocessing
import os
import random
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path

import h5py
import numpy as np

import taichiflap
from taichiflap.export.formats import FORMATS, export
from taichiflap.plots.result import plot
from taichiflap.results import checkpoint, layout
from taichiflap.results.writer import Writer
from taichiflap.run import blocks
from taichiflap.studies import batch
from taichiflap.studies import sweep as studies

CASES = Path(__file__).parent.parent / "cases"
SHORT = ("uvlm.panels=8", "uvlm.wake=100", "time.periods=6", "time.steps_per_period=100", "wing.modes=2")
BLADES = ("time.periods=2", "time.steps_per_period=50", "wing.modes=1")
FAST = ("csv", "vtkhdf", "html", "plots")


def simulate(path):
    """The run to kill: many blocks, a checkpoint after each, and fields to compress at the end."""
    blocks.BLOCK_STEPS, checkpoint.SECONDS, layout.LARGE = 30, 0.0, 64
    taichiflap.simulate(taichiflap.load_case(CASES / "hawkmoth.toml", SHORT), path, resume=True).close()


def sweep(path):
    """The sweep to kill: many batches."""
    batch.BATCH_WORK, studies.WRITTEN_EVERY = 0.0, 0.0
    taichiflap.sweep(
        taichiflap.load_case(CASES / "hawkmoth_dbet.toml", BLADES), {"fluid.density": "1:2:40"}, path, threads=1
    )


def write(whole, folder, kind):
    """The exports to kill."""
    with taichiflap.open_result(whole) as result:
        if kind == "plots":
            plot([result], folder / "export", overwrite=True)
        else:
            export(result, kind, folder / f"export.{kind}", overwrite=True)


def start(work, *arguments, ready=None):
    """A separate process, started up to the beginning of its work, or to a call of a method of the writer."""
    begun, tell = os.pipe()
    process = os.fork()
    if process == 0:
        try:
            if ready is None:
                os.write(tell, b".")
            else:
                method = getattr(Writer, ready)
                setattr(Writer, ready, lambda *given: (os.write(tell, b"."), method(*given))[1])
            work(*arguments)
        except BaseException:
            traceback.print_exc()
            os._exit(1)
        os._exit(0)
    os.close(tell)
    os.read(begun, 1)
    os.close(begun)
    return process


def killed(delay, work, *arguments, ready=None):
    """Whether the work was still running when it was killed, `delay` seconds after its start."""
    process = start(work, *arguments, ready=ready)
    time.sleep(delay)
    os.kill(process, signal.SIGKILL)
    _, status = os.waitpid(process, 0)
    assert status in (0, signal.SIGKILL)
    return status != 0


def timed(work, *arguments):
    """Duration of some work, s."""
    began = time.perf_counter()
    work(*arguments)
    return time.perf_counter() - began


@contextlib.contextmanager
def helper():
    """A process that is not killed: returns a function that does some work in it and returns the duration, s."""
    with multiprocessing.get_context("fork").Pool(1) as pool:
        yield lambda *work: pool.apply(timed, work)


def moment(rng, seconds):
    """A random moment: 30 % of the kills are in the last tenth, when files are closed and renamed."""
    return rng.uniform(0.9 * seconds if rng.random() < 0.3 else 0.0, 1.1 * seconds)


def arrays(path):
    """Every array of an HDF5 file, read with plain h5py."""
    found = {}
    with h5py.File(path, "r") as file:

        def visit(name, item):
            if isinstance(item, h5py.Dataset) and not isinstance(item.dtype, h5py.Reference):
                found[name] = item[...].tolist() if item.dtype.kind == "O" else item[...].tobytes()

        file.visititems(visit)
    return found


def phase(path):
    """Phase of a run when it was killed."""
    part = path.with_name(path.name + ".part")
    if path.exists():
        return "finished, to be tidied up"
    if not part.exists():
        return "before its file was laid out"
    with h5py.File(part, "r") as file:
        return "in its march" if np.isnan(file["time"][-1]) else "in its last writes"


def clear(folder, stem):
    """Remove finished files and temporary files; nothing else may be left."""
    for left in (*folder.glob(f".{stem}*"), folder / f"{stem}.h5"):
        left.unlink(missing_ok=True)
    assert not list(folder.glob(f"{stem}*"))


def crash_runs(kills, rng, folder):
    """Kill and resume runs until `kills` kills have hit; returns their number in each phase."""
    phases, resumed = collections.Counter(), 0
    with helper() as complete:
        complete(simulate, folder / "whole.h5")
        seconds = complete(simulate, folder / "timed.h5")
        expected, path = arrays(folder / "whole.h5"), folder / "run.h5"
        while phases.total() < kills:
            begin, most = (None, 3.0) if rng.random() < 0.1 else ("lay_out", moment(rng, seconds))
            if killed(rng.uniform(0.0, most) if begin is None else most, simulate, path, ready=begin):
                phases[phase(path)] += 1
            for left in (path, path.with_name("run.h5.part")):
                if left.exists():
                    assert arrays(left).keys() == expected.keys(), left
            if rng.random() < 0.2 and phases.total() < kills and not path.exists():
                continue  # killed once more before it is through
            complete(simulate, path)
            assert arrays(path) == expected
            resumed += 1
            clear(folder, "run")
    return phases, resumed


def crash_sweeps(kills, rng, folder):
    """Kill and continue sweeps until `kills` kills have hit."""
    hits = resumed = 0
    with helper() as complete:
        complete(sweep, folder / "map.h5")
        expected, path = arrays(folder / "map.h5"), folder / "sweep.h5"
        seconds = timed(lambda: os.waitpid(start(sweep, folder / "timed_map.h5"), 0))
        while hits < kills:
            hits += killed(rng.uniform(0.0, seconds), sweep, path)
            if path.exists():
                assert arrays(path).keys() == expected.keys()
            if rng.random() < 0.2 and hits < kills:
                continue
            complete(sweep, path)
            assert arrays(path) == expected
            resumed += 1
            clear(folder, "sweep")
    return resumed


def content(path):
    """Content to compare: the bytes, or the arrays of an HDF5 file."""
    return arrays(path) if path.suffix == ".vtkhdf" else path.read_bytes()


def crash_exports(kills, rng, folder, kinds):
    """Kill exports of all kinds in turn; each file must be absent or complete."""
    hits, seconds, expected = 0, {}, {}
    whole = folder / "whole.h5"
    for kind in kinds:
        seconds[kind] = timed(write, whole, folder, kind)
    for path in folder.glob("export*"):
        expected[path.name] = content(path)
        path.unlink()
    while hits < kills:
        # Films are slow.
        kind = rng.choice(kinds if rng.random() < 0.2 else [kind for kind in kinds if kind in FAST])
        hits += killed(moment(rng, seconds[kind]), write, whole, folder, kind)
        for path in folder.glob("export*"):
            assert content(path) == expected[path.name], path
            path.unlink()
        for left in folder.glob(".export*"):
            left.unlink(missing_ok=True)


def main(kills=100, seed=None):
    """Run the test and print its figures."""
    seed = random.randrange(2**31) if seed is None else seed
    print(f"seed {seed}", flush=True)
    rng = random.Random(seed)
    half, some = -(-kills * 2 // 5), kills // 10
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        phases, resumed = crash_runs(half, rng, folder)
        where = ", ".join(f"{count} {place}" for place, count in phases.items())
        print(
            f"{half} kills of runs ({where}): every file readable, {resumed} resumed runs equal to the bit", flush=True
        )
        resumed = crash_sweeps(some, rng, folder)
        print(f"{some} kills of sweeps: every map readable, {resumed} resumed ones equal to the bit", flush=True)
        # Films are slow: a short test does without.
        crash_exports(kills - half - some, rng, folder, FAST if kills < 20 else (*FAST, *FORMATS[3:]))
        print(f"{kills - half - some} kills of exports: every file whole or absent", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
