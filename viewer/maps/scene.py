"""The picture of a map, drawn: its cases, its front, its edges; and which place of it a click hits."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..colours import METRIC, Rgb, Theme
from ..frame import Array
from ..scene import place, polyline
from .picture import Picture, Ticks

WIDTH, HEIGHT = 10.0, 6.5
"""Size of the picture in the scene."""
BOX = (-1.1, -1.1, WIDTH + 0.3, HEIGHT + 0.3)
PIXELS = 1024
"""A heat map is drawn with at least half so many pixels, so that its cells have sharp edges."""
POINT_SIZE = 0.12
TICK, NUMBER, NAME = -0.06, -0.1, -0.6
"""Where, outside of an edge, its ticks end, its numbers begin, and its name does."""
CELLS, FRONT, POINTS = 0.02, 0.01, 0.0
"""Depth of each layer, away from the viewer."""


def draw(scene: Any, picture: Picture, across: str, up: str, theme: Theme) -> None:
    """Draw a picture with the names of its edges, instead of whatever is there."""
    scene.reset()
    (_draw_cells if picture.points is None else _draw_points)(scene, picture, theme)
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]]) * (WIDTH, HEIGHT)
    _draw_lines(scene, "/map/frame", corners, theme.faint, 1.0)
    for side, (ticks, anchor) in enumerate(((picture.across, "top-center"), (picture.up, "center-right"))):
        _draw_ticks(scene, side, ticks, anchor, theme)
    scene.add_label("/map/across", across, position=place(np.array([0.5 * WIDTH, NAME]), 0.0), anchor="top-center")
    scene.add_label("/map/up", up, position=place(np.array([0.0, HEIGHT - NUMBER]), 0.0), anchor="bottom-left")


def hit(event: Any) -> tuple[float, float] | None:
    """The place that a click on the scene hits, as shares of the picture."""
    origin, direction = np.array(event.ray_origin), np.array(event.ray_direction)
    if not direction[1]:
        return None
    spot = origin - direction * (origin[1] / direction[1])
    return float(spot[0] / WIDTH), float(spot[2] / HEIGHT)


def _draw_cells(scene: Any, picture: Picture, theme: Theme) -> None:
    rows, columns = picture.numbers.shape
    repeat = max(1, PIXELS // max(rows, columns))
    image = np.kron(_colours(picture, theme)[::-1], np.ones((repeat, repeat, 1), dtype=np.uint8))
    scene.add_image(
        "/map/cells", image, WIDTH, HEIGHT, format="png", wxyz=(np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0),
        position=place(np.array([0.5 * WIDTH, 0.5 * HEIGHT]), CELLS), cast_shadow=False, receive_shadow=False,
    )  # fmt: skip


def _draw_points(scene: Any, picture: Picture, theme: Theme) -> None:
    assert picture.points is not None
    points = picture.points * (WIDTH, HEIGHT)
    there = np.isfinite(points).all(axis=1)
    scene.add_point_cloud(
        "/map/points", place(points[there], POINTS), _colours(picture, theme)[there],
        point_size=POINT_SIZE, point_shape="circle", point_shading="flat", precision="float32",
    )  # fmt: skip
    for number, front in enumerate(picture.fronts):
        if len(front) > 1:
            _draw_lines(scene, f"/map/front/{number}", points[front], theme.ink, 1.5, FRONT)


def _draw_ticks(scene: Any, side: int, ticks: Ticks, anchor: str, theme: Theme) -> None:
    size = (WIDTH, HEIGHT)[side]
    for number, (share, text) in enumerate(zip(ticks.places, ticks.texts, strict=True)):
        edge, end, spot = (np.insert([outside], side, share * size) for outside in (0.0, TICK, NUMBER))
        _draw_lines(scene, f"/map/tick/{side}/{number}", np.stack((edge, end)), theme.faint, 1.0)
        scene.add_label(f"/map/number/{side}/{number}", text, position=place(spot, 0.0), anchor=anchor)


def _draw_lines(scene: Any, name: str, points: Array, colour: Rgb, width: float, depth: float = 0.0) -> None:
    scene.add_line_segments(name, polyline(points, depth), colour, thickness=width, thickness_units="screen")


def _colours(picture: Picture, theme: Theme) -> NDArray[np.uint8]:
    low, high = picture.limits
    colours = METRIC.between(np.nan_to_num(picture.values, nan=low), low, high)
    colours[~np.isfinite(picture.values)] = theme.faint
    return colours
