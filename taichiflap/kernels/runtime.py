"""The only interface to Taichi: start-up, precision, threads and output.

Every kernel module takes `ti`, the array types and the parallel idiom from here, so that the backend
(or a fork of it) can be changed in one place.
"""

import contextlib
import functools
import io
import os
import tempfile
import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np

from ..errors import UserError
from .loops import count_passes
from .taichi_patches import free_arrays, hasten, hurrying

# Otherwise Taichi sends its version and a machine id to an outside host, and prints a banner.
os.environ["TI_SKIP_VERSION_CHECK"] = "ON"
os.environ["ENABLE_TAICHI_HEADER_PRINT"] = "0"
# Taichi aborts on import without a home folder.
_home = os.path.expanduser("~")
os.environ.setdefault("HOME", _home if os.path.isabs(_home) else tempfile.gettempdir())

LEAST_SPACE = 2**31
"""Address space, in bytes, that Taichi and LLVM need; with less they crash, possibly without a message."""


def _check_space() -> None:
    """Raise an error if the limit of address space (`ulimit -v`) is too low for Taichi."""
    try:
        import resource  # noqa: PLC0415 - not everywhere
    except ImportError:
        return
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit not in (resource.RLIM_INFINITY, -1) and limit < LEAST_SPACE:
        raise UserError(
            f"the limit of address space is {limit / 2**30:.2g} GB (ulimit -v) but a run needs {LEAST_SPACE >> 30} "
            "GB; raise the limit"
        )


_check_space()

if TYPE_CHECKING:
    # Taichi is untyped: for the type checker its names, and decorated functions, are `Any`.
    from typing import Any as Floats1
    from typing import Any as Floats2
    from typing import Any as Floats3
    from typing import Any as Floats4
    from typing import Any as Ints1
    from typing import Any as Ints2
    from typing import Any as Ints3
    from typing import Any as Octets2
    from typing import Any as Octets3
    from typing import Any as Octets4
    from typing import Any as Singles3
    from typing import Any as Singles4
    from typing import Any as View

    ti: Any = None
else:
    with hurrying():
        import taichi as ti

    hasten(ti)
    free_arrays(ti)
    count_passes(ti)
    View = ti.template()
    """Annotation of a `ti.func` parameter that is an array or a group of arrays."""
    Ints1, Ints2, Ints3 = (ti.types.ndarray(dtype=ti.i32, ndim=n) for n in (1, 2, 3))
    Floats1, Floats2, Floats3, Floats4 = (ti.types.ndarray(dtype=ti.f64, ndim=n) for n in (1, 2, 3, 4))
    Singles3, Singles4 = (ti.types.ndarray(dtype=ti.f32, ndim=n) for n in (3, 4))
    Octets2, Octets3, Octets4 = (ti.types.ndarray(dtype=ti.types.vector(8, ti.f64), ndim=n) for n in (2, 3, 4))

Octet: Any = ti.types.vector(8, ti.f64) if ti else None
"""Eight doubles: one AVX-512 register, the unit in which pair sums, eliminations and blade elements are written.

It remains one vector in LLVM; with Taichi's default, vectors are split into scalars and stores are not vectorised. As a
consequence Taichi 1.7 can neither negate an octet nor use `-=` with one: write `u = u - x`."""

Sixteen: Any = ti.types.vector(16, ti.f32) if ti else None
"""Sixteen numbers in single precision, for pair sums."""

LANE = 512
"""Taichi runs a parallel loop of 512 iterations or fewer on one thread. Kernels therefore loop over
`tasks * LANE` and let the first iteration of each lane do the lane's work."""

CALL = "ti.init(arch=ti.cpu, default_fp=ti.f64, fast_math=False, real_matrix_scalarize=False)"
"""Call with which a host program must initialise Taichi to share it with taichiflap."""

alone = threading.RLock()
"""Lock for compiling and launching: Taichi allows one caller at a time."""

P = ParamSpec("P")
R = TypeVar("R")

_runtime: Any = None
_forked = False


class ProgramError(UserError):
    """Raised if Taichi cannot be used in this process; one sentence with the cause and the cure."""


def available_threads() -> int:
    """Number of processors available to this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def check_threads(threads: int | None) -> None:
    """Raise an error for an invalid number of threads.

    Raises:
        ProgramError: if it is not a whole number, or below 1.
    """
    if threads is None or (isinstance(threads, int | np.integer) and not isinstance(threads, bool) and threads >= 1):
        return
    raise ProgramError(f"threads = {threads!r}: must be a whole number >= 1, or None for all of them")


def exclusive(work: Callable[P, R]) -> Callable[P, R]:
    """Decorator that lets only one thread at a time into a function."""

    @functools.wraps(work)
    def one_at_a_time(*arguments: P.args, **named: P.kwargs) -> R:
        with alone:
            return work(*arguments, **named)

    return one_at_a_time


def start() -> Any:
    """Start Taichi on the CPU with strict IEEE double precision; later calls check that this still holds.

    A Taichi program started by the host is shared if its settings are compatible. It is never replaced, since its
    fields would be lost.

    Returns:
        Taichi's runtime, for `check`.

    Raises:
        ProgramError: if the host's program has incompatible settings, or this process was forked from one with a
            program.
    """
    if _forked:
        raise ProgramError(
            "this process was forked after Taichi had started, and its threads do not survive a fork: start processes "
            'with "spawn", for example multiprocessing.get_context("spawn")'
        )
    with alone:
        if ti.lang.impl.get_runtime().prog is None:
            with contextlib.redirect_stdout(io.StringIO()):
                ti.init(
                    arch=ti.cpu,
                    default_fp=ti.f64,
                    fast_math=False,
                    real_matrix_scalarize=False,
                    **_cache(),
                    cpu_max_num_threads=available_threads(),
                    log_level=ti.ERROR,
                )
        _take(ti.lang.impl.get_runtime())
        return _runtime


def check(runtime: Any) -> None:
    """Check that Taichi's runtime is still the one that owns a march's arrays.

    Raises:
        ProgramError: if the host has initialised Taichi again since `start`.
    """
    if ti.lang.impl.get_runtime() is not runtime:
        raise ProgramError("ti.init or ti.reset was called during a run, which deleted its arrays: start the run again")


def _take(runtime: Any) -> None:
    """Use a runtime if its program has compatible settings. No reference to the program is kept, so that it can end."""
    global _runtime  # noqa: PLW0603 - Taichi holds one program a process, and so do we
    if runtime is _runtime:
        return
    config = runtime.prog.config()
    alike = config.arch == ti.cpu and config.default_fp == ti.f64 and config.default_ip == ti.i32
    if not alike or config.fast_math or config.real_matrix_scalarize:
        raise ProgramError(
            "Taichi was initialised by other code in this process with incompatible settings, and initialising it "
            f"again would destroy that code's fields: initialise it there with {CALL}, or run taichiflap in a process "
            "of its own"
        )
    try:
        # Compile now, in the thread that made the program; the first kernel cannot be compiled in another thread.
        runtime.materialize()
    except RuntimeError:
        raise ProgramError(
            "Taichi was initialised by another thread of this process, which has not launched a kernel yet: launch "
            "one there before taichiflap runs in this thread"
        ) from None
    _runtime = runtime


def _after_fork() -> None:
    global _forked, alone  # noqa: PLW0603 - a fork is another process
    _forked = ti.lang.impl.get_runtime().prog is not None
    alone = threading.RLock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


def _cache() -> dict[str, Any]:
    """Cache folder of Taichi: the user's cache, or a temporary folder; empty if neither can be written.

    Taichi 1.7 crashes if it cannot write its cache.
    """
    own = os.environ.get("TI_OFFLINE_CACHE_FILE_PATH") or ti.lang.impl.default_cfg().offline_cache_file_path
    temporary = os.path.join(tempfile.gettempdir(), f"taichi-{getattr(os, 'getuid', int)()}")
    for place in (own, temporary):
        try:
            os.makedirs(place, mode=0o700, exist_ok=True)
            # Code from another user must not be run.
            if place == own or (os.stat(place).st_mode & 0o022 == 0 and os.lstat(place).st_uid == os.getuid()):
                tempfile.TemporaryFile(dir=place).close()
                return {"offline_cache": True, "offline_cache_file_path": place}
        except (OSError, ValueError):
            continue
    return {"offline_cache": False}


@contextlib.contextmanager
def passes(level: int | None) -> Iterator[None]:
    """Context that sets the level of Taichi's own optimisation of kernels.

    Level 0 omits passes whose time grows with the square of a kernel's length; LLVM still optimises. None keeps the
    default.
    """
    if level is None:
        yield
        return
    config = ti.lang.impl.current_cfg()
    before = config.opt_level
    config.opt_level = level
    try:
        yield
    finally:
        config.opt_level = before


def tasks(cases: int, threads: int | None = None) -> int:
    """Number of tasks into which a kernel divides `cases`, so that at most `threads` run at once.

    With all threads every case is one task, and the thread pool balances the load.
    """
    check_threads(threads)
    if threads is None or threads >= _runtime.prog.config().cpu_max_num_threads:
        return cases
    return min(cases, threads)


class _Memory:
    """NumPy interface to the memory of a Taichi array, which it keeps alive."""

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
    with alone:
        # Bypasses `ti.sync`, which looks for fields to be placed.
        ti.lang.impl.get_runtime().prog.synchronize()
        return np.asarray(_Memory(array))
