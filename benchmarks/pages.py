"""The pages of the documentation that hold the figures."""

from collections.abc import Iterable, Mapping

from taichiflap.pages import Block, Figure, Heading, Paragraph, Table

from .accuracy import CYCLES, HALF_SPAN_PANELS, SECTION, Point
from .rows import Row

RATIOS = ("x", "%")
"""Units of ratios, which stand first: they hold on other machines as well."""

ABOUT = """\
Medians of several repeats that alternate within one run. Rows "in processor time" count the time that all \
threads use, and are independent of other load. Rows "on the wall" are elapsed times at the load stated below. \
Ratios come first. `make bench` writes this page."""

ACCURACY = f"""\
A rigid plate plunges at k = 0.5 in a stream. The lift of the last of {CYCLES} periods is compared with \
Theodorsen's. taichiflap computes the plate in two dimensions with a free wake (the default lattice; each \
setting refines panels and steps together; amplitude 1e-4 chords). PteraSoftware has no two-dimensional mode. \
It computes a rectangular wing of aspect ratio 20 with {HALF_SPAN_PANELS} panels on each half of the span, \
cosine spacing, NACA 0012, an amplitude of 0.01 chords, and its prescribed wake, which is its faster one; its \
lift is that of the strip next to mid-span. At aspect ratio 50 its values change by less than 0.1 % (tried by \
hand), so that the difference from theory is not due to the third dimension. Time is the processor time of the \
march alone, after compilation. Both errors are shown at each setting, since the amplitude can be right while \
the phase is wrong."""


def benchmarks(rows: Iterable[Row], machine: Mapping[str, str]) -> list[Block]:
    """The page of all rows."""
    lines = list(rows)
    blocks: list[Block] = [Heading(1, "Benchmarks"), Paragraph(ABOUT), Figure("sizes", "Time against size")]
    for section in dict.fromkeys(row.section for row in lines):
        here = [row for row in lines if row.section == section]
        blocks += [Heading(2, section), _table(sorted(here, key=lambda row: row.unit not in RATIOS))]
    return [*blocks, *_machine(machine)]


def accuracy(points: Iterable[Point], rows: Iterable[Row], machine: Mapping[str, str]) -> list[Block]:
    """The page of time to accuracy."""
    settings = [
        [p.who, str(p.panels), str(p.steps), f"{1e3 * p.seconds:.3g}", f"{p.amplitude:+.2f} %", f"{p.phase:+.2f}"]
        for p in points
    ]
    head = ["", "panels", "steps a period", "time (ms)", "amplitude", "phase (deg)"]
    return [
        Heading(1, SECTION), Paragraph(ACCURACY), Figure("accuracy", "Error against time"), _table(rows),
        Heading(2, "Every setting"), Table(head, settings), *_machine(machine),
    ]  # fmt: skip


def _table(rows: Iterable[Row]) -> Table:
    return Table(
        ["", "figure", "target", "", "note"], [[row.name, row.figure, row.aim, row.verdict, row.note] for row in rows]
    )


def _machine(machine: Mapping[str, str]) -> list[Block]:
    return [Heading(2, "Measured with"), Table(["", ""], [[name, value] for name, value in machine.items()])]
