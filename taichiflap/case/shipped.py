"""The bundled cases."""

import difflib
from pathlib import Path

from .case import CaseError

_HERE = Path(__file__).parent.parent
FOLDER = _HERE / "cases" if (_HERE / "cases").is_dir() else _HERE.parent / "cases"
"""Folder of the bundled cases: in the installed package, or beside it in a checkout."""


def names() -> list[str]:
    """Names of the bundled cases."""
    return sorted(file.stem for file in FOLDER.glob("*.toml"))


def text(name: str) -> str:
    """Text of a bundled case file.

    Raises:
        CaseError: if no bundled case has that name.
    """
    if name not in names():
        nearest = difflib.get_close_matches(name, names(), 1)
        hint = f"did you mean {nearest[0]}?" if nearest else f"the bundled cases are {', '.join(names())}"
        raise CaseError(name, [f"no bundled case has this name; {hint}"])
    return (FOLDER / f"{name}.toml").read_text(encoding="utf-8")


def tables(name: str) -> list[Path]:
    """The motion tables of a bundled case, which share its name."""
    return sorted(file for file in FOLDER.glob(f"{name}.*") if file.suffix != ".toml")
