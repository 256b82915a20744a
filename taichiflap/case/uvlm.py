"""`[uvlm]`: settings of the vortex lattice and its wake."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, ModelWrapValidatorHandler, Tag, model_validator

from .schema import Section, key


def _all_or_number(value: Any) -> str:
    return "all" if isinstance(value, str) else "number"


WakeLength = Annotated[
    Annotated[int, Field(ge=1, le=1_000_000), Tag("number")] | Annotated[Literal["all"], Tag("all")],
    Discriminator(_all_or_number),
]


SHEDDING = {"panels": 40, "wake": 1000, "merge_error": 1e-4, "crossing": "pass", "core": 0.05, "core_growth": 0.3}
"""Defaults of `leading_edge = "sheds"` where they differ."""
LEAST_WAKE = 10
"""Vortices that a wake of two sheets has room for, at least."""


class Uvlm(Section):
    """Unsteady vortex lattice on the deformed camber line, with a free wake.

    With leading_edge = "sheds", what is left out is panels = 40, wake = 1000, merge_error = 1e-4, crossing = "pass",
    core = 0.05 and core_growth = 0.3.
    """

    panels: int = key(20, text="panels along the chord", ge=1, le=1000)
    spacing: Literal["cosine", "uniform"] = key(
        "cosine", text="panels: finer towards both edges, on the camber line itself; or equal and straight"
    )
    loads: Literal["vortices", "panels"] = key(
        "vortices", text="pressure steps at the bound vortices, or counts whole panels as the paper's Eqs 33-34 do"
    )
    leading_edge: Literal["attached", "sheds"] = key(
        "attached",
        text="the flow stays attached at the leading edge, or leaves it as a second sheet of vortices wherever the "
        "suction there would pass its limit",
    )
    suction: bool = key(
        False, text="include the suction at an attached leading edge; one that sheds always has what its limit leaves"
    )
    suction_limit: float = key(
        0.1, text="largest suction velocity at an edge that sheds, as a share of reference_speed; 0: it always sheds",
        ge=0, le=1e9,
    )  # fmt: skip
    reference_speed: float | None = key(
        None, unit="m/s", gt=0, le=1e6, example=1.0,
        text="for suction_limit and merge_error; if left out, the root mean square of the rigid leading edge's speed "
        "relative to the stream",
    )  # fmt: skip
    wake: WakeLength = key("all", text='wake vortices kept, or "all"')
    old_wake: Literal["absorb", "drop"] = key(
        "absorb", text="a full wake merges vortices, keeping circulation and impulse, or drops the oldest"
    )
    absorb_beyond: float = key(
        3.0, unit="chords", text="vortices nearer to the wing's middle than this are absorbed last", ge=0, le=1e6
    )
    merge_error: float = key(
        0.0,
        text="change of the velocity at the wing, as a share of reference_speed, that merging two neighbours of a "
        "sheet may cost; 0: none are merged",
        ge=0,
        le=0.1,
    )
    crossing: Literal["reflect", "pass"] = key(
        "reflect", text="a wake vortex that would cross the wing is kept on its side, or passes; counted either way"
    )
    shedding: Literal["local", "fixed"] = key(
        "local",
        text="new vortex on the trailing edge's path relative to the flow (0.30 of a step, 0.25 with uniform panels), "
        "or at a fixed distance",
    )
    shedding_distance: float = key(
        0.05, unit="chords", text='distance behind the trailing edge, for shedding = "fixed"', gt=0, le=10
    )
    convection: Literal["second_order", "euler"] = key(
        "second_order", text="how the wake moves: Adams-Bashforth of second order, or Euler's steps"
    )
    core: float = key(
        0.02, unit="chords", text="Krasny core of a wake vortex; the squares of a pair's cores add up", ge=0, le=1
    )
    core_growth: float = key(
        0.1, text="growth of a new vortex's core over the way it moves, until it is full; 0: full at once", ge=0, le=100
    )
    precision: Literal["double", "single"] = key(
        "double",
        text="of the sums over pairs of wake vortices: single is quicker, and good to about five digits",
    )
    far_error: float = key(
        0.0,
        text="error allowed in the velocity of a wake vortex, as a share of the trailing edge's typical speed, for the "
        "sake of speed in long wakes; 0: every pair of vortices is summed",
        ge=0,
        le=0.1,
    )

    @model_validator(mode="wrap")
    @classmethod
    def _of_an_edge_that_sheds(cls, given: Any, check: ModelWrapValidatorHandler[Self]) -> Self:
        """Fill in what is not given with the defaults of an edge that sheds; they do not count as given."""
        if not isinstance(given, Mapping) or given.get("leading_edge") != "sheds":
            return check(given)
        made = check(SHEDDING | dict(given))
        made.model_fields_set.intersection_update(given)
        return made

    @model_validator(mode="after")
    def _can_shed(self) -> Self:
        if self.leading_edge != "sheds":
            return self
        if self.spacing == "uniform":
            raise ValueError('a leading edge that sheds needs panels finer towards it; give spacing = "cosine"')
        if self.loads == "panels":
            raise ValueError('a leading edge that sheds needs the pressure at the vortices; give loads = "vortices"')
        if self.suction:
            raise ValueError(
                "suction is for an attached leading edge; one that sheds has the suction that suction_limit leaves"
            )
        if isinstance(self.wake, int) and self.wake < LEAST_WAKE:
            raise ValueError(f"wake = {self.wake}: two edges shed into it; give at least {LEAST_WAKE}")
        return self

    @model_validator(mode="after")
    def _one_saving(self) -> "Uvlm":
        if self.far_error and self.precision == "single":
            raise ValueError('far_error sums in double precision; give far_error = 0 or precision = "double"')
        return self
