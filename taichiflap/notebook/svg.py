"""Small SVG pictures without matplotlib, which takes half a second to load."""

from collections.abc import Iterable, Sequence
from html import escape

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..drawing import palette

Array = NDArray[np.float64]

POINTS = 200
"""Maximum number of points of a curve."""
PAD = 4.0


def picture(width: float, height: float, parts: Iterable[str], label: str) -> str:
    """An SVG of some parts, with a text description for accessibility."""
    size = f'width="{width:g}" height="{height:g}" viewBox="0 0 {width:g} {height:g}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" aria-label="{escape(label)}">{"".join(parts)}</svg>'
    )


def curve(values: ArrayLike, title: str, unit: str, width: float = 200.0, height: float = 64.0) -> str:
    """A sparkline: a curve, its zero line, and its minimum and maximum as text."""
    y = np.asarray(values, dtype=float)
    y = y[:: max(1, -(-len(y) // POINTS))]
    known = y[np.isfinite(y)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    top, foot = 18.0, height - 4.0
    span = (high - low) or 1.0
    across = np.linspace(PAD, width - PAD, len(y))
    up = foot - (y - low) / span * (foot - top)
    places = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, up, strict=True) if np.isfinite(b))
    said = f"{title}: {_number(low)} to {_number(high)} {unit}".strip()
    parts = [f'<text x="{PAD:g}" y="12" font-size="11" fill="{palette.LIGHT.ink}">{escape(said)}</text>']
    if low < 0.0 < high:
        zero = foot + low / span * (foot - top)
        parts.append(line((PAD, zero), (width - PAD, zero), palette.LIGHT.faint, 1.0))
    parts.append(f'<polyline points="{places}" fill="none" stroke="{palette.LINES[0]}" stroke-width="1.5"/>')
    return picture(width, height, parts, said)


class Page:
    """Mapping from positions in metres (right, up) to a picture.

    Args:
        box: left, right, bottom and top, m.
        width, height: maximum size of the picture.
    """

    def __init__(self, box: Sequence[float], width: float, height: float) -> None:
        left, right, bottom, top = box
        self.scale = min(width / (right - left), height / (top - bottom))
        self.width, self.height = self.scale * (right - left), self.scale * (top - bottom)
        self._corner = np.array((left, top))

    def __call__(self, places: ArrayLike) -> Array:
        """Positions (..., 2) on the picture."""
        found: Array = (np.asarray(places, dtype=float) - self._corner) * (self.scale, -self.scale)
        return found


def line(start: Sequence[float] | Array, end: Sequence[float] | Array, colour: str, thick: float) -> str:
    """A line between two points of the picture."""
    (a, b), (c, d) = start, end
    return f'<path d="M{a:.1f} {b:.1f}L{c:.1f} {d:.1f}" stroke="{colour}" stroke-width="{thick:g}" fill="none"/>'


def path(places: Array, colour: str, thick: float) -> str:
    """A line through points (n, 2) of the picture."""
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in places)
    return (
        f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="{thick:g}" stroke-linecap="round"/>'
    )


def dots(places: Array, colours: NDArray[np.uint8], size: float) -> Iterable[str]:
    """Dots at points (n, 2) with colours (n, 3)."""
    for (a, b), colour in zip(places, colours, strict=True):
        yield f'<circle cx="{a:.1f}" cy="{b:.1f}" r="{size:g}" fill="{css(colour)}"/>'


def css(colour: NDArray[np.uint8]) -> str:
    """A colour as `#rrggbb`."""
    return "#{:02x}{:02x}{:02x}".format(*map(int, colour))


def _number(value: float) -> str:
    return f"{value:.3g}".replace("-", "−")
