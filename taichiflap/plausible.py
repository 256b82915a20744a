"""Warnings about cases that are legal but that the models are not good for."""

from . import beam
from .case import Case
from .profile import Profile


def warnings(case: Case) -> list[str]:
    """What is implausible about a case, one sentence each; an empty list when nothing is."""
    found = []
    first = beam.modes(case.wing).frequency[:1]
    flapping = case.motion.frequency
    if first.size and flapping and first[0] < flapping:
        found.append(
            f"the first natural frequency, {first[0]:.4g} Hz, is below the flapping frequency, "
            f"{flapping:g} Hz: check the wing's stiffness and mass"
        )
    if case.wing.density is not None:
        least = Profile.of(case.wing.density).values.min()
        if least <= case.fluid.density:
            found.append(
                f"the wing (wing.density = {least:g} kg/m3) is not denser than the fluid "
                f"(fluid.density = {case.fluid.density:g} kg/m3)"
            )
    if case.wing.thickness is not None:
        most = Profile.of(case.wing.thickness).values.max()
        if most > 0.2 * case.wing.chord:
            found.append(f"wing.thickness = {most:g} m is over a fifth of the chord: no thin plate bends so")
    return found
