"""Warnings about cases that are legal but that the models are not good for."""

from . import beam
from .case import Case


def warnings(case: Case) -> list[str]:
    """What is implausible about a case, one sentence each; an empty list when nothing is."""
    found = []
    first = beam.modes(case.wing).frequency[:1]
    flapping = case.motion.frequency
    if first.size and flapping and first[0] < flapping:
        found.append(
            f"the first natural frequency, {first[0]:.4g} Hz, is below the flapping frequency, "
            f"{flapping:g} Hz: check wing.youngs_modulus and wing.thickness"
        )
    if case.wing.density <= case.fluid.density:
        found.append(
            f"the wing (wing.density = {case.wing.density:g} kg/m3) is not denser than the fluid "
            f"(fluid.density = {case.fluid.density:g} kg/m3)"
        )
    if case.wing.thickness > 0.2 * case.wing.chord:
        found.append(f"wing.thickness = {case.wing.thickness:g} m is over a fifth of the chord: no thin plate bends so")
    return found
