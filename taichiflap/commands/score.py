"""The command `score`: compare the models with published data, or with the user's own measurement."""

import math
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Any

import typer

from .options import Settings, Threads


def score(
    case_file: Annotated[
        Path | None, typer.Argument(help="case file of the measurement given by --against", show_default=False)
    ] = None,
    against: Annotated[
        list[Path] | None,
        typer.Option("--against", metavar="CSV", help="measured trace of this case; may be repeated"),
    ] = None,
    models: Annotated[str, typer.Option(metavar="NAME,...", help="models to score  [default: all]")] = "",
    cases: Annotated[str, typer.Option(metavar="NAME,...", help="published cases to score  [default: all]")] = "",
    output: Annotated[
        Path, typer.Option("-o", "--output", help="folder for the page, its figures and the computed data")
    ] = Path("scores"),
    speed: Annotated[
        float | None,
        typer.Option(min=0.0, metavar="M/S", help="reference speed of the coefficients  [default: of the case]"),
    ] = None,
    area: Annotated[
        float | None,
        typer.Option(min=0.0, metavar="M2", help="reference area of the coefficients  [default: chord times span]"),
    ] = None,
    shift: Annotated[
        str, typer.Option(metavar="BEATS|best", help="delay of the trace; best finds one per trace")
    ] = "0",
    settings: Settings = None,
    threads: Threads = None,
) -> None:
    """Score the models against published data. With a case and --against, compare them with your own measurement."""
    from .. import files
    from ..published.scores import tiers

    wanted = tiers.chosen(filter(None, models.split(",")))
    if case_file or against:
        _compare(case_file, against or [], wanted, bool(models), speed, area, shift, settings or [], threads, output)
        return
    from ..published.scores import library, report, table
    from ..published.scores import score as study

    found = library.chosen(filter(None, cases.split(",")))
    files.make_folder(output)
    store = study.Store(output / report.STORE)
    with _bar("scoring") as told:
        rows = study.score(found, wanted, store, threads=threads, progress=told)
    print("\n".join(table.lines(rows, wanted)))
    print(*(f"{path} written" for path in report.write(rows, wanted, output)), sep="\n")


def _compare(
    case_file: Path | None, files: list[Path], wanted: Any, named: bool, speed: float | None, area: float | None,
    shift: str, settings: list[str], threads: int | None, output: Path,
) -> None:  # fmt: skip
    from .. import files as disk
    from ..case.case import load_case
    from ..published.scores import against, comparison, report, traces
    from ..published.scores.tiers import ScoreError
    from ..scored.regime import Regime

    if case_file is None or not files:
        raise ScoreError("a case file and --against go together: taichiflap score CASE --against trace.csv")
    for name, value in (("--speed", speed), ("--area", area)):
        if value is not None and not 0.0 < value < math.inf:
            raise ScoreError(f"{name} {value:g}: give a number above 0, or leave it out")
    case = load_case(case_file, settings)
    if not named:
        wanted = [tier for tier in wanted if tier.takes(Regime.of(case).reynolds)]
    late, read = against.read_shift(shift), [traces.read_trace(file) for file in files]
    disk.make_folder(output)
    with _bar("comparing") as told:
        found = against.compare(case, read, wanted, speed=speed, area=area, shift=late, threads=threads, progress=told)
    for one in found:
        print("\n".join(comparison.lines(one, wanted)))
    print(*(f"{path} written" for path in report.write_comparison(found, wanted, output)), sep="\n")


def _bar(title: str) -> Any:
    if not sys.stderr.isatty():
        return nullcontext()
    from .progress import steps

    return steps(title)
