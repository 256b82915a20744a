"""`[navier_stokes]`: settings of the grid around the section. Defaults follow from the Reynolds number."""

from typing import TYPE_CHECKING, ClassVar

from pydantic import field_validator
from pydantic.json_schema import SkipJsonSchema

from .schema import ModelTable, key, needed

if TYPE_CHECKING:
    from .case import Case

THINNEST = 0.02
"""Minimum thickness of a flexible section, in chords, for which the grid mapping converges."""


class NavierStokes(ModelTable):
    """Two-dimensional Navier-Stokes flow on a grid that deforms with the section."""

    own_steps: ClassVar[bool] = True

    cells: int | SkipJsonSchema[None] = key(
        None,
        text="cells around the section; default: 128 to 384, depending on the Reynolds number",
        example=256,
        ge=64,
        le=1536,
    )
    thickness: float | SkipJsonSchema[None] = key(
        None,
        unit="chords",
        text="thickness of the ellipse that represents the section; default: 0.04",
        example=0.02,
        ge=0.005,
        le=1,
    )
    radius: float | SkipJsonSchema[None] = key(
        None,
        unit="chords",
        text="outer radius of the grid; default: 7.6, or 30 in a stream",
        example=7.6,
        ge=3,
        le=1e4,
    )
    wall_spacing: float | SkipJsonSchema[None] = key(
        None,
        unit="chords",
        text="thickness of the first row of cells at mid-chord; default: 0.3 over the square root of the Reynolds "
        "number",
        example=0.006,
        gt=0,
        le=0.1,
    )

    @field_validator("cells")
    @classmethod
    def _transformable(cls, value: int | None) -> int | None:
        if value is not None and not _transforms(value):
            near = min((n for n in range(64, 1537, 16) if _transforms(n)), key=lambda n: (abs(n - value), n))
            raise ValueError(f"must be 16 times a product of twos and threes; the nearest such number is {near}")
        return value

    def check(self, case: "Case") -> None:
        """Refuse a case without a viscosity, of many sections, or too thin to bend."""
        if case.fluid.viscosity is None:
            raise needed("fluid.viscosity", "required by the Navier-Stokes model")
        if isinstance(case.wing.span, tuple):
            raise ValueError("wing.span is a table: the Navier-Stokes model is two-dimensional; give a number")
        if case.wing.modes and self.thickness and self.thickness < THINNEST:
            raise ValueError(
                f"navier_stokes.thickness = {self.thickness:g}: the grid of a flexible wing needs at least "
                f"{THINNEST:g} chords; give {THINNEST:g} or leave it out"
            )


def _transforms(cells: int) -> bool:
    """Whether a fast Fourier transform exists for this number of cells."""
    rest = cells // 16
    for factor in (2, 3):
        while rest and rest % factor == 0:
            rest //= factor
    return cells % 16 == 0 and rest == 1
