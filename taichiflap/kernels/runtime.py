"""The one doorway to Taichi: start-up, precision, threads, and quiet.

Every kernel module takes `ti`, the array types and the parallel idiom from here, so that the backend
(or a fork of it) can be changed in one place.
"""

import contextlib
import io
import os
from typing import TYPE_CHECKING, Any

import numpy as np

from .taichi_patches import hasten

# Taichi sends its version and a machine id to an outside host, and prints a banner, unless told not to.
os.environ["TI_SKIP_VERSION_CHECK"] = "ON"
os.environ["ENABLE_TAICHI_HEADER_PRINT"] = "0"

if TYPE_CHECKING:
    # Taichi has no types: to the type checker its names, and what its decorators return, are `Any`.
    from typing import Any as Floats1
    from typing import Any as Floats2
    from typing import Any as Floats3
    from typing import Any as Floats4
    from typing import Any as Ints1
    from typing import Any as Ints2
    from typing import Any as Ints3
    from typing import Any as Octets2
    from typing import Any as Octets3
    from typing import Any as Singles3
    from typing import Any as Singles4
    from typing import Any as View

    ti: Any = None
else:
    import taichi as ti

    hasten(ti)
    View = ti.template()
    """Annotation of a `ti.func` parameter that is an array or a group of arrays."""
    Ints1, Ints2, Ints3 = (ti.types.ndarray(dtype=ti.i32, ndim=n) for n in (1, 2, 3))
    Floats1, Floats2, Floats3, Floats4 = (ti.types.ndarray(dtype=ti.f64, ndim=n) for n in (1, 2, 3, 4))
    Singles3, Singles4 = (ti.types.ndarray(dtype=ti.f32, ndim=n) for n in (3, 4))
    Octets2, Octets3 = (ti.types.ndarray(dtype=ti.types.vector(8, ti.f64), ndim=n) for n in (2, 3))

Octet: Any = ti.types.vector(8, ti.f64) if ti else None
"""Eight doubles: one AVX-512 register, the unit in which pair sums, eliminations and blade elements are written.

To LLVM it stays one vector; taken apart, as by Taichi's default, it is not put together again where it is stored. The
price is that Taichi 1.7 cannot negate an octet, nor take one from a variable by `-=`: write `u = u - x`."""

Sixteen: Any = ti.types.vector(16, ti.f32) if ti else None
"""Sixteen numbers in single precision, for pair sums that need no more."""

LANE = 512
"""Taichi runs a parallel loop of 512 iterations or fewer on one thread. Kernels therefore loop over
`tasks * LANE` and let the first iteration of each lane do the lane's work."""

_threads = 0


def available_threads() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def start() -> None:
    """Start Taichi on the CPU with strict IEEE double precision; later calls do nothing."""
    global _threads  # noqa: PLW0603 - Taichi holds one program a process, and so do we
    if _threads:
        return
    _threads = available_threads()
    with contextlib.redirect_stdout(io.StringIO()):
        ti.init(
            arch=ti.cpu,
            default_fp=ti.f64,
            fast_math=False,
            real_matrix_scalarize=False,
            offline_cache=True,
            cpu_max_num_threads=_threads,
            log_level=ti.ERROR,
        )
    # Taichi 1.7 frees arrays of numbers, but none of vectors: a study would grow with every batch.
    vectors = ti.lang.matrix.VectorNdarray
    vectors.__del__ = getattr(vectors, "__del__", ti.lang._ndarray.ScalarNdarray.__del__)


def tasks(cases: int, threads: int | None = None) -> int:
    """Number of tasks among which a kernel deals out `cases`, so that at most `threads` of them run at once.

    With all threads allowed every case is a task of its own and the thread pool balances the load.
    """
    if threads is None or threads >= _threads:
        return cases
    return min(cases, threads)


class _Memory:
    """The memory of a Taichi array, which it keeps alive, to NumPy."""

    def __init__(self, array: Any) -> None:
        self.array = array
        self.__array_interface__ = {
            "data": (ti.lang.impl.get_runtime().prog.get_ndarray_data_ptr_as_int(array.arr), False),
            "shape": (*array.shape, *array.element_shape),
            "typestr": np.dtype(ti.lang.util.to_numpy_type(array.dtype)).str,
            "version": 3,
        }


def view(array: Any) -> np.ndarray:
    """The memory of a Taichi array as a NumPy array, without a copy.

    Taichi's own `to_numpy` and `from_numpy` compile and launch a kernel for every type and rank.
    """
    ti.sync()
    return np.asarray(_Memory(array))
