"""Colours of all drawings: a diverging map for signed values, and colours of lines. Needs only NumPy.

The map runs from blue over grey to orange: both are distinguishable with all common colour-vision deficiencies, and
lightness changes evenly from zero to either end, so that it works in a grey print.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

LEVELS = 257
"""Number of entries of a colour table; odd, so that zero has its own entry."""
SATURATED = 0.02
"""Share of values that may exceed the limits, so that a few strong vortices do not turn the others grey."""

_TO_CONES = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_TO_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)


@dataclass(frozen=True)
class Theme:
    """Colours of a drawing on a light or a dark background, as `#rrggbb`.

    Attributes:
        ground, ink, muted, faint: background, text and wing, secondary text, grid and half-stroke shading.
        force: the resultant force.
        anchors: the diverging map's colours, evenly spaced from the lower limit to the upper.
        flow: those of a map for pictures that fill the ground, which is what zero looks like.
    """

    ground: str
    ink: str
    muted: str
    faint: str
    force: str
    anchors: tuple[str, ...]
    flow: tuple[str, ...]


LIGHT = Theme(
    "#ffffff", "#16191d", "#5c6570", "#eceff2", "#008560",
    ("#08306b", "#2171c7", "#cbcbcb", "#dd5f0b", "#7a2300"),
    ("#0a3a78", "#2b7fc8", "#94c4ea", "#ffffff", "#f9bd8c", "#df6d1c", "#7f2a00"),
)  # fmt: skip
DARK = Theme(
    "#14171b", "#eef1f4", "#a2abb5", "#23282e", "#3ddba4",
    ("#c6e6ff", "#4aa3f5", "#5f6369", "#f08c38", "#ffe1b3"),
    ("#bfe3ff", "#4aa3f5", "#1f5485", "#14171b", "#7a3f12", "#f08c38", "#ffe1b3"),
)  # fmt: skip

LINES = ("#0060a8", "#d55e00")
"""Colours of the first and second result of a comparison."""
SHEETS = ("#7a8794", "#d03a8c")
"""Colours of vortices by the edge that shed them: trailing and leading edge."""
SEVERAL = (*LINES, "#008560", "#8a4fa0", "#8f6a00", "#16191d")
"""Colours of several results."""
PARTS = ("#16191d", "#0060a8", "#d55e00")
"""Colours of a total and its two parts."""


def table(colours: Sequence[str] = LIGHT.anchors) -> NDArray[np.uint8]:
    """A map through evenly spaced `#rrggbb` colours, lowest value first, sRGB, shape (LEVELS, 3).

    Colours between the anchors are interpolated in Oklab, where equal steps look equal.
    """
    anchors = _oklab(np.array([_rgb(colour) for colour in colours]))
    where = np.linspace(0.0, len(anchors) - 1.0, LEVELS)
    mixed = np.stack([np.interp(where, np.arange(len(anchors)), column) for column in anchors.T], axis=1)
    return np.rint(255.0 * _srgb(mixed)).astype(np.uint8)


def colours(values: ArrayLike, limit: float, theme: Theme = LIGHT) -> NDArray[np.uint8]:
    """Colour of each value between -limit and limit, sRGB, shape (..., 3); values outside take the end colours."""
    scaled = np.clip(np.asarray(values, dtype=float) / limit, -1.0, 1.0)
    return table(theme.anchors)[np.rint((scaled + 1.0) * (LEVELS // 2)).astype(int)]


def symmetric_limit(values: ArrayLike) -> float:
    """Limit of a symmetric colour map that contains all but a few values, rounded up to a plain number.

    1 without values, or if all are zero.
    """
    sizes = np.abs(np.asarray(values, dtype=float))
    largest = float(np.quantile(sizes, 1.0 - SATURATED)) if sizes.size else 0.0
    return rounded_up(largest or float(sizes.max(initial=0.0)) or 1.0)


def rounded_up(value: float) -> float:
    """The next number of the form 1, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten, for limits and scale bars."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(
        next(step * power for step in (1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10) if step * power >= value * (1 - 1e-9))
    )


def _rgb(colour: str) -> list[float]:
    return [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]


def _oklab(rgb: NDArray[np.float64]) -> NDArray[np.float64]:
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return np.cbrt(linear @ _TO_CONES.T) @ _TO_LAB.T


def _srgb(lab: NDArray[np.float64]) -> NDArray[np.float64]:
    linear = np.clip((lab @ np.linalg.inv(_TO_LAB).T) ** 3 @ np.linalg.inv(_TO_CONES).T, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
