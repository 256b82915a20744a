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
