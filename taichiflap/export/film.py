"""Films of the last beats, mp4 and gif, rendered without a screen."""

import contextlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.text import Annotation, Text
from numpy.typing import NDArray
from PIL import Image

from .. import files
from ..drawing import flow, palette, scene
from ..drawing.orientation import INERTIAL
from ..errors import extra
from ..notation import prefixed
from ..results.reader import Result

TALL, WIDE = 840, 1040
"""Maximum size of the picture inside its margins, pixels."""
ABOVE, BELOW, BESIDE, NARROWEST = 96, 24, 176, 640
DPI = 100
MP4_RATE, GIF_RATE = 25, 20
"""Frames per second; a gif counts in hundredths of a second."""
MP4_BEAT, GIF_BEAT = 100, 50
"""Maximum number of frames per beat."""
GIF_SCALE = 0.6
ACROSS = 420
"""Points along the longer side of a picture of the flow in a film of full size."""
FINE = 0.6
"""Width of the wing over such a picture, relative to that of one alone."""


def write_mp4(
    result: Result, path: Path, beats: int, theme: palette.Theme = palette.LIGHT, reference: str = INERTIAL
) -> int:
    """Write an H.264 film of the last beats and return its number of frames.

    Args:
        reference: the frame of reference that it is drawn in.

    Raises:
        SceneError: if the result has no whole beat.
        OutputError: if the file cannot be written, or imageio-ffmpeg is missing.
    """
    imageio_ffmpeg = extra("imageio_ffmpeg", "video", "mp4 needs imageio-ffmpeg", files.OutputError)
    film = Film(result, beats, MP4_BEAT, MP4_RATE, theme=theme, reference=reference)
    with files.standing_in(path) as draft:
        writer = imageio_ffmpeg.write_frames(
            str(draft), film.size, fps=MP4_RATE, codec="libx264", macro_block_size=2, ffmpeg_log_level="error",
            output_params=["-crf", "20", "-preset", "veryfast", "-movflags", "+faststart"], quality=None,
        )  # fmt: skip
        with contextlib.closing(writer):
            writer.send(None)
            for picture in film.pictures():
                writer.send(np.ascontiguousarray(picture))
    return len(film.frames)


def write_gif(
    result: Result, path: Path, beats: int, theme: palette.Theme = palette.LIGHT, reference: str = INERTIAL
) -> int:
    """Write a looping animated gif of the last beats and return its number of frames.

    Args:
        reference: the frame of reference that it is drawn in.

    Raises:
        SceneError: if the result has no whole beat.
        OutputError: if the file cannot be written.
    """
    film = Film(result, beats, GIF_BEAT, GIF_RATE, GIF_SCALE, theme, reference)
    pictures = film.pictures()
    first = Image.fromarray(next(pictures)).quantize(255)
    others = (Image.fromarray(picture).quantize(palette=first, dither=Image.Dither.NONE) for picture in pictures)
    with files.replacing(path) as file:
        first.save(
            file, format="GIF", save_all=True, append_images=others, duration=1000 // GIF_RATE, loop=0, optimize=False
        )
    return len(film.frames)


class Film:
    """Pictures of a result's last beats. Static parts are drawn once, moving parts for each frame.

    Args:
        beats: number of last beats.
        most: maximum number of frames per beat; every n-th stored frame is used.
        rate: frames per second.
        scale: size, relative to the largest.
        theme: the colours.
        reference: the frame of reference that it is drawn in.
    """

    def __init__(
        self,
        result: Result,
        beats: int,
        most: int,
        rate: int,
        scale: float = 1.0,
        theme: palette.Theme = palette.LIGHT,
        reference: str = INERTIAL,
    ) -> None:
        self.theme, self._scale = theme, scale
        stored = scene.last_beats(result, beats)[:-1]
        beats = max(1, round(float(len(stored)) * result.case.output.every / result.case.steps_per_beat))
        stride = math.ceil(len(stored) / beats / most)
        self.frames = [scene.frame(result, int(index), reference) for index in stored[::stride]]
        self._case = result.case
        self._inertial = reference == INERTIAL
        self._stroke = scene.stroke(result, stored) if self._inertial else None
        self.chord = result.case.wing.chord
        self.backdrop = flow.Backdrop.of(result, stored, reference)
        self.shared = scene.bounds(self.frames, result.case, self.backdrop.box if self.backdrop else None)
        self.dotted = any(len(frame.wake) for frame in self.frames)
        self.keyed = self.dotted or self.backdrop is not None
        left, right, bottom, top = self.shared.page
        pixels = min(WIDE / (right - left), TALL / (top - bottom))
        inside = ((right - left) * pixels, (top - bottom) * pixels)
        width = max(inside[0] + (BESIDE if self.keyed else 0), NARROWEST)
        height = inside[1] + ABOVE + BELOW
        self.size = (_even(width * scale), _even(height * scale))
        self._figure = Figure(figsize=(self.size[0] / DPI / scale, self.size[1] / DPI / scale), dpi=DPI * scale)
        self._figure.set_facecolor(theme.ground)
        self._canvas = FigureCanvasAgg(self._figure)
        margin = 0.5 * (width - inside[0] - (BESIDE if self.keyed else 0)) / width
        self._axes = self._figure.add_axes((margin, BELOW / height, inside[0] / width, inside[1] / height))
        self._axes.set(xlim=(left, right), ylim=(bottom, top))
        self._axes.set_axis_off()
        seconds = len(self.frames) / beats / rate
        self._draw_ground(result, scene.pace(result.case, seconds), width, height, margin + inside[0] / width)
        self._moving = self._movers(height, 72.0 / DPI * pixels * self.chord)

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """The pictures in order, RGB, shape (height, width, 3)."""
        self._canvas.draw()
        ground = self._canvas.copy_from_bbox(self._figure.bbox)
        wake, load, wing, edge, clock, force = self._moving
        movers = [*self._moving]
        if self.backdrop:
            # The movers of a page that is filled to its edges: the picture, and what stands still on it.
            picture = self._axes.imshow(np.zeros((2, 2, 3), np.uint8), **self._spread())
            movers = [picture, *self._still, wing, edge, clock, force]
        arrow = scene.REACH * self.chord
        for frame in self.frames:
            self._canvas.restore_region(ground)
            order = np.argsort(np.abs(frame.circulation))
            wake.set_offsets(frame.wake[order])
            wake.set_array(frame.circulation[order])
            wing.set_data(*frame.wing.T)
            edge.set_data(*frame.wing[:1].T)
            if self.backdrop:
                picture.set_data(
                    self.backdrop.picture(frame, self.shared.page, round(ACROSS * self._scale), self.theme)
                )
            elif not self.dotted:
                tips = frame.middles + frame.traction * arrow / self.shared.traction
                load.set_xy(np.concatenate((frame.middles, tips[::-1])))
            tip = frame.foot + frame.force * arrow / self.shared.force
            force.xyann, force.xy = (frame.foot[0], frame.foot[1]), (tip[0], tip[1])
            clock.set_text(self._clock(frame.beats))
            for artist in movers:
                self._figure.draw_artist(artist)
            yield np.asarray(self._canvas.buffer_rgba())[..., :3].copy()

    def _spread(self) -> dict[str, Any]:
        """How a picture fills the page."""
        return {
            "extent": self.shared.page, "origin": "lower", "interpolation": "bicubic", "aspect": "auto",
            "animated": True, "zorder": 0,
        }  # fmt: skip

    def _clock(self, beats: float) -> str:
        if not self._case.periodic:
            return scene.when(self._case, beats)
        beat = math.floor(beats + 1e-9)
        return f"beat {beat + 1},  t/T = {abs(beats - beat):.2f}"

    def _movers(self, height: float, size: float) -> tuple[PathCollection, Polygon, Line2D, Line2D, Text, Annotation]:
        """Parts drawn for each frame; `size` is the chord on the page, points."""
        axes = self._axes
        width = np.clip(0.032 * size, 1.6, 3.6) * (FINE if self.backdrop else 1.0)
        cmap = ListedColormap(palette.table(self.theme.anchors) / 255.0)
        limits = Normalize(-self.shared.circulation, self.shared.circulation)
        wake = axes.scatter(
            [], [], c=[], s=np.clip(0.035 * size, 2.2, 4.0) ** 2, linewidths=0.0, cmap=cmap, norm=limits
        )
        (wing,) = axes.plot([], [], color=self.theme.ink, linewidth=width, solid_capstyle="round")
        (edge,) = axes.plot([], [], "o", color=self.theme.ink, markersize=1.9 * width)
        load = Polygon(np.zeros((1, 2)), facecolor=f"{self.theme.force}40", edgecolor=self.theme.force, linewidth=1.2)
        axes.add_patch(load)
        clock = self._figure.text(
            0.5,
            1.0 - 64.0 / height,
            "",
            ha="center",
            va="center",
            fontsize=14,
            color=self.theme.ink,
            family="DejaVu Sans Mono",
        )
        force = axes.annotate(
            "", (0, 0), (0, 0), annotation_clip=False,
            arrowprops={"arrowstyle": "-|>", "color": self.theme.force, "linewidth": 2.0, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip
        movers = (wake, load, wing, edge, clock, force)
        for artist in (*movers, *self._still):
            artist.set_animated(True)
        return movers

    def _draw_ground(self, result: Result, pace: str, width: float, height: float, right: float) -> None:
        figure, axes, chord = self._figure, self._axes, self.chord
        title = f"{scene.label(result)}   ({result.case.model}, {pace})"
        head = figure.text(
            0.5,
            1.0 - 26.0 / height,
            title,
            ha="center",
            va="center",
            fontsize=11,
            color=self.theme.muted,
            parse_math=False,
        )
        # A long title is shrunk to fit a narrow page.
        head.set_fontsize(11 * min(1.0, 0.97 * figure.bbox.width / head.get_window_extent().width))
        if self._stroke is not None:
            axes.plot(*self._stroke.T, color=self.theme.muted, linewidth=0.8, linestyle=(0, (5, 4)))
        left, _, bottom, top = self.shared.page
        self._draw_stream(left + 0.25 * chord, top - 0.3 * chord)
        start, base = left + 0.25 * chord, bottom + 0.2 * chord
        axes.plot([start, start + chord], [base, base], color=self.theme.ink, linewidth=2.0, solid_capstyle="butt")
        axes.annotate(
            f"1 chord = {1e3 * chord:g} mm", (start, base), (0, 6), textcoords="offset points", fontsize=11,
            color=self.theme.ink,
        )  # fmt: skip
        at = (start, bottom + 0.2 * chord + 0.09 * (top - bottom))
        axes.annotate(
            "", (at[0] + scene.REACH * chord, at[1]), at,
            arrowprops={"arrowstyle": "-|>", "color": self.theme.force, "linewidth": 2.0, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip
        factor, unit = prefixed(self.shared.force, "N")
        force = f"force {factor * self.shared.force:g} {unit}"
        if not self.keyed:
            force += f"; load along the chord {self.shared.traction:g} Pa"
        axes.annotate(force, at, (0, 8), textcoords="offset points", fontsize=11, color=self.theme.ink)
        # Over a picture of the flow, which is drawn anew for each frame.
        self._still = [one for one in axes.get_children() if one in (*axes.lines, *axes.texts)] if self.backdrop else []
        if self.keyed:
            self._draw_legend(right, width, height)

    def _draw_stream(self, x: float, y: float) -> None:
        """An arrow along the free stream, if any."""
        if self._inertial and (text := scene.stream(self._case)):
            self._axes.annotate(
                "", (x + self.chord, y), (x, y), arrowprops={"arrowstyle": "->", "color": self.theme.ink, "shrinkA": 0}
            )
            self._axes.annotate(text, (x, y), (0, 6), textcoords="offset points", fontsize=11, color=self.theme.ink)

    def _draw_legend(self, right: float, width: float, height: float) -> None:
        bar = self._figure.add_axes((right + 44 / width, 0.24, 18 / width, 0.5))
        limit = self.backdrop.limit if self.backdrop else self.shared.circulation
        anchors = self.theme.flow if self.backdrop else self.theme.anchors
        bar.imshow(palette.table(anchors)[::-1, None, :], extent=(0, 1, -limit, limit), aspect="auto")
        bar.set(xticks=[], yticks=np.linspace(-limit, limit, 5))
        bar.yaxis.set_major_formatter("{x:g}")
        bar.yaxis.tick_right()
        bar.tick_params(labelsize=10, color=self.theme.muted, labelcolor=self.theme.ink)
        bar.set_title("ω (s⁻¹)" if self.backdrop else "Γ (m² s⁻¹)", fontsize=11, color=self.theme.ink, pad=10)
        bar.spines[:].set_visible(False)


def _even(pixels: float) -> int:
    """An even whole number, as required by H.264."""
    return 2 * round(pixels / 2.0)
