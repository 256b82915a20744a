"""Taichi arrays made from NumPy values."""

from typing import Any

import numpy as np

from .runtime import Octet, ti, view


def array(values: Any, dtype: type | None = None) -> Any:
    """A Taichi array of doubles or 32-bit integers that holds `values`."""
    values = np.asarray(values, dtype=dtype)
    made = ti.ndarray(ti.f64 if values.dtype.kind == "f" else ti.i32, values.shape)
    view(made)[...] = values
    return made


def octet_array(values: np.ndarray) -> Any:
    """A Taichi array of octets that holds `values`, whose last axis is a multiple of eight."""
    made = ti.ndarray(Octet, (*values.shape[:-1], values.shape[-1] // 8))
    view(made)[...] = values.reshape(*made.shape, 8)
    return made


def zeros(dtype: Any, *shape: int) -> Any:
    """A Taichi array of zeros."""
    made = ti.ndarray(dtype, shape)
    view(made)[...] = 0
    return made


class Spare:
    """Large arrays that one march leaves to the next of the same size.

    The system hands out memory page by page when it is first written, which takes a tenth of the time of a short case.
    """

    def __init__(self) -> None:
        self._arrays: dict[tuple[int, ...], Any] = {}

    def take(self, *shape: int) -> Any:
        """A Taichi array of doubles, with anything in it."""
        found = self._arrays.pop(shape, None)
        # One of an earlier program of Taichi is gone.
        return found if found is not None and found.made_in is ti.lang.impl.get_runtime() else ti.ndarray(ti.f64, shape)

    def leave(self, *arrays: Any) -> None:
        """Leave arrays, which nobody uses any more; those that were left before and not taken are freed."""
        self._arrays = {tuple(one.shape): one for one in arrays}
