"""Commands that run many cases: sweep, converge, optimise, strips."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from .interrupts import heard, interruptible
from .options import CaseFile, Cluster, Overwrite, Range, Seed, Settings, Threads, Vary


def sweep(
    case_file: CaseFile,
    vary: Vary,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="map file  [default: the case's name -map.h5, here]")
    ] = None,
    sample: Annotated[
        str | None, typer.Option(metavar="sobol:N|lhs:N", help="sample the ranges instead of a full grid")
    ] = None,
    seed: Seed = 0,
    metric: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="store this metric; may be repeated  [default: all]")
    ] = None,
    keep: Annotated[str | None, typer.Option(metavar="series", help="also store the time series of every case")] = None,
    settings: Settings = None,
    cluster: Cluster = None,
    threads: Threads = None,
    overwrite: Overwrite = False,
) -> None:
    """Run a case for many values of its keys and write a map. After a crash the same command continues."""
    from ..case.case import load_case
    from ..maps.design import design, read_vary
    from ..studies import sweep as study

    case = load_case(case_file, settings or ())
    planned = design(case, read_vary(vary), sample, seed)
    path = output or Path(f"{case_file.stem}-map.h5")
    advice = f"interrupted: {path} keeps every finished batch; the same command continues"
    with (
        interruptible(advice),
        study.prepare(case, planned, path, metrics=metric or (), keep=keep, overwrite=overwrite) as sheet,
    ):
        missing = len(sheet.pending)
        if missing < planned.size:
            print(f"{path}: {planned.size - missing:,} of {planned.size:,} cases are done already")
        with progress(case.title or "sweep") as update, heard(update) as tell:
            study.fill(sheet, cluster=cluster, threads=threads, progress=tell)
        _print_map(sheet)


def converge(
    case_file: CaseFile,
    tolerance: Annotated[str, typer.Option(metavar="SHARE", help="largest allowed relative change of a metric")] = "1%",
    metric: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="metric to converge; may be repeated  [default: force, power, tip]"),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="map of the cases  [default: the case's name -converge.h5]"),
    ] = None,
    settings: Settings = None,
    cluster: Cluster = None,
    threads: Threads = None,
    overwrite: Overwrite = False,
) -> None:
    """Find a converged resolution: panels or elements, steps, wake, beats and modes. Exit code 1 if none is found."""
    from ..case.case import load_case
    from ..plots import maps as map_plots
    from ..studies import converge as study

    share = study.read_tolerance(tolerance)
    case = load_case(case_file, settings or ())
    path = output or Path(f"{case_file.stem}-converge.h5")
    advice = f"interrupted: {path} keeps every finished case; the same command continues"
    with interruptible(advice), heard(lambda trial: print(study.line(trial), flush=True)) as told:
        found = study.converge(
            case, share, path, metrics=metric or (), cluster=cluster, threads=threads, overwrite=overwrite, told=told,
        )  # fmt: skip
    for figure in map_plots.convergence(found, path.with_suffix("")):
        print(f"{figure} written")
    print(f"all cases are in {path}")
    print("\n".join(study.verdict(found)))
    if found.open:
        raise typer.Exit(1)


def optimise(
    case_file: CaseFile,
    vary: Range,
    maximise: Annotated[str | None, typer.Option(metavar="EXPR", help="formula of metrics to maximise")] = None,
    minimise: Annotated[str | None, typer.Option(metavar="EXPR", help="formula of metrics to minimise")] = None,
    subject_to: Annotated[
        list[str] | None,
        typer.Option("--subject-to", metavar="EXPR", help="constraint, A >= B or A <= B; may be repeated"),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="map of the search  [default: the case's name -optimum.h5]")
    ] = None,
    generations: Annotated[int, typer.Option(min=1, metavar="N", help="maximum number of generations")] = 40,
    population: Annotated[int, typer.Option(min=5, metavar="N", help="cases per generation")] = 32,
    seed: Seed = 0,
    settings: Settings = None,
    cluster: Cluster = None,
    threads: Threads = None,
    overwrite: Overwrite = False,
) -> None:
    """Optimise a case over ranges of keys by differential evolution. Exit code 1 if no case meets the constraints."""
    from ..case.case import load_case
    from ..maps.design import read_vary
    from ..studies import optimise as study

    case = load_case(case_file, settings or ())
    path = output or Path(f"{case_file.stem}-optimum.h5")
    advice = f"interrupted: {path} keeps every finished case; the same command continues"

    def tell(number: int, one: Any) -> None:
        print(f"generation {number:3d}: {study.line(one)}", flush=True)

    with interruptible(advice), heard(tell) as told:
        best = study.optimise(
            case, read_vary(vary), maximise, minimise, subject_to or (), path, generations=generations,
            population=population, seed=seed, cluster=cluster, threads=threads, overwrite=overwrite, told=told,
        )  # fmt: skip
    print("\n".join(study.verdict(best, path)))
    if best is None or not best.holds:
        raise typer.Exit(1)


def strips(
    case_file: CaseFile,
    radii: Annotated[int, typer.Option(min=1, metavar="N", help="number of strips of equal width")] = 5,
    at: Annotated[
        float | None,
        typer.Option(
            metavar="SHARE", help="share of the span that moves as given in the case; not with measured angles"
        ),
    ] = None,
    root: Annotated[float, typer.Option(metavar="SHARE", help="share of the span at which the wing starts")] = 0.0,
    planform: Annotated[
        str, typer.Option(metavar="SHARE:CHORD,...", help="chord relative to the case's chord, e.g. 0:0.6,0.5:1,1:0.3")
    ] = "",
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="CSV file with the time series of the sums", show_default=False),
    ] = None,
    settings: Settings = None,
    threads: Threads = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace an existing file")] = False,
) -> None:
    """Run sections at several radii from the hinge to the tip (wing.span), and sum their forces."""
    from .. import files
    from ..case.case import load_case
    from ..studies import strips as study

    case = load_case(case_file, settings or ())
    if output:
        files.check(output, overwrite)
    found = study.strips(case, radii, at=at, root=root, planform=study.read_planform(planform), threads=threads)
    print("\n".join(study.lines(found)))
    if output:
        found.write(output, overwrite)
        print(f"{output} written")


@contextmanager
def progress(title: str) -> Iterator[Any]:
    """A progress bar of cases on a terminal; occasional lines in a log."""
    from .progress import cases, log

    with (cases if sys.stderr.isatty() else log)(title) as tell:
        yield tell


def _print_map(sheet: Any) -> None:
    from .map_summary import map_lines

    print("\n".join(map_lines(sheet)))
