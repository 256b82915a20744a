"""How well a mean over beats is known when the beats differ and depend on each other."""

import numpy as np
from numpy.typing import NDArray

FEWEST_BEATS = 10
"""Settled beats below which no standard error is given."""

Array = NDArray[np.float64]


def standard_errors(values: Array) -> Array:
    """Standard errors of the means of several variables, each with one value per beat.

    A beat resembles the one before: the flow that it meets is that beat's wake. Beats with correlation `r` between
    neighbours are worth `n (1 - r) / (1 + r)` independent ones. The correlation found in few beats is too low by about
    `(1 + 4 r) / n` (Orcutt & Irwin, J. R. Stat. Soc. B 10, 1948), which is corrected; a negative one counts as zero.

    Args:
        values: shape (..., beats).

    Returns:
        Shape (...); not-a-number where there are fewer than `FEWEST_BEATS` beats.
    """
    count = values.shape[-1]
    if count < FEWEST_BEATS:
        return np.full(values.shape[:-1], np.nan)
    apart = values - values.mean(axis=-1, keepdims=True)
    squares = (apart**2).sum(axis=-1)
    products = (apart[..., 1:] * apart[..., :-1]).sum(axis=-1)
    found = np.divide(products, squares, out=np.zeros(squares.shape), where=squares > 0.0)
    correlation = np.clip((count * found + 1.0) / (count - 4.0), 0.0, (count - 2.0) / (count + 2.0))
    independent = count * (1.0 - correlation) / (1.0 + correlation)
    return np.sqrt(squares / count / (independent - 1.0))
