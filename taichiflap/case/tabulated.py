"""Points of a tabulated motion, from a text or CSV file into the case, so that a case needs no file beside it."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .document import DocumentError, read_text

SEPARATOR = re.compile(r"\s*[,;]\s*|\s+")


class PointsError(ValueError):
    """A file of points that cannot be used: one sentence with the key and the file."""


def with_points(document: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """The document with the points of every table that names a `file` in the place of that name.

    Args:
        folder: where a relative name begins.

    Raises:
        PointsError: when a file is missing or holds something else.
    """
    motion = document.get("motion")
    if not isinstance(motion, Mapping):
        return dict(document)
    read = {}
    for name, key in (("plunge", "points"), ("pitch", "points_deg"), ("surge", "points")):
        table = motion.get(name)
        if isinstance(table, Mapping) and table.get("kind") == "table" and isinstance(table.get("file"), str):
            rest = {k: v for k, v in table.items() if k not in ("file", "column")}
            if key in rest:
                raise PointsError(f"motion.{name}: has both {key} and a file; give one")
            column = table.get("column", 2)
            if not isinstance(column, int) or column < 2:
                raise PointsError(
                    f"motion.{name}.column = {column}: must be a whole number >= 2, e.g. 2 (column 1 is time)"
                )
            file = table["file"]
            try:
                read[name] = rest | {key: read_points(folder / file, column)}
            except PointsError as error:
                raise PointsError(f'motion.{name}.file = "{file}": {error}') from None
    return {**document, "motion": {**motion, **read}}


def read_points(path: Path, column: int) -> list[list[float]]:
    """Rows `[time, value]` from columns 1 and `column` of a file of numbers.

    Numbers stand between commas, semicolons or spaces; between semicolons they may have decimal commas. A `#` begins
    a comment, and one line of names may come first.

    Raises:
        PointsError: when the file cannot be read, a line does not hold the numbers, or lines differ in their columns.
    """
    try:
        lines = read_text(path, regular=True).splitlines()
    except FileNotFoundError:
        raise PointsError("no such file beside the case") from None
    except OSError as error:
        raise PointsError(f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise PointsError("not a text file in UTF-8") from None
    except DocumentError as error:
        raise PointsError(str(error)) from None
    points: list[list[float]] = []
    named = False
    columns = 0
    for number, line in enumerate(lines, 1):
        text = line.partition("#")[0].strip()
        cells = SEPARATOR.split(text.replace(",", ".") if ";" in text else text)
        if cells == [""]:
            continue
        try:
            points.append([float(cells[0]), float(cells[column - 1])])
        except IndexError:
            raise PointsError(f"line {number} has no column {column}: {line.strip()[:40]}") from None
        except ValueError:
            if points or named:
                raise PointsError(f"line {number} holds no numbers: {line.strip()[:40]}") from None
            named = True
            continue
        columns = columns or len(cells)
        if len(cells) != columns:
            raise PointsError(f"line {number} has {len(cells)} columns, the first has {columns}: {line.strip()[:40]}")
    return points
