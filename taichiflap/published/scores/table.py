"""The scores as text, for the terminal."""

from collections.abc import Iterator, Sequence

from .score import Row
from .tiers import Tier
from .truths import NEAR, OUTSIDE, WITHIN
from .verdict import hopeless, sentence

MARKS = {WITHIN: "=", NEAR: "~", OUTSIDE: "!"}
"""Marks next to an error in the narrow columns of a terminal."""
LEGEND = "  ".join(f"{mark} {word}" for word, mark in MARKS.items())


def groups(rows: Sequence[Row]) -> Iterator[tuple[str, list[Row]]]:
    """Rows by regime, in order; within a regime values that every model misses come first."""
    names = dict.fromkeys(row.published.group for row in rows)
    for name in names:
        own = [row for row in rows if row.published.group == name]
        yield name, sorted(own, key=lambda row: not hopeless(row))


def missing(row: Row, tier: Tier) -> str:
    """Why a tier has no value: it was not run, it failed, or the quantity does not occur in it."""
    outcome = row.outcomes.get(tier.name)
    if outcome is None:
        return "not run"
    return "failed" if outcome.reason else "none"


def cell(row: Row, tier: Tier) -> str:
    """A tier's value, error and mark, or why there is none."""
    value = row.value(tier.name)
    if value is None:
        return missing(row, tier)
    return f"{value:.3g} {100 * row.truth.error(value):+.0f} % {MARKS[row.truth.word(value)]}"


def lines(rows: Sequence[Row], tiers: Sequence[Tier]) -> Iterator[str]:
    """The table, regime by regime."""
    for name, own in groups(rows):
        heads = ["case", "quantity", "published", "band", *(tier.label for tier in tiers)]
        body = [
            [
                row.published.name, row.truth.quantity, f"{row.truth.value:.4g}",
                f"{row.truth.low:.4g} to {row.truth.high:.4g}", *(cell(row, tier) for tier in tiers),
            ]
            for row in own
        ]  # fmt: skip
        widths = [max(map(len, column)) for column in zip(heads, *body, strict=True)]
        yield name
        for row in (heads, *body):
            yield "  " + "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip()
        yield f"  {sentence(own, tiers)}"
        yield ""
    yield LEGEND
