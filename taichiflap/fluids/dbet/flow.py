"""Deformable blade elements: separated flow, attached flow and added mass of every element, blended and summed.

Reade & Jankauski (2020), Eqs 17-27, is one choice of settings; docs/theory/dbet.md derives the model. The force per
area along the normal n of the section is

    p = -[sigma (f_n + f_rot) + (1 - sigma) pi rho |u_t| (K u_n + g D)] + p_added,

and along its tangent t `-f`; on the area `span dy` of an element they give `F_z = p - s f` and `F_y = -s p - f`, s the
slope of the bent wing. p is linear in the modal rates and accelerations, since geometry, sigma and f are evaluated at
the predicted rates.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...case.case import Case
from ...kernels import linear
from ...kernels.arrays import array, octet_array, zeros
from ...kernels.runtime import Floats2, Floats3, Ints1, Ints2, Octets3, View, ti
from ...march.state import common_modes, held_body, most_modes
from ...march.stream import streams
from ...motion.sampling import PITCH_RATE
from ...structure.beam import Modes
from ...structure.chordwise import Profile
from ...vortex.sum import TINY
from ..interface import Flow
from . import added_mass, attached, elements, loads, separated, strips
from .added_mass import TERMS
from .attached import ADVANCE, COEFFICIENTS, LAGS, SEPARATED
from .elements import (
    AREA,
    ATTACHED,
    CHORD,
    FRICTION,
    HALF_DENSITY,
    LIFTED,
    PER_AREA,
    POSITION,
    POTENTIAL,
    PRESSURE,
    ROTATION,
    ROWS,
    SHARE,
    SHEAR,
    SHEARING,
    SLOPE,
    STRETCH,
    STRIP,
    TRACTION,
    U_T,
)
from .separated import BROADSIDE

Blades = ti.types.argpack(
    elements=Ints1,
    option=Ints2,  # (case, 4) and (case, 12): see the names of their columns in `elements`
    setting=Floats2,
    stream=Floats2,  # see `taichiflap.march.stream`
    element=Octets3,  # (case, row, eight elements)
    strip=Floats3,  # (case, 2 + modes, 2 + modes): see `strips.masses`
    shape=Octets3,  # (case, mode, eight elements): mode shapes at the midpoints, and their slopes
    shape_slope=Octets3,
    sines=Octets3,  # (case, term, eight elements): see `added_mass.table`
    shape_sine=Floats3,  # (case, mode, term): sine coefficients of the mode shapes
    sine=Floats3,  # (case, 1 + modes, term): of the flux's rate without modal acceleration, and for a unit one
    cosines=Octets3,  # see `attached.cosines` and `attached.loads`
    loads=Octets3,
    cosine=Floats3,  # (case, 1 + modes, term): cosine coefficients of u_n, likewise
    work=Floats3,  # (case, 1, term): of a mode on the loads of attached flow
    lag=Floats2,  # (case, LAGS): see `attached`
)


class Uses(NamedTuple):
    """What a batch needs of the model; its kernel holds nothing else.

    Attributes:
        extended: whether some case needs more than the paper's model, see `extends`.
        truncated: whether some case has the truncated speed.
        modes: see `taichiflap.march.state.common_modes`.
    """

    extended: bool
    truncated: bool
    modes: int


def extends(case: Case) -> bool:
    """Whether a case needs more than the paper's model. If no case of a batch does, the kernel contains only that
    model.
    """
    dbet = case.dbet
    gusty = case.fluid.gust != "none"
    return dbet.frame == "deformed" or dbet.added_mass == "potential" or dbet.attached or dbet.rotation > 0.0 or gusty


def flow(cases: Sequence[Case], sections: Sequence[Modes]) -> Flow:
    """Elements of a batch at rest."""
    count = len(cases)
    most = 8 * linear.octets(max(case.dbet.elements for case in cases))
    modes = most_modes(sections)
    element = np.zeros((count, ROWS, most))
    shape, slope = np.zeros((2, count, modes, most))
    truncated = any(case.dbet.speed == "truncated" for case in cases)
    used = Uses(any(map(extends, cases)), truncated, common_modes(sections))
    # The paper's model does not read the tables of the others.
    terms, coefficients, loads_of = (TERMS, COEFFICIENTS, COEFFICIENTS - 1) if used.extended else (1, 1, 1)
    sines, shape_sine = np.zeros((count, terms, most)), np.zeros((count, modes, terms))
    cosines, lifts = np.zeros((count, coefficients, most)), np.zeros((count, loads_of, most))
    strip = np.zeros((count, 2 + modes, 2 + modes))
    tables = element, strip, shape, slope, sines, shape_sine, cosines, lifts
    laid: dict[Any, int] = {}
    rows: list[int] = []
    for b, (case, section) in enumerate(zip(cases, sections, strict=True)):
        # The cases of a study often share their wing, but for its stiffness.
        wing = case.wing
        own = id(section.shapes), wing.chord, wing.pivot, wing.span, case.dbet.elements
        rows.append(laid.setdefault(own, b))
        if rows[b] < b:
            continue
        n, y = case.dbet.elements, elements.middles(case)
        element[b, POSITION, :n] = y
        element[b, AREA, :n] = elements.areas(case)
        element[b, SHARE, :n] = 1.0 / n
        element[b, STRETCH, :n] = 1.0
        element[b, PER_AREA, :n] = 1.0 / element[b, AREA, :n]
        shape[b, : section.count, :n], slope[b, : section.count, :n] = section.curves(y)
        strip[b] = strips.masses(y, element[b, AREA, :n], shape[b, :, :n])
        if used.extended:
            sines[b, :, :n] = added_mass.table(case)
            shape_sine[b] = (shape[b, :, None] * sines[b]).sum(axis=2)
            cosines[b, :, :n], lifts[b, :, :n] = attached.cosines(n), attached.loads(n)
    for table in tables if len(laid) < count else ():
        table[:] = table[rows]
    settings = np.array([_settings(case) for case in cases])
    strip *= settings[:, STRIP, None, None]
    blades = Blades(
        elements=array([case.dbet.elements for case in cases]),
        option=array([_options(case) for case in cases]),
        setting=array(settings),
        stream=streams(cases, [case.dbet.elements for case in cases]),
        element=octet_array(element),
        strip=array(strip),
        shape=octet_array(shape),
        shape_slope=octet_array(slope),
        sines=octet_array(sines),
        shape_sine=array(shape_sine),
        sine=zeros(ti.f64, count, modes + 1, terms),
        cosines=octet_array(cosines),
        loads=octet_array(lifts),
        cosine=zeros(ti.f64, count, modes + 1, coefficients),
        work=zeros(ti.f64, count, 1, coefficients),
        lag=zeros(ti.f64, count, LAGS),
    )
    return Flow({"flow": blades}, {"flow": Blades}, prepare, settle, record, uses=used)


def _options(case: Case) -> list[int]:
    """Options of a case, in the order of their names in `elements`."""
    dbet = case.dbet
    bends = dbet.frame == "deformed" and case.wing.modes > 0
    return [int(dbet.speed == "truncated"), int(bends), int(dbet.added_mass == "potential"), int(dbet.attached)]


def _settings(case: Case) -> list[float]:
    """Settings of a case, in the order of their names in `elements`."""
    dbet, density, chord = case.dbet, case.fluid.density, case.wing.chord
    polar = dbet.polar
    friction = 0.0
    if dbet.friction == "laminar" and case.fluid.viscosity is not None:
        friction = 1.328 * density * math.sqrt(case.fluid.viscosity / chord)
    return [
        0.5 * density,
        math.pi * density * (chord if dbet.added_mass == "strip" else 0.0) / 4.0,
        0.5 * density * (polar.drag_min + 2.0 * polar.lift_max),
        0.5 * density * polar.drag_max,
        0.5 * density * polar.drag_min,
        0.5 * density * (polar.drag_max - 2.0 * polar.lift_max),
        dbet.rotation * 0.25 * math.pi * density * chord,
        dbet.suction * math.pi * density * chord * Profile.of(case.wing.span).mean,
        *map(math.radians, dbet.stall_deg),
        friction,
        chord,
    ]


@ti.func
def blend(body: View, flow: View, b, n, mean_n, mean_t, used: View):
    """Weight the forces of attached and separated flow, and add the rotational force to the latter."""
    speed = ti.sqrt(mean_n * mean_n + mean_t * mean_t)
    share = 1.0
    if ti.static(used.extended):
        if flow.option[b, ATTACHED] == 1:
            share = attached.separate(flow, b, mean_n, mean_t)
            flow.lag[b, SEPARATED] = share
            flow.lag[b, ADVANCE] = 0.0
            if n > 0:
                flow.lag[b, ADVANCE] = 2.0 * speed * body.dt[b] / flow.setting[b, CHORD]
    leading = ti.min(ti.max(-mean_t / (BROADSIDE * speed + TINY), -1.0), 1.0)
    turning = flow.setting[b, ROTATION] * body.motion[b, n, PITCH_RATE] * speed * leading
    for block in range((flow.elements[b] + 7) // 8):
        flow.element[b, TRACTION, block] = share * (flow.element[b, TRACTION, block] + turning)
        flow.element[b, SLOPE, block] = share * flow.element[b, SLOPE, block]
        if ti.static(used.extended):
            if share < 1.0:
                u_t = flow.element[b, U_T, block]
                along = ti.max(u_t, -1.0 * u_t)
                friction = flow.setting[b, FRICTION] * ti.sqrt(along) * u_t
                shearing = share * flow.element[b, SHEARING, block] + (1.0 - share) * friction
                lifted = (1.0 - share) * 2.0 * math.pi * flow.setting[b, HALF_DENSITY]
                flow.element[b, SHEARING, block] = shearing
                flow.element[b, LIFTED, block] = lifted * along


@ti.func
def prepare(batch: View, b, n, rule, used: View):
    """Modal force of step `n`."""
    body = ti.static(held_body(batch.body, used.modes))
    mean_n, mean_t = separated.linearise(body, batch.flow, b, n, used)
    if ti.static(used.extended):
        blend(body, batch.flow, b, n, mean_n, mean_t, used)
    if ti.static(used.extended):
        if batch.flow.option[b, POTENTIAL] == 1:
            added_mass.flux_rates(body, batch.flow, b, n, rule, used)
    if ti.static(used.extended):
        if batch.flow.option[b, ATTACHED] == 1:
            attached.lift(body, batch.flow, b, rule, used)
    loads.load_modes(body, batch.flow, b, n, rule, used)


@ti.func
def settle(batch: View, b, n, rule, used: View):
    """Forces of step `n` at the known modal acceleration."""
    body = ti.static(held_body(batch.body, used.modes))
    loads.sum_forces(body, batch.flow, b, n, used, ti.static("output" in batch.keys))


@ti.func
def record(batch: View, b, frame):
    elements = batch.flow.elements[b]
    for block in range((elements + 7) // 8):
        pressure = batch.flow.element[b, PRESSURE, block]
        shear = batch.flow.element[b, SHEAR, block]
        for lane in ti.static(range(8)):
            if 8 * block + lane < elements:
                batch.output.pressure_jump[b, frame, 8 * block + lane] = ti.cast(pressure[lane], ti.f32)
                batch.output.shear[b, frame, 8 * block + lane] = ti.cast(shear[lane], ti.f32)
