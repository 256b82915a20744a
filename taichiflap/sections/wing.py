"""`[wing]`: the elastic section."""

from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, Field, Tag, ValidationInfo, field_validator

from ..keys import Section, as_tuple, key


def _one_or_each(value: Any) -> str:
    return "each" if isinstance(value, list | tuple) else "one"


_Damping = Annotated[float, Field(ge=0, le=10)]
DampingRatio = Annotated[
    Annotated[_Damping, Tag("one")] | Annotated[tuple[_Damping, ...], BeforeValidator(as_tuple), Tag("each")],
    Discriminator(_one_or_each),
]


class Wing(Section):
    """A uniform wing section, clamped at its leading edge."""

    chord: float = key(unit="m", text="chord, leading to trailing edge", example=0.02, gt=0, le=100)
    span: float = key(unit="m", text="span, out of the page", example=0.05, gt=0, le=100)
    thickness: float = key(unit="m", text="thickness", example=40e-6, gt=0, le=10)
    density: float = key(unit="kg/m3", text="density of the wing's material", example=1000.0, gt=0, le=1e5)
    youngs_modulus: float = key(unit="Pa", text="Young's modulus", example=24.5e9, gt=0, le=1e13)
    modes: int = key(1, text="elastic modes kept; 0 is a rigid wing", ge=0, le=20)
    damping_ratio: DampingRatio = key(0.05, text="damping ratio: one, or one per mode")

    @field_validator("damping_ratio")
    @classmethod
    def _one_per_mode(cls, value: Any, info: ValidationInfo) -> Any:
        modes = info.data.get("modes")
        if isinstance(value, tuple) and modes is not None and len(value) < modes:
            raise ValueError(f"too few for {modes} modes; give one number, or one per mode")
        return value
