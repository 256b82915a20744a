"""Charts of series over time, with units and a dot at the current frame."""

import contextlib
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from taichiflap.notation import prefixed
from taichiflap.results.variables import VARIABLES

from . import wire
from .colours import RUNS
from .frame import Array
from .frames import Run
from .scene import common_ranges
from .timeline import ALL, LAST_BEAT, THIS_BEAT, Playback

POINTS = 241
"""Maximum number of points of a curve."""
HEIGHT = 106
MODE_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""Okabe and Ito's."""
WINDOWS = (LAST_BEAT, THIS_BEAT, ALL)
CHOICES, FIRST = 1e12, -30.0
"""Where the choice of charts stands, below them all, and the chart of a narrow window, above all else."""
NUDGE = 1e-9
"""Small change of the end of the time axis. A page that receives new data while a chart is resized omits the axis
numbers unless the range changes as well.
"""


@dataclass(frozen=True)
class Quantity:
    """A variable to plot, its title, its unit and the factor from SI to it."""

    name: str
    title: str
    unit: str
    factor: float


MODES = Quantity("q", "Modal amplitudes", f"10⁻³ {VARIABLES['q'].units}", 1e3)


SHEDDING = Quantity("leading_edge_sheds", "Leading edge sheds", "1: yes, 0: no", 1.0)


FORCES = (("force_normal", "Force along the wing's normal"), ("force_vertical", "Vertical force"))
IN_STREAM = (("lift", "Lift across the stream"), ("thrust", "Thrust against the stream"))
"""Force series and their titles."""


def quantities(runs: list[Run]) -> list[Quantity]:
    """Charts of some results, in units that suit the largest values."""
    ranges = common_ranges(runs)
    length, metres = prefixed(max(run.chord for run in runs), "m")
    force, newtons = prefixed(ranges.force, "N")
    power, watts = prefixed(ranges.force * ranges.speed, "W")
    first = Quantity("tip_deflection", "Tip deflection", metres, length)
    if not any(len(run.shape) for run in runs):  # rigid wings: show the motion instead
        plunges = any(run.path is not None for run in runs)
        degrees = 180.0 / math.pi
        first = Quantity("plunge", "Plunge", metres, length) if plunges else Quantity("pitch", "Pitch", "deg", degrees)
    shown = IN_STREAM if all(run.case.fluid.streams for run in runs) else FORCES
    found = [
        first,
        *(Quantity(name, title, newtons, force) for name, title in shown),
        Quantity("power", "Mechanical power", watts, power),
    ]
    if any(len(run.shape) > 1 for run in runs):
        found.append(MODES)
    if any(run.has_sheets for run in runs):
        found.append(SHEDDING)
    return [*found, *_own(runs)]


def available(runs: list[Run], shown: list[Quantity]) -> list[Quantity]:
    """Every series that can be shown: the default ones, then all others of the results."""
    known = {one.name for one in shown}
    others: list[Quantity] = []
    for name in runs[0].variables:
        if name in known or name == "time" or not all(name in run.variables for run in runs):
            continue
        others += _described(runs, name)
    return [*shown, *others]


def _own(runs: list[Run]) -> Iterator[Quantity]:
    """Series that only the fluid model of these results defines."""
    for name in runs[0].variables:
        if name not in VARIABLES and all(name in run.variables for run in runs):
            yield from _described(runs, name)


def _described(runs: list[Run], name: str) -> Iterator[Quantity]:
    """A series as the results describe it, in a unit that suits its largest value; nothing for a field."""
    one = runs[0].result.describe(name)
    if one.dimensions == ("time",):
        values = (np.abs(run.series(name, 0, run.steps - 1, POINTS)[1]) for run in runs)
        most = max(float(np.max(each, initial=0.0, where=np.isfinite(each))) for each in values)
        factor, unit = prefixed(most, one.units) if one.units in ("m", "N", "W", "Pa") else (1.0, one.units)
        yield Quantity(name, one.long_name[:1].upper() + one.long_name[1:], "" if unit == "1" else unit, factor)


class Charts:
    """The charts of one browser.

    Args:
        gui: viser's container of the charts.
        tab: the tab that contains them.
        runs: one result, or two to compare; the first defines the times.
        modes: whether to show the modal amplitudes of wings that have several.
        choose: called with the names of what somebody wants to see instead.
        narrow: whether the window is a phone's: the first chart stands above all controls.
    """

    def __init__(
        self, gui: Any, tab: Any, runs: list[Run], playback: Playback, modes: bool = True, *,
        choose: Callable[[list[str]], None] = lambda _: None, narrow: bool = False,
    ) -> None:  # fmt: skip
        self.runs, self._gui, self._tab, self._narrow = runs, gui, tab, narrow
        usual = [one for one in quantities(runs) if modes or one is not MODES]
        self._usual = [one.name for one in usual]
        self._known = {one.name: one for one in available(runs, usual)}
        self.quantities = self._chosen(playback)
        self._window: tuple[int, int] | None = None
        self._curves: dict[str, list[Array]] = {}
        self._times: Array = np.zeros(0)  # beats
        # A page keeps the label of its axis, whatever run follows.
        self._milliseconds = not runs[0].case.periodic
        self._nudge = 0.0
        self._load(playback)
        self.handles: dict[str, Any] = {}
        self._draw(playback)
        with tab, gui.add_folder("Choose charts", expand_by_default=False, order=CHOICES):
            self._boxes = {
                name: gui.add_checkbox(one.title, one in self.quantities) for name, one in self._known.items()
            }
        for box in self._boxes.values():
            box.on_update(self._tell(choose))

    def _tell(self, choose: Callable[[list[str]], None]) -> Callable[[Any], None]:
        def listen(event: Any) -> None:
            # What the server sets comes back without a client.
            # The browser may have left since, with all its controls.
            with contextlib.suppress(RuntimeError, KeyError):
                if event.client is not None:
                    choose([name for name, box in self._boxes.items() if box.value])

        return listen

    def choose(self, playback: Playback) -> None:
        """Show the charts that playback names. Others are hidden: the page complains of news for one that is gone."""
        self.quantities = self._chosen(playback)
        self._curves = {quantity.name: self._read(quantity) for quantity in self.quantities}
        self._draw(playback)
        shown = {one.name for one in self.quantities}
        for name, handle in self.handles.items():
            handle.visible = name in shown
        for name, box in self._boxes.items():
            if box.value != (name in shown):
                box.value = name in shown

    def _chosen(self, playback: Playback) -> list[Quantity]:
        named = [self._known[name] for name in playback.charts if name in self._known]
        return named or [self._known[name] for name in self._usual]

    def _draw(self, playback: Playback) -> None:
        for number, quantity in enumerate(self.quantities):
            if quantity.name in self.handles:
                continue
            first = self._narrow and number == 0
            with contextlib.nullcontext() if first else self._tab:
                self.handles[quantity.name] = self._gui.add_uplot(
                    self._data(quantity, playback.frame),
                    self._series(quantity),
                    title=", ".join(filter(None, (quantity.title, quantity.unit))),
                    scales={"x": {"time": False}},
                    axes=({"size": 26, "space": 40}, {"size": 46, "space": 17}),
                    legend={"show": False},
                    height=HEIGHT,
                    padding=(8, 14, 0, 0),
                    order=FIRST if first else None,
                )

    def show(self, playback: Playback, frame: int) -> None:
        """Move the dots to the current frame."""
        self._load(playback)
        self._nudge = NUDGE - self._nudge
        for quantity in self.quantities:
            data = self._data(quantity, frame)
            curves = (len(data) + 1) // 2
            wire.send(self.handles[quantity.name], data=(*map(_drawable, data[:curves]), *data[curves:]))

    def read_again(self, playback: Playback) -> None:
        """Read the curves again: the file has grown, or there are other runs."""
        self._load(playback, again=True)

    def _load(self, playback: Playback, again: bool = False) -> None:
        """Read the curves if they have changed."""
        run = self.runs[0]
        newest = run.steps - 1
        if playback.window == ALL:
            window = 0, newest
        elif playback.window == LAST_BEAT and run.live:
            window = max(0, newest - round(run.steps_per_beat)), newest
        else:
            number = run.beats if playback.window == LAST_BEAT else run.beat_of(playback.frame)[0]
            window = run.step_at(number - 1), run.step_at(number)
        if window == self._window and not again:
            return
        self._window = window
        self._times, _ = run.series("time", *window, POINTS)
        self._curves = {quantity.name: self._read(quantity) for quantity in self.quantities}

    def _read(self, quantity: Quantity) -> list[Array]:
        assert self._window is not None
        first = self.runs[0]
        window = [step / first.steps_per_beat for step in self._window]
        curves: list[Array] = []
        for run in self.runs:
            if quantity.name not in (*run.variables, *dict(IN_STREAM)):
                # A curve all the same: a chart keeps its number of curves.
                curves.append(np.full(len(self._times), np.nan))
                continue
            start, end = (run.step_at(run.beats_at(first, beats)) for beats in window)
            times, values = run.curve(quantity.name, start, end, POINTS)
            times = first.beats_at(run, times)
            for curve in np.atleast_2d(values.T):
                curves.append(quantity.factor * np.interp(self._times, times, curve, right=np.nan))
        return curves

    def _data(self, quantity: Quantity, frame: int) -> tuple[Array, ...]:
        curves = self._curves[quantity.name]
        dots = [np.full(len(curve), np.nan) for curve in curves]
        now = self.runs[0].turns(frame)
        if len(self._times) and self._times[0] <= now + 1e-9 and now <= self._times[-1] + 1.0 / POINTS:
            nearest = int(np.argmin(np.abs(self._times - now)))
            for dot, curve in zip(dots, curves, strict=True):
                dot[nearest] = curve[nearest]
        times = self._times * (1e3 * self.runs[0].case.beat if self._milliseconds else 1.0)
        times[-1:] += self._nudge * (times[-1:] - times[:1])
        return (times, *curves, *dots)

    def _series(self, quantity: Quantity) -> tuple[Any, ...]:
        colours: list[str] = []
        for number, run in enumerate(self.runs):
            if quantity is MODES:
                colours += [MODE_COLOURS[k % len(MODE_COLOURS)] for k in range(len(run.shape))]
            else:
                colours.append(RUNS[number])
        lines = [{"stroke": colour, "width": 1.8, "points": {"show": False}} for colour in colours]
        if quantity is MODES and len(self.runs) > 1:
            for line in lines[len(self.runs[0].shape) :]:
                line["dash"] = [5, 4]
        dots = [
            {"stroke": colour, "points": {"show": True, "size": 9, "fill": colour}, "auto": False} for colour in colours
        ]
        return ({"label": "t, ms" if self._milliseconds else "t/T"}, *lines, *dots)


def _drawable(curve: Array) -> Array | list[float | None]:
    """A curve for a page: uPlot finds no range for data that start with NaN, but ignores None."""
    if not len(curve) or np.isfinite(curve[0]):
        return curve
    return [float(value) if np.isfinite(value) else None for value in curve]


def caption(runs: list[Run]) -> str:
    """Legend of the charts, as HTML."""
    text = f"Horizontal axis: time in {'beats' if runs[0].case.periodic else 'ms'}. The dot marks the current frame."
    if len(runs) > 1:
        names = " ".join(
            f'<b style="color:{colour}">{escape(run.label)}</b>' for run, colour in zip(runs, RUNS, strict=False)
        )
        text = f"{names}. {text}"
    modes = max(len(run.shape) for run in runs)
    if modes > 1:
        named = " ".join(f'<span style="color:{MODE_COLOURS[k % 6]}">mode {k + 1}</span>' for k in range(modes))
        text += f" Modal amplitudes: {named}{', the second result dashed' if len(runs) > 1 else ''}."
    return f'<div style="font-size:11px;padding:2px 4px;line-height:1.4">{text}</div>'
