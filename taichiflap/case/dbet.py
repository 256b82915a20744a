"""`[dbet]`: settings of deformable blade element theory."""

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, field_validator, model_validator

from .schema import ModelTable, as_tuple, key


@dataclass(frozen=True)
class Polar:
    """Coefficients of a separated plate: `C_L = lift_max sin 2A`, `C_D` from `drag_min` to `drag_max` as `sin^2 A`.

    Attributes:
        reynolds: Reynolds numbers (mean speed and chord) for which the set was measured.
        source: where the numbers come from.
    """

    lift_max: float
    drag_min: float
    drag_max: float
    reynolds: tuple[float, float] = (0.0, float("inf"))
    source: str = ""


POLARS = {
    "whitney_wood": Polar(
        1.8,
        0.4,
        3.4,
        (100.0, 1e4),
        "Whitney & Wood, J. Fluid Mech. 660 (2010), after Dickinson et al., Science 284 (1999)",
    ),
    "reade_jankauski": Polar(
        1.8, 0.4, 4.0, (1e3, 1e4), "Reade & Jankauski, ASME IDETC DETC2020-22638 (2020), section on DBET"
    ),
    "wang": Polar(1.2, 0.4, 2.4, (30.0, 200.0), "Wang, Birch & Dickinson, J. Exp. Biol. 207 (2004), two-dimensional"),
}
"""Named sets of coefficients."""

_Degrees = Annotated[float, Field(ge=0, le=90)]
Stall = Annotated[tuple[_Degrees, _Degrees], BeforeValidator(as_tuple)]

_PAPER = {
    "coefficients": "reade_jankauski",
    "frame": "chord",
    "attached": False,
    "rotation": 0.0,
    "friction": "none",
}
"""Defaults for files of version 0.1, which have `added_mass = true` or `false`."""


class Dbet(ModelTable):
    """Deformable blade element theory, quasi-steady."""

    elements: int = key(50, text="blade elements along the chord", ge=1, le=10_000)
    coefficients: Literal["whitney_wood", "reade_jankauski", "wang"] = key(
        "whitney_wood", text="coefficients of separated flow: lift_max, drag_min, drag_max 1.8/0.4/3.4, 1.8/0.4/4.0 "
        "or, below a Reynolds number of 200, 1.2/0.4/2.4",
    )  # fmt: skip
    lift_max: float | None = key(
        None, text="maximum lift coefficient, at 45 degrees; replaces that of the set", example=1.8, ge=0, le=100
    )
    drag_min: float | None = key(
        None, text="drag coefficient at zero angle of attack; replaces that of the set", example=0.4, ge=0, le=100
    )
    drag_max: float | None = key(
        None, text="drag coefficient at 90 degrees; replaces that of the set", example=3.4, ge=0, le=100
    )
    frame: Literal["deformed", "chord"] = key(
        "deformed", text="direction of the forces: normal and tangent of the bent wing, or of the undeformed chord"
    )
    added_mass: Literal["potential", "strip", "none"] = key(
        "potential", text="added mass: potential flow about the whole chord, independent strips (the paper's), or none"
    )
    attached: bool = key(
        True, text="attached flow at small angles of attack: unsteady thin-aerofoil theory, including the wake's memory"
    )
    stall_deg: Stall = key((20.0, 45.0), unit="deg", text="angles of attack at which separation starts and is complete")
    suction: float = key(
        1.0, text="fraction of the leading-edge suction in attached flow: 1 for a round edge, 0 for none", ge=0, le=1
    )
    rotation: float = key(
        1.0, text="factor of the rotational force in separated flow; 0: none", ge=0, le=10
    )  # fmt: skip
    friction: Literal["laminar", "none"] = key(
        "laminar", text="skin friction of a laminar boundary layer in attached flow; needs fluid.viscosity"
    )
    speed: Literal["full", "truncated"] = key(
        "full", text="square of the local speed: full, or truncated as in the paper's Eqs 21-22"
    )

    @model_validator(mode="before")
    @classmethod
    def _of_version_1(cls, given: Any) -> Any:
        """Accept `added_mass = true` or `false`; the other settings then default to the paper's model."""
        if isinstance(given, dict) and isinstance(given.get("added_mass"), bool):
            return {**_PAPER, **given, "added_mass": "strip" if given["added_mass"] else "none"}
        return given

    @field_validator("stall_deg")
    @classmethod
    def _rising(cls, stall: tuple[float, float]) -> tuple[float, float]:
        if not stall[0] < stall[1]:
            raise ValueError("the first angle must be smaller than the second")
        return stall

    @property
    def polar(self) -> Polar:
        """Coefficients of separated flow: the named set, with the file's own values where given."""
        own = {name: getattr(self, name) for name in ("lift_max", "drag_min", "drag_max")}
        given = {name: value for name, value in own.items() if value is not None}
        named = POLARS[self.coefficients]
        return Polar(**{name: getattr(named, name) for name in own} | given) if given else named
