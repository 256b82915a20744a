"""The map file: many cases of a study and their metrics."""

from ..doors import lazy

__getattr__ = lazy(
    __name__,
    {
        "Map": "file",
        "MapError": "file",
        "is_map": "file",
        "open_map": "file",
    },
)
