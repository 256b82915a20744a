"""Two-dimensional Navier-Stokes flow about a rigid or bending section, on a conformal grid."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ...case.case import Case
from ...motion.gust import gust_velocity
from ...structure.beam import Modes
from ...structure.chordwise import Profile
from ..interface import Array, Axis, Flow, FlowField, Model, Output, Refinement, Velocity, standard
from .settings import INSERTED, ResolutionError, checked, completed, settings, starts_with_jump

_FRICTION = "the rest is pressure"


class NavierStokes(Model):
    """The Navier-Stokes equations (`[navier_stokes]`)."""

    name = "Navier-Stokes"
    draws_flow = True
    stores_vorticity = True
    outputs = (
        *standard("pressure_jump", "shear"),
        Output("friction_normal", (), "N", "part of the normal force due to friction", "F_N,f", _FRICTION),
        Output("friction_axial", (), "N", "part of the axial force due to friction", "F_A,f", _FRICTION),
        Output(
            "courant", (), "1", "largest Courant number of a cell so far", "C",
            "looked at when fields are stored; beyond about 15 the first beat errs by more than 1 %",
        ),
        Output(
            "vorticity", ("rho", "phi"), "s-1", "vorticity of the fluid", "omega",
            "on the grid about the wing, in the inertial frame; positive counter-clockwise in (Y, Z); rounded to 2^-11 "
            "of itself, and to zero below 0.001 viscosities over the chord squared", "f4",
        ),
        Output(
            "map", ("exponent", "part"), "m", "coefficients of the map of the grid", "a",
            "y + i z = sum of a zeta^exponent, zeta = exp(rho + i phi), in the wing's axes from the pivot",
        ),
    )  # fmt: skip

    def nodes(self, case: Case) -> Array:
        half, chord = settings(case).cells // 2, case.wing.chord
        return chord * (0.5 * (1.0 - np.cos(np.pi * np.arange(half + 1) / half)) - case.wing.pivot)

    def axes(self, case: Case) -> Mapping[str, Axis]:
        grid = settings(case).grid(case.wing.pivot)
        terms = min(MOST_TERMS, grid.points // 2) if case.wing.modes else 2
        return {
            "rho": Axis(0.5 * (grid.faces[1:] + grid.faces[:-1]), "1", "logarithm of the distance in the map's plane"),
            "phi": Axis(grid.centres, "rad", "angle in the map's plane"),
            "exponent": Axis(1 - np.arange(terms + 1), "1", "exponent of zeta"),
            "part": Axis(np.arange(2), "1", "real and imaginary part"),
        }

    def problems(self, case: Case) -> list[str]:
        try:
            checked(case)
        except ResolutionError as error:
            return [str(error)]
        return []

    def warnings(self, case: Case) -> list[str]:
        found = []
        number = settings(case).reynolds
        if number > WILD:
            found.append(
                f"the Reynolds number of the mean speed is {number:.3g}; above {WILD:g} the vortices of a "
                "two-dimensional flow are too strong"
            )
        given, start_up = case.motion, completed(case).motion.start_up
        if given.frequency and start_up == INSERTED / given.frequency and starts_with_jump(case):
            found.append(
                "the motion begins with a jump in velocity, which a viscous flow cannot follow; "
                f"motion.start_up = {start_up:g} s is used"
            )
        return found

    def outcome(self, case: Case, written: Callable[[str], Any]) -> list[str]:
        found = []
        bent = float(np.abs(written("tip_deflection")).max(initial=0.0)) / case.wing.chord
        if bent > FAR:
            found.append(f"the tip deflection reaches {bent:.2g} chords; above {FAR:g} the grid's map may not converge")
        if case.periodic and case.time.periods and case.time.periods < SETTLED and settings(case).reynolds > SHEDDING:
            found.append(f"time.periods = {case.time.periods}: the mean of a separated flow needs at least {SETTLED}")
        section = settings(case).thickness
        own = thickest(case)
        if own is not None and own < 0.5 * section:
            found.append(
                f"the section is an ellipse of navier_stokes.thickness = {section:g} chords, the wing has {own:.2g}: "
                "the lift is too low, by about 3 % between 0.02 and 0.04 chords"
            )
        number = float(written("courant")[-1])
        if number > COURANT:
            found.append(
                f"the Courant number reached {number:.3g}; above {COURANT:g} the error of a step exceeds 1 %; "
                f"{_cure(case, number / COURANT)}"
            )
        return found

    def completed(self, case: Case) -> Case:
        return completed(case)

    def stride(self, case: Case) -> float:
        number = settings(case).reynolds
        return case.wing.chord * next(share for most, share in STRIDE if number <= most)

    def settings(self, case: Case) -> list[str]:
        found = settings(case)
        rows = found.grid(case.wing.pivot).rows
        return [f"{rows} x {found.cells} cells"]

    def refinements(self, case: Case) -> list[Refinement]:
        return [Refinement("navier_stokes.cells", settings(case).cells)]

    def work(self, case: Case, step: int) -> float:
        grid = settings(case).grid(case.wing.pivot)
        return (40.0 if case.wing.modes else 20.0) * grid.rows * grid.points

    def memory(self, case: Case) -> float:
        modes, grid = case.wing.modes, settings(case).grid(case.wing.pivot)
        fields = FIELDS + (FIELDS_OF_BENDING if modes else 0)
        spectra = 16 * grid.plan.slots * (grid.rows + 2 * modes)
        lines = (LINES + 6 * modes) * grid.points
        # Behind the fields of the cells the influence matrix and its inverse, and the points of the map.
        numbers = fields * grid.rows * grid.points + spectra + lines + 2 * grid.points**2
        return 8.0 * (numbers + (OF_MAP if modes else 0))

    def velocity(self, result: Any, index: int) -> Velocity:
        return self.field(result, index).velocity

    def field(self, result: Any, index: int) -> FlowField:
        from .field import Field  # noqa: PLC0415 - for a picture of the flow alone

        found = Field.of(result, index)
        if result.case.fluid.gust == "none":
            return FlowField(found.velocity_at, found.vorticity_at, found.streamfunction_at)
        time = float(result.frame("time", index))

        def velocity(points: Array) -> Array:
            return found.velocity_at(points) + gust_velocity(result.case.fluid, time, *points)

        return FlowField(velocity, found.vorticity_at)

    def flow(self, cases: Sequence[Case], sections: Sequence[Modes], body: Any, threads: int | None) -> Flow:
        from .flow import flow  # noqa: PLC0415 - Taichi, for a run alone

        return flow(cases, sections, body)


def _cure(case: Case, times: float) -> str:
    """The setting of a case for steps that are so many times shorter."""
    if not math.isfinite(times):
        return "use far shorter steps"
    if case.time.periods is None:
        return f"use time.step = {case.step / times:.3g} s or less"
    return f"use time.steps_per_period = {math.ceil(case.steps_per_beat * times)} or more"


def thickest(case: Case) -> float | None:
    """Maximum thickness of the wing itself, chords; None if unknown."""
    given = case.wing.thickness
    return None if given is None else float(Profile.of(given).values.max()) / case.wing.chord


STRIDE = ((300.0, 0.01), (3000.0, 0.0028), (math.inf, 0.0018))
"""Chords that the trailing edge travels in an automatic step, up to a Reynolds number."""
WILD = 3000.0
"""Reynolds number of a warning."""
SETTLED, SHEDDING = 10, 300.0
"""Periods of a mean that repeats, from a Reynolds number on."""
FAR = 0.5
"""Tip deflection of a warning, chords."""
COURANT = 15.0
"""Courant number of a warning."""
FIELDS, FIELDS_OF_BENDING = 11, 5
"""Arrays of one number a cell that a case has, and those of a bending section besides."""
LINES, OF_MAP = 150, 7e4
"""Numbers an angle that are not of the cells, and numbers of the map of a bending section."""
MOST_TERMS = 64
"""Coefficients of the map of a bent section that are stored, besides the first."""

MODEL = NavierStokes()
