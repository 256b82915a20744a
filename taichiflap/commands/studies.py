"""Commands that run many cases: sweep."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from .options import CaseFile, Cluster, Settings, Threads, Vary


def sweep(
    case_file: CaseFile,
    vary: Vary,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="map file  [default: the case's name -map.h5, here]")
    ] = None,
    sample: Annotated[
        str | None, typer.Option(metavar="sobol:N|lhs:N", help="sample the ranges instead of a full grid")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="seed of the sample")] = 0,
    metric: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="keep this metric; may be repeated  [default: all]")
    ] = None,
    keep: Annotated[str | None, typer.Option(metavar="series", help="keep the time series of every case too")] = None,
    settings: Settings = None,
    cluster: Cluster = None,
    threads: Threads = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace the map of another study")] = False,
) -> None:
    """Run a case for many values of its keys and write a map. Run it again after a crash: it goes on."""
    from ..case import load_case
    from ..design import design, read_vary
    from ..studies import sweep as study

    case = load_case(case_file, settings or ())
    planned = design(case, read_vary(vary), sample, seed)
    path = output or Path(f"{case_file.stem}-map.h5")
    with study.prepare(case, planned, path, metrics=metric or (), keep=keep, overwrite=overwrite) as sheet:
        missing = len(sheet.pending)
        if missing < planned.size:
            print(f"{path}: {planned.size - missing:,} of {planned.size:,} cases are there already")
        advice = f"{path} keeps every finished batch; the same command goes on"
        with interruptible(advice), progress(case.title or "sweep") as tell:
            study.fill(sheet, cluster=cluster, threads=threads, progress=tell)
        _print_map(sheet)


@contextmanager
def interruptible(advice: str) -> Iterator[None]:
    """End with code 130 and a word of advice when interrupted."""
    try:
        yield
    except KeyboardInterrupt:
        print(f"interrupted: {advice}", file=sys.stderr)
        raise typer.Exit(130) from None


@contextmanager
def progress(title: str) -> Iterator[Any]:
    """A bar of cases on a terminal; a line now and then in a log."""
    from ..progress import cases, log

    with (cases if sys.stderr.isatty() else log)(title) as tell:
        yield tell


def _print_map(sheet: Any) -> None:
    from ..map_report import map_lines

    print("\n".join(map_lines(sheet)))
