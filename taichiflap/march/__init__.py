"""Time integration of modes and fluid, strongly coupled."""

from ..doors import lazy

__getattr__ = lazy(
    __name__,
    {
        "March": "march",
        "differencing": "march",
    },
)
