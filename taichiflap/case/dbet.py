"""`[dbet]`: settings of the blade elements."""

from typing import Literal

from .schema import Section, key


class Dbet(Section):
    """Deformable blade element theory, quasi-steady."""

    elements: int = key(50, text="blade elements along the chord", ge=1, le=10_000)
    lift_max: float = key(1.8, text="largest lift coefficient, at 45 degrees", ge=0, le=100)
    drag_min: float = key(0.4, text="drag coefficient along the chord", ge=0, le=100)
    drag_max: float = key(4.0, text="drag coefficient across the chord", ge=0, le=100)
    added_mass: bool = key(True, text="include the added mass of the fluid")
    speed: Literal["full", "truncated"] = key(
        "full", text="square of the local speed: full, or truncated as the paper's Eqs 21-22"
    )
