"""Base of every kind of plunge, pitch and surge, and their lists of numbers."""

import math
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from .schema import CaseTable, as_tuple

MOST_HARMONICS = 100


def _terms(value: Any) -> Any:
    if isinstance(value, list) and len(value) > MOST_HARMONICS:
        raise ValueError(f"has {len(value):,} terms; give at most {MOST_HARMONICS}, or a table of points")
    return rows(value)


def rows(value: Any) -> Any:
    """Convert a list of lists from the file to tuples, since tables are immutable."""
    return tuple(as_tuple(row) for row in value) if isinstance(value, list) else value


_Order = Annotated[int, Field(ge=1, le=100, title="n")]
_Phase = Annotated[float, Field(ge=-360, le=360, title="phase_deg")]
_Length = Annotated[float, Field(ge=-100, le=100, title="m")]
Angle = Annotated[float, Field(ge=-360, le=360, title="deg")]
Moment = Annotated[float, Field(ge=-1e6, le=1e6, title="time")]
LengthHarmonics = Annotated[tuple[tuple[_Order, _Length, _Phase], ...], BeforeValidator(_terms)]
AngleHarmonics = Annotated[tuple[tuple[_Order, Angle, _Phase], ...], BeforeValidator(_terms)]
LengthPoints = Annotated[tuple[tuple[Moment, _Length], ...], BeforeValidator(rows)]
AnglePoints = Annotated[tuple[tuple[Moment, Angle], ...], BeforeValidator(rows)]

HARMONICS = "additional terms [n, amplitude, phase_deg] of sin(2 pi n frequency t + phase)"


class Travel(CaseTable):
    """Plunge, pitch or surge as a function of time."""

    kind: str

    @property
    def repeats(self) -> bool:
        """Whether it is periodic and needs a frequency."""
        return True

    def in_si(self, frequency: float | None = None) -> dict[str, Any]:
        """Keys in metres and radians, without `_deg`: the arguments of this kind's formula.

        Args:
            frequency: Hz, of the motion.
        """
        return {
            name.removesuffix("_deg"): math.radians(value) if value and name.endswith("_deg") else value
            for name, value in self
            if value is None or isinstance(value, float)
        }
