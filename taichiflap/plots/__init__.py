"""Figures. Matplotlib is imported only when a figure is drawn."""

from ..doors import lazy

__getattr__ = lazy(
    __name__,
    {
        "plot": "result",
    },
)
