"""Tables of motion: a smooth curve through or near given points, and checks of the points' range."""

import itertools
import math
from typing import Any, Literal

from pydantic import model_validator

from .clock import COUNTS, looks_like, period, spacing
from .schema import key
from .travel import AnglePoints, LengthPoints, Travel

FEWEST = 4
SEAM = 0.1
"""Share of the spacing within which a last point at the end of the period counts as the first one repeated."""
ENDS = 1e-3
"""Share of the range of values within which both ends of a period count as equal (rounded) values."""
LEAST_SHARE = 0.45
"""Minimum share of the period that a periodic table covers; less suggests a different unit of time."""
SMOOTH = 8
"""Suggested number of harmonics, as far as the points resolve so many."""
Points = tuple[tuple[float, float], ...]

POINTS = "points [time, value] to pass through; times in periods if periodic, else in s, or in the unit given by time"
SMOOTH_ERROR = "allowed root-mean-square error of a fit with as few harmonics as possible; replaces smooth"


class Table(Travel):
    """A smooth curve through points."""

    kind: Literal["table"] = key(text="kind: smooth curve through points", example="table")
    periodic: bool = key(
        False, text="whether the motion is periodic; times are then fractions of the period, unless time is given"
    )
    time: Literal["s", "ms", "periods"] | None = key(
        None, text="unit of the times; default: periods if periodic, else s", example="s"
    )
    smooth: int | None = key(
        None,
        text="number of harmonics of a fit to noisy periodic points; the curve then passes near the points",
        example=8,
        ge=1,
    )
    file: str | None = key(
        None, text="text or CSV file of points, relative to the case file's folder", example="stroke.csv"
    )
    column: int | str | None = key(
        None, text="number or name of the value column; default: the one after the time", example=2
    )
    time_column: int | str | None = key(
        None, text="number or name of the time column; default: the one called t or time, or the first", example="time"
    )

    @property
    def repeats(self) -> bool:
        return self.periodic

    @property
    def given(self) -> Points:
        """Points as given in the file."""
        raise NotImplementedError

    @property
    def clock(self) -> str:
        """Unit of its times."""
        return self.time or ("periods" if self.periodic else "s")

    def period(self, frequency: float | None) -> float:
        """Period of `frequency` (Hz) in the unit of its times."""
        return period(self.clock, frequency)

    def _in_time(self, points: Points, frequency: float | None) -> Points:
        """Points with times in periods if periodic, else in s, without a repeated first point at the end."""
        if self.periodic:
            length = self.period(frequency)
            points = points[:-1] if _closes(points, length) else points
            return points if length == 1.0 else tuple((time / length, value) for time, value in points)
        scale = {"s": 1.0, "ms": 1e3, "periods": frequency or math.nan}[self.clock]
        return points if scale == 1.0 else tuple((time / scale, value) for time, value in points)

    @model_validator(mode="after")
    def _passable(self) -> "Table":
        points = self.given
        if len(points) < FEWEST:
            raise ValueError(f"has {len(points)} points; give at least {FEWEST}, in the case or in a file")
        for (early, _), (late, _) in itertools.pairwise(points):
            if late <= early:
                raise ValueError(f"times must increase, but {late:.9g} follows {early:.9g}")
        if self.smoothed and not self.periodic:
            raise ValueError("smooth and smooth_error need a periodic table; smooth these points beforehand")
        if self.smooth and self.tolerance:
            raise ValueError("give either smooth or smooth_error")
        most = (len(points) - 1) // 2
        if self.smooth and self.smooth > most:
            raise ValueError(f"smooth = {self.smooth}: {len(points)} points resolve at most {most} harmonics")
        return self

    @property
    def tolerance(self) -> float | None:
        """Allowed root-mean-square distance (m or rad) of a smoothed curve from its points."""
        raise NotImplementedError

    def _arguments(self, points: Points) -> dict[str, Any]:
        return {"points": points} | ({"smooth": self.smooth, "tolerance": self.tolerance} if self.smoothed else {})

    @property
    def smoothed(self) -> bool:
        """Whether the curve is a smoothing fit."""
        return bool(self.smooth or self.tolerance)

    def problem(self, frequency: float | None, duration: float) -> str:
        """Why its points do not cover `duration` (s); empty if they do.

        Args:
            frequency: Hz.
        """
        if self.clock == "periods" and frequency is None:
            return 'time = "periods" needs motion.frequency'
        return self._problem_of_period(frequency) if self.periodic else self._problem_of_run(frequency, duration)

    def _problem_of_period(self, frequency: float | None) -> str:
        points, length = self.given, self.period(frequency)
        first, last = points[0][0], points[-1][0]
        times = [time for time, _ in points]
        span, usual = last - first, spacing(times)
        if span - length > SEAM * usual or span + usual < LEAST_SHARE * length:
            return (
                f"its times are {COUNTS[self.clock]}, from {first:g} to {last:g}: {span / length:.3g} periods "
                f"instead of about one{looks_like(times, self.clock, frequency)}"
            )
        (_, begin), (_, end) = points[0], points[-1]
        if _closes(points, length) and not self.smoothed:
            values = [value for _, value in points]
            slope = max(abs((v - u) / (t - s)) for (s, u), (t, v) in itertools.pairwise(points))
            if abs(end - begin) > ENDS * (max(values) - min(values)) + 2.0 * slope * abs(span - length):
                return (
                    f"is periodic but begins with {begin:g} and ends with {end:g}; make them equal, or smooth the "
                    f"points: smooth = {min(SMOOTH, (len(points) - 1) // 2)}"
                )
        return ""

    def _problem_of_run(self, frequency: float | None, duration: float) -> str:
        points = self._in_time(self.given, frequency)
        first, last = points[0][0], points[-1][0]
        if first > 0.0 or last < duration * (1.0 - 1e-9):
            return (
                f"its points cover {first:.9g} to {last:.9g} s but the case runs from 0 to {duration:.9g} s; give more "
                "points, or make it periodic"
            )
        return ""


class TablePlunge(Table):
    """Tabulated plunge: a cubic spline through points in the case or in a file."""

    points: LengthPoints = key((), unit="m", text=POINTS, example=[[0.0, 0.0], [0.1, 0.01]])
    unit: Literal["m", "cm", "mm"] | None = key(
        None, text="unit of the value column; default: from the column name, or m", example="mm"
    )
    smooth_error: float | None = key(None, unit="m", text=SMOOTH_ERROR, example=1e-4, gt=0, le=100)

    @property
    def given(self) -> Points:
        return self.points

    @property
    def tolerance(self) -> float | None:
        return self.smooth_error

    def in_si(self, frequency: float | None = None) -> dict[str, Any]:
        return self._arguments(self._in_time(self.points, frequency))


class TablePitch(Table):
    """Tabulated pitch: a cubic spline through points in the case or in a file."""

    points_deg: AnglePoints = key((), unit="deg", text=POINTS, example=[[0.0, 0.0], [0.1, 20.0]])
    unit: Literal["deg", "rad"] | None = key(
        None, text="unit of the value column; default: from the column name, or deg", example="rad"
    )
    smooth_error_deg: float | None = key(None, unit="deg", text=SMOOTH_ERROR, example=0.5, gt=0, le=360)

    @property
    def given(self) -> Points:
        return self.points_deg

    @property
    def tolerance(self) -> float | None:
        return None if self.smooth_error_deg is None else math.radians(self.smooth_error_deg)

    def in_si(self, frequency: float | None = None) -> dict[str, Any]:
        points = self._in_time(self.points_deg, frequency)
        return self._arguments(tuple((time, math.radians(value)) for time, value in points))


def _closes(points: Points, length: float) -> bool:
    """Whether the last point repeats the first, one period later."""
    return points[-1][0] - points[0][0] > length - SEAM * spacing([time for time, _ in points])
