"""Exact solutions with which the models are compared. Each cites its source; none shares code with the models.

A plate of chord c in a stream U. Lengths are in chords, frequencies are `k = omega c / (2 U)`, lift and thrust are over
`rho U^2 c / 2` and moments over `rho U^2 c^2 / 2`, all per unit span. Harmonic quantities are complex amplitudes of
`exp(i omega t)`.
"""

from .classical import (
    added_mass,
    cantilever_frequencies,
    cantilever_roots,
    cantilever_shape,
    mean_power,
    mean_thrust,
    oscillating_loads,
    pair_rotation,
    pair_speed,
    parabolic_camber_lift,
    plate_load_ahead,
    plate_normal_force,
    polygon_rotation,
    theodorsen,
    wagner,
    wet_frequencies,
)
from .gusts import kuessner, sears
from .plate import ElasticPlate, flutter_onset

__all__ = [
    "ElasticPlate",
    "added_mass",
    "cantilever_frequencies",
    "cantilever_roots",
    "cantilever_shape",
    "flutter_onset",
    "kuessner",
    "mean_power",
    "mean_thrust",
    "oscillating_loads",
    "pair_rotation",
    "pair_speed",
    "parabolic_camber_lift",
    "plate_load_ahead",
    "plate_normal_force",
    "polygon_rotation",
    "sears",
    "theodorsen",
    "wagner",
    "wet_frequencies",
]
