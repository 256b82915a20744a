"""Pareto fronts: what nothing beats in both of two respects."""

import numpy as np
from numpy.typing import NDArray


def pareto_front(cost: np.ndarray, gain: np.ndarray) -> NDArray[np.intp]:
    """Places of the points that no other beats in cost and in gain, by rising cost; not-a-numbers have no place."""
    order = np.lexsort((-gain, cost))
    order = order[np.isfinite(cost[order]) & np.isfinite(gain[order])]
    best = np.maximum.accumulate(gain[order])
    first = np.r_[True, best[1:] > best[:-1]] if len(order) else np.empty(0, bool)
    return order[first]
