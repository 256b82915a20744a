"""`[motion.measured]`: flapping angles of an animal, or of a robot, against its stroke plane."""

import itertools
from typing import Annotated, Literal

from pydantic import BeforeValidator, model_validator

from .clock import looks_like, period, spacing
from .schema import Section, key
from .travel import Angle, Moment, rows

FEWEST = 8
"""Points a beat, that tell of three harmonics."""
SHORTEST = 0.9
"""Share of a beat that the points cover at least."""
TURN = 180.0
"""Degrees between one point and the next: an angle that was wrapped."""
JUMP = 40.0
SUDDEN = 6.0
"""A step is a jump when it is larger than these degrees, and so many times as large as most of the angle's steps."""

AngleRows = Annotated[tuple[tuple[Moment, Angle, Angle, Angle], ...], BeforeValidator(rows)]
NAMES = ("stroke", "deviation", "rotation")


class Measured(Section):
    """Measured flapping angles, which give plunge, pitch and surge."""

    file: str | None = key(
        None, text="text or CSV file of the angles, named from the case file's folder", example="moth.csv"
    )
    time_column: int | str | None = key(
        None, text="number or name of the column of the times; else one called t or time, or the first", example="time"
    )
    stroke: int | str | None = key(
        None, text="column of the angle in the stroke plane (positional angle); else one of that name", example="stroke"
    )
    deviation: int | str | None = key(
        None, text="column of the angle out of the stroke plane; else one of that name", example="deviation"
    )
    rotation: int | str | None = key(
        None, text="column of the angle about the wing's axis; else one of that name", example="rotation"
    )
    unit: Literal["deg", "rad"] | None = key(
        None, text="unit of the angles; else what the columns' names say, or deg", example="rad"
    )
    time: Literal["s", "ms", "periods"] | None = key(None, text="unit of the times; else s", example="ms")
    angles_deg: AngleRows = key(
        (),
        unit="deg",
        text="points [time, stroke, deviation, rotation], of one beat or several",
        example=[[0.0, 60.0, 0.0, 90.0]],
    )
    rotation_from: Literal["plane", "normal", "attack"] = key(
        text="what rotation is counted from: plane, 0 when the leading edge points forward in the stroke plane, 90 up; "
        "normal, 0 when it points up, positive when it leans forward; attack, the geometric angle of attack, 0 when "
        "it points the way the wing moves",
        example="plane",
    )
    stroke_positive: Literal["forward", "backward"] = key(
        "forward", text="where the wing is when the stroke angle is positive: towards the head, or the tail"
    )
    deviation_positive: Literal["up", "down"] = key(
        "up", text="the same of deviation: above the stroke plane, or below"
    )
    side: Literal["right", "left"] = key(
        "right", text="which wing: seen from its tip, the head is to the right, or to the left"
    )
    stroke_plane_deg: float = key(
        0.0,
        unit="deg",
        text="angle of the stroke plane to the horizon, positive when its front is lower",
        ge=-180,
        le=180,
    )
    radius: float | None = key(
        None, unit="m", text="distance of the section from the hinge", example=0.03, gt=0, le=100
    )
    radius_share: float | None = key(
        None, unit="span", text="the same as a share of wing.span, at its widest", example=0.6, gt=0, le=10
    )
    smooth: int = key(8, text="harmonics kept of every angle", ge=1, le=100)

    def from_hinge(self, span: float) -> float:
        """Distance of the section from the hinge, m, of a wing whose span (m) is this at its widest."""
        return self.radius if self.radius is not None else (self.radius_share or 0.0) * span

    @property
    def clock(self) -> str:
        """What its times are counted in."""
        return self.time or "s"

    @model_validator(mode="after")
    def _passable(self) -> "Measured":
        if (self.radius is None) == (self.radius_share is None):
            raise ValueError("give radius (m) or radius_share (of wing.span), one of them")
        if not self.angles_deg:
            raise ValueError('has no angles: give file = "...", or angles_deg')
        for early, late in itertools.pairwise(self.angles_deg):
            if late[0] <= early[0]:
                raise ValueError(f"times must rise, and {late[0]:g} comes after {early[0]:g}")
        for place, name in enumerate(NAMES, 1):
            problem = _jump([row[place] for row in self.angles_deg], [row[0] for row in self.angles_deg])
            if problem:
                raise ValueError(f"{name} {problem}")
        return self

    def problem(self, frequency: float) -> str:
        """Why its times cannot be those of beats of a frequency (Hz), in words; empty when they can."""
        times = [row[0] for row in self.angles_deg]
        beat = period(self.clock, frequency)
        span, usual = times[-1] - times[0], spacing(times)
        beats = (span + usual) / beat
        if beats < SHORTEST or len(times) / beats < FEWEST:
            few = f"{len(times)} points of {beats:.3g} beats" if beats >= SHORTEST else f"{beats:.3g} of a beat"
            return (
                f"its times go from {times[0]:g} to {times[-1]:g} {self.clock}: {few}, and at least a beat of {FEWEST} "
                f"points is needed{looks_like(times, self.clock, frequency)}"
            )
        if 2 * self.smooth + 1 > len(times):
            return f"smooth = {self.smooth}: {len(times)} points tell of at most {(len(times) - 1) // 2} harmonics"
        return ""


def _jump(values: list[float], times: list[float]) -> str:
    """Where an angle jumps from one point to the next, in words; empty when it does not."""
    steps = [abs(late - early) for early, late in itertools.pairwise(values)]
    if not steps:
        return ""
    largest = max(steps)
    place = steps.index(largest)
    usual = sorted(steps)[int(0.9 * (len(steps) - 1))]
    if largest <= JUMP or (largest <= SUDDEN * usual and largest < TURN):
        return ""
    cure = "it was wrapped: add or take 360 deg" if largest > TURN else "correct the points there, or leave them out"
    return f"jumps from {values[place]:g} to {values[place + 1]:g} deg at time {times[place + 1]:g}; {cure}"
