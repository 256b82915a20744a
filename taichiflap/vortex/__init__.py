"""Velocities induced by point vortices: the direct sum of 1/r, and its multipole expansion."""

from ..doors import lazy

__getattr__ = lazy(
    __name__,
    {
        "induce": "sum",
        "induced_velocity": "sum",
    },
)
