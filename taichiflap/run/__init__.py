"""One run: cases are marched in blocks and written, with warnings before and after."""

from ..doors import lazy

__getattr__ = lazy(
    __name__,
    {
        "Progress": "blocks",
        "simulate": "blocks",
    },
)
