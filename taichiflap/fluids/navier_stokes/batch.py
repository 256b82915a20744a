"""The arrays of a batch of flows at its start."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...case.case import Case
from ...kernels.arrays import array, octet_array, zeros
from ...kernels.runtime import Octet
from ...march.stream import streams
from ...structure.beam import Modes
from . import arrays, gust, mapping
from .arrays import LINES, MODAL_LINES, Arrays
from .plan import PLAN
from .tables import SPARE, Given


def allocate(cases: Sequence[Case], sections: Sequence[Modes]) -> Any:  # noqa: PLR0915 - one loop nest
    """Arrays of a batch at its start."""
    given = [Given.of(case, modes) for case, modes in zip(cases, sections, strict=True)]
    count = len(given)
    most = max(one.modes.count for one in given)
    deep = max(one.grid.rows for one in given) + SPARE
    wide = max(one.grid.points for one in given)
    octets = wide // 8
    slots = max(plan.slots for one in given for plan in one.plans)
    flow_slots = max(one.grid.plan.slots for one in given)
    longest = max(plan.octets for one in given for plan in one.plans)
    twiddled = max(8 * plan.groups + plan.tail for one in given for plan in one.plans)
    bends = most > 0
    size = np.array([one.sizes() for one in given], np.int32)
    number = np.zeros((count, arrays.NUMBERS))
    row = np.zeros((count, deep, arrays.COLUMNS))
    row[:, :, arrays.THICKNESS] = 1.0
    plan = np.zeros((count, 2, PLAN), np.int32)
    root = np.zeros((count, 2, longest, 2))
    twiddle = np.zeros((count, 2, twiddled, 2, 8))
    slot = np.zeros((count, arrays.FACTORS, slots, 8))
    decay = np.zeros((count, max(one.grid.alike for one in given) + 1, flow_slots, 8))
    terms = wide // 2 + 1 if bends else 3
    equation = np.zeros((count, 2 * wide + wide // 2 + 1), np.int32)
    across = max([2 * one.plans[1].slots for one in given if one.modes.count] + [longest, 1]) if bends else 1
    contour = np.zeros((count, mapping.CONTOUR_LINES if bends else 1, 8 * across))
    series = np.zeros((count, 2 * most + 1, int(size[:, arrays.SERIES].max()) + 1))
    coefficient = np.zeros((count, terms, 2))
    area, vorticity = np.zeros((count, deep, wide)), np.zeros((count, deep, wide))
    corner = np.zeros((2, count, deep, wide))
    line = np.zeros((count, LINES + MODAL_LINES * most, wide))
    for b, one in enumerate(given):
        points, rows = one.grid.points, one.grid.rows
        number[b, : arrays.RUBBED_Y] = one.numbers()
        row[b, : rows + SPARE] = one.rows()
        for p, transform in enumerate(one.plans):
            plan[b, p] = transform.entries
            root[b, p, : transform.octets] = transform.roots
            twiddle[b, p, : len(transform.twiddles)] = transform.twiddles
        slot[b] = one.factors(slots)
        decay[b, : one.grid.alike + 1, : one.grid.plan.slots] = one.decay()
        equation[b, : 2 * points] = one.equations()
        if one.modes.count:
            places, of_modes, around = one.map_places(), one.series(), one.contour()
            equation[b, 2 * points : 2 * points + len(places)] = places
            series[b, : len(of_modes), : of_modes.shape[1]] = of_modes
            contour[b, :, : around.shape[1]] = around
        area[b, :rows, :points] = one.grid.area
        corner[0, b, : rows + 1, :points] = one.grid.corner.real
        corner[1, b, : rows + 1, :points] = one.grid.corner.imag
        vorticity[b, 0, :points] = one.vorticity()
        coefficient[b, :3, 0] = one.grid.coefficients.real
        lines = one.lines()
        line[b, : len(lines), :points] = lines

    def rows_of(length: int = octets, depth: int = deep) -> Any:
        return zeros(Octet, count, depth, length)

    def bending() -> Any:
        return rows_of() if bends else rows_of(1, 1)

    felt = int(size[:, arrays.FELT].max())
    spectra = deep + arrays.WALL_SPECTRA + 2 * (most + 1) + 1
    return Arrays(
        size=array(size),
        number=array(number),
        row=array(row),
        plan=array(plan),
        root=array(root),
        twiddle=octets_of(twiddle),
        slot=octets_of(slot),
        decay=octets_of(decay),
        equation=array(equation),
        vorticity=octet_array(vorticity),
        change=rows_of(),
        content=octet_array(area * vorticity) if bends else bending(),
        area=octet_array(area),
        convection=rows_of(),
        flux_rho=rows_of(),
        flux_phi=rows_of(),
        ahead_rho=rows_of(),
        ahead_phi=rows_of(),
        factor_rho=rows_of(),
        corner_y=octet_array(corner[0]),
        corner_z=octet_array(corner[1]),
        moved_y=bending(),
        moved_z=bending(),
        rate_y=bending(),
        rate_z=bending(),
        line=octet_array(line),
        strip=rows_of(wide, 4),
        spectra=rows_of(2 * flow_slots, spectra),
        work=rows_of(2 * longest, 2),
        response=rows_of(octets, felt),
        felt=rows_of(octets, felt),
        influence=rows_of(2 * octets, wide),
        pivots=zeros(Octet, count, wide),
        contour=octet_array(contour),
        coefficient=array(coefficient),
        series=array(series),
        gust=streams(cases, [gust.PIECES] * count),
    )


def octets_of(values: np.ndarray) -> Any:
    """A Taichi array of octets whose lanes are the last axis."""
    return octet_array(values.reshape(*values.shape[:-2], -1))
