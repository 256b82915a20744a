"""The index from the paper's equations to functions, read from their docstrings; writes `theory/equations.md`."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "theory" / "equations.md"
LAST = 34
"""Number of the paper's last equation."""
OTHERS = ("theory/", "vortex/multipole.py", "published/", "validation/")
"""Modules whose equation numbers are of other papers, or that redo the paper as printed."""
MENTION = re.compile(r"\bEqs?\.? (\d+(?:(?: ?- ?|, | and )\d+)*)")
INTRODUCTION = """# Where is equation N?

For each equation of Reade & Jankauski (2020), the functions and modules that implement it. The list is read from their
docstrings by `docs/equations.py`; a test compares the two.

| equation | where |
|---|---|
"""


def mentions() -> Iterator[tuple[int, str]]:
    """Each equation number that a docstring of the solver names, with the place."""
    package = ROOT / "taichiflap"
    for file in sorted(package.rglob("*.py")):
        name = file.relative_to(package).as_posix()
        if name.startswith(OTHERS):
            continue
        module = name.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
        tree = ast.parse(file.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.Module | ast.FunctionDef | ast.ClassDef):
                place = module if isinstance(node, ast.Module) else f"{module}.{node.name}"
                for text in MENTION.findall(ast.get_docstring(node) or ""):
                    for number in numbers(text):
                        yield number, place


def numbers(text: str) -> Iterator[int]:
    """The equation numbers in words such as "28-31", "29 and 32" or "28, 31"."""
    for part in re.split(r", | and ", text):
        first, _, last = part.partition("-")
        yield from range(int(first), int(last or first) + 1)


def page() -> str:
    """Text of the page."""
    places: dict[int, list[str]] = {}
    for number, place in mentions():
        if place not in places.setdefault(number, []):
            places[number].append(place)
    rows = []
    for number in sorted(places):
        # A function says more than its module; the module stands where no function of it names the equation.
        own = [p for p in places[number] if not any(other.startswith(f"{p}.") for other in places[number])]
        rows.append(f"| {number} | {', '.join(f'`{place}`' for place in own)} |\n")
    return INTRODUCTION + "".join(rows)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
