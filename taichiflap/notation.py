"""How numbers and texts are written for people: engineering notation, thousandths of a unit, one printable line."""

from decimal import Decimal
from typing import Any

PREFIXES = (
    (1e9, 1e-9, "G"), (1e6, 1e-6, "M"), (1e3, 1e-3, "k"), (1.0, 1.0, ""), (1e-4, 1e3, "m"),
    (1e-7, 1e6, "µ"), (0.0, 1e9, "n"),
)  # fmt: skip
"""The least size in a unit that has a prefix, the factor to it, and the prefix. Thousandths reach down to 0.1:
of newtons, watts and metres they are what an insect's wing is measured in."""


def prefixed(size: float, unit: str) -> tuple[float, str]:
    """Factor and name of the multiple of a unit that suits quantities up to `size`: 0.03 N are shown in mN.

    What is nothing, or not finite, is shown in thousandths too.
    """
    if not 0.0 < abs(size) < float("inf"):
        return 1e3, f"m{unit}"
    return next((factor, prefix + unit) for least, factor, prefix in PREFIXES if abs(size) >= least)


def fraction(units: str) -> str:
    """Units as people write them, N/W for N W-1, and nothing for a pure number."""
    return "" if units == "1" else units.replace(" W-1", "/W")


def engineering(value: float) -> str:
    """A number with an exponent in threes where it is large or small, such as 24.5e9; it reads back as the same."""
    if value == 0.0 or 1e-3 <= abs(value) < 1e6 or not abs(value) < float("inf"):
        return f"{value}"
    digits = Decimal(repr(value))
    exponent = 3 * (digits.adjusted() // 3)
    return f"{digits.scaleb(-exponent).normalize():f}e{exponent}"


def short(value: Any) -> str:
    """A number in four digits, and anything else as it is."""
    return engineering(float(f"{value:.4g}")).removesuffix(".0") if isinstance(value, float) else str(value)


def printable(text: str) -> str:
    """A text on one line that steers no terminal and breaks no drawing: what cannot be printed is replaced."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
