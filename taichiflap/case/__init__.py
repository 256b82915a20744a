"""Case files: the keys of each table, reading and checking a file, and the error messages."""

from ..doors import lazy

__getattr__ = lazy(
    __name__,
    {
        "Case": "case",
        "CaseError": "case",
        "apply_settings": "case",
        "case_schema": "case",
        "load_case": "case",
        "parse_case": "case",
        "read_value": "case",
    },
)
