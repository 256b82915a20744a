"""The arrays of the Navier-Stokes model for a batch, and the meaning of their rows and columns."""

from ...kernels.runtime import Floats2, Floats3, Floats4, Ints2, Ints3, Octets2, Octets3, Octets4, ti

ROWS, OCTETS, NEAR, FELT, BASE, TERMS, SERIES, STORED, ALIKE = range(9)
UNMAPPED = 9
"""Entries of `size`: rows of cells, octets of a row, rows of implicit convection, rows that feel the wall's flux, first
spectrum behind those of A, coefficients of the map and of a mode's series, coefficients that are stored, first of the
rows that are of one thickness; and the step at which the map of a bent section did not converge, or zero."""

NU, DPHI, SCALE, LENGTH, LOAD, MOMENT_LOAD, HALF_THICKNESS, STREAM_Y, STREAM_Z, PASCAL = range(10)
RUBBED_Y, RUBBED_Z, COURANT, NUMBERS = range(10, 14)
"""Entries of `number`: viscosity (chords^2/s), angle of a cell, 1/points, chord (m), force (N) and moment (N m) per
unit of the flow's (lengths in chords, density one), half of the thickness (chords), the free stream (m/s), pressure
(Pa) per unit of the flow's; and found on the way: friction's forces (N), the largest Courant number."""

(
    THICKNESS,
    UPPER_FACE,
    LOWER_FACE,
    INVERSE,
    SHARE_FACE,
    SHARE_ROW,
    SHARE_UPPER,
    GROWN,
    DECAYED,
    HIGHER_FACE,
    HIGHER_ROW,
    COLUMNS,
) = range(12)
"""Columns of `row`: drho, diffusion through the upper and lower face over viscosity, 1/(drho dphi), implicit share at
the lower face, in the row and at the upper face, e^rho and e^-rho at the lower face, share of the higher order there
and in the row."""

SOURCE, CARRY, STREAM_LINES, LOWER, WALL_Y, WALL_Z, SLOPE_Y, SLOPE_Z, TANGENT = 0, 2, 3, 7, 9, 10, 11, 12, 13
WALL_STREAM, ACCELERATION, FLUX, STEP, CORNER_COS, CORNER_SIN, CENTRE_COS, CENTRE_SIN = range(14, 22)
GRADIENT, FRICTION, EQUATION, OF_MEAN, LINES = range(22, 27)
"""Lines of `line`, one value an angle: scratch up to LOWER + 1; the wall's position F and slope G at the cells'
centres; over the number of points, Im(V conj G) of its velocity and its streamfunction; Im(a conj G) of its
acceleration; g, the wall's flux of circulation, and its change in the step; cosines and sines; pressure gradient
-dp/dphi and friction, over density; right-hand sides; the change of g with its mean."""

SHAPE, INTEGRAL, RESPONSE, MODAL, MODAL_STREAM, MODAL_LINES = range(6)
"""Lines of a mode, from LINES on: phi_k and its integral from the leading edge, the change of g with its rate, and as
TANGENT and WALL_STREAM."""

STREAMS, SOURCES, WALL_SPECTRA = 0, 4, 6
"""Spectra behind those of A: of the streamfunction at four faces, of two rows' content, and of pairs of wall lines."""

WAVE, INVERSE_K, IS_ZERO, HALF, HILBERT, SMOOTH, FACTORS = 0, 1, 2, 3, 5, 7, 9
"""Rows of `slot`: |k|, 1/|k| or zero, one where k = 0, and complex factors, two rows each: a shift by half a cell;
and of the map's points, the conjugate function and a low-pass filter, with 1/points."""

Arrays = ti.types.argpack(
    size=Ints2,
    number=Floats2,
    row=Floats3,
    plan=Ints3,
    root=Floats4,
    twiddle=Octets4,
    slot=Octets3,
    decay=Octets3,  # e^(-k drho) of the rows that differ
    equation=Ints2,  # where the right-hand sides of the influence matrix stand in a spectrum
    vorticity=Octets3,
    change=Octets3,  # of J w in the last step
    content=Octets3,  # J w, of bending sections
    area=Octets3,  # J
    convection=Octets3,  # explicit, of the last step
    flux_rho=Octets3,
    flux_phi=Octets3,
    ahead_rho=Octets3,  # extrapolated to the coming step
    ahead_phi=Octets3,
    factor_rho=Octets3,
    corner_y=Octets3,
    corner_z=Octets3,
    moved_y=Octets3,  # since the last step
    moved_z=Octets3,
    rate_y=Octets3,
    rate_z=Octets3,
    line=Octets3,
    strip=Octets3,
    spectra=Octets3,
    work=Octets3,
    response=Octets3,  # of vorticity to the wall's flux
    felt=Octets3,
    influence=Octets3,  # matrix of the slip by the wall's flux; behind it its inverse
    pivots=Octets2,
    contour=Octets3,
    coefficient=Floats3,
    series=Floats3,
    gust=Floats2,  # see taichiflap.march.stream
)

CELLS = (
    "vorticity", "change", "content", "area", "convection", "flux_rho", "flux_phi", "ahead_rho", "ahead_phi",
    "factor_rho", "corner_y", "corner_z", "moved_y", "moved_z", "rate_y", "rate_z",
)  # fmt: skip
"""Arrays of one number a cell. They have one shape; those that only bending sections need are empty without one."""
HELD = CELLS, ("line",), ("strip",)
"""Arrays whose shapes a kernel reads once, see `taichiflap.kernels.held`. To hold those of the transforms as well takes
another 4 % from a step, but a third more time to compile."""
