"""Warnings about valid cases, and their results, that are outside the models' range of validity."""

import functools
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .. import fluids
from ..case.case import Case
from ..case.motion import Motion
from ..case.solver import ELSEWHERE
from ..metrics.summary import Summary
from ..motion import sampling
from ..structure import beam
from ..structure.chordwise import Profile
from . import tables

LARGE = 50e9
"""Size of a result file, in bytes, that gives a warning."""
GAS = 20.0
"""Density, kg/m3, that separates air from water."""
VISCOSITY = {"air": 1.5e-5, "water": 1.0e-6}
"""Kinematic viscosities, m2/s."""
REYNOLDS = 30.0, 1e7
"""Range from the smallest insects to the largest swimmers; below it, viscosity dominates the force."""
FASTEST = {"air": (100.0, "is compressed"), "water": (30.0, "boils at the edges")}
"""Speed limit, m/s, and what happens to the fluid beyond it."""
MASS_RATIO = 0.005, 1000.0
"""Range of the ratio of wing mass to added mass: from a foil in water to a plate in air."""
BENT = 0.3
"""Tip deflection, in chords, at which a real beam with a tip load bends 10 % less than a linear one."""
BROKEN = 1.0
"""Maximum possible tip deflection, in chords."""
FORCE = 40.0
"""Limit of the normal force without added mass, in `rho V^2 S / 2` (`Summary.force_coefficient_peak`)."""
UNACCOUNTED = 0.03
"""Share of unaccounted work that gives a warning."""
BACKWARDS = -0.1
"""Mean velocity from leading to trailing edge, over the root-mean-square speed, below which flow is from behind."""
TIMES = 2048


def warnings(case: Case) -> list[str]:
    """Warnings about a case, one sentence each."""
    found = [*_of_mass(case), *_of_speed(case), *tables.warnings(case), *_of_numbers(case), *_of_direction(case)]
    with fluids.blamed(case.solver):
        found += fluids.load(case.solver).warnings(case)
        size = file_size(case)
    first = beam.modes(case.wing).frequency[:1]
    flapping = case.motion.frequency
    if first.size and flapping and first[0] < flapping:
        found.append(
            f"the first natural frequency, {first[0]:.4g} Hz, is below the flapping frequency, {flapping:g} Hz; check "
            "the wing's stiffness and mass"
        )
    if case.wing.thickness is not None:
        most = Profile.of(case.wing.thickness).values.max()
        if most > 0.2 * case.wing.chord:
            found.append(
                f"wing.thickness = {most:g} m exceeds a fifth of the chord, the limit of thin-plate bending; check it"
            )
    if size > LARGE:
        found.append(f"the result file will take {size / 1e9:.3g} GB; increase output.every to make it smaller")
    return found


def outcome(case: Case, tip_deflection: NDArray[np.float64], summary: Summary | None = None) -> list[str]:
    """Warnings about the results of a case, one sentence each."""
    found = list(too_bent(float(np.abs(tip_deflection).max(initial=0.0)), case.wing.chord))
    if summary:
        found += [*too_strong(summary.force_coefficient_peak), *unbalanced(summary.energy_residual, case)]
    model = fluids.load(case.solver)
    attached = model.attached_in(case)
    if attached is not None:
        angle = sampling.typical_angle(_last_beat(case), _middle(case), case.fluid.velocity)
        if angle > attached:
            found.append(
                f"angle of attack reaches {angle:.0f} deg at high speed; above about {attached:g} deg the flow "
                f"separates at the leading edge, which {model.name} does not capture"
            )
    return found


def too_bent(tip_peak: float, chord: float) -> Iterator[str]:
    """Warning about a peak tip deflection (m) beyond the validity of a linear beam."""
    bent = tip_peak / chord
    if bent > BROKEN:
        yield (
            f"the model is invalid: peak tip deflection is {bent:.2g} chords, more than the chord itself; discard "
            "this run and use a stiffer wing"
        )
    elif bent > BENT:
        yield f"peak tip deflection is {bent:.2g} chords; above {BENT:g} the error of the linear beam exceeds 10 %"


def too_strong(coefficient: float | None) -> Iterator[str]:
    """Warning about an unphysical peak force coefficient."""
    if coefficient is not None and coefficient > FORCE:
        yield (
            f"the model is invalid: the normal force without added mass reaches {coefficient:.2g} times rho V^2 S / "
            f"2, above the limit of {FORCE:g}; use more panels and steps, or a larger uvlm.core"
        )


def unbalanced(residual: float | None, case: Case) -> Iterator[str]:
    """Warning about energy that a run leaves unaccounted for."""
    if residual is None or residual <= UNACCOUNTED:
        return
    if case.time.periods is None:
        cure = f"use a smaller time.step, such as {0.5 * case.step:.3g}"
    else:
        cure = f"increase time.steps_per_period, for example to {2.0 * case.steps_per_beat:g}"
    yield f"{100.0 * residual:.2g} % of the work is unaccounted for because the time step is too long; {cure}"


def _of_numbers(case: Case) -> Iterator[str]:
    if case.numbers and not case.solver.startswith(ELSEWHERE):
        names = ", ".join(case.numbers)
        yield f'solver = "{case.solver}" uses none of the numbers {names}; they apply only to your own fluid model'


def _of_direction(case: Case) -> Iterator[str]:
    """Warning that the flow reaches the trailing edge first."""
    model, streams = fluids.load(case.solver), case.fluid.streams
    if streams and not model.sheds_behind:
        return
    along, across = sampling.flow_to_chord(_last_beat(case), _middle(case), case.fluid.velocity)
    speed = math.sqrt(float(np.mean(along**2 + across**2)))
    if not speed or np.mean(along) >= BACKWARDS * speed:
        return
    if streams:
        yield (
            f"the stream, fluid.velocity = [{case.fluid.velocity[0]:g}, {case.fluid.velocity[1]:g}] m/s, reaches the "
            f"trailing edge first, where {model.name} sheds the wake; turn the stream, or the wing by "
            "motion.pitch.mean_deg"
        )
        return
    cure = "the sign and the phase of motion.pitch"
    if case.motion.measured:
        cure = "rotation_from, stroke_positive and the signs of the angles in motion.measured"
    share = 100.0 * float(np.mean(along < 0.0))
    yield f"the trailing edge leads during {share:.0f} % of the beat; check {cure}"


def _of_mass(case: Case) -> Iterator[str]:
    if case.wing.density is not None:
        least = Profile.of(case.wing.density).values.min()
        if least <= case.fluid.density:
            yield (
                f"the wing (wing.density = {least:g} kg/m3) is less dense than the fluid "
                f"(fluid.density = {case.fluid.density:g} kg/m3)"
            )
    mass = beam.modes(case.wing).mass
    moved = 0.25 * math.pi * case.fluid.density * case.wing.chord**2 * Profile.of(case.wing.span).mean
    if moved and not MASS_RATIO[0] < mass / moved < MASS_RATIO[1]:
        yield (
            f"the wing's mass is {mass:.3g} kg, {mass / moved:.2g} times its added mass; check the units of its mass, "
            "its size and fluid.density"
        )


def _of_speed(case: Case) -> Iterator[str]:
    chord = case.wing.chord
    speed = sampling.speed_of(_last_beat(case), (1.0 - case.wing.pivot) * chord, case.fluid.velocity)
    fluid = "air" if case.fluid.density < GAS else "water"
    fastest, there = FASTEST[fluid]
    if speed > fastest:
        yield f"the trailing edge moves through the fluid at {speed:.3g} m/s, but {fluid} {there} at such speeds"
    reynolds = speed * chord / (case.fluid.viscosity or VISCOSITY[fluid])
    guess = "" if case.fluid.viscosity else f" if the fluid is {fluid}"
    if case.fluid.density and speed and not REYNOLDS[0] < reynolds < REYNOLDS[1]:
        yield (
            f"the Reynolds number is about {reynolds:.2g}{guess}; wings and fins have {REYNOLDS[0]:g} to "
            f"{REYNOLDS[1]:g}; check wing.chord, motion.frequency and the amplitudes"
        )


def _last_beat(case: Case) -> NDArray[np.float64]:
    """Motion over the last beat, as `sampling.sample` returns it."""
    return _sampled(case.motion, max(0.0, case.duration - case.beat), case.duration)


@functools.lru_cache(maxsize=16)
def _sampled(motion: Motion, first: float, last: float) -> NDArray[np.float64]:
    found = sampling.sample(motion, np.linspace(first, last, TIMES))
    found.setflags(write=False)
    return found


def _middle(case: Case) -> float:
    """Distance of the middle of the chord behind the pivot, m."""
    return (0.5 - case.wing.pivot) * case.wing.chord


def file_size(case: Case) -> float:
    """Approximate size of a case's result file, bytes."""
    model = fluids.load(case.solver)
    step = 8.0 * (21 + 2 * case.fluid.streams + 4 * case.wing.modes)
    shape = 4.0 * 2 * len(model.nodes(case))
    ragged = sum(4.0 * model.totals(case)[one.over[0]] for one in model.outputs if one.ragged)
    plain = model.frame_bytes(case) - sum(4.0 * model.entries(case, case.steps) for one in model.outputs if one.ragged)
    return float(step * (case.steps + 1) + (shape + plain) * case.frames() + ragged)
