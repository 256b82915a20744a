"""Series over time, and maps, as CSV."""

import csv
import io
from pathlib import Path

import numpy as np

from .. import files
from ..maps.file import Map
from ..maps.outcome import COMPLETE, FAILED
from ..results.reader import Result
from ..results.variables import AXES


def write_csv(result: Result, path: Path) -> None:
    """Write every series, one row per step, with enough digits to reproduce every number exactly.

    The header row has names and units; a modal variable has one column per mode.

    Raises:
        OutputError: when the file cannot be written.
    """
    columns = [(f"time ({AXES['time'].units})", result.time)]
    for name in result.variables:
        one = result.describe(name)
        if name == "time" or one.dimensions[:1] != ("time",) or one.field:
            continue
        values, units = getattr(result, name), one.units
        if values.ndim == 1:
            columns.append((f"{name} ({units})", values))
        else:
            columns += [(f"{name}_{k} ({units})", column) for k, column in enumerate(values.T, 1)]
    rows = zip(*(map(repr, values.tolist()) for _, values in columns), strict=True)
    with files.replacing(path) as file:
        file.write((",".join(name for name, _ in columns) + "\n").encode())
        file.writelines((",".join(row) + "\n").encode() for row in rows)


def write_map_csv(sheet: Map, path: Path) -> None:
    """Write a map, one row per case: keys, metrics, status, and the reason of a failure.

    The header row has names and units; undefined values are left empty.

    Raises:
        OutputError: when the file cannot be written.
    """
    names = [axis.key for axis in sheet.design.axes]
    units = [sheet.units(name) for name in (*names, *sheet.metrics)]
    header = [f"{name} ({unit})" if unit else name for name, unit in zip((*names, *sheet.metrics), units, strict=True)]
    columns = [sheet.values(name).ravel().tolist() for name in sheet.metrics]
    statuses = {COMPLETE: "complete", FAILED: "failed"}
    outcomes = sheet.outcomes(range(sheet.design.size))
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([*header, "status", "reason"])
    for number, (status, outcome) in enumerate(zip(sheet.status.tolist(), outcomes, strict=True)):
        values = ["" if np.isnan(column[number]) else repr(column[number]) for column in columns]
        reason = outcome.reason if outcome else ""
        table.writerow([*sheet.design.point(number).values(), *values, statuses.get(status, "to do"), reason])
    with files.replacing(path) as file:
        file.write(text.getvalue().encode())
