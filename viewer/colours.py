"""Colours: two themes, and maps that people with any colour vision can read.

Circulation runs from blue to orange and pressure from magenta to green, both through a neutral colour of the theme that
stands out from the background.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taichiflap.drawing import palette

Rgb = tuple[int, int, int]
Colours = NDArray[np.uint8]

LEVELS = palette.LEVELS


class Map:
    """A colour map, given by evenly spaced `#rrggbb` stops and interpolated as in `palette`."""

    def __init__(self, *stops: str) -> None:
        self.stops = stops
        self.table = palette.table(stops)

    def symmetric(self, values: NDArray[np.floating], limit: float) -> Colours:
        """Colours of `values`, with zero in the middle and `-limit`, `limit` at the ends; shape (..., 3)."""
        return self.between(values, -limit, limit)

    def between(self, values: NDArray[np.floating], low: float, high: float) -> Colours:
        """Colours of `values`, with `low` and `high` at the ends; shape (..., 3)."""
        level = (np.asarray(values) - low) * ((LEVELS - 1) / max(high - low, 1e-300))
        return self.table[np.clip(np.rint(level), 0, LEVELS - 1).astype(np.intp)]


@dataclass(frozen=True)
class Theme:
    """Colours of the scene on one background.

    Attributes:
        ink: labels, the scale bar.
        faint: the stroke plane, the pivot's path, the undeformed chord.
        force: the force vector.
        load: the force along the chord.
        velocity: velocity arrows.
        flow: stored vorticity, which has the picture to itself.
    """

    background: Rgb
    ink: Rgb
    faint: Rgb
    force: Rgb
    load: Rgb
    velocity: Rgb
    circulation: Map
    pressure: Map
    vorticity: Map
    speed: Map
    flow: Map


RUNS = "#1f7bd0", "#cc5f10"
"""Colours of curves of one and of two results. They are visible on both backgrounds, so that no chart is rebuilt for
another theme; a page reports an error if a chart is removed just after new data were sent.
"""

METRIC = Map("#440154", "#3b528b", "#21918c", "#5ec962", "#fde725")
"""Colours of a metric over a map: viridis, as in figures."""


def linear(colours: Colours) -> Colours:
    """Colours for lines, which alone viser interprets as linear light."""
    share = colours / 255.0
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.round(255.0 * light).astype(np.uint8)


def rgb(colour: str) -> Rgb:
    """`#rrggbb` as three numbers up to 255."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def css(colour: Rgb) -> str:
    """Three numbers up to 255 as `#rrggbb`."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


LIGHT = Theme(
    background=(255, 255, 255),
    ink=(40, 44, 52),
    faint=(170, 176, 186),
    force=(200, 30, 45),
    load=(14, 128, 112),
    velocity=(95, 103, 117),
    circulation=Map(*palette.LIGHT.anchors),
    pressure=Map("#c2148a", "#2a2a2e", "#2c9a1f"),
    vorticity=Map("#5b9bd3", "#b9d5ec", "#ffffff", "#f3cfb0", "#e39a5f"),
    speed=Map("#ffffff", "#d5e4e8", "#93bfc9", "#4a8c9c", "#1d5566"),
    flow=Map(*palette.LIGHT.flow),
)

DARK = Theme(
    background=(20, 20, 20),
    ink=(226, 230, 236),
    faint=(98, 104, 114),
    force=(255, 92, 105),
    load=(70, 205, 185),
    velocity=(168, 176, 190),
    circulation=Map(*palette.DARK.anchors),
    pressure=Map("#ff6fd0", "#f4f4f6", "#7fe05a"),
    vorticity=Map("#2f78b3", "#1e4260", "#141414", "#593a20", "#ab6327"),
    speed=Map("#141414", "#1d333a", "#2c6170", "#5ba3b3", "#c4ecf2"),
    flow=Map(*palette.DARK.flow[:3], "#141414", *palette.DARK.flow[4:]),
)


def theme(dark: bool) -> Theme:
    """The colours for a dark or a light background."""
    return DARK if dark else LIGHT
