"""State of the moving elastic section of every case of a batch, and positions and velocities of its points.

Reade & Jankauski (2020), Eqs 1-8. Chordwise axis `e_y = (cos theta, sin theta)` and normal axis
`e_z = (-sin theta, cos theta)` in (Y, Z); a point sits at `(Y, Z) + y e_y + W e_z` with `W = sum_k phi_k q_k`.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..kernels.arrays import Spare, array, zeros
from ..kernels.held import held, length
from ..kernels.runtime import Floats1, Floats2, Floats3, Ints1, Ints2, View, ti, view
from ..motion import sampling
from ..motion.sampling import PLUNGE_ACCEL, PLUNGE_RATE, SURGE_ACCEL, SURGE_RATE
from ..structure import beam
from . import divergence

NORMAL, AXIAL, MOMENT, UNSTEADY = range(4)
"""Columns of `force`: along e_z, along e_y (N), about the pivot (N m), and the part of the normal force due to
acceleration (DBET: added mass; UVLM: d(Gamma)/dt).
"""

C0, C1, C2, BETA = range(4)
"""Coefficients of the backward difference: `x' = C0 x + C1 x_before + C2 x_before_that`, and `BETA = dx / dx'`."""

AMPLITUDE, RATE, ACCEL, BEFORE = range(4)
"""Rows of a modal state, shape (case, row, mode); from BEFORE on amplitude and rate one step earlier."""
ROWS = BEFORE + 2

STEPS, EVERY = range(2)
"""Columns of `plan`: number of steps of a case, and steps between its frames."""

STIFFNESS, DAMPING, LAMBDA, PSI, RUNAWAY = range(5)
"""Rows of the modal constants: omega_k^2, 2 zeta_k omega_k, lambda_k, psi_k, and the amplitude at which a case has
diverged.
"""

COSINE, SINE = SURGE_ACCEL + 1, SURGE_ACCEL + 2
"""Columns that a march adds to the sampled motion: cosine and sine of the pitch angle."""
COLUMNS = SINE + 1

Body = ti.types.argpack(
    modes=Ints1,
    plan=Ints2,  # (case, 2): STEPS, EVERY
    failed=Ints1,  # step at which the case diverged, see taichiflap.march.divergence; else -1
    dt=Floats1,
    motion=Floats3,  # (case, step, COLUMNS), see taichiflap.motion; and cos theta, sin theta
    constant=Floats3,
    q=Floats3,  # (case, ROWS, mode)
    q_free=Floats3,  # amplitude and rate at the next step without acceleration
    q_predicted=Floats3,  # amplitude and rate at the next step, extrapolated to second order
    load=Floats2,  # modal force Q_j without modal acceleration
    response=Floats3,  # d Q_j / d qdd_k
    force=Floats2,
    system=Floats3,
)

GIVEN = ("motion",)
"""Arrays determined by the case alone; they are not part of a march's state."""


def sample_motions(cases: Sequence[Case], spare: Spare) -> tuple[Any, list[NDArray[np.float64]]]:
    """The motion of every case at all its steps, see `COSINE`.

    Returns:
        An array of Taichi, shape (cases, steps + 1, COLUMNS), at rest after a case's last step; and the same of each
        case, shape (COLUMNS, steps + 1), one array for cases with the same motion.
    """
    longest = max(case.steps for case in cases) + 1
    made = spare.take(len(cases), longest, COLUMNS)
    sampled: dict[Any, tuple[Any, NDArray[np.float64]]] = {}
    columns = []
    for moving, case in zip(view(made), cases, strict=True):
        moves, count = case.motion, case.steps + 1
        how = moves.frequency, moves.growth, case.step, count
        # The cases of a study share their motion, if it is not what varies; to copy it takes a tenth of the time.
        known = sampled.get((id(moves), *how))
        if known is not None:
            moving[:] = known[0]
        else:
            axes = [sampling.axis_at_steps(axis, *how) for axis in (moves.plunge, moves.pitch, moves.surge)]
            own = np.concatenate([one.T for one in (*axes, sampling.turned_at_steps(moves.pitch, *how))])
            moving[:count], moving[count:] = own.T, 0.0
            known = sampled[(id(moves), *how)] = moving, own
        columns.append(known[1])
    return made, columns


def allocate(cases: Sequence[Case], sections: Sequence[beam.Modes], motions: Any) -> Any:
    """Arrays of a batch, at rest; `motions` as of `sample_motions`."""
    count = len(cases)
    most = most_modes(sections)
    constant = np.zeros((count, RUNAWAY + 1, most))
    for b, section in enumerate(sections):
        damping = 2.0 * section.damping_ratio * section.omega
        stop = divergence.limits(section)
        constant[b, :, : section.count] = section.omega**2, damping, section.lam, section.psi, stop
    return Body(
        modes=array([section.count for section in sections]),
        plan=array([[case.steps, case.output.every] for case in cases]),
        failed=array([-1] * count),
        dt=array([case.step for case in cases], float),
        motion=motions,
        constant=array(constant),
        q=zeros(ti.f64, count, ROWS, most),
        q_free=zeros(ti.f64, count, 2, most),
        q_predicted=zeros(ti.f64, count, 2, most),
        load=zeros(ti.f64, count, most),
        response=zeros(ti.f64, count, most, most),
        force=zeros(ti.f64, count, 4),
        system=zeros(ti.f64, count, most, most + 1),
    )


def most_modes(sections: Sequence[beam.Modes]) -> int:
    """Maximum number of modes in a batch, at least 1, so that no array is empty."""
    return max(1, *(section.count for section in sections))


def common_modes(sections: Sequence[beam.Modes]) -> int:
    """How many modes every section of a batch has, if that is none or one; -1 otherwise.

    A kernel that knows the number has no loops over modes, and is a quarter faster. Others share one kernel, which
    reads it: every kernel takes a second to compile, once.
    """
    (count, *others) = {section.count for section in sections}
    return count if not others and count <= 1 else -1


@ti.func
def modes_of(body: View, b, known: View):
    """Number of modes of a case: `known` is what `common_modes` says of its batch."""
    count = known
    if ti.static(known < 0):
        count = body.modes[b]
    return count


def held_body(body: Any, known: int) -> Any:
    """The group `Body` within a kernel, its shapes in local variables; call it inside `ti.static`.

    Args:
        known: what `common_modes` says of the batch.
    """
    most = 1 if known >= 0 else length(body["q"], 2)
    return held(
        body,
        motion=(length(body["motion"], 1), COLUMNS),
        constant=(RUNAWAY + 1, most),
        q=(ROWS, most),
        q_free=(2, most),
        q_predicted=(2, most),
        load=(most,),
        response=(most, most),
        force=(4,),
        system=(most, most + 1),
    )


@ti.func
def superpose(shape: View, state: View, b, row, point, count):
    """`sum_k phi_k(point) q_k` of a row of a modal state: deflection W (Eq. 8), its rate or acceleration."""
    total = 0.0
    for k in range(count):
        total += shape[b, k, point] * state[b, row, k]
    return total


@ti.func
def pivot_velocity(body: View, stream: View, b, n):
    """Velocity of the pivot relative to the free stream, along e_y and e_z (Eq. 6 with y = W = 0, and surge)."""
    cosine = body.motion[b, n, COSINE]
    sine = body.motion[b, n, SINE]
    along_y = body.motion[b, n, SURGE_RATE] - stream[b, 0]
    along_z = body.motion[b, n, PLUNGE_RATE] - stream[b, 1]
    return along_z * sine + along_y * cosine, along_z * cosine - along_y * sine


@ti.func
def pivot_heave(body: View, b, n):
    """Acceleration of the pivot along e_z (Eq. 7 with y = W = 0, and surge)."""
    across = body.motion[b, n, PLUNGE_ACCEL] * body.motion[b, n, COSINE]
    return across - body.motion[b, n, SURGE_ACCEL] * body.motion[b, n, SINE]


@ti.func
def pivot_advance(body: View, b, n):
    """Acceleration of the pivot along e_y."""
    along = body.motion[b, n, PLUNGE_ACCEL] * body.motion[b, n, SINE]
    return along + body.motion[b, n, SURGE_ACCEL] * body.motion[b, n, COSINE]
