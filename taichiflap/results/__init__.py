"""The result file: written so that no crash can damage it, and read."""

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
