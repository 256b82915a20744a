"""Arguments and options shared by several commands."""

from pathlib import Path
from typing import Annotated

import typer

CaseFile = Annotated[Path, typer.Argument(help="case file, TOML", show_default=False)]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="change a key of the case file; may be repeated"),
]
Threads = Annotated[int | None, typer.Option(min=1, metavar="N", help="threads to use  [default: all]")]
Vary = Annotated[
    list[str],
    typer.Option(
        "--vary",
        metavar="KEY=a:b:n[:log]|v1,v2,...",
        help="key of the case file and its values; may be repeated. With --sample, a range a:b or a:b:log",
    ),
]
Range = Annotated[
    list[str],
    typer.Option(
        "--vary",
        metavar="KEY=a:b[:log]|v1,v2,...",
        help="key of the case file and its range or list of values; may be repeated",
    ),
]
Cluster = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS|local:N", help="run on a Dask scheduler, or on N local worker processes"),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="replace the file of another study")]
Seed = Annotated[int, typer.Option(min=0, metavar="N", help="seed of the random numbers")]
