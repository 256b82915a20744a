"""`[uvlm]`: settings of the vortex lattice and its wake."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from ..keys import Section, key


def _all_or_number(value: Any) -> str:
    return "all" if isinstance(value, str) else "number"


WakeLength = Annotated[
    Annotated[int, Field(ge=1, le=1_000_000), Tag("number")] | Annotated[Literal["all"], Tag("all")],
    Discriminator(_all_or_number),
]


class Uvlm(Section):
    """Unsteady vortex lattice on the deformed camber line, with a free wake."""

    panels: int = key(50, text="panels along the chord", ge=1, le=1000)
    spacing: Literal["uniform"] = key("uniform", text="spacing of the panels")
    wake: WakeLength = key("all", text='wake vortices kept, or "all"')
    old_wake: Literal["drop"] = key("drop", text="what happens to the oldest vortex of a full wake")
    shedding: Literal["local", "fixed"] = key(
        "local",
        text="new vortex at 0.25 of the trailing edge's travel relative to the flow, or at a fixed distance",
    )
    shedding_distance: float = key(
        0.05, unit="chords", text='distance behind the trailing edge, for shedding = "fixed"', gt=0, le=10
    )
    core: float = key(0.0, unit="chords", text="Krasny core of every wake interaction", ge=0, le=1)
