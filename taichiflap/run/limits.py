"""Cases of a map in which the models are invalid, judged by their results."""

import numpy as np
from numpy.typing import NDArray

from ..maps.file import Map
from .warnings import BENT, BROKEN, FORCE, UNACCOUNTED

TIP, COEFFICIENT, RESIDUAL = "tip_peak_mean", "force_coefficient_peak", "energy_residual"
"""Metrics used for this."""

Mask = NDArray[np.bool_]


def bend(sheet: Map) -> NDArray[np.float64]:
    """Peak tip deflection of every case in chords, flat; NaN if the map lacks it."""
    return _values(sheet, TIP) / _chords(sheet)


def bent(sheet: Map) -> Mask:
    """Cases that bend beyond the validity of a linear beam, flat."""
    return _above(bend(sheet), BENT)


def broken(sheet: Map) -> Mask:
    """Cases in which the model is invalid: tip deflection above a chord, or unphysical forces; flat."""
    return _above(bend(sheet), BROKEN) | _above(_values(sheet, COEFFICIENT), FORCE)


def unbalanced(sheet: Map) -> Mask:
    """Cases with unaccounted work, flat."""
    return _above(_values(sheet, RESIDUAL), UNACCOUNTED)


def _values(sheet: Map, metric: str) -> NDArray[np.float64]:
    known = metric in sheet.metrics
    return sheet.values(metric).ravel() if known else np.full(sheet.design.size, np.nan)


def _above(values: NDArray[np.float64], limit: float) -> Mask:
    return np.nan_to_num(values, nan=0.0) > limit


def _chords(sheet: Map) -> NDArray[np.float64]:
    for position, axis in enumerate(sheet.design.axes):
        if axis.key == "wing.chord":
            places = np.unravel_index(np.arange(sheet.design.size), sheet.design.shape)
            return np.array(axis.values, float)[places[position if sheet.design.grid else 0]]
    return np.full(sheet.design.size, sheet.case.wing.chord)
