"""`solver`: the fluid model of a case, one of this package's or a module from elsewhere."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

ELSEWHERE = "module:"
"""How the name of a model that is not part of this package begins."""


def _whose(value: object) -> str:
    return "elsewhere" if isinstance(value, str) and value.startswith(ELSEWHERE) else "here"


Solver = Annotated[
    Annotated[Literal["uvlm", "dbet", "navier_stokes"], Tag("here")]
    | Annotated[
        str, Field(pattern=rf"^{ELSEWHERE}[A-Za-z_]\w*(\.[A-Za-z_]\w*)*$", title="module:NAME"), Tag("elsewhere")
    ],
    Discriminator(_whose),
]


def model_name(solver: str) -> str:
    """What a model is called in headings: `UVLM`, `Navier-Stokes`, or the last word of its module's name."""
    if solver == "navier_stokes":
        return "Navier-Stokes"
    return solver.removeprefix(ELSEWHERE).rpartition(".")[2].upper()
