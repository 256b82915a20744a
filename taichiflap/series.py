"""From what a march tracks to the series and fields that a result holds: positions, inertial forces, power."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .beam import Modes
from .body import ACCEL, AMPLITUDE, AXIAL, MOMENT, NORMAL, RATE, UNSTEADY
from .case import Case
from .motion import PITCH, PITCH_ACCEL, PITCH_RATE, PLUNGE, PLUNGE_ACCEL, PLUNGE_RATE

Array = NDArray[np.float64]


def derive(case: Case, section: Modes, nodes: Array, motion: Array, frames: dict[str, np.ndarray]) -> dict[str, Any]:
    """Variables of the result file for some frames of a case.

    Args:
        nodes: positions of the nodes along the chord, from the pivot, m.
        motion: sampled motion at every step, shape (steps + 1, 6).
        frames: what `March.advance` returned for the case.
    """
    state = frames["q"]
    moved = motion[frames["step"]]
    theta = moved[:, PITCH]
    cosine, sine = np.cos(theta), np.sin(theta)
    normal, axial = frames["force"][:, NORMAL], frames["force"][:, AXIAL]
    force_y = axial * cosine - normal * sine
    force_z = axial * sine + normal * cosine
    aerodynamic = -(force_z * moved[:, PLUNGE_RATE] + frames["force"][:, MOMENT] * moved[:, PITCH_RATE])
    inertial = inertial_power(section, moved, state)
    deflection = _superpose(section.shape(nodes), state[:, AMPLITUDE])
    derived = {
        "time": case.step * frames["step"],
        "plunge": moved[:, PLUNGE],
        "pitch": theta,
        "q": state[:, AMPLITUDE],
        "q_rate": state[:, RATE],
        "q_acceleration": state[:, ACCEL],
        "modal_force": frames["modal_force"],
        "tip_deflection": _superpose(section.shape([case.wing.chord]), state[:, AMPLITUDE])[:, 0],
        "force_normal": normal,
        "force_axial": axial,
        "force_normal_unsteady": frames["force"][:, UNSTEADY],
        "force_y": force_y,
        "force_z": force_z,
        "force_vertical": -force_y,
        "force_vertical_normal": normal * sine,
        "moment": frames["force"][:, MOMENT],
        "power": aerodynamic + inertial,
        "power_aerodynamic": aerodynamic,
        "power_inertial": inertial,
        "node_position": np.stack(
            (
                cosine[:, None] * nodes - sine[:, None] * deflection,
                moved[:, PLUNGE, None] + sine[:, None] * nodes + cosine[:, None] * deflection,
            ),
            axis=2,
        ),
    }
    fields = {name: values for name, values in frames.items() if name not in ("step", "q", "force")}
    return derived | fields


def inertial_power(section: Modes, motion: Array, state: Array) -> Array:
    """Power (W) that the actuator spends on the wing's own mass, at the pivot.

    The generalised inertia forces of plunge and pitch are Lagrange's, from the kinetic energy of the paper's
    Appendix A (whose T6 lacks its factor thetadot), times the plunge and pitch rates.

    Args:
        motion: shape (frames, 6).
        state: modal state, shape (frames, 3, modes).
    """
    rate, accel = motion[:, PLUNGE_RATE], motion[:, PLUNGE_ACCEL]
    theta_rate, theta_accel = motion[:, PITCH_RATE], motion[:, PITCH_ACCEL]
    cosine, sine = np.cos(motion[:, PITCH]), np.sin(motion[:, PITCH])
    q, q_rate, q_accel = state[:, AMPLITUDE], state[:, RATE], state[:, ACCEL]
    lifted, lifted_rate, lifted_accel = (_weighted(section.lam, row) for row in (q, q_rate, q_accel))
    along = section.mass * accel + section.first_moment * (theta_accel * cosine - theta_rate**2 * sine)
    along += cosine * lifted_accel - 2.0 * theta_rate * sine * lifted_rate
    along -= (theta_accel * sine + theta_rate**2 * cosine) * lifted
    around = (section.second_moment + _summed(q * q)) * theta_accel + 2.0 * theta_rate * _summed(q * q_rate)
    around += accel * (section.first_moment * cosine - sine * lifted) + _weighted(section.psi, q_accel)
    return along * rate + around * theta_rate


def mechanical_energy(section: Modes, motion: Array, state: Array) -> Array:
    """Kinetic plus elastic energy (J) of the wing: Eqs 9-10 with the paper's Appendix A.

    Args:
        motion: shape (frames, 6).
        state: modal state, shape (frames, 3, modes).
    """
    rate, theta_rate = motion[:, PLUNGE_RATE], motion[:, PITCH_RATE]
    cosine, sine = np.cos(motion[:, PITCH]), np.sin(motion[:, PITCH])
    q, q_rate = state[:, AMPLITUDE], state[:, RATE]
    kinetic = 0.5 * (section.mass * rate**2 + section.second_moment * theta_rate**2 + _summed(q_rate * q_rate))
    kinetic += 0.5 * theta_rate**2 * _summed(q * q)
    kinetic += section.first_moment * rate * theta_rate * cosine
    kinetic += rate * (cosine * _weighted(section.lam, q_rate) - theta_rate * sine * _weighted(section.lam, q))
    kinetic += theta_rate * _weighted(section.psi, q_rate)
    return kinetic + 0.5 * _weighted(section.omega**2, q * q)


def _weighted(weights: Array, rows: Array) -> Array:
    """`sum_k weights_k rows_k`, added in order: a matrix product would round by the number of rows."""
    total = np.zeros(len(rows))
    for k, weight in enumerate(weights):
        total += weight * rows[:, k]
    return total


def _summed(rows: Array) -> Array:
    return _weighted(np.ones(rows.shape[1]), rows)


def _superpose(shape: Array, q: Array) -> Array:
    """`sum_k phi_k(y) q_k`, shape (frames, points), added in order."""
    total = np.zeros((len(q), shape.shape[1]))
    for k, phi in enumerate(shape):
        total += q[:, k, None] * phi
    return total
