"""Why the means of a run are not yet known to the digits that are printed."""

import math

from .columns import FEWEST_BEATS
from .summary import Summary
from .uncertainty import FEWEST_BEATS as LEAST

CURE = "increase time.periods, or time.duration of a run in seconds"


def unsettled(summary: Summary) -> str:
    """Warning that a run is not yet periodic; empty if it is, or if its motion is not periodic."""
    if summary.settled is not False:
        return ""
    if summary.beats < FEWEST_BEATS:
        return f"too few beats to tell whether the run is periodic; {CURE}"
    if summary.force_drift > 2.0 * summary.force_spread:
        return (
            f"not yet periodic: over these beats the mean force drifts by {100 * summary.force_drift:.2g} % "
            f"of its rms; {CURE}"
        )
    known = f"a standard error takes {LEAST} settled beats, these are {summary.beats}"
    if summary.beats >= LEAST:
        known = f"the mean force vector has a standard error of {100 * _relative_error(summary):.2g} %"
    return (
        f"the beats do not repeat: their mean force spreads by {100 * summary.force_spread:.2g} % of its rms; "
        f"{known}; {CURE}"
    )


def _relative_error(summary: Summary) -> float:
    """Standard error of the mean force, as a share of its size."""
    forces = summary.force_y, summary.force_z
    size = math.hypot(*(one.mean for one in forces))
    return math.hypot(*(one.error or 0.0 for one in forces)) / size if size else math.inf
