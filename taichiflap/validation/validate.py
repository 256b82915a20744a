"""All reference solutions in the order of the report, and the printed table."""

from collections.abc import Callable, Iterator, Sequence

from . import elastic, gust, orders, oscillation, separated, start, steady, structure, viscous
from .checks import Check, Row

Study = Callable[[], Sequence[Check]]

STUDIES: tuple[tuple[str, Study], ...] = (
    ("steady lift", lambda: [steady.steady()]),
    ("camber", lambda: [steady.camber()]),
    ("Wagner", lambda: [start.wagner()]),
    ("Theodorsen and Garrick", oscillation.oscillation),
    ("gusts", gust.gusts),
    ("added mass", lambda: [steady.added_mass()]),
    ("modes", lambda: [structure.modes()]),
    ("wet frequency", lambda: [structure.wet_frequency()]),
    ("elastic plate", lambda: [elastic.elastic_plate()]),
    ("flutter", lambda: [elastic.flutter()]),
    ("vortices", lambda: [structure.vortices()]),
    ("energy", lambda: [structure.energy()]),
    ("convergence", lambda: [orders.convergence()]),
    ("viscous flow", viscous.checks),
    ("separated flow", lambda: [separated.separated()]),
)
"""Studies by their name in progress lines."""

HEADINGS = ("Setting", "Measured", "Reference", "Error", "Tolerance", "Verdict")


def validate(
    studies: Sequence[tuple[str, Study]] | None = None, progress: Callable[[str], None] | None = None
) -> Iterator[Check]:
    """Run the studies one after another.

    Args:
        studies: names and functions, all of them by default.
        progress: callback of a line such as `3 of 10: Wagner` before each study.
    """
    chosen = STUDIES if studies is None else studies
    for number, (name, study) in enumerate(chosen, 1):
        if progress:
            progress(f"{number} of {len(chosen)}: {name}")
        yield from study()


def table(check: Check) -> list[str]:
    """The rows of a check as lines of text, below its reference."""
    cells = [HEADINGS, *(tuple(row_cells(row)) for row in check.rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = ["  ".join(_aligned(line, widths)).rstrip() for line in cells]
    return [check.reference, *(f"  {line}" for line in lines), ""]


def _aligned(cells: Sequence[str], widths: Sequence[int]) -> Iterator[str]:
    """Align the setting and the verdict to the left, numbers to the right."""
    for number, (cell, width) in enumerate(zip(cells, widths, strict=True)):
        yield cell.ljust(width) if number in (0, len(cells) - 1) else cell.rjust(width)


def row_cells(row: Row) -> list[str]:
    """Setting, both values, error with its unit, tolerance and verdict of a row, as text."""
    error = f"{row.error:.2g}" if abs(row.error) < 0.01 else f"{row.error:.2f}"
    return [
        row.setting,
        f"{row.measured:.6g}",
        f"{row.expected:.6g}",
        f"{error} {row.unit}".strip(),
        f"{row.tolerance:g}",
        "pass" if row.passed else "FAIL",
    ]


def verdict(checks: Sequence[Check]) -> str:
    """Number of rows that passed, as a sentence."""
    rows = [row for check in checks for row in check.rows]
    failed = sum(not row.passed for row in rows)
    return f"{len(rows) - failed} of {len(rows)} rows pass" + (f", {failed} fail" if failed else "")
