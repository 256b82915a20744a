"""Series and fields of a result from the march's state: positions, inertial forces, power."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..motion.attack import angle_of_attack
from ..motion.sampling import PITCH, PITCH_RATE, PLUNGE, PLUNGE_RATE, SURGE, SURGE_RATE
from ..motion.stream import in_stream
from ..structure.beam import Modes
from .reference import reference
from .state import ACCEL, AMPLITUDE, AXIAL, COSINE, MOMENT, NORMAL, RATE, SINE, UNSTEADY

Array = NDArray[np.float64]


TOGETHER = 128
"""Frames whose nodes are placed together."""

OWN = ("step", "field_step", "q", "force")
"""Variables that are renamed from the arrays of a block of steps."""


def derive(case: Case, section: Modes, nodes: Array, motion: Array, frames: dict[str, np.ndarray]) -> dict[str, Any]:
    """Variables of the result file for some steps of a case, and for the frames among them.

    Args:
        nodes: positions of the nodes along the chord, from the pivot, m.
        motion: sampled motion at every step, shape (steps + 1, COLUMNS).
        frames: arrays that `March.advance` returned for the case.
    """
    state = frames["q"]
    series = over_time(case, section, motion, frames)
    at = frames["field_step"]
    # The steps of a block follow each other.
    rows = at - (frames["step"][0] if len(at) else 0)
    fields = {
        "q": state[:, AMPLITUDE],
        "q_rate": state[:, RATE],
        "q_acceleration": state[:, ACCEL],
        "field_time": case.step * at,
        "node_position": positions(section.shape(nodes), nodes, motion[at], state[rows, AMPLITUDE]),
    }
    return series | fields | {name: values for name, values in frames.items() if name not in OWN}


def positions(shape: Array, nodes: Array, motion: Array, q: Array) -> NDArray[np.float32]:
    """Where the nodes are along Y and Z, m, shape (frames, nodes, 2).

    Args:
        shape: mode shapes at the nodes, shape (modes, nodes).
        nodes: their positions along the chord, from the pivot, m.
        motion: as a march samples it, shape (frames, COLUMNS).
        q: modal amplitudes, shape (frames, modes).
    """
    placed = np.empty((len(q), len(nodes), 2), np.float32)
    # Some frames at a time stay in the cache, which takes a fifth of the time.
    for first in range(0, len(q), TOGETHER):
        some = slice(first, first + TOGETHER)
        cosine, sine, surge, plunge = (motion[some, column, None] for column in (COSINE, SINE, SURGE, PLUNGE))
        deflection = _superpose(shape, q[some])
        placed[some, :, 0] = surge + (cosine * nodes - sine * deflection)
        placed[some, :, 1] = plunge + (sine * nodes + cosine * deflection)
    return placed


def over_time(case: Case, section: Modes, motion: Array, frames: dict[str, np.ndarray]) -> dict[str, Array]:
    """The variables with one value per step; same arguments as `derive`."""
    state = frames["q"]
    steps = frames["step"]
    # The steps of a block follow each other.
    moved = np.ascontiguousarray(motion[steps[0] : steps[-1] + 1].T if len(steps) else motion[:0].T)
    cosine, sine = moved[COSINE], moved[SINE]
    force = np.ascontiguousarray(frames["force"].T)
    normal, axial, moment = force[NORMAL], force[AXIAL], force[MOMENT]
    force_y = axial * cosine - normal * sine
    vertical_normal = normal * sine
    force_z = axial * sine + normal * cosine
    by_fluid, damped = _elastic_powers(section, state, frames["modal_force"])
    aerodynamic = -(force_z * moved[PLUNGE_RATE] + moment * moved[PITCH_RATE] + force_y * moved[SURGE_RATE])
    inertial = inertial_power(section, moved.T, state)
    streaming = (
        dict(zip(("lift", "thrust"), in_stream(case, force_y, force_z), strict=True)) if case.fluid.streams else {}
    )
    return {
        "time": case.step * frames["step"],
        "plunge": moved[PLUNGE],
        "surge": moved[SURGE],
        "pitch": moved[PITCH],
        "tip_deflection": _weighted(section.shape([case.wing.chord])[:, 0], state[:, AMPLITUDE].T),
        "force_normal": normal,
        "force_axial": axial,
        "force_normal_unsteady": force[UNSTEADY],
        "force_y": force_y,
        "force_z": force_z,
        "force_vertical": -force_y,
        "force_vertical_normal": vertical_normal,
        **streaming,
        "moment": moment,
        "power": aerodynamic + inertial,
        "power_aerodynamic": aerodynamic,
        "power_inertial": inertial,
        "power_net": inertial + by_fluid - damped,
        "energy": mechanical_energy(section, moved.T, state),
        "angle_of_attack": angle_of_attack(case.fluid.velocity, moved.T),
        **_coefficients(case, {"force_vertical": -force_y, **streaming, "power": aerodynamic + inertial}),
    }


def _coefficients(case: Case, series: dict[str, Array]) -> dict[str, Array]:
    """Coefficients of the lift (in hover of the vertical force), drag, thrust and power; none where nothing moves."""
    scale = reference(case)
    if not scale.force:
        return {}
    found = {
        "lift_coefficient": series.get("lift", series["force_vertical"]) / scale.force,
        "power_coefficient": series["power"] / scale.power,
    }
    if "thrust" in series:
        thrust = series["thrust"] / scale.force
        found |= {"drag_coefficient": -thrust, "thrust_coefficient": thrust}
    return found


def _elastic_powers(section: Modes, state: Array, modal_force: Array) -> tuple[Array, Array]:
    """Power (W) of the fluid on the wing's deformation, and power dissipated by structural damping."""
    rates = np.ascontiguousarray(state[:, RATE].T)
    by_fluid = _summed(np.ascontiguousarray(modal_force.T) * rates)
    return by_fluid, _weighted(2.0 * section.damping_ratio * section.omega, rates * rates)


def inertial_power(section: Modes, motion: Array, state: Array) -> Array:
    """Inertial power (W) of the actuator at the pivot.

    The generalised inertia forces of plunge, pitch and surge are Lagrange's, from the kinetic energy of the paper's
    Appendix A (whose T6 lacks its factor thetadot) with surge added, times the rates.

    Args:
        motion: sampled motion, shape (frames, COLUMNS).
        state: modal state, shape (frames, 3, modes).
    """
    _, rate, accel, _, theta_rate, theta_accel, _, surge_rate, surge_accel, cosine, sine = motion.T
    q, q_rate, q_accel = np.ascontiguousarray(state.transpose(1, 2, 0))
    lifted, lifted_rate, lifted_accel = (_weighted(section.lam, row) for row in (q, q_rate, q_accel))
    along = section.mass * accel + section.first_moment * (theta_accel * cosine - theta_rate**2 * sine)
    along += cosine * lifted_accel - 2.0 * theta_rate * sine * lifted_rate
    along -= (theta_accel * sine + theta_rate**2 * cosine) * lifted
    around = (section.second_moment + _summed(q * q)) * theta_accel + 2.0 * theta_rate * _summed(q * q_rate)
    around += accel * (section.first_moment * cosine - sine * lifted) + _weighted(section.psi, q_accel)
    around -= surge_accel * (section.first_moment * sine + cosine * lifted)
    down = section.mass * surge_accel - section.first_moment * (theta_accel * sine + theta_rate**2 * cosine)
    down -= sine * lifted_accel + 2.0 * theta_rate * cosine * lifted_rate
    down -= (theta_accel * cosine - theta_rate**2 * sine) * lifted
    return along * rate + around * theta_rate + down * surge_rate


def mechanical_energy(section: Modes, motion: Array, state: Array) -> Array:
    """Kinetic plus elastic energy (J) of the wing: Eqs 9-10 with the paper's Appendix A, and surge.

    Args:
        motion: sampled motion, shape (frames, COLUMNS).
        state: modal state, shape (frames, 3, modes).
    """
    _, rate, _, _, theta_rate, _, _, surge_rate, _, cosine, sine = motion.T
    q, q_rate = state[:, AMPLITUDE].T, state[:, RATE].T
    kinetic = 0.5 * (section.mass * rate**2 + section.second_moment * theta_rate**2 + _summed(q_rate * q_rate))
    kinetic += 0.5 * theta_rate**2 * _summed(q * q)
    kinetic += section.first_moment * rate * theta_rate * cosine
    kinetic += rate * (cosine * _weighted(section.lam, q_rate) - theta_rate * sine * _weighted(section.lam, q))
    kinetic += theta_rate * _weighted(section.psi, q_rate)
    turned = section.first_moment * sine + cosine * _weighted(section.lam, q)
    kinetic += surge_rate * (
        0.5 * section.mass * surge_rate - theta_rate * turned - sine * _weighted(section.lam, q_rate)
    )
    return kinetic + 0.5 * _weighted(section.omega**2, q * q)


def _weighted(weights: Array, modes: Array) -> Array:
    """`sum_k weights_k modes_k`, added in order, since the rounding of a matrix product depends on the number of
    frames.

    Args:
        modes: values of each mode in each frame, shape (modes, frames).
    """
    if not len(modes):
        return np.zeros(modes.shape[1])
    total = weights[0] * modes[0]
    for weight, values in zip(weights[1:], modes[1:], strict=True):
        total += weight * values
    return total


def _summed(modes: Array) -> Array:
    return _weighted(np.ones(len(modes)), modes)


def _superpose(shape: Array, q: Array) -> Array:
    """`sum_k phi_k(y) q_k`, shape (frames, points), added in order."""
    total = np.zeros((len(q), shape.shape[1]))
    for k, phi in enumerate(shape):
        total += q[:, k, None] * phi
    return total
