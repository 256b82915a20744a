"""The command line. Heavy modules are imported inside the commands, so that `--help` is fast."""

import gc
import os
import shlex
import sys
from collections.abc import Collection
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .commands import score as scoring
from .commands import standard_streams, studies
from .commands.interrupts import heard, interruptible
from .commands.options import CaseFile, Settings, Threads
from .errors import UserError
from .notation import printable

if TYPE_CHECKING:
    from .case.case import Case

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Fast, trustworthy models of flexible flapping wings.",
)


def main() -> None:
    """Run the command line. User errors print one sentence on stderr and exit with code 2 or 1."""
    standard_streams.settle()
    _lighten()
    try:
        app()
    except (MemoryError, ImportError) as error:
        if isinstance(error, ImportError) and "cannot allocate" not in str(error) and "failed to map" not in str(error):
            raise
        print(
            "error: out of memory: the limit of this process (ulimit -v) or of the machine is reached; use fewer "
            "panels, steps or frames",
            file=sys.stderr,
        )
        sys.exit(1)
    except UserError as error:
        for line in str(error).splitlines():
            print(f"error: {printable(line)}", file=sys.stderr)
        sys.exit(error.exit_code)
    except SystemExit as done:
        sys.exit(done.code or int(standard_streams.failed()))


def _lighten() -> None:
    """Leave out of this process what its libraries would do for others, before they are imported."""
    # Pydantic looks through everything that is installed for plugins of its own; NumPy starts threads for a BLAS.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Imports make half a million objects that stay: there is nothing among them to collect.
    gc.set_threshold(100_000)


def _version(wanted: bool) -> None:
    if wanted:
        from ._version import __version__

        print(f"taichiflap {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version and stop")
    ] = False,
) -> None:
    pass


@app.command()
def simulate(
    case_file: CaseFile,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="result file  [default: the case's name .h5, here]")
    ] = None,
    settings: Settings = None,
    threads: Threads = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="replace an existing result, or the file of an interrupted run")
    ] = False,
    resume: Annotated[bool, typer.Option("--resume", help="continue an interrupted run")] = False,
    view: Annotated[bool, typer.Option("--view", help="show the run in the browser while it is computed")] = False,
) -> None:
    """Compute a case and write its result file."""
    from .case.case import load_case
    from .results.reader import part
    from .run.warnings import warnings

    case = load_case(case_file, settings or ())
    path = output or Path(f"{case_file.stem}.h5")
    if resume and not os.path.exists(path) and not os.path.exists(part(path)):
        print(f"{path}: no interrupted run to resume; starting from the beginning", file=sys.stderr)
    found = warnings(case)
    for warning in found:
        print(f"warning: {warning}", file=sys.stderr)
    with _viewing(path) if view else nullcontext():
        again = ["taichiflap", "simulate", str(case_file), *(f"--set={setting}" for setting in settings or ())]
        again += [*(["-o", str(output)] if output else []), "--resume"]
        with interruptible(
            f"interrupted: taichiflap info {path} shows what has been computed",
            f"continue with: {shlex.join(again)}",
        ):
            result = _simulate_with_progress(case, path, threads, overwrite, resume)
        with result:
            failed = result.status == "failed"
            _print_summary(result, [*found, str(result.attributes.get("reason"))])
            if failed:
                print(f"error: {path}: {result.attributes['reason']}", file=sys.stderr)
    # Exit after the viewer is closed, which shows the frames before the failure.
    if failed:
        raise typer.Exit(1)


@app.command(short_help="Draw the motion of a case before running it.")
def preview(
    case_file: CaseFile,
    settings: Settings = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="png, pdf, svg or eps file  [default: the case's name-preview.png, here]"),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace an existing picture")] = False,
) -> None:
    """Draw the wing's path, angle of attack and speeds over a beat, before running the case."""
    from .case.case import load_case
    from .commands.summary import motion_line
    from .plots import undocumented

    undocumented.skip()
    from .plots.preview import write
    from .run.warnings import warnings

    case = load_case(case_file, settings or ())
    path = write(case, output or Path(f"{case_file.stem}-preview.png"), overwrite)
    print(f"{path} written")
    print(motion_line(case))
    for warning in warnings(case):
        print(f"warning: {warning}", file=sys.stderr)


@app.command(short_help="Show a result or a map in the browser.")
def view(
    files: Annotated[list[Path], typer.Argument(help="a result file, two to compare, or a map", show_default=False)],
    host: Annotated[
        str, typer.Option(metavar="ADDRESS", help="where to listen; this machine only, unless told otherwise")
    ] = "127.0.0.1",
    port: Annotated[
        int,
        typer.Option(min=1, max=65535, metavar="N", help="port to listen at; a taken one gives way to the next"),
    ] = 8080,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="open a browser")] = True,
    trust: Annotated[
        bool, typer.Option("--trust", help="allow a map's cases to run their own solver module, which is code")
    ] = False,
    token: Annotated[
        bool, typer.Option("--token/--no-token", help="have the address hold a secret, without which nobody comes in")
    ] = True,
) -> None:
    """Show a result or a map in the browser, even while it is being computed."""
    from taichiflap_viewer import view as show

    show(files, host=host, port=port, browser=browser, token=token, trust=trust)


@app.command(short_help="Change a case with sliders in the browser and see the result at once.")
def explore(
    case_file: CaseFile,
    settings: Settings = None,
    threads: Threads = None,
    host: Annotated[
        str, typer.Option(metavar="ADDRESS", help="where to listen; this machine only, unless told otherwise")
    ] = "127.0.0.1",
    port: Annotated[
        int,
        typer.Option(min=1, max=65535, metavar="N", help="port to listen at; a taken one gives way to the next"),
    ] = 8080,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="open a browser")] = True,
    token: Annotated[
        bool, typer.Option("--token/--no-token", help="have the address hold a secret, without which nobody comes in")
    ] = True,
) -> None:
    """Change a case with sliders in the browser. Each change is computed at once, for at most five beats."""
    from taichiflap_viewer.explore.viewer import explore as show

    show(case_file, settings or (), threads=threads, host=host, port=port, browser=browser, token=token)


@app.command()
def info(file: Annotated[Path, typer.Argument(help="result file, or map", show_default=False)]) -> None:
    """Summarise a result or a map."""
    from .maps.file import is_map, open_map
    from .results.reader import open_result

    if is_map(file):
        from .commands.map_summary import map_lines

        with open_map(file) as sheet:
            print("\n".join(map_lines(sheet)))
        return
    with open_result(file) as result:
        _print_summary(result)


@app.command(short_help="Draw figures of results or a map for print.")
def plot(
    files: Annotated[
        list[Path], typer.Argument(help="a result file, several to compare, or a map", show_default=False)
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="NAME[.pdf|.eps|.svg|.png]",
            help="folder, or start of the file names with an optional type  [default: the result's name, here, as PNG "
            "and SVG]",
        ),
    ] = None,
    width: Annotated[
        float | None,
        typer.Option(min=60.0, max=400.0, metavar="MM", help="width of a result's figures  [default: 180]"),
    ] = None,
    metric: Annotated[
        list[str] | None,
        typer.Option("--metric", metavar="NAME", help="series of results, or metric of a map, to draw; repeatable"),
    ] = None,
    beats: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="last beats of results to draw  [default: 1]")
    ] = None,
    style: Annotated[
        str | None, typer.Option(metavar="NAME|FILE", help="a style of matplotlib's, or a .mplstyle file")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace existing figures")] = False,
    whole: Annotated[
        bool, typer.Option("--whole", help="in a map, do not grey out cases in which the model is invalid")
    ] = False,
    sheets: Annotated[bool, typer.Option("--sheets", help="colour the wake by the edge that shed it")] = False,
    frame: Annotated[str, typer.Option(help="frame of reference of the wing: inertial or wing")] = "inertial",
) -> None:
    """Draw for print: the last beats of one result or several, and the wing of each; or a map."""
    from contextlib import ExitStack

    from .drawing.orientation import FRAMES
    from .maps.file import is_map, open_map
    from .plots import undocumented
    from .results.reader import open_result

    undocumented.skip()
    if len(files) == 1 and is_map(files[0]):
        from .plots import maps as map_plots

        if width or beats or sheets:
            raise UserError("--width, --beats and --sheets are for results, not for a map")
        with open_map(files[0]) as sheet:
            for path in map_plots.plot(sheet, output, overwrite, whole, metrics=metric or (), look=style):
                print(f"{path} written")
        return
    if whole:
        raise UserError("--whole is for a map, not for results")
    if frame not in FRAMES:
        raise UserError(f"--frame {frame}: use {' or '.join(FRAMES)}")
    with ExitStack() as stack:
        results = [stack.enter_context(open_result(path)) for path in files]
        from .plots.result import plot as draw
        from .plots.style import WIDTH

        wide = width / 25.4 if width else WIDTH
        for path in draw(
            results,
            output,
            overwrite,
            sheets,
            width=wide,
            metrics=metric or (),
            beats=beats or 1,
            look=style,
            reference=frame,
        ):
            print(f"{path} written")


@app.command(short_help="Export a result as a table, for ParaView, or as a film.")
def export(
    file: Annotated[Path, typer.Argument(help="result file, or map", show_default=False)],
    to: Annotated[
        str,
        typer.Option("--to", metavar="FORMAT", help="csv, vtkhdf, html, mp4, gif, flow.vtkhdf, nc; for a map csv"),
    ],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="file, or folder  [default: the result's name, here]")
    ] = None,
    beats: Annotated[
        int | None,
        typer.Option(metavar="N", help="number of last beats to show  [default: 4 in html, 2 in mp4, 1 in gif]"),
    ] = None,
    dark: Annotated[bool, typer.Option("--dark", help="dark background for a film")] = False,
    frame: Annotated[
        str, typer.Option(help="frame of reference of a page, film or plain grid: inertial or wing")
    ] = "inertial",
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace an existing file")] = False,
) -> None:
    """Export a result as a table, for ParaView, or as a page or film of its last beats; or a map as a table."""
    from .export.formats import export as write
    from .export.formats import export_map
    from .maps.file import is_map, open_map
    from .results.reader import open_result

    if is_map(file):
        if beats is not None or dark:
            raise UserError("--beats and --dark apply to results; a map is exported as csv")
        with open_map(file) as sheet:
            print(f"{export_map(sheet, to, output, overwrite)} written")
        return
    with open_result(file) as result:
        print(f"{write(result, to, output, beats, overwrite, dark=dark, reference=frame)} written")


@app.command()
def init(
    file: Annotated[Path, typer.Argument(help="case file to write")] = Path("case.toml"),
    source: Annotated[
        str | None,
        typer.Option("--from", metavar="NAME", help="start from a bundled case such as hawkmoth"),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace an existing file")] = False,
) -> None:
    """Write a commented case file to start from."""
    from .case import shipped
    from .case.template import commented_case
    from .files import check, replacing

    contents = {file: (shipped.text(source) if source else commented_case()).encode()}
    check(file, overwrite)
    for table in shipped.tables(source) if source else ():
        path, content = file.parent / table.name, table.read_bytes()
        if path == file:
            raise UserError(f"{file}: is the name of the case's motion table; name the case file {source}.toml")
        check(path, overwrite or (path.is_file() and path.read_bytes() == content))
        contents[path] = content
    for path, content in contents.items():
        with replacing(path) as written:
            written.write(content)
    print(f"{file} written; edit it, then run: taichiflap simulate {file}")


@app.command(short_help="Compare the solver with exact solutions.")
def validate(
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="folder for a report with figures  [default: none]")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace an existing report")] = False,
) -> None:
    """Compare the solver with exact solutions, row by row. Exit code 1 if a row fails."""
    from .validation import report
    from .validation import validate as study

    if output:
        report.check_folder(output, overwrite)
    checks = []
    for check in study.validate(progress=_pass_by):
        checks.append(check)
        _pass_by("")
        print("\n".join(study.table(check)), flush=True)
    print(study.verdict(checks))
    if output:
        print(*(f"{path} written" for path in report.write(checks, output)), sep="\n")
    if not all(check.passed for check in checks):
        raise typer.Exit(1)


@app.command(short_help="Reproduce the paper's numbers and figures.")
def reproduce(
    output: Annotated[Path, typer.Option("-o", "--output", help="folder for the report, figures and data")] = Path(
        "reproduction"
    ),
    every_model: Annotated[
        bool, typer.Option("--models", help="also rerun the wing in every model: tens of minutes on one core")
    ] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="write into a folder that is not empty")] = False,
) -> None:
    """Reproduce the paper: write a report with its numbers and figures next to the computed ones."""
    from .commands.progress import share
    from .published.reade2020 import reproduce as study

    with share("reproducing the paper") if sys.stderr.isatty() else nullcontext() as progress:
        found = study.reproduce(output, every_model=every_model, overwrite=overwrite, progress=progress)
    print(*found, sep="\n")
    print(f"{output / study.REPORT}, {output / study.PAGE} and {output / study.DATA} written")


app.command(short_help="Score the models against published data.")(scoring.score)
app.command()(studies.sweep)
app.command(short_help="Find a converged resolution.")(studies.converge)
app.command(short_help="Optimise a case over ranges of keys.")(studies.optimise)
app.command(short_help="Sum the forces of sections at several radii.")(studies.strips)


@app.command()
def schema() -> None:
    """Print the JSON schema of a case file."""
    import json

    from .case.case import case_schema

    print(json.dumps(case_schema(), indent=2))


@app.command(short_help="Print how to cite taichiflap, as BibTeX.")
def cite() -> None:
    """Print how to cite taichiflap and the paper it is based on, as BibTeX."""
    from .commands.citation import BIBTEX

    print(BIBTEX)


def _viewing(path: Path) -> AbstractContextManager[Any]:
    from taichiflap_viewer.beside import Beside

    return Beside(path)


def _pass_by(text: str) -> None:
    """Show a line on the terminal that the next line replaces."""
    if sys.stderr.isatty():
        print(f"\r\x1b[2K{text}", end="", file=sys.stderr, flush=True)


def _simulate_with_progress(case: "Case", path: Path, threads: int | None, overwrite: bool, resume: bool) -> Any:
    from .run.blocks import simulate as run

    shown: Any = nullcontext()
    if sys.stderr.isatty():
        from .commands.progress import bar

        shown = bar(case)
    with shown as update, heard(update) as progress:
        return run(case, path, threads=threads, progress=progress, overwrite=overwrite, resume=resume)


def _print_summary(result: Any, said: Collection[str] = ()) -> None:
    from .commands.summary import summary_lines

    print("\n".join(summary_lines(result, said)), flush=True)
