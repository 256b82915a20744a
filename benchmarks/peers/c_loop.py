"""C double loops over vortex pairs, one thread: the limit of the hardware, as a compiler finds it.

One divides for every pair. In the other two sources share a division, `q = 1/(d e)`, `1/d = e q`, `1/e = d q`, which
pays where a division costs more than the multiplications and registers that replace it.
"""

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

void induce_shared(long targets, const double *y, const double *z, double *u, double *v,
                   long sources, const double *sy, const double *sz, const double *g, double core2)
{
    long i = 0, even = sources / 2 * 2, whole = targets / 8 * 8;
    for (; i < whole; i += 8) {
        double a[8] = {0}, b[8] = {0};
        for (long j = 0; j < even; j += 2)
            for (int k = 0; k < 8; k++) {
                double py = y[i + k] - sy[j], pz = z[i + k] - sz[j], d = py * py + pz * pz + core2;
                double qy = y[i + k] - sy[j + 1], qz = z[i + k] - sz[j + 1], e = qy * qy + qz * qz + core2;
                double q = 1.0 / (d * e), s = g[j] * (e * q), t = g[j + 1] * (d * q);
                a[k] -= pz * s + qz * t;
                b[k] += py * s + qy * t;
            }
        for (int k = 0; k < 8; k++) {
            u[i + k] = a[k] * 0.15915494309189535;
            v[i + k] = b[k] * 0.15915494309189535;
        }
    }
    induce(targets - i, y + i, z + i, u + i, v + i, even, sy, sz, g, core2);
}
"""

Sum = Callable[[np.ndarray, np.ndarray, float], np.ndarray]
"""Velocity (2, targets) at points (2, targets) from vortices (3, sources) with a core radius."""


@functools.cache
def load(function: str = "induce") -> Sum | None:
    """A loop, compiled; None without a compiler.

    Args:
        function: `induce`, or `induce_shared`, which takes an even number of sources.
    """
    compiler = shutil.which("gcc") or shutil.which("cc")
    if not compiler:
        return None
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder, "pairs.c"), Path(folder, "pairs.so")
        source.write_text(SOURCE)
        subprocess.run([compiler, *FLAGS, str(source), "-o", str(library)], check=True)
        loop = getattr(ctypes.CDLL(str(library)), function)
    row = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
    loop.argtypes = [ctypes.c_long, row, row, row, row, ctypes.c_long, row, row, row, ctypes.c_double]
    loop.restype = None

    def induced_velocity(points: np.ndarray, vortices: np.ndarray, core: float) -> np.ndarray:
        velocity = np.empty_like(points)
        loop(points.shape[1], *points, *velocity, vortices.shape[1], *vortices, core**2)
        return velocity

    return induced_velocity
