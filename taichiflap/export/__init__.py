"""Results in other formats: tables, VTKHDF, a page that plays offline, films."""

from ..doors import lazy

__getattr__ = lazy(
    __name__,
    {
        "FORMATS": "formats",
        "export": "formats",
    },
)
