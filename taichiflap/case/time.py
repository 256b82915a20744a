"""`[time]`: duration and time step, in periods or in seconds."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from .schema import CaseTable, key, needed

IN_PERIODS = ("periods", "steps_per_period")
IN_SECONDS = ("duration", "step")


def _auto_or_number(value: Any) -> str:
    return "auto" if isinstance(value, str) else "number"


StepsPerPeriod = Annotated[
    Annotated[int, Field(ge=4, le=1_000_000), Tag("number")] | Annotated[Literal["auto"], Tag("auto")],
    Discriminator(_auto_or_number),
]
Step = Annotated[
    Annotated[float, Field(gt=0, le=1e6), Tag("number")] | Annotated[Literal["auto"], Tag("auto")],
    Discriminator(_auto_or_number),
]


class Time(CaseTable):
    """Duration and time step: periods and steps_per_period, or duration and step.

    With "auto" the trailing edge travels one panel length through the fluid per step.
    """

    periods: int | None = key(15, text="number of flapping periods", ge=1, le=100_000)
    steps_per_period: StepsPerPeriod | None = key(200, text='time steps per period, or "auto"')
    duration: float | None = key(None, unit="s", text="duration of a non-periodic motion", example=1.0, gt=0, le=1e6)
    step: Step | None = key(None, unit="s", text='time step of a non-periodic motion, or "auto"', example=1e-3)

    @model_validator(mode="before")
    @classmethod
    def _one_way(cls, given: Any) -> Any:
        if not isinstance(given, Mapping) or not any(name in given for name in IN_SECONDS):
            return given
        if any(given.get(name) is not None for name in IN_PERIODS):
            raise ValueError("mixes periods and seconds; give periods and steps_per_period, or duration and step")
        return dict.fromkeys(IN_PERIODS) | dict(given)

    @model_validator(mode="after")
    def _whole(self) -> "Time":
        for name in IN_SECONDS if self.periods is None else IN_PERIODS:
            if getattr(self, name) is None:
                raise needed(name, "duration and step must be given together")
        if self.duration is not None and isinstance(self.step, float) and self.step > self.duration:
            raise ValueError(
                f"step = {self.step:g} s is longer than duration = {self.duration:g} s; give a shorter step"
            )
        return self
