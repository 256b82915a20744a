"""Metrics of a result: means, peaks, harmonics, and those that studies compare."""

from ..doors import lazy

__getattr__ = lazy(
    __name__,
    {
        "Statistic": "statistic",
        "Summary": "summary",
        "after_reversal": "waves",
        "harmonic": "waves",
        "harmonics": "waves",
        "in_stream": "summary",
        "reversals": "waves",
        "summarise": "summary",
    },
)
