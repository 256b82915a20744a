"""The outcome of a case of a study."""

from dataclasses import dataclass, field

import numpy as np

TO_DO, COMPLETE, FAILED = range(3)
"""Values of a map's `status`."""


@dataclass(frozen=True)
class Outcome:
    """The outcome of a case: its metrics and series by name, or the reason of its failure."""

    metrics: dict[str, float] = field(default_factory=dict)
    series: dict[str, np.ndarray] = field(default_factory=dict)
    reason: str = ""
