"""`make bench`: measure everything, print a table, and write docs/benchmarks/."""

import dataclasses
import json
from collections.abc import Iterable

from taichiflap.pages import markdown

from . import accuracy, commands, figures, load, machine, others, pages, pairs, runs, viscous, wakes
from .rows import Row

FOLDER = machine.ROOT / "docs" / "benchmarks"


def main() -> None:
    """Rows are printed as they are measured."""
    FOLDER.mkdir(exist_ok=True)
    described = machine.describe()
    for name, value in described.items():
        print(f"{name:<22}{value}")
    rates = pairs.measure()
    limit = rates.limit()
    rows = printed(pairs.rows(rates))
    for some in (runs.alone(limit), runs.in_memory(), runs.parts(), runs.sweeps()):
        rows += printed(some)
    steps = wakes.step_times(limit)
    for some in (
        wakes.rows(steps, limit),
        commands.start(),
        commands.drawing(),
        commands.output(),
        load.rows(),
        viscous.rows(),
        others.rows(),
    ):
        rows += printed(some)
    points = accuracy.measure()
    reached = printed(accuracy.rows(points))
    figures.draw_sizes(rates, steps, FOLDER / "sizes.png")
    figures.draw_accuracy(points, FOLDER / "accuracy.png")
    FOLDER.joinpath("benchmarks.md").write_text(markdown(pages.benchmarks(rows, described)), encoding="utf-8")
    FOLDER.joinpath("accuracy.md").write_text(markdown(pages.accuracy(points, reached, described)), encoding="utf-8")
    record = {"machine": described, "rows": [{**dataclasses.asdict(row), "met": row.met} for row in rows + reached],
              "accuracy": [dataclasses.asdict(point) for point in points]}  # fmt: skip
    FOLDER.joinpath("bench.json").write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    print(f"\n{FOLDER.relative_to(machine.ROOT)} written")


def printed(rows: Iterable[Row]) -> list[Row]:
    """The rows, each printed when it comes."""
    found: list[Row] = []
    for row in rows:
        if row.section not in {one.section for one in found}:
            print(f"\n{row.section}")
        print(f"  {row.name:<78}{row.figure:<18}{row.aim:<16}{row.verdict:<9}{row.note}", flush=True)
        found.append(row)
    return found


if __name__ == "__main__":
    main()
