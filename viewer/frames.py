"""A result as needed by the scene: one frame at a time, in chords, with the stream to the right and lift up.

Only this module reads the file. Frames are kept in a small cache shared by all browsers.
"""

import contextlib
import tempfile
import threading
import time
from collections import OrderedDict
from pathlib import Path

import h5py
import numpy as np

from taichiflap import Result, fluids
from taichiflap.drawing import flow, scene
from taichiflap.drawing.orientation import INERTIAL, WING, Standpoint
from taichiflap.errors import UserError
from taichiflap.fluids.interface import FlowField, Velocity
from taichiflap.metrics.summary import Summary, summarise
from taichiflap.motion import sampling
from taichiflap.motion.stream import in_stream
from taichiflap.results.reader import ResultError

from .clock import Clock
from .frame import Array, Frame
from .survey import HEADROOM, Ranges, survey
from .watch import Watch

UNREADABLE = (OSError, RuntimeError, KeyError, ValueError)
"""Exceptions of HDF5 for a file that changes during reading, or is closed until the next refresh."""

IN_STREAM = ("lift", "thrust")
"""Forces derived from stored ones."""
CACHE_BYTES = 2**25
SURVEYED = 12
"""Number of frames used to choose colour ranges and the initial view."""


class Run(Clock):
    """A result file, complete or growing, shared by all browsers.

    Args:
        result: the open result; the run closes it.
        label: short name in comparisons.
        like: another run whose ranges and initial view are used.

    Attributes:
        path: both ends of the pivot's path in the last beat, chords, shape (2, 2); None if it is at rest.
        trouble: sentence about a changed or deleted file; empty if it is unchanged.
        ranges, box: scales of colours and arrows, and the box (left, bottom, right, top; chords) of the initial view.
            For a growing run they are updated each time its length doubles, and when it is complete.
        surveys: number of these updates.
    """

    def __init__(self, result: Result, label: str, like: "Run | None" = None) -> None:
        self.result = result
        self.label = label
        super().__init__(result.case)
        self.chord = self.case.wing.chord
        self.title = self.case.title or label
        self.trouble = ""
        self._document = result.attributes["case"]
        self._begin_to_watch()
        self._lock = threading.RLock()
        self._cache: OrderedDict[int, Frame] = OrderedDict()
        self._held = 0
        self.surveys = self._surveyed = 0
        self._given: tuple[Ranges, Array] | None = None if like is None else (like.ranges, like.box)
        self._summary: Summary | None = None
        if not result.frames:
            raise ResultError(f"{result.path}: has no frame yet")
        self._model = fluids.known(self.case.solver)
        self.draws_flow = self._model is not None and self._model.draws_flow
        self.stores_vorticity = flow.stored(result)
        self.has_streamlines = self.stores_vorticity and self.case.fluid.gust == "none"
        self._extents: dict[str, flow.Extent] = {}
        self._load()
        self._first_seen = self.steps, time.monotonic()

    def _load(self) -> None:
        self.frames = self.result.frames
        self.steps = self.result.steps
        self.status = self.result.status
        # Only the short reason; `info` prints details and cures.
        self.reason = str(self.result.attributes.get("reason", "")).partition(";")[0].partition(". ")[0]
        self.has_wake, self.has_sheets = self.result.has_wake, self.result.has_sheets
        self.variables = self.result.variables
        self.station = self.result.stations
        self.shape = self.result.modes.get("shape", np.zeros((0, len(self.station))))
        if not self.surveys or self.frames >= 2 * self._surveyed or not self.live:
            self._extents.clear()
            self.ranges, self.box = self._given or self._survey()
            self.path = self._reach()
            self.surveys, self._surveyed = self.surveys + 1, self.frames

    @property
    def live(self) -> bool:
        """Whether the run is still growing."""
        return self.status == "running"

    @property
    def progress(self) -> str:
        """Progress of a growing run, and estimated time left."""
        done, seconds = self.steps - self._first_seen[0], time.monotonic() - self._first_seen[1]
        share = f"{100 * (self.steps - 1) // self.case.steps} %"
        if done < self.case.steps / 100 or seconds < 1.0:
            return share
        left = seconds * (self.case.steps + 1 - self.steps) / done
        return f"{share}, {left:.0f} s left" if left < 100.0 else f"{share}, {left / 60.0:.0f} min left"

    def refresh(self) -> bool:
        """Check for new frames and for a changed file; returns whether anything has changed."""
        with self._lock:
            before = self.trouble
            grown = self.live and not before and self._grow()
            self.trouble = self.trouble or self._watch.look()
            return grown or self.trouble != before

    def _grow(self) -> bool:
        """Check for new frames; returns whether there are any. A file in the middle of a write is checked later."""
        before = self.steps, self.status
        try:
            self.result.refresh()
            # Frames read from the end of a growing file may be incomplete.
            self._cache.clear()
            self._held = 0
            if self.result.attributes["case"] != self._document:
                self.trouble = f"{self.label} has been replaced by another result; restart the viewer to see it."
                return False
            if self.result.path != self._path or self.result.status != self.status:
                self._begin_to_watch()
            if (self.result.steps, self.result.status) == before:
                return False
            self._load()
        except (ResultError, *UNREADABLE):
            return False
        return True

    def _begin_to_watch(self) -> None:
        self._path = self.result.path
        self._watch = Watch(self._path, fixed=self.result.status != "running")

    def close(self) -> None:
        """Close the file."""
        with self._lock:
            self.result.close()

    def content(self) -> bytes:
        """The result's file."""
        with self._lock:
            if isinstance(self.result.file, h5py.File):
                return self.result.file.id.get_file_image()
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder, "result.h5")
                self.result.save(path)
                return path.read_bytes()

    def frame(self, index: int) -> Frame:
        """A frame, from the cache if it was shown lately.

        Raises:
            OSError: when a file that is being written cannot be read just now.
        """
        with self._lock:
            index = min(max(index, 0), self.frames - 1)
            if self.live and self.trouble:
                raise OSError(self.trouble)
            if index in self._cache:
                self._cache.move_to_end(index)
                return self._cache[index]
            try:
                frame = self._read(index)
            except UNREADABLE as error:
                raise OSError(f"frame {index} cannot be read: {error}") from None
            self._cache[index] = frame
            self._held += frame.size
            while self._held > CACHE_BYTES and len(self._cache) > 1:
                self._held -= self._cache.popitem(last=False)[1].size
            return frame

    def series(self, name: str, first: int, last: int, most: int) -> tuple[Array, Array]:
        """Times (beats) and values, in SI units, of a series at `most` steps at most, evenly from `first` to `last`.

        Values that cannot be read are NaN.
        """
        stride = max(1, -(-(last - first) // (most - 1)))
        picked = np.array([*range(first, last, stride), last])
        with self._lock:
            try:
                values = np.concatenate(
                    (self.result.between(name, first, last - 1, stride), self.result.between(name, last, last))
                )
            except UNREADABLE:
                values = np.full((len(picked), len(self.shape)) if name == "q" else len(picked), np.nan)
        return picked / self.steps_per_beat, values

    def velocity(self, index: int) -> Velocity | None:
        """The flow of a frame from its fluid model; None if the model has none.

        Raises:
            OSError: when a file that is being written cannot be read just now.
        """
        with self._lock:
            try:
                return self._model.velocity(self.result, index) if self._model else None
            except UNREADABLE as error:
                raise OSError(f"frame {index} cannot be read: {error}") from None

    def flow_field(self, index: int) -> FlowField | None:
        """The fluid model's flow field of a frame.

        Raises:
            OSError: when a file that is being written cannot be read just now.
        """
        with self._lock:
            try:
                return self._model.field(self.result, index) if self._model else None
            except UNREADABLE as error:
                raise OSError(f"frame {index} cannot be read: {error}") from None

    def standpoint(self, index: int, riding: bool) -> Standpoint:
        """Frame of reference of a frame: the wing's if `riding`."""
        with self._lock:
            try:
                return Standpoint.of(self.result, index, WING if riding else INERTIAL)
            except UNREADABLE as error:
                raise OSError(f"frame {index} cannot be read: {error}") from None

    def carried(self, index: int) -> flow.Carried:
        """Velocity of points that move with the wing in a frame."""
        return flow.Carried.at(self.case, self.time(index))

    def extent(self, riding: bool) -> flow.Extent:
        """Extent of the stored vorticity of the last beat, m, and the limit of its colours."""
        frame = WING if riding else INERTIAL
        with self._lock:
            if frame not in self._extents:
                first = max(0, round(self.frames - 1 - self.frames_per_beat))
                self._extents[frame] = flow.extent(self.result, range(first, self.frames), frame)
            return self._extents[frame]

    def first_view(self, riding: bool) -> Array:
        """The box (left, bottom, right, top; chords) of the first view, from the wing if `riding`."""
        if not riding:
            return self.box
        if self.stores_vorticity:
            return np.array(self.extent(True).box) / self.chord + HEADROOM * np.array([0.0, 0.0, 0.0, 1.0])
        half = 0.5 * float((self.box[2:] - self.box[:2]).max())
        middle = 0.5 - self.case.wing.pivot
        return np.array([middle - half, -half, middle + half, half])

    def curve(self, name: str, first: int, last: int, most: int) -> tuple[Array, Array]:
        """As `series`, including `lift` and `thrust`."""
        if name not in IN_STREAM:
            return self.series(name, first, last, most)
        (times, y), (_, z) = (self.series(part, first, last, most) for part in ("force_y", "force_z"))
        lift, thrust = in_stream(self.case, np.asarray(y, dtype=float), np.asarray(z, dtype=float))
        return times, lift if name == "lift" else thrust

    def summary(self) -> Summary | None:
        """Means, peaks and phases over the settled beats; None without a whole beat or if it cannot be read."""
        with self._lock, contextlib.suppress(UserError, *UNREADABLE):
            if self.live or self._summary is None:
                self._summary = summarise(self.result)
            return self._summary
        return None

    def _read(self, index: int) -> Frame:
        result, scale, on_page = self.result, 1.0 / self.chord, self.page.on_page
        plunge, pitch = float(result.frame("plunge", index)), float(result.frame("pitch", index))
        surge = float(result.frame("surge", index)) if "surge" in self.variables else 0.0
        moving = self.moving(self.time(index))
        plunge_rate, pitch_rate, surge_rate = moving[[sampling.PLUNGE_RATE, sampling.PITCH_RATE, sampling.SURGE_RATE]]
        along = on_page(np.cos(pitch), np.sin(pitch))
        across = on_page(-np.sin(pitch), np.cos(pitch))
        pivot = scale * on_page(surge, plunge)
        deflection = result.frame("q", index) @ self.shape if len(self.shape) else np.zeros(len(self.station))
        rate = result.frame("q_rate", index) @ self.shape if len(self.shape) else np.zeros(len(self.station))
        stream_y, stream_z = self.case.fluid.velocity
        velocity = (
            on_page(surge_rate - stream_y, plunge_rate - stream_z)
            - np.outer(deflection * pitch_rate, along)
            + np.outer(self.station * pitch_rate + rate, across)
        )
        places = result.frame("node_position", index)
        nodes = scale * on_page(places[:, 0], places[:, 1])
        wake = result.wake(index)
        return Frame(
            index=index,
            text="   ".join(filter(None, (self.when(index), self.half_stroke(index)))),
            nodes=nodes,
            chord=pivot + np.outer((-self.case.wing.pivot, 1.0 - self.case.wing.pivot), along),
            pivot=pivot,
            axes=np.stack((along, across)),
            pressure=result.frame("pressure_jump", index),
            shear=self._field("shear", index),
            force=on_page(result.frame("force_y", index), result.frame("force_z", index)),
            velocity=velocity,
            wake=scale * on_page(wake["y"], wake["z"]),
            circulation=wake["circulation"],
            age=self.turns(index) - wake["birth"] / self.steps_per_beat,
            edge=wake["edge"].astype(int),
        )

    def _reach(self) -> Array | None:
        first = max(0, round(self.frames - 1 - self.frames_per_beat))
        ends = scene.stroke(self.result, np.arange(first, self.frames))
        return None if ends is None else ends / self.chord

    def _field(self, name: str, index: int) -> Array:
        return self.result.frame(name, index) if name in self.variables else np.zeros(0, dtype=np.float32)

    def _survey(self) -> tuple[Ranges, Array]:
        """Ranges and first view, from frames of the last beat."""
        first = max(0, round(self.frames - 1 - self.frames_per_beat))
        picked = np.unique(np.linspace(first, self.frames - 1, SURVEYED).astype(int))
        ranges, box = survey([self._read(int(index)) for index in picked])
        if self.stores_vorticity:
            seen = np.array(self.extent(False).box) / self.chord + HEADROOM * np.array([0.0, 0.0, 0.0, 1.0])
            box = np.concatenate((np.minimum(box[:2], seen[:2]), np.maximum(box[2:], seen[2:])))
        return ranges, box
