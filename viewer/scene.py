"""The scene of one browser: the wing, its wake and the forces, drawn in a plane.

The scene's x is to the right and its z upwards, in chords; its y only orders the layers.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taichiflap.drawing.palette import SHEETS

from . import wire
from .colours import RUNS, Rgb, Theme, linear, rgb
from .frame import Array, Frame
from .frames import Run
from .survey import Ranges

FIELD, ARROWS, PLANE, WAKE, STREAK, GHOST, LOAD, WING, FORCE = (
    0.05,
    0.045,
    0.04,
    0.03,
    0.005,
    -0.01,
    -0.02,
    -0.03,
    -0.04,
)
"""Depth of each layer, chords away from the viewer."""
WAKE_DEPTH = 0.02
"""Depth between strong and weak vortices."""

STATIONS = 13
"""Number of points along the chord at which velocity and load are drawn."""
FORCE_CHORDS, VELOCITY_CHORDS, LOAD_CHORDS = 1.0, 0.5, 0.5
"""Length of an arrow of full range."""

LAYERS = {
    "wake": ("Wake", "vortices shed by the wing"),
    "sheets": ("Two sheets", "colour the wake by the edge that shed it instead of by circulation"),
    "ghost": ("Undeformed", "chord of the undeformed wing"),
    "stroke": ("Stroke plane", "the stroke plane and the pivot's path"),
    "force": ("Force", "the fluid's force on the whole wing"),
    "velocity": ("Wing velocity", "velocity of points of the wing relative to the fluid"),
    "load": ("Local force", "the fluid's force along the chord"),
    "arrows": ("Flow arrows", "the fluid's velocity, over a background"),
    "streamlines": ("Streamlines", "streamlines of the flow, over a background"),
    "streaks": (
        "Streak lines",
        "from the leading (red) and trailing edge (grey), and where you double-click",
    ),
    "riding": ("Wing's frame", "the flow as seen from the wing"),
}
"""Title and description of each layer."""


def default_layers(run: Run) -> dict[str, bool]:
    """Initially visible layers; a model without a wake or a stored flow shows its local forces."""
    wake, pictured = run.has_wake, run.stores_vorticity
    shown = {"wake": wake, "sheets": False, "ghost": not pictured, "stroke": True, "force": True}
    details = not (wake or pictured)
    flow = {"arrows": not pictured, "streamlines": False, "streaks": False, "riding": False}
    return shown | {"velocity": details, "load": details} | flow


def place(points: Array, depth: float | Array) -> NDArray[np.float32]:
    """Points (..., 2) on the screen as points of the scene."""
    placed = np.empty((*points.shape[:-1], 3), dtype=np.float32)
    placed[..., 0], placed[..., 1], placed[..., 2] = points[..., 0], depth, points[..., 1]
    return placed


def polyline(points: Array, depth: float) -> NDArray[np.float32]:
    """Line segments (n, 2, 3) through points (n + 1, 2)."""
    return place(np.stack((points[:-1], points[1:]), axis=1), depth)


def arrows(tails: Array, vectors: Array, depth: float, head: float) -> NDArray[np.float32]:
    """Line segments (3 n, 2, 3) that draw arrows; a head is `head` chords long, or a third of a short arrow."""
    tips = tails + vectors
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    along = vectors / np.maximum(length, 1e-12) * np.minimum(head, length / 3.0)
    aside = 0.5 * np.stack((-along[..., 1], along[..., 0]), axis=-1)
    lines = [(tails, tips), (tips, tips - along + aside), (tips, tips - along - aside)]
    return place(np.stack([np.stack(line, axis=1) for line in lines], axis=1).reshape(-1, 2, 2), depth)


def wing_colours(frame: Frame, theme: Theme, limit: float) -> NDArray[np.uint8]:
    """Colours (n, 2, 3) of the wing's segments by pressure jump."""
    colours = theme.pressure.symmetric(frame.pressure, limit)
    return np.repeat(linear(colours)[:, None], 2, axis=1)


def wake_points(frame: Frame, limit: float) -> NDArray[np.float32]:
    """Points (n, 3) of the wake vortices, strong ones above weak ones."""
    strength = np.minimum(np.abs(frame.circulation) / limit, 1.0)
    return place(frame.wake, WAKE - WAKE_DEPTH * strength)


@dataclass(frozen=True)
class Look:
    """Style that distinguishes the results in a scene.

    Attributes:
        prefix: prefix of the names of its layers.
        colour: colour of its wing; None shows the pressure instead.
        shape: shape of its vortices.
        width: line width of its wing, pixels.
        lift: depth of its wing above the other's, chords.
    """

    prefix: str
    colour: Rgb | None
    shape: str
    width: float = 7.0
    lift: float = 0.0


def looks(runs: list[Run]) -> list[Look]:
    """Styles of one result or of two; the wing is thin in front of a stored flow."""
    if len(runs) == 1:
        return [Look("", None, "circle", 3.5 if runs[0].stores_vorticity else 7.0)]
    first, second = (rgb(colour) for colour in RUNS)
    # A thin line over a thick one, so that both are visible where they agree.
    return [Look("", first, "circle", 10.0), Look("/second", second, "diamond", 4.0, 0.005)]


class Actor:
    """The layers of one result in one browser: built once, updated for every frame."""

    def __init__(self, scene: Any, run: Run, look: Look, theme: Theme, ranges: Ranges) -> None:
        self.run, self.look, self.theme, self.ranges = run, look, theme, ranges
        self._style = look, theme.background, ranges
        frame = run.frame(0)
        lines, colour = scene.add_line_segments, look.colour
        faint = theme.faint if colour is None else colour
        screen = {"thickness_units": "screen"}
        name = look.prefix
        self.wing = lines(f"{name}/wing", self._wing(frame), self._wing_colours(frame), thickness=look.width, **screen)
        self.layers = {
            "ghost": lines(f"{name}/ghost", polyline(frame.chord, GHOST), faint, thickness=2.0, **screen),
            "force": lines(f"{name}/force", self._force(frame), colour or theme.force, thickness=3.0, **screen),
            "velocity": lines(
                f"{name}/velocity", self._velocity(frame), colour or theme.velocity, thickness=1.5, **screen
            ),
            "load": lines(f"{name}/load", self._load(frame), colour or theme.load, thickness=1.5, **screen),
        }
        if run.has_wake:
            self.layers["wake"] = scene.add_point_cloud(
                f"{name}/wake",
                np.zeros((1, 3), dtype=np.float32),
                np.zeros((1, 3), dtype=np.uint8),
                point_size=0.033 if look.shape == "circle" else 0.038,
                point_shape=look.shape,
                point_shading="flat",
                precision="float32",
            )

    def show(self, index: int, shown: dict[str, bool]) -> None:
        """Show a frame; hidden layers are not sent."""
        frame = self.run.frame(index)
        if shown["riding"]:
            frame = frame.from_wing
        drawn = frame.drawn.setdefault(self._style, {})
        handles = {"wing": self.wing}
        drawing = {"wake": "sheets"} if shown["sheets"] else {}
        for name, handle in self.layers.items():
            visible = shown[name] and (name != "wake" or len(frame.wake) > 0)
            if visible:
                handles[name] = handle
            if handle.visible != visible:
                handle.visible = visible
        for name, handle in handles.items():
            way = drawing.get(name, name)
            if way not in drawn:
                drawn[way] = self._draw(way, frame)
            wire.send(handle, **drawn[way])

    def _draw(self, name: str, frame: Frame) -> dict[str, NDArray[Any]]:
        if name == "wing":
            return {"points": self._wing(frame), "colors": self._wing_colours(frame)}
        if name in ("wake", "sheets"):
            limit = self.ranges.circulation
            colours = self.theme.circulation.symmetric(frame.circulation, limit)
            if name == "sheets":
                colours = np.array([rgb(colour) for colour in SHEETS], dtype=np.uint8)[frame.edge]
            return {"points": wake_points(frame, limit), "colors": colours}
        if name == "ghost":
            return {"points": polyline(frame.chord, GHOST)}
        shapes = {"force": self._force, "velocity": self._velocity, "load": self._load}
        return {"points": shapes[name](frame)}

    def _wing(self, frame: Frame) -> NDArray[np.float32]:
        return polyline(frame.nodes, WING - self.look.lift)

    def _wing_colours(self, frame: Frame) -> NDArray[np.uint8]:
        if self.look.colour is None:
            return wing_colours(frame, self.theme, self.ranges.pressure)
        colour = linear(np.array(self.look.colour, dtype=np.uint8))
        return np.full((len(frame.pressure), 2, 3), colour)

    def _force(self, frame: Frame) -> NDArray[np.float32]:
        middle = frame.nodes[len(frame.nodes) // 2]
        return arrows(middle[None], frame.force[None] * (FORCE_CHORDS / self.ranges.force), FORCE, 0.12)

    def _velocity(self, frame: Frame) -> NDArray[np.float32]:
        picked = _stations(len(frame.nodes))
        vectors = frame.velocity[picked] * (VELOCITY_CHORDS / self.ranges.speed)
        return arrows(frame.nodes[picked], vectors, LOAD, 0.05)

    def _load(self, frame: Frame) -> NDArray[np.float32]:
        picked = _stations(len(frame.pressure))
        middles = 0.5 * (frame.nodes[:-1] + frame.nodes[1:])
        along, across = frame.axes
        load = np.outer(frame.pressure, across)
        if len(frame.shear):
            load = load + np.outer(frame.shear, along)
        return arrows(middles[picked], load[picked] * (LOAD_CHORDS / self.ranges.pressure), LOAD, 0.05)


def common_ranges(runs: list[Run]) -> Ranges:
    """Common ranges of all results of a scene."""
    return Ranges(
        circulation=max((run.ranges.circulation for run in runs if run.has_wake), default=1.0),
        pressure=max(run.ranges.pressure for run in runs),
        force=max(run.ranges.force for run in runs),
        speed=max(run.ranges.speed for run in runs),
    )


def _stations(count: int) -> NDArray[np.intp]:
    return np.unique(np.linspace(0, count - 1, min(STATIONS, count)).round().astype(int))
