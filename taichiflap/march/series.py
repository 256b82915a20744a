"""The variables of cases with one value per step: forces in both frames, power, energy.

They are derived from the march's state when they are first read. A study reads few of them, a result file all.
"""

import functools
from collections.abc import Iterable, Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..motion.attack import angle_of_attack
from ..motion.sampling import PITCH, PITCH_RATE, PLUNGE, PLUNGE_RATE, SURGE, SURGE_RATE
from ..motion.stream import in_stream
from ..structure.beam import Modes
from .reference import Reference, reference
from .state import AMPLITUDE, AXIAL, COSINE, MOMENT, NORMAL, RATE, SINE, UNSTEADY

Array = NDArray[np.float64]

ALWAYS = (
    "time", "plunge", "surge", "pitch", "tip_deflection", "force_normal", "force_axial", "force_normal_unsteady",
    "force_y", "force_z", "force_vertical", "force_vertical_normal", "moment", "power", "power_aerodynamic",
    "power_inertial", "power_net", "energy", "angle_of_attack",
)  # fmt: skip
STREAMING = "lift", "thrust"
"""Variables in a free stream."""
COEFFICIENTS, OF_STREAM = ("lift_coefficient", "power_coefficient"), ("drag_coefficient", "thrust_coefficient")
"""Variables where something moves, and in a free stream."""
CONSTANTS = ("omega", "damping_ratio", "lam", "psi", "mass", "first_moment", "second_moment")
"""Numbers of a section in the equations."""


class Series:
    """Variables of cases over the same steps, each an attribute of shape (cases, steps).

    `taichiflap.results.variables` describes them, with their units and signs.

    Args:
        cases: either all in a free stream or none, and likewise with something that moves; all of as many modes.
        sections: their modes.
        moved: columns of the motion, see `taichiflap.march.state`, shape (COLUMNS, cases, steps), or (COLUMNS, 1,
            steps) if the cases share it.
        steps: numbers of the steps, which follow each other.
        state: amplitudes, rates and accelerations of the modes, shape (3, modes, cases, steps).
        modal_force: shape (modes, cases, steps).
        loads: columns of the force, see `taichiflap.march.state`, shape (4, cases, steps).
        scales: the reference values of the cases, if they are known.
    """

    def __init__(
        self, cases: Sequence[Case], sections: Sequence[Modes], moved: Array, steps: NDArray[np.int64], state: Array,
        modal_force: Array, loads: Array, scales: Sequence[Reference] | None = None,
    ) -> None:  # fmt: skip
        self.cases, self.sections = cases, sections
        self.scales = [reference(case) for case in cases] if scales is None else scales
        self.moved, self.state, self.loads = moved, state, loads
        self._steps, self._modal_force = steps, modal_force

    @classmethod
    def of(cls, case: Case, section: Modes, motion: Array, frames: Mapping[str, Any]) -> "Series":
        """The variables of one case over a block of steps.

        Args:
            motion: sampled motion at every step, shape (steps + 1, COLUMNS).
            frames: arrays that `March.advance` returned for the case.
        """
        steps = frames["step"]
        # A copy, whatever becomes of the march.
        moved = np.array((motion[steps[0] : steps[-1] + 1] if len(steps) else motion[:0]).T, order="C")[:, None]
        state = (np.moveaxis(frames[name], 0, -1)[..., None, :] for name in ("q", "modal_force", "force"))
        return cls([case], [section], moved, steps, *state)

    @property
    def variables(self) -> list[str]:
        """Names of the variables."""
        streams = self.cases[0].fluid.streams
        found = [*ALWAYS, *(STREAMING if streams else ())]
        if self.scales[0].force:
            found += [*COEFFICIENTS, *(OF_STREAM if streams else ())]
        return found

    def alone(self, name: str) -> Array:
        """A variable of the first case, shape (steps,)."""
        values: Array = getattr(self, name)
        return values[0]

    def at(self, places: Sequence[int]) -> "Series":
        """The variables at some of the steps."""
        moved, state, modal_force, loads = (
            values[..., places] for values in (self.moved, self.state, self._modal_force, self.loads)
        )
        return Series(self.cases, self.sections, moved, self._steps[places], state, modal_force, loads, self.scales)

    @functools.cached_property
    def section(self) -> Any:
        """Numbers of all sections: of shape (cases, 1), or of every mode, (modes, cases, 1)."""
        return SimpleNamespace(**{name: _stacked(getattr(one, name) for one in self.sections) for name in CONSTANTS})

    @functools.cached_property
    def time(self) -> Array:
        return self._of_each(_stacked(case.step for case in self.cases) * self._steps)

    @property
    def plunge(self) -> Array:
        return self._of_each(self.moved[PLUNGE])

    @property
    def surge(self) -> Array:
        return self._of_each(self.moved[SURGE])

    @property
    def pitch(self) -> Array:
        return self._of_each(self.moved[PITCH])

    def _of_each(self, values: Array) -> Array:
        """What cases may have in common, shape (cases, steps)."""
        return np.broadcast_to(values, (len(self.cases), values.shape[-1]))

    @functools.cached_property
    def tip_deflection(self) -> Array:
        return weighted(_stacked(one.tip for one in self.sections), self.state[AMPLITUDE])

    @property
    def force_normal(self) -> Array:
        return self.loads[NORMAL]

    @property
    def force_axial(self) -> Array:
        return self.loads[AXIAL]

    @property
    def force_normal_unsteady(self) -> Array:
        return self.loads[UNSTEADY]

    @property
    def moment(self) -> Array:
        return self.loads[MOMENT]

    @functools.cached_property
    def force_y(self) -> Array:
        return self.force_axial * self.moved[COSINE] - self.force_vertical_normal

    @functools.cached_property
    def force_z(self) -> Array:
        return self.force_axial * self.moved[SINE] + self.force_normal * self.moved[COSINE]

    @functools.cached_property
    def force_vertical(self) -> Array:
        return -self.force_y

    @functools.cached_property
    def force_vertical_normal(self) -> Array:
        return self.force_normal * self.moved[SINE]

    @functools.cached_property
    def _in_stream(self) -> tuple[Array, Array]:
        each = zip(self.cases, self.force_y, self.force_z, strict=True)
        lift, thrust = zip(*(in_stream(case, y, z) for case, y, z in each), strict=True)
        return np.array(lift), np.array(thrust)

    @property
    def lift(self) -> Array:
        return self._in_stream[0]

    @property
    def thrust(self) -> Array:
        return self._in_stream[1]

    @functools.cached_property
    def power_aerodynamic(self) -> Array:
        moved = self.moved
        along = self.force_z * -moved[PLUNGE_RATE] - self.moment * moved[PITCH_RATE]
        if moved[SURGE_RATE].any():
            along -= self.force_y * moved[SURGE_RATE]
        return along

    @functools.cached_property
    def power_inertial(self) -> Array:
        return self._of_each(inertial_power(self.section, self.moved, self.state))

    @functools.cached_property
    def power(self) -> Array:
        return self.power_aerodynamic + self.power_inertial

    @functools.cached_property
    def power_net(self) -> Array:
        """Inertial power and the fluid's power on the deformation, less what damping dissipates."""
        damping = 2.0 * self.section.damping_ratio * self.section.omega
        power = self.power_inertial
        for loss, force, rate in zip(damping, self._modal_force, self.state[RATE], strict=True):
            of_mode = force - loss * rate
            of_mode *= rate
            power = power + of_mode
        return power

    @functools.cached_property
    def energy(self) -> Array:
        return self._of_each(mechanical_energy(self.section, self.moved, self.state))

    @functools.cached_property
    def angle_of_attack(self) -> Array:
        moved = np.moveaxis(self.moved, 0, -1)
        each = zip(self.cases, np.broadcast_to(moved, (len(self.cases), *moved.shape[1:])), strict=True)
        return np.array([angle_of_attack(case.fluid.velocity, moved) for case, moved in each])

    @functools.cached_property
    def _reference_force(self) -> Array:
        return _stacked(scale.force for scale in self.scales)

    @functools.cached_property
    def lift_coefficient(self) -> Array:
        """Of the lift, in hover of the vertical force."""
        return (self.lift if self.cases[0].fluid.streams else self.force_vertical) / self._reference_force

    @functools.cached_property
    def power_coefficient(self) -> Array:
        return self.power / _stacked(scale.power for scale in self.scales)

    @functools.cached_property
    def thrust_coefficient(self) -> Array:
        return self.thrust / self._reference_force

    @functools.cached_property
    def drag_coefficient(self) -> Array:
        return -self.thrust_coefficient


def _stacked(values: Iterable[Any]) -> Array:
    """A number of each case, shape (cases, 1), or one of every mode, (modes, cases, 1); of one if all are equal."""
    found = np.array([*values])
    return (found[:1] if (found == found[0]).all() else found).T[..., None]


def inertial_power(section: Any, motion: Array, state: Array) -> Array:
    """Inertial power (W) of the actuator at the pivot, shape (...).

    The generalised inertia forces of plunge, pitch and surge are Lagrange's, from the kinetic energy of the paper's
    Appendix A (whose T6 lacks its factor thetadot) with surge added, times the rates. They are written in the wing's
    axes, and what cases have in common is computed once.

    Args:
        section: the modes, see `Series.section`.
        motion: columns of the sampled motion, shape (COLUMNS, ...).
        state: modal state, shape (3, modes, ...).
    """
    _, rate, accel, _, theta_rate, theta_accel, _, surge_rate, surge_accel, cosine, sine = motion
    across, along = cosine * rate - sine * surge_rate, sine * rate + cosine * surge_rate
    across_accel, along_accel = cosine * accel - sine * surge_accel, sine * accel + cosine * surge_accel
    turning, spinning = 2.0 * theta_rate**2, theta_rate * theta_accel
    turned = theta_accel * across - theta_rate**2 * along + theta_rate * across_accel
    bent = theta_accel * along + theta_rate**2 * across + theta_rate * along_accel
    power = section.mass * (rate * accel + surge_rate * surge_accel)
    power = power + section.first_moment * turned + section.second_moment * spinning
    for lam, psi, q, q_rate, q_accel in zip(section.lam, section.psi, *state, strict=True):
        of_mode = q * spinning
        of_mode += q_rate * turning
        of_mode -= lam * bent
        of_mode *= q
        of_mode += q_accel * (lam * across + psi * theta_rate)
        of_mode -= q_rate * (lam * (2.0 * theta_rate * along))
        power = power + of_mode
    return power


def mechanical_energy(section: Any, motion: Array, state: Array) -> Array:
    """Kinetic plus elastic energy (J) of the wing: Eqs 9-10 with the paper's Appendix A, and surge.

    Arguments as of `inertial_power`.
    """
    _, rate, _, _, theta_rate, _, _, surge_rate, _, cosine, sine = motion
    across, along = cosine * rate - sine * surge_rate, sine * rate + cosine * surge_rate
    energy = 0.5 * (section.mass * (rate**2 + surge_rate**2) + section.second_moment * theta_rate**2)
    energy = energy + section.first_moment * (theta_rate * across)
    for lam, psi, omega, q, q_rate in zip(section.lam, section.psi, section.omega, *state[:2], strict=True):
        energy = energy + 0.5 * (q_rate**2 + q**2 * (omega**2 + theta_rate**2))
        energy += q_rate * (lam * across + psi * theta_rate) - q * (lam * theta_rate * along)
    return energy


def weighted(weights: Array, modes: Array) -> Array:
    """`sum_k weights_k modes_k`, added in order, since the rounding of a matrix product depends on the number of
    steps.

    Args:
        modes: values of each mode, shape (modes, ...).
    """
    if not len(modes):
        return np.zeros(modes.shape[1:])
    total = weights[0] * modes[0]
    for weight, values in zip(weights[1:], modes[1:], strict=True):
        total += weight * values
    return total
