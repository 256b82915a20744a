"""`[wing]`: the elastic section."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, ValidationInfo, field_validator
from pydantic.json_schema import SkipJsonSchema
from pydantic_core import PydanticKnownError

from .schema import CaseTable, as_tuple, key

MOST_ENTRIES = 100

Table = tuple[tuple[float, float], ...]
AlongChord = float | Table
"""A number, or a table [[s, value], ...] over s = y/chord, linear between its entries."""


def _one_or_each(value: Any) -> str:
    return "each" if isinstance(value, list | tuple) else "one"


def _as_table(value: Any) -> Any:
    return tuple(as_tuple(entry) for entry in value) if isinstance(value, list | tuple) else value


_Station = Annotated[float, Field(ge=0, le=1, title="s")]


@dataclass(frozen=True)
class _UpTo:
    """Check of an `AlongChord`: values are positive, or zero at the trailing edge where allowed."""

    most: float
    may_vanish: bool = False

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        value = Annotated[float, Field(ge=0, le=self.most, title="value")]
        number = Annotated[float, Field(gt=0, le=self.most), Tag("one")]
        table = Annotated[
            tuple[tuple[_Station, value], ...],
            Field(max_length=MOST_ENTRIES),
            BeforeValidator(_as_table),
            AfterValidator(self._check),
            Tag("each"),
        ]
        return handler.generate_schema(Annotated[number | table, Discriminator(_one_or_each)])

    def _check(self, table: Table) -> Table:
        if len(table) < 2 or table[0][0] != 0.0 or table[-1][0] != 1.0:
            raise ValueError("must run from s = 0 to s = 1; give the values at the leading and trailing edge")
        for (before, _), (after, _) in pairwise(table):
            if after <= before:
                raise ValueError(
                    f"s must increase, but {after:.9g} follows {before:.9g}; for a jump give two close values of s"
                )
        must = table[:-1] if self.may_vanish else table
        if min(value for _, value in must) == 0.0:
            at = "but at the trailing edge" if self.may_vanish else "everywhere"
            raise ValueError(f"must be > 0 {at}; give a small number instead")
        return table


_Damping = Annotated[float, Field(ge=0, le=10)]
DampingRatio = Annotated[
    Annotated[_Damping, Tag("one")] | Annotated[tuple[_Damping, ...], BeforeValidator(as_tuple), Tag("each")],
    Discriminator(_one_or_each),
]
_PointMass = tuple[_Station, Annotated[float, Field(gt=0, le=1e6, title="kg")]]
PointMasses = Annotated[tuple[_PointMass, ...], Field(max_length=MOST_ENTRIES), BeforeValidator(_as_table)]

_MEASURED = ("mass_per_length", "flexural_rigidity")


class Wing(CaseTable):
    """The wing section, clamped at its leading edge; many keys also take a table [[s, value], ...], s = y/chord."""

    chord: float = key(unit="m", text="chord length", example=0.02, gt=0, le=100)
    span: Annotated[AlongChord, _UpTo(100, may_vanish=True)] = key(
        unit="m", text="span (normal to the section)", example=0.05
    )
    modes: int = key(1, text="number of elastic modes; 0 is a rigid wing", ge=0, le=20)
    damping_ratio: DampingRatio = key(0.05, text="damping ratio: one value, or one per mode")
    pivot: float = key(
        0.0, unit="chords", text="distance of the pivot behind the leading edge; only for rigid wings", ge=-5, le=5
    )
    mass_per_length: Annotated[AlongChord, _UpTo(1e5, may_vanish=True)] | SkipJsonSchema[None] = key(
        None,
        unit="kg/m",
        text="measured wing: mass per length of chord",
        example=2e-3,
        validate_default=True,
    )
    flexural_rigidity: Annotated[AlongChord, _UpTo(1e12, may_vanish=True)] | SkipJsonSchema[None] = key(
        None,
        unit="N m2",
        text="measured wing: E I of the whole span",
        example=6.5e-6,
        validate_default=True,
    )
    thickness: Annotated[AlongChord, _UpTo(10, may_vanish=True)] | SkipJsonSchema[None] = key(
        None, unit="m", text="thickness", example=40e-6, validate_default=True
    )
    density: Annotated[AlongChord, _UpTo(1e5)] | SkipJsonSchema[None] = key(
        None, unit="kg/m3", text="density of the wing's material", example=1000.0, validate_default=True
    )
    youngs_modulus: Annotated[AlongChord, _UpTo(1e13)] | SkipJsonSchema[None] = key(
        None, unit="Pa", text="Young's modulus", example=24.5e9, validate_default=True
    )
    point_masses: PointMasses = key((), text="point masses on the section: s and kg of each", example=((0.5, 2e-6),))

    @property
    def widest(self) -> float:
        """The largest span, m."""
        return self.span if isinstance(self.span, float) else max(value for _, value in self.span)

    @field_validator("damping_ratio")
    @classmethod
    def _one_per_mode(cls, value: Any, info: ValidationInfo) -> Any:
        modes = info.data.get("modes")
        if isinstance(value, tuple) and modes is not None and len(value) < modes:
            raise ValueError(f"too few values for {modes} modes; give one number, or one per mode")
        return value

    @field_validator("pivot")
    @classmethod
    def _clamped_where_it_pivots(cls, value: float, info: ValidationInfo) -> float:
        if value and info.data.get("modes"):
            raise ValueError("an elastic wing is clamped at its leading edge; set wing.modes = 0, or leave pivot out")
        return value

    @field_validator("flexural_rigidity")
    @classmethod
    def _measured_whole(cls, value: Any, info: ValidationInfo) -> Any:
        mass = info.data.get("mass_per_length", value)
        if value is None and mass is not None and info.data.get("modes"):
            raise PydanticKnownError("missing")
        if value is not None and mass is None:
            raise ValueError("needs mass_per_length as well")
        return value

    @field_validator("thickness", "density", "youngs_modulus")
    @classmethod
    def _material_or_measured(cls, value: Any, info: ValidationInfo) -> Any:
        measured = any(info.data.get(name, "wrong") is not None for name in _MEASURED)
        if value is not None and measured:
            raise ValueError(
                "give either thickness, density and youngs_modulus, or mass_per_length and flexural_rigidity"
            )
        unused = info.field_name == "youngs_modulus" and info.data.get("modes") == 0
        if value is None and not measured and not unused:
            raise PydanticKnownError("missing")
        return value
