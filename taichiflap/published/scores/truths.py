"""Published cases: case file, Reynolds number, and published values."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ...case.case import Case, parse_case
from ...scored.ramps import Ramp
from .measures import ANGLES

WITHIN, NEAR, OUTSIDE = "inside the band", "within 25 %", "outside"
"""The three words of a score."""
NEARBY = 0.25
"""Errors below this share of the published value count as near."""
RIGHT_ANGLE = 90.0
"""The scale of an error in phase, degrees."""


@dataclass(frozen=True)
class Truth:
    """A published value.

    Attributes:
        quantity: a name of `measures.QUANTITIES`.
        value: the published value, in the unit of the quantity.
        low, high: its band: the scatter between sources, or the error of the instrument and of reading a figure.
        window: first and last time, in beats for a periodic motion and in s otherwise.
        source: who measured or computed it, and the origin of the band.
    """

    quantity: str
    value: float
    low: float
    high: float
    window: tuple[float, float]
    source: str

    def error(self, found: float) -> float:
        """Relative error of a model's value; for a phase relative to a right angle."""
        if self.quantity in ANGLES:
            return ((found - self.value + 180.0) % 360.0 - 180.0) / RIGHT_ANGLE
        return (found - self.value) / abs(self.value)

    def word(self, found: float) -> str:
        """Rating of a model's value: `WITHIN`, `NEAR` or `OUTSIDE`."""
        turned = self.value + RIGHT_ANGLE * self.error(found) if self.quantity in ANGLES else found
        if self.low <= turned <= self.high:
            return WITHIN
        return NEAR if abs(self.error(found)) <= NEARBY else OUTSIDE


@dataclass(frozen=True, eq=False)
class Published:
    """A published case.

    Attributes:
        name: short unique name, for `--cases`.
        group: its regime in the report.
        about: motion and section in one sentence.
        document: the case file.
        reynolds: of the chord and the reference speed; None for an inviscid theory.
        speed: the reference speed of its coefficients, m/s.
        truths: its published values.
        citation: where they come from.
        waves: mean and harmonics of the published lift and drag coefficients, of a motion that repeats:
            `C(t) = Re(sum_n a_n exp(2 pi i n t))` with t in beats.
        ramp: published coefficients of a motion that does not repeat.
        settings: additional settings of this case for a tier, by the tier's name.
        family: settings of each run where several runs give a value together, by the parameter that they vary, such as
            the reduced speed near the onset of flutter; empty for values of one run.
        models: names of the tiers that it is for; all if None.
    """

    name: str
    group: str
    about: str
    document: Mapping[str, Any]
    reynolds: float | None
    speed: float
    truths: tuple[Truth, ...]
    citation: str
    waves: Mapping[str, tuple[complex, ...]] = field(default_factory=dict)
    ramp: Ramp | None = None
    settings: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    models: tuple[str, ...] | None = None
    family: Mapping[float, tuple[str, ...]] = field(default_factory=dict)

    @property
    def drawn(self) -> bool:
        """Whether time histories were published, so that they are drawn."""
        return bool(self.waves or self.ramp)

    def case(self) -> Case:
        """The case without a tier's settings."""
        return parse_case(self.document, self.name)


def around(quantity: str, value: float, share: float, window: tuple[float, float], source: str) -> Truth:
    """A value from one source, with a relative band on either side."""
    half = share * abs(value)
    return Truth(quantity, value, value - half, value + half, window, source)
