"""Case files: what each table may say, how a file is read, and what its errors say."""

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
