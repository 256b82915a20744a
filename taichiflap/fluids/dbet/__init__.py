"""Deformable blade element theory: separated flow, attached flow and added mass of every chordwise element."""

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...case.case import Case
from ...motion import sampling
from ...structure.beam import Modes
from ..interface import Array, Flow, Model, Refinement, standard

TIMES = 512
"""Number of times of the last beat at which the speed is sampled."""


class Dbet(Model):
    """Blade elements (`[dbet]`)."""

    name = "DBET"
    outputs = standard("pressure_jump", "shear")

    def nodes(self, case: Case) -> Array:
        return _nodes(case.wing.chord, case.wing.pivot, case.dbet.elements)

    def problems(self, case: Case) -> list[str]:
        dbet, found = case.dbet, []
        new = {
            'dbet.frame = "deformed"': dbet.frame == "deformed",
            'dbet.added_mass = "potential"': dbet.added_mass == "potential",
            "dbet.attached = true": dbet.attached,
            f"dbet.rotation = {dbet.rotation:g}": dbet.rotation > 0.0,
            f'fluid.gust = "{case.fluid.gust}"': case.fluid.gust != "none",
        }
        there = ", ".join(name for name, stated in new.items() if stated)
        if dbet.speed == "truncated" and there:
            found.append(
                f'dbet.speed = "truncated" is the paper\'s and cannot be combined with {there}; '
                'give dbet.speed = "full", or frame = "chord", added_mass = "strip", attached = false, rotation = 0.0 '
                "and no gust"
            )
        if dbet.attached and case.wing.modes and (dbet.frame != "deformed" or dbet.added_mass != "potential"):
            found.append(
                f'dbet.attached = true on a flexible wing cannot be combined with frame = "{dbet.frame}" and '
                f'added_mass = "{dbet.added_mass}": the flutter speed would be wrong; give frame = "deformed" and '
                'added_mass = "potential", or attached = false'
            )
        return found

    def warnings(self, case: Case) -> list[str]:
        polar, viscosity = case.dbet.polar, case.fluid.viscosity
        if viscosity is None or not polar.source:
            return []
        times = np.linspace(max(0.0, case.duration - case.beat), case.duration, TIMES)
        behind = (1.0 - case.wing.pivot) * case.wing.chord
        speed = sampling.typical_speed(case.motion, behind, case.fluid.velocity, times)
        reynolds = speed * case.wing.chord / viscosity
        low, high = polar.reynolds
        if low <= reynolds <= high:
            return []
        return [
            f'dbet.coefficients = "{case.dbet.coefficients}" is valid for Reynolds numbers of {low:g} to {high:g} '
            f"({polar.source}); here, by the speed of the trailing edge, it is {reynolds:.2g}; "
            "choose another set, or give lift_max, drag_min and drag_max"
        ]

    def settings(self, case: Case) -> list[str]:
        return [f"{case.dbet.elements} elements"]

    def refinements(self, case: Case) -> list[Refinement]:
        return [Refinement("dbet.elements", case.dbet.elements)]

    def flow(self, cases: Sequence[Case], sections: Sequence[Modes], body: Any, threads: int | None) -> Flow:
        from .flow import flow  # noqa: PLC0415 - Taichi, for a run alone

        return flow(cases, sections)


@functools.lru_cache(maxsize=64)
def _nodes(chord: float, pivot: float, elements: int) -> Array:
    """Ends of the elements; not to change, since the cases of a study share them."""
    found: Array = chord * np.arange(elements + 1) / elements - pivot * chord
    found.setflags(write=False)
    return found


MODEL = Dbet()
