"""`solver`: the fluid model of a case, built in or from a module of your own."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

ELSEWHERE = "module:"
"""Prefix of the name of an external model."""


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
    """Display name of a model: `UVLM`, `Navier-Stokes`, or the last word of its module's name."""
    if solver == "navier_stokes":
        return "Navier-Stokes"
    return solver.removeprefix(ELSEWHERE).rpartition(".")[2].upper()
