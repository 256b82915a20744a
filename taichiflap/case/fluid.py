"""`[fluid]`: the fluid around the wing."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic.json_schema import SkipJsonSchema

from .schema import CaseTable, as_tuple, key, needed

Velocity = Annotated[
    tuple[Annotated[float, Field(ge=-1000, le=1000)], Annotated[float, Field(ge=-1000, le=1000)]],
    BeforeValidator(as_tuple),
]


class Fluid(CaseTable):
    """The fluid around the wing."""

    density: float = key(1.225, unit="kg/m3", text="density of the fluid", ge=0, le=1e5)
    viscosity: float | SkipJsonSchema[None] = key(
        None, unit="m2/s", text="kinematic viscosity: air 1.5e-5, water 1e-6", example=1.5e-5, gt=0, le=1e3
    )
    velocity: Velocity = key((0.0, 0.0), unit="m/s", text="free stream along Y and Z (-Y is up)")
    gust: Literal["none", "sharp_edged", "one_minus_cosine", "sinusoidal"] = key(
        "none", text="gust normal to the stream, carried along with it"
    )
    gust_velocity: float = key(
        0.0,
        unit="m/s",
        text="maximum velocity of the gust, 90 degrees counter-clockwise from the stream (along Z for a stream along "
        "Y)",
        ge=-1000,
        le=1000,
    )
    gust_length: float | SkipJsonSchema[None] = key(
        None,
        unit="m",
        text="length of a one_minus_cosine gust, or wavelength of a sinusoidal gust",
        example=0.1,
        gt=0,
        le=1e6,
    )
    gust_arrival: float = key(
        0.0, unit="s", text="time at which the front of the gust reaches the origin of Y and Z", ge=-1e6, le=1e6
    )

    @model_validator(mode="after")
    def _of_gusts(self) -> "Fluid":
        if self.gust != "none":
            if not self.streams:
                raise needed("velocity", "a gust needs a free stream; set velocity")
            if self.gust != "sharp_edged" and self.gust_length is None:
                raise needed("gust_length", f'gust = "{self.gust}" needs a length; set gust_length')
        return self

    @property
    def streams(self) -> bool:
        """Whether there is a free stream."""
        return any(self.velocity)
