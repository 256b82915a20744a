"""Export of results: tables, VTKHDF, an offline page with a player, films."""

from ..doors import lazy

__getattr__ = lazy(
    __name__,
    {
        "FORMATS": "formats",
        "export": "formats",
    },
)
