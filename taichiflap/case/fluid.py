"""`[fluid]`: what surrounds the wing."""

from typing import Annotated

from pydantic import BeforeValidator, Field
from pydantic.json_schema import SkipJsonSchema

from .schema import Section, as_tuple, key

Velocity = Annotated[
    tuple[Annotated[float, Field(ge=-1000, le=1000)], Annotated[float, Field(ge=-1000, le=1000)]],
    BeforeValidator(as_tuple),
]


class Fluid(Section):
    """The fluid around the wing."""

    density: float = key(1.225, unit="kg/m3", text="density of the fluid", ge=0, le=1e5)
    viscosity: float | SkipJsonSchema[None] = key(
        None, unit="m2/s", text="kinematic viscosity: air 1.5e-5, water 1e-6", example=1.5e-5, gt=0, le=1e3
    )
    velocity: Velocity = key((0.0, 0.0), unit="m/s", text="free stream along Y and Z (-Y is up)")

    @property
    def streams(self) -> bool:
        """Whether there is a free stream; without one the wing hovers."""
        return any(self.velocity)
