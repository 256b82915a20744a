"""The n-th write to the disk fails, n = 1, 2, ..., for every command that writes; its files must stay readable.

    python tests/full_disk.py [every K-th n]

A library that is loaded before all others counts the calls that write into one folder and refuses the n-th and all
after it, as a full disk does, or the n-th alone. What a command leaves must be readable or absent, it must say so in
one sentence, and its exit code must tell. Each trial is a fork of this process, which has imported all, but not
started Taichi. Without a C compiler there is nothing to load, and nothing is tried.
"""

import collections
import contextlib
import ctypes
import io
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import traceback
from pathlib import Path

import h5py

import taichiflap
from taichiflap.cli import main as command_line
from taichiflap.results import checkpoint, layout
from taichiflap.run import blocks
from taichiflap.studies import batch
from taichiflap.studies import sweep as studies

SHIM = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static char folder[4096];
static long countdown = -1, counted;
static int forever;

void arm(const char *name, long n, int persists) {
    strncpy(folder, name, sizeof folder - 1);
    countdown = n; forever = persists; counted = 0;
}
long count(void) { return counted; }

static int refused(int file) {
    char link[64], path[4096];
    if (countdown < 0) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t size = readlink(link, path, sizeof path - 1);
    if (size <= 0) return 0;
    path[size] = 0;
    if (strncmp(path, folder, strlen(folder))) return 0;
    counted++;
    if (countdown == 0 || counted < countdown || (counted > countdown && !forever)) return 0;
    errno = ENOSPC;
    return 1;
}

#define NEXT(name) static __typeof__(name) *next; if (!next) next = dlsym(RTLD_NEXT, #name)
ssize_t write(int file, const void *data, size_t size) {
    NEXT(write); return refused(file) ? -1 : next(file, data, size);
}
ssize_t pwrite(int file, const void *data, size_t size, off_t at) {
    NEXT(pwrite); return refused(file) ? -1 : next(file, data, size, at);
}
ssize_t pwrite64(int file, const void *data, size_t size, off64_t at) {
    NEXT(pwrite64); return refused(file) ? -1 : next(file, data, size, at);
}
ssize_t writev(int file, const struct iovec *data, int many) {
    NEXT(writev); return refused(file) ? -1 : next(file, data, many);
}
int ftruncate(int file, off_t size) { NEXT(ftruncate); return refused(file) ? -1 : next(file, size); }
int ftruncate64(int file, off64_t size) { NEXT(ftruncate64); return refused(file) ? -1 : next(file, size); }
int fsync(int file) { NEXT(fsync); return refused(file) ? -1 : next(file); }
"""
CASES = Path(__file__).parent.parent / "cases"
LATTICE = [
    str(CASES / "hawkmoth.toml"), "--threads=1", "--set=uvlm.panels=4", "--set=uvlm.wake=10", "--set=time.periods=2",
    "--set=time.steps_per_period=20", "--set=wing.modes=1",
]  # fmt: skip
BLADES = [
    str(CASES / "hawkmoth_dbet.toml"), "--threads=1", "--set=time.periods=2", "--set=time.steps_per_period=20",
    "--set=wing.modes=1",
]  # fmt: skip
OPTIMISE = ["--maximise=force_vertical_mean", "--generations=2", "--population=5"]
COMMANDS = {
    "simulate": ["simulate", *LATTICE, "-o", "run.h5"],
    "simulate, compressed": ["simulate", *BLADES, "-o", "run.h5"],
    "sweep": ["sweep", *BLADES, "--vary=fluid.density=1:2:6", "-o", "map.h5"],
    "sweep --sample": ["sweep", *BLADES, "--vary=fluid.density=1:2", "--sample=lhs:6", "-o", "map.h5"],
    "sweep --keep series": ["sweep", *BLADES, "--vary=fluid.density=1:2:6", "--keep=series", "-o", "map.h5"],
    "optimise": ["optimise", *BLADES, "--vary=fluid.density=1:2", *OPTIMISE, "-o", "map.h5"],
    "export csv": ["export", "whole.h5", "--to=csv", "-o", "out.csv"],
    "export vtkhdf": ["export", "whole.h5", "--to=vtkhdf", "-o", "out.vtkhdf"],
    "export html": ["export", "whole.h5", "--to=html", "-o", "out.html"],
    "export gif": ["export", "whole.h5", "--to=gif", "--beats=1", "-o", "out.gif"],
    "plot": ["plot", "whole.h5", "-o", "figure"],
    "preview": ["preview", LATTICE[0], "-o", "path.png"],
    "strips": ["strips", *BLADES, "--radii=2", "--at=0.6", "-o", "strips.csv"],
    "converge": ["converge", *BLADES, "--tolerance=0.5", "-o", "map.h5"],
    "score": ["score", "--cases=kinsey-dumas", "--models=dbet", "-o", "scores"],
    "init": ["init", "mine.toml"],
}
"""Every command that writes, but for `validate` and `reproduce`, whose pages take minutes."""


OTHERS = (".state", ".csv", ".json", ".md", ".html", ".gif", ".png", ".svg", ".toml")
"""What commands write besides HDF5."""


def compiler():
    """A C compiler, if there is one."""
    return shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")


def loaded():
    """The preloaded library; restarts this process with it if necessary."""
    path = os.environ.get("TAICHIFLAP_FULL_DISK")
    if path:
        library = ctypes.CDLL(path)
        shutil.rmtree(Path(path).parent)
        for name in ("TAICHIFLAP_FULL_DISK", "LD_PRELOAD"):
            del os.environ[name]
        return library
    path = f"{tempfile.mkdtemp()}/full_disk.so"
    options = ("-shared", "-fPIC", "-O1", "-w", "-x", "c", "-", "-o", path, "-ldl")
    subprocess.run([compiler(), *options], input=SHIM.encode(), check=True)
    os.environ["TAICHIFLAP_FULL_DISK"] = os.environ["LD_PRELOAD"] = path
    os.execv(sys.executable, [sys.executable, *sys.argv])


def attempt(shim, folder, name, n, persists, told):
    """In a fork: a command whose n-th write is refused; its exit code, or minus the signal that ended it."""
    process = os.fork()
    if process:
        _, status = os.waitpid(process, 0)
        return os.waitstatus_to_exitcode(status)
    os.chdir(folder)
    blocks.BLOCK_STEPS, checkpoint.SECONDS, batch.BATCH_WORK = 10, 0.0, 0.0
    batch.SHARES, studies.WRITTEN_EVERY = 2, 0.0
    if "compressed" in name:
        layout.LARGE = 64
    said, code = io.StringIO(), 0
    shim.arm(str(folder).encode(), n, persists)
    try:
        sys.argv = ["taichiflap", *COMMANDS[name]]
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
            command_line()
    except SystemExit as error:
        code = error.code or 0
    except BaseException:
        traceback.print_exc(file=said)
        code = 70
    calls = shim.count()
    shim.arm(b"", -1, 0)
    told.write_text(f"{calls}\n{said.getvalue()}")
    # As an interpreter ends, with its exit handlers, but without the tests' own.
    os._exit(code)


def look(folder):
    """Check that every file of a command can be read and that no temporary file is left."""
    for path in sorted(folder.rglob("*")):
        if path.name == "whole.h5" or path.is_dir():
            continue
        assert not path.name.startswith("."), f"{path.name} is left"
        if path.name.endswith((".h5", ".h5.part")):
            with h5py.File(path, "r") as plain:
                plain.visititems(lambda name, item: item[()] if isinstance(item, h5py.Dataset) else None)
            (taichiflap.open_result if path.name.startswith("run") else taichiflap.open_map)(path).close()
        elif path.suffix == ".vtkhdf":
            h5py.File(path, "r").close()
        else:
            assert path.suffix in OTHERS, path.name
            assert path.stat().st_size > 0, f"{path.name} is empty"


def trial(shim, folder, name, n, persists, whole):
    """One refused write; the number of calls that the command made, and its exit code."""
    place = folder / "trial"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    if "whole.h5" in COMMANDS[name]:
        shutil.copy(whole, place / "whole.h5")
    told = folder / "told"
    told.unlink(missing_ok=True)
    code = attempt(shim, place, name, n, persists, told)
    assert code >= 0, f"{name}, write {n}: ended by {signal.Signals(-code).name}"
    calls, _, said = told.read_text().partition("\n")
    assert "Traceback" not in said, f"{name}, write {n}:\n{said}"
    look(place)
    errors = [line for line in said.splitlines() if line.startswith("error: ")]
    if code:
        assert len(errors) == 1, f"{name}, write {n}: {said}"
    return int(calls), code


def main(stride=1, names=tuple(COMMANDS)):
    """Run all trials and print the results."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made).resolve()
        shim = loaded()
        shim.arm.argtypes = (ctypes.c_char_p, ctypes.c_long, ctypes.c_int)
        shim.count.restype = ctypes.c_long
        whole = folder / "whole.h5"
        process = os.fork()
        if not process:
            case = taichiflap.load_case(LATTICE[0], [word.removeprefix("--set=") for word in LATTICE[2:]])
            taichiflap.simulate(case, whole).close()
            os._exit(0)
        os.waitpid(process, 0)
        for name in names:
            calls, code = trial(shim, folder, name, 0, 0, whole)
            assert (code, calls > 0) == (0, True), name
            found = collections.Counter()
            for n in range(1, calls + 1, stride):
                for persists in (1, 0):
                    _, code = trial(shim, folder, name, n, persists, whole)
                    found["refused" if code else "done all the same"] += 1
                    # What a full disk refuses for good is never taken for done, but for what is only tidied up.
                    assert code or not persists or n > calls - 3, f"{name}, write {n} of {calls}: exit code 0"
            print(f"{name}: {calls} calls, {', '.join(f'{n} {what}' for what, n in found.items())}", flush=True)


if __name__ == "__main__":
    if not compiler():
        sys.exit("no C compiler: nothing tried")
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1, tuple(sys.argv[2:]) or tuple(COMMANDS))
