"""What came of a case of a study."""

from dataclasses import dataclass, field

import numpy as np

TO_DO, COMPLETE, FAILED = range(3)
"""What a map's `status` says of a case."""


@dataclass(frozen=True)
class Outcome:
    """What came of a case: its metrics and series by name, or the reason why it has none."""

    metrics: dict[str, float] = field(default_factory=dict)
    series: dict[str, np.ndarray] = field(default_factory=dict)
    reason: str = ""
