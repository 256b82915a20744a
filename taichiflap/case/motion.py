"""`[motion]`: prescribed motion of the pivot. `taichiflap.motion.waveforms` holds the formula of each kind."""

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import (
    Discriminator,
    Field,
    SerializerFunctionWrapHandler,
    Tag,
    ValidationInfo,
    field_validator,
    model_serializer,
    model_validator,
)

from .measured import Measured
from .schema import CaseTable, key, needed
from .tables import TablePitch, TablePlunge
from .travel import HARMONICS, AngleHarmonics, LengthHarmonics, Travel

ROUNDED = 1e-5
"""Relative tolerance of a limit that a message shows with six digits."""


class _LengthWave(Travel):
    amplitude: float = key(0.0, unit="m", text="amplitude", ge=0, le=100)
    phase_deg: float = key(0.0, unit="deg", text="phase advance", ge=-360, le=360)
    mean: float = key(0.0, unit="m", text="mean position", ge=-100, le=100)


class _AngleWave(Travel):
    amplitude_deg: float = key(0.0, unit="deg", text="amplitude", ge=0, le=360)
    phase_deg: float = key(0.0, unit="deg", text="phase advance", ge=-360, le=360)
    mean_deg: float = key(0.0, unit="deg", text="mean angle", ge=-360, le=360)


class HarmonicPlunge(_LengthWave):
    """Plunge along Z: mean + amplitude * sin(2 pi frequency t + phase), and harmonics."""

    kind: Literal["harmonic"] = key("harmonic", text="kind of plunge")
    harmonics: LengthHarmonics = key((), unit="m and deg", text=HARMONICS, example=[[3, 0.001, 0.0]])

    @property
    def repeats(self) -> bool:
        return bool(self.amplitude or self.harmonics)

    def in_si(self, frequency: float | None = None) -> dict[str, Any]:
        terms = tuple((n, size, math.radians(phase)) for n, size, phase in self.harmonics)
        return super().in_si(frequency) | {"harmonics": terms}


class HarmonicPitch(_AngleWave):
    """Pitch: mean + amplitude * sin(2 pi frequency t + phase), and harmonics."""

    kind: Literal["harmonic"] = key("harmonic", text="kind of pitch")
    harmonics_deg: AngleHarmonics = key((), unit="deg", text=HARMONICS, example=[[2, 3.0, 0.0]])

    @property
    def repeats(self) -> bool:
        return bool(self.amplitude_deg or self.harmonics_deg)

    def in_si(self, frequency: float | None = None) -> dict[str, Any]:
        terms = tuple((n, math.radians(size), math.radians(phase)) for n, size, phase in self.harmonics_deg)
        return super().in_si(frequency) | {"harmonics": terms}


class _Triangle(Travel):
    kind: Literal["triangle"] = key(text="kind: a smoothed triangular wave", example="triangle")
    sharpness: float = key(
        text="K of Berman & Wang (2007): 0 gives a sine, values near 1 a triangle", example=0.7, ge=0, lt=1
    )


class TrianglePlunge(_Triangle, _LengthWave):
    """Plunge along Z: mean + amplitude * asin(K sin(2 pi frequency t + phase)) / asin(K)."""


class TrianglePitch(_Triangle, _AngleWave):
    """Pitch: mean + amplitude * asin(K sin(2 pi frequency t + phase)) / asin(K)."""


class _Trapezoid(Travel):
    kind: Literal["trapezoid"] = key(text="kind: a smoothed trapezoidal wave", example="trapezoid")
    sharpness: float = key(
        text="C of Berman & Wang (2007): 0 gives a sine, large values a square wave", example=3.0, ge=0, le=100
    )


class TrapezoidPlunge(_Trapezoid, _LengthWave):
    """Plunge along Z: mean + amplitude * tanh(C sin(2 pi frequency t + phase)) / tanh(C)."""


class TrapezoidPitch(_Trapezoid, _AngleWave):
    """Pitch: mean + amplitude * tanh(C sin(2 pi frequency t + phase)) / tanh(C)."""


class _Ramp(Travel):
    kind: Literal["ramp"] = key(text="kind: ramp, hold and return", example="ramp")
    start: float = key(unit="s", text="start time of the ramp", example=0.1, ge=-1e6, le=1e6)
    ramp: float = key(unit="s", text="duration of the ramp and of the return", example=0.1, gt=0, le=1e6)
    hold: float | None = key(
        None,
        unit="s",
        text="duration of the hold before the return; if left out, there is no return",
        example=0.1,
        ge=0,
        le=1e6,
    )
    smoothing: float = key(
        unit="1/s",
        text="corners are rounded over about its inverse: a U/c in Eldredge's ramp",
        example=200.0,
        gt=0,
        le=1e9,
    )

    @field_validator("smoothing")
    @classmethod
    def _leaves_a_ramp(cls, value: float, info: ValidationInfo) -> float:
        ramp = info.data.get("ramp")
        if ramp is not None and value * ramp < 1.0 - ROUNDED:
            raise ValueError(f"rounds the corners over {1.0 / value:g} s, longer than the ramp; give >= {1.0 / ramp:g}")
        return value

    @property
    def repeats(self) -> bool:
        return False


class RampPlunge(_Ramp):
    """Plunge from an initial position by an amplitude at a constant rate, a hold, and a return."""

    amplitude: float = key(unit="m", text="travel of the ramp, positive or negative", example=0.01, ge=-100, le=100)
    initial: float = key(0.0, unit="m", text="position before the ramp", ge=-100, le=100)


class RampPitch(_Ramp):
    """Pitch from an initial angle by an amplitude at a constant rate, a hold, and a return."""

    amplitude_deg: float = key(
        unit="deg", text="rotation of the ramp, positive or negative", example=45.0, ge=-360, le=360
    )
    initial_deg: float = key(0.0, unit="deg", text="angle before the ramp", ge=-360, le=360)


def kind_of(value: Any) -> str:
    """Kind of plunge or pitch that a table of the file names."""
    return str(value.get("kind", "harmonic") if isinstance(value, Mapping) else getattr(value, "kind", "harmonic"))


Plunge = Annotated[
    Annotated[HarmonicPlunge, Tag("harmonic")]
    | Annotated[TrianglePlunge, Tag("triangle")]
    | Annotated[TrapezoidPlunge, Tag("trapezoid")]
    | Annotated[RampPlunge, Tag("ramp")]
    | Annotated[TablePlunge, Tag("table")],
    Discriminator(kind_of),
]
Pitch = Annotated[
    Annotated[HarmonicPitch, Tag("harmonic")]
    | Annotated[TrianglePitch, Tag("triangle")]
    | Annotated[TrapezoidPitch, Tag("trapezoid")]
    | Annotated[RampPitch, Tag("ramp")]
    | Annotated[TablePitch, Tag("table")],
    Discriminator(kind_of),
]


def _rests(travel: Travel) -> bool:
    return isinstance(travel, HarmonicPlunge) and not travel.repeats


class Motion(CaseTable):
    """Prescribed motion of the pivot."""

    frequency: float | None = key(
        None, unit="Hz", text="flapping frequency; required by periodic motions", example=25.0, gt=0, le=1e5
    )
    plunge: Plunge = Field(default_factory=HarmonicPlunge, description="plunge along Z")
    pitch: Pitch = Field(default_factory=HarmonicPitch, description="pitch about the pivot")
    surge: Plunge = Field(default_factory=HarmonicPlunge, description="surge along Y, which points down")
    measured: Measured | None = Field(None, description="measured angles; they replace plunge, pitch and surge")
    start_up: float | None = key(
        None,
        unit="s",
        text="time in which plunge, pitch and surge grow smoothly from zero",
        example=0.04,
        gt=0,
        le=1e6,
    )
    start_up_periods: float | None = key(None, unit="periods", text="start_up in periods", example=1.0, gt=0, le=1e5)

    @model_validator(mode="after")
    def _consistent(self) -> "Motion":
        if self.measured and self.model_fields_set & {"plunge", "pitch", "surge"}:
            raise ValueError("give either plunge, pitch and surge or measured")
        if self.frequency is None and (
            self.measured or self.plunge.repeats or self.pitch.repeats or self.surge.repeats or self.start_up_periods
        ):
            raise needed("frequency", "required by periodic motions")
        if self.start_up and self.start_up_periods:
            raise ValueError("give either start_up or start_up_periods")
        return self

    @model_serializer(mode="wrap")
    def _without_what_follows(self, whole: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Store only the angles of a measured motion: plunge, pitch and surge follow from them."""
        dumped: dict[str, Any] = whole(self)
        return {k: v for k, v in dumped.items() if k not in ("plunge", "pitch", "surge")} if self.measured else dumped

    @cached_property
    def stroke(self) -> Travel:
        """The motion whose reversal marks the wing's: plunge, surge without plunge, or the measured stroke."""
        return self.surge if _rests(self.plunge) and not _rests(self.surge) else self.plunge

    @property
    def growth(self) -> float:
        """Duration of the start-up, s."""
        if self.start_up_periods and self.frequency:
            return self.start_up_periods / self.frequency
        return self.start_up or 0.0
