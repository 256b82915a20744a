"""The keys of a case as controls: names, units and ranges of sliders."""

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from taichiflap.case.case import Case
from taichiflap.fluids import MODELS
from taichiflap.notation import prefixed

NUMBER, WHOLE, CHOICE, SWITCH = "number", "whole number", "choice", "switch"
FIRST = (
    "solver", "wing.youngs_modulus", "wing.thickness", "wing.modes", "wing.density", "motion.frequency",
    "motion.plunge.amplitude", "motion.plunge.phase_deg", "motion.pitch.amplitude_deg", "motion.pitch.phase_deg",
    "motion.pitch.mean_deg", "fluid.density",
)  # fmt: skip
"""Keys that are always shown; all others can be searched."""
NAMES = {
    "solver": "Fluid model", "wing.youngs_modulus": "Young's modulus", "wing.density": "Wing density",
    "fluid.density": "Fluid density",
}  # fmt: skip
"""What some keys are called, where their own name without its underscores will not do."""
HIDDEN = ("title", "output", "motion.start_up", "motion.start_up_periods", "time.duration", "time.step")
"""Keys that are not offered."""
REACH = 4.0
"""Factor between a value and the ends of its slider."""
STEPS = 100


@dataclass(frozen=True)
class Control:
    """A key with a plain value.

    Attributes:
        key: its dotted name.
        kind: `NUMBER`, `WHOLE`, `CHOICE` or `SWITCH`.
        value: in the case, SI units.
        low, high: allowed range.
        options: options of a choice.
        unit: display unit; `factor` converts from SI to it.
        text: its description.
    """

    key: str
    kind: str
    value: Any
    low: float = -math.inf
    high: float = math.inf
    options: tuple[str, ...] = ()
    unit: str = ""
    factor: float = 1.0
    text: str = ""

    @property
    def label(self) -> str:
        """The name and the unit."""
        name = self.key.rpartition(".")[2].removesuffix("_deg").replace("_", " ")
        section = self.key.split(".")[-2] if self.key.startswith("motion.") and self.key.count(".") > 1 else ""
        return NAMES.get(self.key, f"{section} {name}".strip().capitalize()) + (f", {self.unit}" if self.unit else "")

    def shown(self, value: Any) -> Any:
        """Convert a value of the case to the control's."""
        return value * self.factor if self.kind == NUMBER else value

    def meant(self, value: Any) -> Any:
        """Convert the control's value to the case's, without round-off."""
        return float(f"{value / self.factor:.12g}") if self.kind == NUMBER else value

    def slider(self) -> tuple[float, float, float]:
        """Minimum, maximum and step of its slider, as displayed."""
        low, high = self._span()
        if self.kind == WHOLE:
            return int(max(low, self.low)), int(min(high, self.high)), 1
        low, high = max(low, self.low) * self.factor, min(high, self.high) * self.factor
        step = 10.0 ** math.floor(math.log10((high - low) / STEPS))
        return float(f"{low:.6g}"), float(f"{high:.6g}"), float(f"{step:.1g}")

    def _span(self) -> tuple[float, float]:
        if self.kind == WHOLE:
            return max(0, int(self.value / REACH)), max(int(REACH * self.value), 8)
        if self.key.endswith("_deg"):
            return (-180.0, 180.0) if self.low < 0.0 else (0.0, 90.0)
        size = abs(self.value) or 1.0
        return (size / REACH, REACH * size) if self.value > 0.0 else (-REACH * size, REACH * size)


def controls(case: Case) -> list[Control]:
    """All keys of a case with a plain number, a choice or a switch; those of `FIRST` come first."""
    solvers = tuple(dict.fromkeys((*MODELS, case.solver)))
    found = [Control("solver", CHOICE, case.solver, options=solvers, text="the model of the fluid")]
    for name in ("wing", "motion", "fluid", "time", case.solver):
        part = getattr(case, name, None)
        if isinstance(part, BaseModel):
            found += _walk(part, f"{name}.")
    rank = {key: number for number, key in enumerate(FIRST)}
    return sorted(found, key=lambda one: rank.get(one.key, len(rank)))


def value_of(case: Case, key: str) -> Any:
    """Value of a dotted key; None if absent."""
    found: Any = case
    for name in key.split("."):
        found = getattr(found, name, None)
    return found


@functools.cache
def _schema(kind: type[BaseModel]) -> dict[str, Any]:
    """Schema of a table of the case file, cached, since creating it takes longer than a run of blade elements."""
    return kind.model_json_schema()


def _walk(part: BaseModel, prefix: str) -> Iterator[Control]:
    schema = _schema(type(part))
    for name in type(part).model_fields:
        key, value = f"{prefix}{name}", getattr(part, name)
        if key in HIDDEN or name == "kind":
            continue
        if isinstance(value, BaseModel):
            yield from _walk(value, f"{key}.")
        elif isinstance(value, bool | int | float | str):
            found = _control(key, value, schema["properties"].get(name, {}))
            if found:
                yield found


def _control(key: str, value: Any, schema: dict[str, Any]) -> Control | None:
    text, unit = schema.get("description", ""), schema.get("unit", "")
    branches = schema.get("anyOf", schema.get("oneOf", [schema]))
    if isinstance(value, bool):
        return Control(key, SWITCH, value, text=text)
    if isinstance(value, str):
        options = next((tuple(one["enum"]) for one in branches if "enum" in one), ())
        return Control(key, CHOICE, value, options=options, text=text) if value in options else None
    kind, names = (WHOLE, ("integer",)) if isinstance(value, int) else (NUMBER, ("number",))
    limits: dict[str, Any] = next((one for one in branches if one.get("type") in names), {})
    low = limits.get("minimum", limits.get("exclusiveMinimum", -math.inf))
    high = limits.get("maximum", limits.get("exclusiveMaximum", math.inf))
    factor, shown = (1.0, unit)
    if kind == NUMBER and unit in ("m", "Pa", "N", "s") and value:
        factor, shown = prefixed(abs(value), unit)
    return Control(key, kind, value, low, high, (), shown, factor, text)
