"""A plain C double loop over vortex pairs, one thread: the limit of the hardware, as a compiler finds it."""

import ctypes
import functools
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

FLAGS = ("-O3", "-march=native", "-ffast-math", "-shared", "-fPIC")
MISSING = "no C compiler found; on Debian: apt-get install gcc"

SOURCE = r"""
void induce(long targets, const double *y, const double *z, double *u, double *v,
            long sources, const double *sy, const double *sz, const double *g, double core2)
{
    for (long i = 0; i < targets; i++) {
        double a = 0, b = 0;
        for (long j = 0; j < sources; j++) {
            double dy = y[i] - sy[j], dz = z[i] - sz[j], s = g[j] / (dy * dy + dz * dz + core2);
            a -= dz * s;
            b += dy * s;
        }
        u[i] = a * 0.15915494309189535;
        v[i] = b * 0.15915494309189535;
    }
}
"""

Sum = Callable[[np.ndarray, np.ndarray, float], np.ndarray]
"""Velocity (2, targets) at points (2, targets) from vortices (3, sources) with a core radius."""


@functools.cache
def load() -> Sum | None:
    """The loop, compiled; None without a compiler."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if not compiler:
        return None
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder, "pairs.c"), Path(folder, "pairs.so")
        source.write_text(SOURCE)
        subprocess.run([compiler, *FLAGS, str(source), "-o", str(library)], check=True)
        loop = ctypes.CDLL(str(library)).induce
    row = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
    loop.argtypes = [ctypes.c_long, row, row, row, row, ctypes.c_long, row, row, row, ctypes.c_double]
    loop.restype = None

    def induced_velocity(points: np.ndarray, vortices: np.ndarray, core: float) -> np.ndarray:
        velocity = np.empty_like(points)
        loop(points.shape[1], *points, *velocity, vortices.shape[1], *vortices, core**2)
        return velocity

    return induced_velocity
