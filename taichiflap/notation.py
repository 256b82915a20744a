"""Formatting of numbers and text: engineering notation, unit prefixes, one printable line."""

from decimal import Decimal
from typing import Any

PREFIXES = (
    (1e9, 1e-9, "G"), (1e6, 1e-6, "M"), (1e3, 1e-3, "k"), (1.0, 1.0, ""), (1e-4, 1e3, "m"),
    (1e-7, 1e6, "µ"), (0.0, 1e9, "n"),
)  # fmt: skip
"""Minimum size for a prefix, its factor, and the prefix. Milli is used from 0.1 on, since an insect's wing is measured
in mN, mW and mm.
"""


def prefixed(size: float, unit: str) -> tuple[float, str]:
    """Factor and name of the multiple of a unit that suits values up to `size`: 0.03 N is shown in mN.

    Zero and non-finite values are shown in thousandths.
    """
    if not 0.0 < abs(size) < float("inf"):
        return 1e3, f"m{unit}"
    return next((factor, prefix + unit) for least, factor, prefix in PREFIXES if abs(size) >= least)


def fraction(units: str) -> str:
    """Units written as a fraction, N/W for N W-1; empty for a dimensionless number."""
    return "" if units == "1" else units.replace(" W-1", "/W")


def engineering(value: float) -> str:
    """A number in engineering notation if it is large or small, such as 24.5e9; it reads back exactly."""
    if value == 0.0 or 1e-3 <= abs(value) < 1e6 or not abs(value) < float("inf"):
        return f"{value}"
    digits = Decimal(repr(value))
    exponent = 3 * (digits.adjusted() // 3)
    return f"{digits.scaleb(-exponent).normalize():f}e{exponent}"


def short(value: Any) -> str:
    """A number with four digits; other values unchanged."""
    return engineering(float(f"{value:.4g}")).removesuffix(".0") if isinstance(value, float) else str(value)


def printable(text: str) -> str:
    """Text on one line with unprintable characters replaced, safe for terminals and drawings."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
