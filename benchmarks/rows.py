"""A line of the table: what was measured, the figure, and the target that the project has set itself."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One figure.

    Attributes:
        section: the heading under which it stands.
        name: what was measured.
        value, unit: the figure; no value where it could not be measured, and `note` then says why.
        target: the bound that the figure is to keep, if there is one.
        at_least: whether the bound is a lower one.
        note: what the reader must know to read the figure.
    """

    section: str
    name: str
    value: float | None
    unit: str
    target: float | None = None
    at_least: bool = True
    note: str = ""

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None where there is none, or nothing to hold against it."""
        if self.value is None or self.target is None:
            return None
        return self.value >= self.target if self.at_least else self.value <= self.target

    @property
    def figure(self) -> str:
        """The figure with its unit."""
        return "not measured" if self.value is None else f"{self.value:.3g} {self.unit}".rstrip()

    @property
    def aim(self) -> str:
        """The target in words."""
        if self.target is None:
            return ""
        return f"{'≥' if self.at_least else '≤'} {self.target:g} {self.unit}".rstrip()

    @property
    def verdict(self) -> str:
        """`met`, `NOT MET`, or nothing."""
        return {None: "", True: "met", False: "NOT MET"}[self.met]
