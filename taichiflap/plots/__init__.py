"""Figures. Nothing here is imported before a figure is asked for: matplotlib is heavy."""

from ..doors import lazy

__getattr__ = lazy(
    __name__,
    {
        "plot": "result",
    },
)
