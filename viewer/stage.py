"""What stands still in a scene: stroke plane, path of the pivot, stream and scale bar; and the time label."""

from typing import Any

import numpy as np

from taichiflap.drawing.scene import stream
from taichiflap.notation import prefixed

from . import wire
from .colours import Theme
from .frame import Array
from .frames import Run
from .scene import FORCE, PLANE, Actor, arrows, common_ranges, looks, place, polyline


class Stage:
    """Static parts: stroke plane, path of the pivot and scale bar; and the time label."""

    def __init__(self, scene: Any, run: Run, theme: Theme, riding: bool = False) -> None:
        screen = {"thickness_units": "screen"}
        self.stroke = [] if run.path is None else self._draw_stroke(scene, run.path, theme)
        if not riding:
            self._draw_stream(scene, run, theme)
        left, bottom, right, top = (float(edge) for edge in run.first_view(riding))
        factor, unit = prefixed(run.chord, "m")
        bar = np.array([[right - 1.0, bottom + 0.1], [right, bottom + 0.1]])
        ends = np.concatenate([polyline(end + np.array([[0.0, -0.05], [0.0, 0.05]]), FORCE) for end in bar])
        scene.add_line_segments(
            "/scale/bar", np.concatenate((polyline(bar, FORCE), ends)), theme.ink, thickness=2.0, **screen
        )
        scene.add_label(
            "/scale/label", f"1 chord = {factor * run.chord:g} {unit}", position=(right, FORCE, bottom + 0.16),
            anchor="bottom-right",
        )  # fmt: skip
        self.time = scene.add_label(
            "/time", " ", position=(0.5 * (left + right), FORCE, top), anchor="top-center", font_screen_scale=1.2
        )

    @staticmethod
    def _draw_stroke(scene: Any, path: Array, theme: Theme) -> list[Any]:
        middle, way = path.mean(axis=0), path[1] - path[0]
        length = float(np.hypot(*way))
        along, aside = way / length, np.array([-way[1], way[0]]) / length
        beyond = max(0.5 * length, 0.5) + 0.35
        dashes = middle + np.outer(np.arange(-beyond, beyond, 0.1), along)
        ticks = np.concatenate([polyline(end + np.outer((-0.06, 0.06), aside), PLANE) for end in path])
        end = middle + (beyond + 0.05) * along
        anchor = "center-left" if abs(along[0]) > abs(along[1]) else "bottom-center"
        screen = {"thickness_units": "screen"}
        return [
            scene.add_line_segments(
                "/stroke/plane", place(np.stack((dashes, dashes + 0.05 * along), axis=1), PLANE), theme.faint,
                thickness=1.5, **screen,
            ),
            scene.add_line_segments(
                "/stroke/pivot", np.concatenate((polyline(path, PLANE - 0.005), ticks)), theme.faint,
                thickness=2.5, **screen,
            ),
            scene.add_label(
                "/stroke/label", "stroke plane", position=place(end, PLANE), anchor=anchor, font_screen_scale=0.9,
            ),
        ]  # fmt: skip

    @staticmethod
    def _draw_stream(scene: Any, run: Run, theme: Theme) -> None:
        """An arrow along the free stream, if any."""
        left, top = float(run.box[0]), float(run.box[3])
        if text := stream(run.case):
            tail, way = np.array([[left + 0.1, top - 0.35]]), np.array([[0.8, 0.0]])
            scene.add_line_segments(
                "/stream/arrow", arrows(tail, way, FORCE, 0.15), theme.ink, thickness=2.0, thickness_units="screen"
            )
            scene.add_label(
                "/stream/label", text, position=(left + 0.1, FORCE, top - 0.25), anchor="bottom-left",
                font_screen_scale=0.9,
            )  # fmt: skip

    def show(self, text: str, stroke: bool) -> None:
        """Update the time label; show or hide the stroke plane."""
        wire.send(self.time, text=text)
        for handle in self.stroke:
            if handle.visible != stroke:
                handle.visible = stroke


def set_up(scene: Any, runs: list[Run], theme: Theme, riding: bool = False) -> tuple[Stage, list[Actor]]:
    """Build the scene of one result, or of two superimposed, seen from the wing if `riding`."""
    ranges = common_ranges(runs)
    shown = zip(runs, looks(runs), strict=True)
    return Stage(scene, runs[0], theme, riding), [Actor(scene, run, look, theme, ranges) for run, look in shown]
