"""Summary of a run: means over its settled beats and their spread, harmonics and phase, peaks, power."""

from dataclasses import dataclass
from typing import Annotated, Any

from ..motion.stream import in_stream
from ..results.reader import Result
from .beats import Beats
from .columns import columns
from .reduced import MEANS, WAVING, Alone
from .statistic import Statistic, Statistics

__all__ = "MEANS", "WAVING", "Alone", "Statistic", "Summary", "in_stream", "summarise"


@dataclass(frozen=True)
class Summary:
    """Settled behaviour of a run. Each attribute is annotated with its units; times are fractions of the period.

    For a non-periodic motion the whole run counts as one beat.

    Attributes:
        beats: number of settled beats, the last of the run, over which statistics are taken.
        settled: whether drift and spread of the mean force over these beats are below 1 % of the root-mean-square
            force. None for a non-periodic motion.
        force_drift: change of the mean force over these beats by a linear fit, relative to the root-mean-square force.
        force_spread: standard deviation of the mean force of these beats, relative to the root-mean-square force.
        force_vertical, force_vertical_normal: mean vertical force, full vector and e_z component alone.
        force_normal, force_axial, force_y, force_z, moment, tip_deflection: means of these variables.
        lift, thrust: mean force normal to the free stream, 90 degrees counter-clockwise from it (along Z for a stream
            along Y), and against it; None without a stream.
        reference_speed, reference_area: what coefficients are made with, see `march.reference`.
        lift_coefficient: lift, or vertical force in hover, over `rho U^2 S / 2`. None if the reference speed or the
            density is zero.
        drag_coefficient, thrust_coefficient: from the force along and against the stream; None without a stream.
        power_coefficient: mean power over `rho U^3 S / 2`.
        propulsive_efficiency: thrust times stream speed over power; None without a stream or if the power is not
            positive.
        lift_over_weight: vertical force of all wings over the weight that they carry; None without `body.mass`.
        reynolds, reduced_frequency, pivot_speed, wing_tip_speed, angle_of_attack_mean, angle_of_attack_rms: see
            `metrics.similarity`.
        strouhal: frequency times the extent of the bent wing's trailing edge across the stream over the stream's speed;
            None without a stream, or where nothing repeats.
        force_normal_peak: largest magnitude of the normal force.
        force_normal_phase: phase lead of its first harmonic over that of the plunge (of the pitch, without plunge),
            degrees in (-180, 180]; None without plunge and pitch, or without a force.
        tip_peak: largest magnitude of the tip deflection.
        tip_peak_time: time of the tip peak, as t/T within the beat.
        tip_peak_after_reversal: the same, from the last stroke reversal; None without plunge.
        power, power_aerodynamic, power_inertial: mean mechanical power of the actuator, and its parts.
        power_positive: mean of the positive part of the power: the power of an actuator without energy storage.
        wake_lost: mean velocity at the wing lost by dropping or absorbing vortices (`wake_lost` of the result),
            relative to the wing's root-mean-square speed: an estimate of the relative error of the forces. None for a
            model without a wake.
        wake_far_error: largest measured error of a wake vortex's velocity by multipoles, m/s; None with direct sums.
        wake_crossings: number of wake-wing crossings in the whole run; None without a wake.
        force_coefficient_peak: largest normal force without the part due to acceleration, over `rho V^2 S / 2`, with
            the root-mean-square speed V of all points of the bent wing through the fluid. Typical values are of order
            one. None if V is zero.
        energy_residual: difference between the work done on the wing and the change of its energy, relative to the
            actuator's gross work (or the gross work on the wing, if larger).
        harmonics: complex amplitudes of the first harmonics of some variables, see `harmonics`; empty for a
            non-periodic motion.
    """

    beats: Annotated[int, "1"]
    settled: Annotated[bool | None, "1"]
    force_drift: Annotated[float, "1"]
    force_spread: Annotated[float, "1"]
    force_vertical: Annotated[Statistic, "N"]
    force_vertical_normal: Annotated[Statistic, "N"]
    force_normal: Annotated[Statistic, "N"]
    force_axial: Annotated[Statistic, "N"]
    force_y: Annotated[Statistic, "N"]
    force_z: Annotated[Statistic, "N"]
    lift: Annotated[Statistic | None, "N"]
    thrust: Annotated[Statistic | None, "N"]
    reference_speed: Annotated[float, "m s-1"]
    reference_area: Annotated[float, "m2"]
    lift_coefficient: Annotated[Statistic | None, "1"]
    drag_coefficient: Annotated[Statistic | None, "1"]
    thrust_coefficient: Annotated[Statistic | None, "1"]
    power_coefficient: Annotated[Statistic | None, "1"]
    propulsive_efficiency: Annotated[float | None, "1"]
    lift_over_weight: Annotated[float | None, "1"]
    reynolds: Annotated[float | None, "1"]
    reduced_frequency: Annotated[float | None, "1"]
    strouhal: Annotated[float | None, "1"]
    pivot_speed: Annotated[float, "m s-1"]
    wing_tip_speed: Annotated[float | None, "m s-1"]
    angle_of_attack_mean: Annotated[float | None, "degree"]
    angle_of_attack_rms: Annotated[float | None, "degree"]
    force_normal_peak: Annotated[Statistic, "N"]
    force_normal_phase: Annotated[float | None, "degree"]
    moment: Annotated[Statistic, "N m"]
    tip_deflection: Annotated[Statistic, "m"]
    tip_peak: Annotated[Statistic, "m"]
    tip_peak_time: Annotated[float, "1"]
    tip_peak_after_reversal: Annotated[float | None, "1"]
    power: Annotated[Statistic, "W"]
    power_aerodynamic: Annotated[Statistic, "W"]
    power_inertial: Annotated[Statistic, "W"]
    power_positive: Annotated[Statistic, "W"]
    force_coefficient_peak: Annotated[float | None, "1"]
    energy_residual: Annotated[float | None, "1"]
    wake_lost: Annotated[float | None, "1"]
    wake_far_error: Annotated[float | None, "m s-1"]
    wake_crossings: Annotated[int | None, "1"]
    harmonics: dict[str, list[complex]]


def summarise(result: Result, beats: Beats | None = None) -> Summary | None:
    """Summary of a run; None without a whole beat.

    Args:
        beats: beats to summarise; the settled beats if None.
    """
    ((_, found),) = columns([Alone(result)], beats)
    return Summary(**{name: _first(column) for name, column in found.items()}) if found else None


def _first(column: Any) -> Any:
    """What a column holds of its first run."""
    if isinstance(column, Statistics):
        return column.of(0)
    if isinstance(column, dict):
        return {name: waves[0] for name, waves in column.items()}
    return None if column is None else column[0]
