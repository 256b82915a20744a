"""Series over time as CSV, for a spreadsheet or any other program."""

from pathlib import Path

from .. import files
from ..results.reader import Result
from ..results.variables import AXES


def write_csv(result: Result, path: Path) -> None:
    """Write every series, one row a step, with as many digits as it takes to read the same numbers.

    The header row carries names and units; a modal variable has one column a mode.

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
