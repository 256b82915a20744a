"""Deformable blade element theory: separated, attached and accelerated flow past every chordwise element."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...case.case import Case
from ...structure.beam import Modes
from ..interface import Array, Flow, Model, Refinement, standard


class Dbet(Model):
    """Blade elements (`[dbet]`)."""

    name = "DBET"
    outputs = standard("pressure_jump", "shear")

    def nodes(self, case: Case) -> Array:
        chord = case.wing.chord
        return chord * np.arange(case.dbet.elements + 1) / case.dbet.elements - case.wing.pivot * chord

    def settings(self, case: Case) -> list[str]:
        return [f"{case.dbet.elements} elements"]

    def refinements(self, case: Case) -> list[Refinement]:
        return [Refinement("dbet.elements", case.dbet.elements)]

    def flow(self, cases: Sequence[Case], sections: Sequence[Modes], body: Any, threads: int | None) -> Flow:
        from .flow import flow  # noqa: PLC0415 - Taichi, for a run alone

        return flow(cases, sections)


MODEL = Dbet()
