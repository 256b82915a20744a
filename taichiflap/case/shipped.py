"""The cases that come with the package."""

import difflib
from pathlib import Path

from .case import CaseError

_HERE = Path(__file__).parent.parent
FOLDER = _HERE / "cases" if (_HERE / "cases").is_dir() else _HERE.parent / "cases"
"""Where they are: in the installed package, or beside it in a checkout."""


def names() -> list[str]:
    """Names of the cases."""
    return sorted(file.stem for file in FOLDER.glob("*.toml"))


def text(name: str) -> str:
    """Text of a case file by its name.

    Raises:
        CaseError: when there is none of that name.
    """
    if name not in names():
        nearest = difflib.get_close_matches(name, names(), 1)
        hint = f"did you mean {nearest[0]}?" if nearest else f"there are {', '.join(names())}"
        raise CaseError(name, [f"no case of that name comes with taichiflap; {hint}"])
    return (FOLDER / f"{name}.toml").read_text(encoding="utf-8")


def tables(name: str) -> list[Path]:
    """The files of points that a case needs beside it: those of its name."""
    return sorted(file for file in FOLDER.glob(f"{name}.*") if file.suffix != ".toml")
