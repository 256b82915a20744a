"""Prescribed motion: plunge, pitch and surge with exact time derivatives."""

from ..doors import lazy

__getattr__ = lazy(
    __name__,
    {
        "reversals": "sampling",
        "sample": "sampling",
        "sample_axis": "sampling",
        "typical_speed": "sampling",
    },
)
