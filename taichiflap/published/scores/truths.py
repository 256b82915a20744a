"""What a published case is: its case file, its Reynolds number, and the figures that were published of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ...case.case import Case, parse_case
from .measures import ANGLES

WITHIN, NEAR, OUTSIDE = "inside the band", "within 25 %", "outside"
"""The three words of a score."""
NEARBY = 0.25
"""An error below this share of the true value is near."""
RIGHT_ANGLE = 90.0
"""The scale of an error in phase, degrees."""


@dataclass(frozen=True)
class Truth:
    """A published figure.

    Attributes:
        quantity: a name of `measures.QUANTITIES`.
        value: the published value, in the unit of the quantity.
        low, high: its band: the scatter between sources, or the error of the instrument and of reading a figure.
        window: first and last time, in beats for a periodic motion and in s otherwise.
        source: who measured or computed it, and what the band is.
    """

    quantity: str
    value: float
    low: float
    high: float
    window: tuple[float, float]
    source: str

    def error(self, found: float) -> float:
        """Error of a model's value: as a share of the true value, or of a right angle for a phase."""
        if self.quantity in ANGLES:
            return ((found - self.value + 180.0) % 360.0 - 180.0) / RIGHT_ANGLE
        return (found - self.value) / abs(self.value)

    def word(self, found: float) -> str:
        """Where a model's value lies: one of `WITHIN`, `NEAR` and `OUTSIDE`."""
        turned = self.value + RIGHT_ANGLE * self.error(found) if self.quantity in ANGLES else found
        if self.low <= turned <= self.high:
            return WITHIN
        return NEAR if abs(self.error(found)) <= NEARBY else OUTSIDE


@dataclass(frozen=True, eq=False)
class Published:
    """A case that somebody measured or computed.

    Attributes:
        name: short, unique, as `--cases` names it.
        group: the regime under which the report lists it.
        about: motion and section in one sentence.
        document: the case file.
        reynolds: of the chord and the reference speed; None for an inviscid theory.
        speed: the reference speed of its coefficients, m/s.
        truths: its figures.
        citation: where they come from.
        waves: mean and harmonics of the published lift and drag coefficients, of a case whose time histories are drawn:
            `C(t) = Re(sum_n a_n exp(2 pi i n t))` with t in beats; empty where none were published.
        settings: what a tier changes of this case beside its own settings, by the tier's name.
    """

    name: str
    group: str
    about: str
    document: Mapping[str, Any]
    reynolds: float | None
    speed: float
    truths: tuple[Truth, ...]
    citation: str
    waves: Mapping[str, tuple[complex, ...]] | None = None
    settings: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def case(self) -> Case:
        """The case, before a tier sets its model."""
        return parse_case(self.document, self.name)


def around(quantity: str, value: float, share: float, window: tuple[float, float], source: str) -> Truth:
    """A figure of one source with a band of a share on either side."""
    half = share * abs(value)
    return Truth(quantity, value, value - half, value + half, window, source)
