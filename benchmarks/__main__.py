"""`make bench`: measure everything, print a table, and write docs/benchmarks/.

`python -m benchmarks sweeps wakes` measures only those parts, and writes nothing; `--short` clocks everything once.
"""

import argparse
import dataclasses
import json
import time
from collections.abc import Callable, Iterable, Iterator

from taichiflap.pages import markdown

from . import accuracy, clock, commands, figures, load, machine, others, pages, pairs, runs, viscous, wakes
from .rows import Row

FOLDER = machine.ROOT / "docs" / "benchmarks"

Measured = Callable[["Bench"], Iterable[Row]]


class Bench:
    """What has been measured, beside the rows.

    Attributes:
        rates: of pair sums, at all sizes if the part `pairs` is measured.
        steps: of long wakes.
        points: of time to accuracy.
    """

    def __init__(self, whole: bool) -> None:
        self.rates = pairs.measure() if whole else pairs.measure(pairs.SIZES[:1])
        self.limit = self.rates.limit()
        self.steps: wakes.StepTimes = {}
        self.points: list[accuracy.Point] = []


def _wakes(bench: Bench) -> Iterator[Row]:
    bench.steps = wakes.step_times(bench.limit)
    yield from wakes.rows(bench.steps, bench.limit)


def _accuracy(bench: Bench) -> Iterator[Row]:
    bench.points = accuracy.measure()
    yield from accuracy.rows(bench.points)


PARTS: dict[str, Measured] = {
    "pairs": lambda bench: pairs.rows(bench.rates),
    "alone": lambda bench: runs.alone(bench.limit),
    "memory": lambda _: runs.in_memory(),
    "step": lambda _: runs.parts(),
    "sweeps": lambda _: runs.sweeps(),
    "wakes": _wakes,
    "crossover": lambda bench: wakes.crossover(bench.limit),
    "start": lambda _: commands.start(),
    "figures": lambda _: commands.drawing(),
    "output": lambda _: commands.output(),
    "load": lambda _: load.rows(),
    "viscous": lambda _: viscous.rows(),
    "others": lambda _: others.rows(),
    "accuracy": _accuracy,
}


def main() -> None:
    """Rows are printed as they are measured."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)}; all if none is given")
    parser.add_argument("--short", action="store_true", help="clock everything once, and write nothing")
    asked = parser.parse_args()
    if unknown := set(asked.parts) - set(PARTS):
        parser.error(f"{', '.join(sorted(unknown))}: no such part; the parts are {', '.join(PARTS)}")
    clock.short = asked.short
    described = machine.describe()
    for name, value in described.items():
        print(f"{name:<22}{value}")
    bench = Bench("pairs" in asked.parts or not asked.parts)
    found: dict[str, list[Row]] = {}
    for name in asked.parts or PARTS:
        began = time.perf_counter()
        found[name] = printed(PARTS[name](bench))
        print(f"  [{name}: {time.perf_counter() - began:.0f} s]", flush=True)
    if not asked.parts and not asked.short:
        _write(bench, found, described)


def _write(bench: Bench, found: dict[str, list[Row]], described: dict[str, str]) -> None:
    """Write the pages and figures, and what they were made of."""
    FOLDER.mkdir(exist_ok=True)
    rows, reached = [row for name, some in found.items() if name != "accuracy" for row in some], found["accuracy"]
    figures.draw_sizes(bench.rates, bench.steps, FOLDER / "sizes.png")
    figures.draw_accuracy(bench.points, FOLDER / "accuracy.png")
    FOLDER.joinpath("benchmarks.md").write_text(markdown(pages.benchmarks(rows, described)), encoding="utf-8")
    FOLDER.joinpath("accuracy.md").write_text(
        markdown(pages.accuracy(bench.points, reached, described)), encoding="utf-8"
    )
    record = {"machine": described, "rows": [{**dataclasses.asdict(row), "met": row.met} for row in rows + reached],
              "accuracy": [dataclasses.asdict(point) for point in bench.points]}  # fmt: skip
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
