"""Warnings about cases that are legal but that the models are not good for."""

from . import beam, fluids
from .case import Case
from .profile import Profile

LARGE = 50e9
"""Bytes of a result file that are worth a warning."""


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
    size = file_size(case)
    if size > LARGE:
        found.append(f"the result file will take {size / 1e9:.3g} GB; a larger output.every makes it smaller")
    return found


def file_size(case: Case) -> float:
    """Size of a case's result file, bytes, but for a few percent."""
    model = fluids.load(case.solver)
    points = len(model.nodes(case))
    frame = 8.0 * (18 + 4 * case.wing.modes) + 4.0 * 4 * points
    return float(frame * (case.steps // case.output.every + 1) + 16.0 * model.vortices(case))
