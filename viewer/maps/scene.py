"""Drawing of a map: its cases, front and axes; and the position of clicks."""

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
CELLS, CONTOURS, FRONT, POINTS = 0.02, 0.015, 0.01, 0.0
"""Depth of each layer, away from the viewer."""
HATCH = 16
"""Pixels from one line of a hatching to the next where the model does not hold; twice that where the wing bends far."""
FEWEST = 1.0
"""A contour shorter than this bears no number."""


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


def shares(right: float, up: float) -> tuple[float, float]:
    """A place of the scene as shares of the picture."""
    return right / WIDTH, up / HEIGHT


def hit(event: Any) -> tuple[float, float] | None:
    """The place that a click on the scene hits, as shares of the picture."""
    origin, direction = np.array(event.ray_origin), np.array(event.ray_direction)
    if not direction[1]:
        return None
    spot = origin - direction * (origin[1] / direction[1])
    return shares(float(spot[0]), float(spot[2]))


def _draw_cells(scene: Any, picture: Picture, theme: Theme) -> None:
    rows, columns = picture.numbers.shape
    repeat = max(1, PIXELS // max(rows, columns))
    large = np.ones((repeat, repeat), dtype=np.uint8)
    image = np.kron(_colours(picture, theme)[::-1], large[:, :, None])
    across = np.add.outer(np.arange(len(image)), np.arange(image.shape[1]))
    for mask, every, colour in (
        (picture.broken, HATCH, theme.ink), (picture.bent & ~picture.broken, 2 * HATCH, (255, 255, 255))
    ):  # fmt: skip
        line = (across % every < 2) & np.kron(mask[::-1], large).astype(bool)
        image[line] = (0.5 * (image[line] + np.array(colour))).astype(np.uint8)
    scene.add_image(
        "/map/cells", image, WIDTH, HEIGHT, format="png", wxyz=(np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0),
        position=place(np.array([0.5 * WIDTH, 0.5 * HEIGHT]), CELLS), cast_shadow=False, receive_shadow=False,
    )  # fmt: skip
    _draw_contours(scene, picture)


def _draw_contours(scene: Any, picture: Picture) -> None:
    size = np.array((WIDTH, HEIGHT))
    for number, (level, lines) in enumerate(picture.contours()):
        if not lines:
            continue
        segments = np.concatenate([polyline(line * size, CONTOURS) for line in lines])
        scene.add_line_segments(
            f"/map/contour/{number}", segments, (255, 255, 255), thickness=1.2, thickness_units="screen"
        )
        longest = max(lines, key=lambda line: float(np.hypot(*np.diff(line * size, axis=0).T).sum()))
        if np.hypot(*np.diff(longest * size, axis=0).T).sum() > FEWEST:
            # Not all in a row: levels follow one another.
            middle = longest[int((0.3 + 0.4 * (number % 2)) * len(longest))] * size
            scene.add_label(
                f"/map/level/{number}", f"{level:.4g}", position=place(middle, FRONT), anchor="center-center",
                font_screen_scale=0.8,
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
