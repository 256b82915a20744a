"""The result file: crash-safe writing, and reading."""

from ..doors import lazy

__getattr__ = lazy(
    __name__,
    {
        "Result": "reader",
        "ResultError": "reader",
        "first_line": "reader",
        "open_result": "reader",
        "part": "reader",
    },
)
