"""Settings of a case's grid, from its table `[navier_stokes]` or from its Reynolds number."""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...case.case import Case
from ...case.motion import Motion
from ...errors import UserError
from ...motion import sampling
from ...motion.sampling import PITCH, PITCH_RATE, PLUNGE_RATE, SURGE_RATE
from .grid import Grid

POINTS = ((300.0, 128), (1500.0, 192), (3000.0, 256), (math.inf, 384))
"""Cells around the section up to a Reynolds number."""
SPACING = 0.3
"""Thickness of the first row at mid-chord times the root of the Reynolds number, chords."""
WIDEST = 0.3
"""The first row at mid-chord is at most this share of a cell's angle."""
RADIUS = 7.6, 30.0
"""Outer radius without and with a free stream, chords."""
THICKNESS = 0.04
"""Thickness of the section, chords: the flow around the edges of a thinner one asks for shorter steps."""
LEAST_SQUARE = 8.0
"""Square of the cells over the Reynolds number below which they cannot resolve the flow; the defaults have 20 and
more."""
COARSEST = 4.0
"""Automatic steps that a step may be long."""
FRAMES_A_BEAT = 40
INSERTED = 1.0
"""Periods of the start-up where the motion begins with a jump."""
JUMP = 0.01
"""Speed of the trailing edge at the start, as a share of its typical speed, that counts as one."""
STILL = 0.1
"""Share of the trailing edge's speed below which a pivot counts as still."""
CELLS = (64, 96, 128, 192, 256, 288, 384, 512, 576, 768, 1024, 1152, 1536)
"""Numbers of cells that a message may name."""
TIMES = 512


class ResolutionError(UserError):
    """Raised if the cells cannot resolve a flow: one sentence with the required number."""


@dataclass(frozen=True)
class Settings:
    """Settings of a case's flow; lengths in chords. `reynolds` is that of the mean speed, see `reynolds`."""

    reynolds: float
    cells: int
    thickness: float
    radius: float
    wall_spacing: float

    def grid(self, pivot: float) -> Grid:
        """The grid of these settings."""
        return _grid(self, pivot)


@functools.lru_cache(maxsize=256)
def _grid(found: Settings, pivot: float) -> Grid:
    half = 0.5 * found.thickness
    far = math.log(found.radius / (0.5 * (0.5 + half)))
    return Grid.stretched(found.cells, 2.0 * found.wall_spacing, far, half, pivot)


def reynolds(case: Case) -> float:
    """Mean speed of the pivot through the fluid, or of the trailing edge if the pivot rests, times chord over
    viscosity.

    The metric `reynolds` takes the reference speed of coefficients: in a harmonic stroke 1.11 times the mean.
    """
    # Of the case as it was given: an automatic time step follows from the Reynolds number.
    speed = _mean_speed(case.motion, case.wing.pivot, case.wing.chord, case.fluid.velocity, case.time.duration or 0.0)
    assert case.fluid.viscosity is not None  # a case without it is refused
    return speed * case.wing.chord / case.fluid.viscosity


@functools.lru_cache(maxsize=256)
def _mean_speed(motion: Motion, at: float, chord: float, stream: tuple[float, float], duration: float) -> float:
    first = motion.growth
    span = 1.0 / motion.frequency if motion.frequency else max(duration - first, duration / TIMES)
    moved = sampling.sample(motion, first + span * np.arange(TIMES) / TIMES)
    y, z = moved[:, SURGE_RATE] - stream[0], moved[:, PLUNGE_RATE] - stream[1]
    turning = (1.0 - at) * chord * moved[:, PITCH_RATE]
    sine, cosine = np.sin(moved[:, PITCH]), np.cos(moved[:, PITCH])
    pivot, edge = np.hypot(y, z).mean(), np.hypot(y - turning * sine, z + turning * cosine).mean()
    return float(pivot if pivot > STILL * edge else edge)


def settings(case: Case) -> Settings:
    """The settings of a case: given, or found from its Reynolds number."""
    asked, number = case.navier_stokes, reynolds(case)
    cells = asked.cells or next(points for most, points in POINTS if number <= most)
    stream = case.fluid.streams
    spacing = min(SPACING / math.sqrt(max(number, 1.0)), WIDEST * 2.0 * math.pi / cells)
    return Settings(
        reynolds=number,
        cells=cells,
        thickness=asked.thickness or THICKNESS,
        radius=asked.radius or RADIUS[stream],
        wall_spacing=asked.wall_spacing or spacing,
    )


def checked(case: Case) -> Settings:
    """The case's numbers.

    Raises:
        ResolutionError: when the cells or steps cannot resolve the flow.
    """
    found = settings(case)
    if found.cells**2 < LEAST_SQUARE * found.reynolds:
        least = next((n for n in CELLS if n**2 >= LEAST_SQUARE * found.reynolds), None)
        if least is None:
            most = CELLS[-1] ** 2 / LEAST_SQUARE
            raise ResolutionError(
                f"the Reynolds number of the mean speed is {found.reynolds:.3g}: beyond {most:.3g} no grid of this "
                "model resolves the flow; check fluid.viscosity, or take another solver"
            )
        raise ResolutionError(
            f"navier_stokes.cells = {found.cells} is too few at a Reynolds number, by the mean speed, of "
            f"{found.reynolds:.3g}; give {least}{', or leave it out' if case.navier_stokes.cells else ''}"
        )
    needed = COARSEST * case.matched_step() if found.reynolds else math.inf
    if case.step > needed:
        auto = case.matched_step()
        cure = f'time.step = {needed:.3g} s or less; "auto" takes {auto:.3g} s'
        if case.time.periods is not None:
            fewest, usual = math.ceil(case.beat / needed), math.ceil(case.beat / auto)
            cure = f'time.steps_per_period = {fewest} or more; "auto" takes {usual}'
        raise ResolutionError(
            f"the step of {case.step:.3g} s is too long at a Reynolds number, by the mean speed, of "
            f"{found.reynolds:.3g}: the flow would pass many cells in one; give {cure}"
        )
    return found


def completed(case: Case) -> Case:
    """The case with its defaults for the number of frames and the start-up filled in."""
    changed: dict[str, Any] = {}
    if "every" not in case.output.model_fields_set:
        every = max(1, round(case.steps_per_beat / FRAMES_A_BEAT))
        changed["output"] = case.output.model_copy(update={"every": every})
    if case.motion.frequency and not case.motion.growth and starts_with_jump(case):
        changed["motion"] = case.motion.model_copy(update={"start_up": INSERTED / case.motion.frequency})
    return case.model_copy(update=changed) if changed else case


def starts_with_jump(case: Case) -> bool:
    """Whether the wing would have a velocity at the start without a start-up."""
    motion = case.motion.model_copy(update={"start_up": None, "start_up_periods": None})
    behind = (1.0 - case.wing.pivot) * case.wing.chord
    over = 1.0 / motion.frequency if motion.frequency else case.duration
    typical = sampling.typical_speed(motion, behind, (0.0, 0.0), over * np.arange(TIMES) / TIMES)
    return sampling.typical_speed(motion, behind, (0.0, 0.0), np.zeros(1)) > JUMP * typical
