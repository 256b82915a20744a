"""Warnings about cases, and what came of them, that are legal but that the models are not good for."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .. import fluids
from ..case.case import Case
from ..case.solver import ELSEWHERE
from ..metrics.summary import Summary
from ..motion import sampling
from ..structure import beam
from ..structure.chordwise import Profile
from . import tables

LARGE = 50e9
"""Bytes of a result file that are worth a warning."""
GAS = 20.0
"""A fluid of less than this density, kg/m3, is taken for air, a denser one for water."""
VISCOSITY = {"air": 1.5e-5, "water": 1.0e-6}
"""Kinematic, m2/s."""
REYNOLDS = 30.0, 1e7
"""Between the smallest insects and the largest swimmers; below, viscosity makes most of the force."""
FASTEST = {"air": (100.0, "is compressed"), "water": (30.0, "boils at the edges")}
"""Speed, m/s, and what the fluid does beyond."""
MASS_RATIO = 0.005, 1000.0
"""A wing's mass over that of the fluid that moves with it: of a foil in water, and of a plate in air."""
BENT = 0.3
"""Tip deflection, in chords, at which a load on the tip of a real beam bends it a tenth less than a linear one."""
BROKEN = 1.0
"""Tip deflection, in chords, that no wing can have: its chord is no longer."""
FORCE = 40.0
"""Normal force but for added mass, in `rho V^2 S / 2` (`Summary.force_coefficient_peak`), of which flows give some."""
UNACCOUNTED = 0.03
"""Share of the work that a run may leave unaccounted for, without a word."""
BACKWARDS = -0.1
"""Mean speed from the leading to the trailing edge, over the root mean square speed, of a flow from behind."""
TIMES = 2048


def warnings(case: Case) -> list[str]:
    """What is implausible about a case, one sentence each; an empty list when nothing is."""
    found = [*_of_mass(case), *_of_speed(case), *tables.warnings(case), *_of_numbers(case), *_of_stream(case)]
    with fluids.blamed(case.solver):
        found += fluids.load(case.solver).warnings(case)
        size = file_size(case)
    first = beam.modes(case.wing).frequency[:1]
    flapping = case.motion.frequency
    if first.size and flapping and first[0] < flapping:
        found.append(
            f"the first natural frequency, {first[0]:.4g} Hz, is below the flapping frequency, "
            f"{flapping:g} Hz: check the wing's stiffness and mass"
        )
    if case.wing.thickness is not None:
        most = Profile.of(case.wing.thickness).values.max()
        if most > 0.2 * case.wing.chord:
            found.append(f"wing.thickness = {most:g} m is over a fifth of the chord: no thin plate bends so")
    if size > LARGE:
        found.append(f"the result file will take {size / 1e9:.3g} GB; a larger output.every makes it smaller")
    return found


def outcome(case: Case, tip_deflection: NDArray[np.float64], summary: Summary | None = None) -> list[str]:
    """What is implausible about what came of a case, one sentence each; an empty list when nothing is."""
    found = list(too_bent(float(np.abs(tip_deflection).max(initial=0.0)), case.wing.chord))
    if summary:
        found += [*too_strong(summary.force_coefficient_peak), *unbalanced(summary.energy_residual, case)]
    model = fluids.load(case.solver)
    attached = model.attached_in(case)
    if attached is not None:
        angle = sampling.typical_angle(case.motion, _middle(case), case.fluid.velocity, _last_beat(case))
        if angle > attached:
            found.append(
                f"the flow meets the chord at {angle:.0f} deg where it is fast: beyond some {attached:g} deg "
                f"it separates at the leading edge, of which {model.name} knows nothing"
            )
    return found


def too_bent(tip_peak: float, chord: float) -> Iterator[str]:
    """A sentence on a largest tip deflection (m) that a linear beam is not good for."""
    bent = tip_peak / chord
    if bent > BROKEN:
        yield (
            f"the model does not hold: the trailing edge bends by up to {bent:.2g} chords, further than the chord is "
            "long; no number of this run means anything; give a stiffer wing"
        )
    elif bent > BENT:
        yield (
            f"the trailing edge bends by up to {bent:.2g} chords: "
            f"beyond {BENT:g} the linear beam errs by more than a tenth"
        )


def too_strong(coefficient: float | None) -> Iterator[str]:
    """A sentence on a largest force coefficient that no flow gives."""
    if coefficient is not None and coefficient > FORCE:
        yield (
            f"the model does not hold: the normal force but for added mass reaches {coefficient:.2g} times "
            f"rho V^2 S / 2, of which flows give some units and this warning allows {FORCE:g}; "
            "give more panels and steps, or a larger uvlm.core"
        )


def unbalanced(residual: float | None, case: Case) -> Iterator[str]:
    """A sentence on energy that a run leaves unaccounted for."""
    if residual is None or residual <= UNACCOUNTED:
        return
    if case.time.periods is None:
        cure = f"give a smaller time.step, such as {0.5 * case.step:.3g}"
    else:
        cure = f"give more time.steps_per_period, such as {2.0 * case.steps_per_beat:g}"
    yield f"{100.0 * residual:.2g} % of the work is unaccounted for: the step is too long; {cure}"


def _of_numbers(case: Case) -> Iterator[str]:
    if case.numbers and not case.solver.startswith(ELSEWHERE):
        names = ", ".join(case.numbers)
        yield f'numbers are for a fluid model of your own: solver = "{case.solver}" reads none of {names}'


def _of_stream(case: Case) -> Iterator[str]:
    """A model that sheds its wake from the trailing edge does so whichever edge the flow comes to first."""
    model = fluids.load(case.solver)
    if not model.sheds_behind or not case.fluid.streams:
        return
    along, across = sampling.flow_to_chord(case.motion, _middle(case), case.fluid.velocity, _last_beat(case))
    speed = math.sqrt(float(np.mean(along**2 + across**2)))
    if speed and np.mean(along) < BACKWARDS * speed:
        yield (
            f"the stream, fluid.velocity = [{case.fluid.velocity[0]:g}, {case.fluid.velocity[1]:g}] m/s, meets the "
            f"trailing edge first, but {model.name} sheds the wake there: turn the stream, or the wing by "
            "motion.pitch.mean_deg"
        )


def _of_mass(case: Case) -> Iterator[str]:
    if case.wing.density is not None:
        least = Profile.of(case.wing.density).values.min()
        if least <= case.fluid.density:
            yield (
                f"the wing (wing.density = {least:g} kg/m3) is not denser than the fluid "
                f"(fluid.density = {case.fluid.density:g} kg/m3)"
            )
    mass = beam.modes(case.wing).mass
    moved = 0.25 * math.pi * case.fluid.density * case.wing.chord**2 * Profile.of(case.wing.span).mean
    if moved and not MASS_RATIO[0] < mass / moved < MASS_RATIO[1]:
        yield (
            f"the wing weighs {mass:.3g} kg, {mass / moved:.2g} times the fluid that moves with it: "
            "check the units of its mass, its size and fluid.density"
        )


def _of_speed(case: Case) -> Iterator[str]:
    chord = case.wing.chord
    speed = sampling.typical_speed(case.motion, (1.0 - case.wing.pivot) * chord, case.fluid.velocity, _last_beat(case))
    fluid = "air" if case.fluid.density < GAS else "water"
    fastest, there = FASTEST[fluid]
    if speed > fastest:
        yield f"the trailing edge moves through the fluid at {speed:.3g} m/s, but {fluid} {there} at such speeds"
    reynolds = speed * chord / (case.fluid.viscosity or VISCOSITY[fluid])
    guess = "" if case.fluid.viscosity else f" if the fluid is {fluid}"
    if case.fluid.density and speed and not REYNOLDS[0] < reynolds < REYNOLDS[1]:
        yield (
            f"the Reynolds number is about {reynolds:.2g}{guess}; wings and fins have "
            f"{REYNOLDS[0]:g} to {REYNOLDS[1]:g}: check wing.chord, motion.frequency and the amplitudes"
        )


def _last_beat(case: Case) -> NDArray[np.float64]:
    return np.linspace(max(0.0, case.duration - case.beat), case.duration, TIMES)


def _middle(case: Case) -> float:
    """Distance of the middle of the chord behind the pivot, m."""
    return (0.5 - case.wing.pivot) * case.wing.chord


def file_size(case: Case) -> float:
    """Size of a case's result file, bytes, but for a few percent."""
    model = fluids.load(case.solver)
    step = 8.0 * (21 + 2 * case.fluid.streams + 4 * case.wing.modes)
    shape = 4.0 * 2 * len(model.nodes(case))
    ragged = sum(4.0 * model.totals(case)[one.over[0]] for one in model.outputs if one.ragged)
    plain = model.frame_bytes(case) - sum(4.0 * model.entries(case, case.steps) for one in model.outputs if one.ragged)
    return float(step * (case.steps + 1) + (shape + plain) * case.frames() + ragged)
