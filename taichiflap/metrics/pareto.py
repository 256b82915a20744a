"""Pareto fronts: points that no other point beats in both of two metrics."""

import numpy as np
from numpy.typing import NDArray


def pareto_front(cost: np.ndarray, gain: np.ndarray) -> NDArray[np.intp]:
    """Indices of the points that no other point beats in both cost and gain, in order of cost; NaN are left out."""
    order = np.lexsort((-gain, cost))
    order = order[np.isfinite(cost[order]) & np.isfinite(gain[order])]
    best = np.maximum.accumulate(gain[order])
    first = np.r_[True, best[1:] > best[:-1]] if len(order) else np.empty(0, bool)
    return order[first]
