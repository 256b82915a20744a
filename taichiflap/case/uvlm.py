"""`[uvlm]`: settings of the vortex lattice and its wake."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, ModelWrapValidatorHandler, Tag, model_validator

from .schema import ModelTable, key, needed

if TYPE_CHECKING:
    from .case import Case


def _all_or_number(value: Any) -> str:
    return "all" if isinstance(value, str) else "number"


WakeLength = Annotated[
    Annotated[int, Field(ge=1, le=1_000_000), Tag("number")] | Annotated[Literal["all"], Tag("all")],
    Discriminator(_all_or_number),
]


SHEDDING = {"panels": 40, "wake": 1000, "merge_error": 1e-4, "crossing": "pass", "core": 0.05, "core_growth": 0.3}
"""Defaults that differ with `leading_edge = "sheds"`."""
LEAST_WAKE = 10
"""Minimum length of a wake with two sheets."""


class Uvlm(ModelTable):
    """Unsteady vortex lattice on the deformed camber line, with a free wake.

    With leading_edge = "sheds" the defaults are panels = 40, wake = 1000, merge_error = 1e-4, crossing = "pass", core =
    0.05 and core_growth = 0.3.
    """

    panels: int = key(20, text="panels along the chord", ge=1, le=1000)
    spacing: Literal["cosine", "uniform"] = key(
        "cosine", text="panels: finer towards both edges, on the camber line (cosine); or equal and straight (uniform)"
    )
    loads: Literal["vortices", "panels"] = key(
        "vortices",
        text="pressure changes at the bound vortices, or is uniform over each panel as in the paper's Eqs 33-34",
    )
    leading_edge: Literal["attached", "sheds"] = key(
        "attached",
        text="flow at the leading edge: attached, or shedding a second vortex sheet whenever the suction would exceed "
        "suction_limit",
    )
    suction: bool = key(
        False, text="include leading-edge suction in attached flow; an edge that sheds always has its limited suction"
    )
    suction_limit: float = key(
        0.1, text="maximum suction velocity at an edge that sheds, as a share of reference_speed; 0: always sheds",
        ge=0, le=1e9,
    )  # fmt: skip
    reference_speed: float | None = key(
        None, unit="m/s", gt=0, le=1e6, example=1.0,
        text="reference speed of suction_limit and merge_error; default: root-mean-square speed of the rigid leading "
            "edge relative to the stream",
    )  # fmt: skip
    wake: WakeLength = key("all", text='number of wake vortices kept, or "all"')
    old_wake: Literal["absorb", "drop"] = key(
        "absorb", text="a full wake merges vortices, conserving circulation and impulse (absorb), or drops the oldest"
    )
    absorb_beyond: float = key(
        3.0, unit="chords", text="vortices closer than this to mid-chord are absorbed last", ge=0, le=1e6
    )
    merge_error: float = key(
        0.0,
        text="allowed change of the velocity at the wing, as a share of reference_speed, when two neighbouring "
        "vortices merge; 0: no merging",
        ge=0,
        le=0.1,
    )
    crossing: Literal["reflect", "pass"] = key(
        "reflect",
        text="a wake vortex that would cross the wing is kept on its side (reflect), or passes; both are counted",
    )
    shedding: Literal["local", "fixed"] = key(
        "local",
        text="position of a new vortex: on the trailing edge's path relative to the flow (0.30 of a step; 0.25 with "
        "uniform panels), or at a fixed distance",
    )
    shedding_distance: float = key(
        0.05,
        unit="chords",
        text='distance of a new vortex behind the trailing edge with shedding = "fixed"',
        gt=0,
        le=10,
    )
    convection: Literal["second_order", "euler"] = key(
        "second_order", text="convection of the wake: second-order Adams-Bashforth, or Euler"
    )
    core: float = key(
        0.02, unit="chords", text="Krasny core radius of a wake vortex; the squared cores of a pair add up", ge=0, le=1
    )
    core_growth: float = key(
        0.1,
        text="growth of a new vortex's core per distance travelled, until it is full; 0: full at once",
        ge=0,
        le=100,
    )
    precision: Literal["double", "single"] = key(
        "double",
        text="precision of the sums over pairs of wake vortices; single is faster and accurate to about five digits",
    )
    far_error: float = key(
        0.0,
        text="allowed error in the velocity of a wake vortex, as a share of the trailing edge's typical speed; speeds "
        "up long wakes; 0: sums every pair",
        ge=0,
        le=0.1,
    )

    @model_validator(mode="wrap")
    @classmethod
    def _of_an_edge_that_sheds(cls, given: Any, check: ModelWrapValidatorHandler[Self]) -> Self:
        """Fill in the defaults of an edge that sheds. They do not count as given keys."""
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
            raise ValueError('a leading edge that sheds needs finer panels near it; give spacing = "cosine"')
        if self.loads == "panels":
            raise ValueError('a leading edge that sheds needs the pressure at the vortices; give loads = "vortices"')
        if self.suction:
            raise ValueError(
                "suction applies to an attached leading edge; leave it out, since suction_limit sets the suction of "
                "an edge that sheds"
            )
        if isinstance(self.wake, int) and self.wake < LEAST_WAKE:
            raise ValueError(f"wake = {self.wake}: both edges shed into it; give at least {LEAST_WAKE}")
        return self

    def check(self, case: "Case") -> None:
        """Refuse a case in which nothing tells the speed that a limit is a share of."""
        limited = self.suction_limit if self.leading_edge == "sheds" else self.merge_error
        if limited and not case.reference_speed:
            raise needed("uvlm.reference_speed", "the leading edge itself does not move through the fluid")

    @model_validator(mode="after")
    def _one_saving(self) -> "Uvlm":
        if self.far_error and self.precision == "single":
            raise ValueError('far_error needs double precision; give far_error = 0 or precision = "double"')
        return self
