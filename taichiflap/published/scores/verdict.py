"""Summary of a regime: one sentence on which model to use."""

import math
from collections.abc import Sequence

from .score import Row
from .tiers import Tier
from .truths import NEARBY, OUTSIDE, WITHIN

WORST = 2.0
"""Maximum relative error counted, so that a single large error does not dominate the mean."""
ALIKE = 1.25
"""Mean errors within this factor count as equal."""


def mean_error(rows: Sequence[Row], tier: str) -> float:
    """Mean relative error of a tier over rows; NaN if it has none. A failed run counts as `WORST`."""
    errors = []
    for row in rows:
        if tier in row.outcomes:
            value = row.value(tier)
            if value is not None:
                errors.append(min(abs(row.truth.error(value)), WORST))
            elif row.outcomes[tier].reason:
                errors.append(WORST)
    return sum(errors) / len(errors) if errors else math.nan


def hopeless(row: Row) -> bool:
    """Whether every model that was run is outside the band by more than a quarter."""
    values = [row.value(tier) for tier in row.outcomes]
    return bool(values) and all(value is None or row.truth.word(value) == OUTSIDE for value in values)


def sentence(rows: Sequence[Row], tiers: Sequence[Tier]) -> str:
    """Which model to use for a regime, with the mean errors, and how many figures are inside their bands."""
    errors = {tier.label: mean_error(rows, tier.name) for tier in tiers}
    ranked = sorted((error, label) for label, error in errors.items() if not math.isnan(error))
    if not ranked:
        return "No model was run."
    best = ranked[0][0]
    names = [label for error, label in ranked if error <= ALIKE * best]
    rest = [f"{label} {100 * error:.0f} %" for error, label in ranked if error > ALIKE * best]
    inside = {
        tier.label: sum(1 for row in rows if (value := row.value(tier.name)) is not None
                        and row.truth.word(value) == WITHIN) for tier in tiers
    }  # fmt: skip
    counts = f"mean error {100 * best:.0f} %, {inside[names[0]]} of {len(rows)} figures inside the band"
    said = f"Use {' or '.join(names)}: {counts}"
    if best > NEARBY:
        said = f"No model comes within 25 % on the mean; the nearest is {' or '.join(names)}: {counts}"
    said += f" (the others: {', '.join(rest)})." if rest else "."
    ran = {name for row in rows for name in row.outcomes}
    lacking = [tier.label for tier in tiers if tier.name in ran and math.isnan(errors[tier.label])]
    return said + (f" Without a value: {'; '.join(lacking)}." if lacking else "")
