"""`[motion.measured]`: measured flapping angles of an animal or a robot, relative to its stroke plane."""

import itertools
from typing import Annotated, Literal

from pydantic import BeforeValidator, model_validator

from .clock import looks_like, period, spacing
from .schema import CaseTable, key
from .travel import Angle, Moment, rows

FEWEST = 8
"""Minimum number of points per beat, which resolves three harmonics."""
SHORTEST = 0.9
"""Minimum share of a beat that the points must cover."""
TURN = 180.0
"""Change between consecutive points, in degrees, that shows a wrapped angle."""
JUMP = 40.0
SUDDEN = 6.0
"""A change between points counts as a jump if it exceeds this many degrees, and this many times the typical change."""

AngleRows = Annotated[tuple[tuple[Moment, Angle, Angle, Angle], ...], BeforeValidator(rows)]
NAMES = ("stroke", "deviation", "rotation")


class Measured(CaseTable):
    """Measured flapping angles, from which plunge, pitch and surge follow."""

    file: str | None = key(
        None, text="text or CSV file of the angles, relative to the case file's folder", example="moth.csv"
    )
    time_column: int | str | None = key(
        None, text="number or name of the time column; default: the one called t or time, or the first", example="time"
    )
    stroke: int | str | None = key(
        None,
        text="column of the angle in the stroke plane (positional angle); default: the one of that name",
        example="stroke",
    )
    deviation: int | str | None = key(
        None, text="column of the angle out of the stroke plane; default: the one of that name", example="deviation"
    )
    rotation: int | str | None = key(
        None, text="column of the angle about the wing's axis; default: the one of that name", example="rotation"
    )
    unit: Literal["deg", "rad"] | None = key(
        None, text="unit of the angles; default: from the column names, or deg", example="rad"
    )
    time: Literal["s", "ms", "periods"] | None = key(None, text="unit of the times; default: s", example="ms")
    angles_deg: AngleRows = key(
        (),
        unit="deg",
        text="points [time, stroke, deviation, rotation], of one beat or several",
        example=[[0.0, 60.0, 0.0, 90.0]],
    )
    rotation_from: Literal["plane", "normal", "attack"] = key(
        text="zero of rotation: plane, 0 with the leading edge forward in the stroke plane and 90 with it up; normal, "
        "0 with it up and positive when it leans forward; attack, the geometric angle of attack, 0 with it in the "
        "direction of motion",
        example="plane",
    )
    stroke_positive: Literal["forward", "backward"] = key(
        "forward", text="direction of positive stroke angles: towards the head, or the tail"
    )
    deviation_positive: Literal["up", "down"] = key(
        "up", text="direction of positive deviation: above the stroke plane, or below"
    )
    side: Literal["right", "left"] = key("right", text="which wing: right or left")
    stroke_plane_deg: float = key(
        0.0,
        unit="deg",
        text="inclination of the stroke plane, positive when its front is lower",
        ge=-180,
        le=180,
    )
    radius: float | None = key(
        None, unit="m", text="distance of the section from the wing hinge", example=0.03, gt=0, le=100
    )
    radius_share: float | None = key(
        None,
        unit="span",
        text="distance of the section from the wing hinge as a share of wing.span (its maximum)",
        example=0.6,
        gt=0,
        le=10,
    )
    smooth: int = key(8, text="number of harmonics kept of each angle", ge=1, le=100)

    def from_hinge(self, span: float) -> float:
        """Distance of the section from the hinge, m, of a wing whose span (m) is this at its widest."""
        return self.radius if self.radius is not None else (self.radius_share or 0.0) * span

    @property
    def clock(self) -> str:
        """Unit of its times."""
        return self.time or "s"

    @model_validator(mode="after")
    def _passable(self) -> "Measured":
        if (self.radius is None) == (self.radius_share is None):
            raise ValueError("give either radius (m) or radius_share (of wing.span)")
        if not self.angles_deg:
            raise ValueError('has no angles: give file = "...", or angles_deg')
        for early, late in itertools.pairwise(self.angles_deg):
            if late[0] <= early[0]:
                raise ValueError(f"times must increase, but {late[0]:.9g} follows {early[0]:.9g}")
        for place, name in enumerate(NAMES, 1):
            problem = _jump([row[place] for row in self.angles_deg], [row[0] for row in self.angles_deg])
            if problem:
                raise ValueError(f"{name} {problem}")
        return self

    def problem(self, frequency: float) -> str:
        """Why its times do not fit beats of a frequency (Hz); empty if they do."""
        times = [row[0] for row in self.angles_deg]
        if len(times) == 1:
            return f"has a single point; give at least one beat with {FEWEST} points"
        beat = period(self.clock, frequency)
        span, usual = times[-1] - times[0], spacing(times)
        beats = (span + usual) / beat
        if beats < SHORTEST or len(times) / beats < FEWEST:
            few = f"{len(times)} points in {beats:.3g} beats" if beats >= SHORTEST else f"{beats:.3g} of a beat"
            return (
                f"its times go from {times[0]:g} to {times[-1]:g} {self.clock}: {few}; give at least one beat with "
                f"{FEWEST} points{looks_like(times, self.clock, frequency)}"
            )
        if 2 * self.smooth + 1 > len(times):
            return f"smooth = {self.smooth}: {len(times)} points resolve at most {(len(times) - 1) // 2} harmonics"
        return ""


def _jump(values: list[float], times: list[float]) -> str:
    """Message about a jump between consecutive angles; empty without one."""
    steps = [abs(late - early) for early, late in itertools.pairwise(values)]
    if not steps:
        return ""
    largest = max(steps)
    place = steps.index(largest)
    usual = sorted(steps)[int(0.9 * (len(steps) - 1))]
    if largest <= JUMP or (largest <= SUDDEN * usual and largest < TURN):
        return ""
    cure = "the angle was wrapped: add or subtract 360 deg" if largest > TURN else "correct or remove the points there"
    return f"jumps from {values[place]:g} to {values[place + 1]:g} deg at time {times[place + 1]:g}; {cure}"
