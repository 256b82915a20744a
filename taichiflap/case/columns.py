"""Columns of numbers from text files written by instruments, spreadsheets and Fortran programs."""

import codecs
import difflib
import re
from dataclasses import dataclass
from pathlib import Path

from .document import DocumentError, read_bytes

NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eEdD][+-]?\d+)?")
COMMENT = re.compile(r"\s*(#|%|;|//|!|sep=.$)")
"""Start of a comment line, or of a spreadsheet's separator declaration."""
BEHIND = re.compile(r"#.*|(?<=\d)\s+[%!].*")
"""A comment after the numbers of a line."""
UNIT = re.compile(r"[(\[{]([^)\]}]*)[)\]}]\s*$|(?:_|,\s*|\s/\s|\sin\s|/(?!T))(\w+|°)\s*$")
"""The unit in a column's name: in brackets, or after an underscore, a comma, a slash or `in`. A share t/T has none."""
ALIKE = str.maketrans(
    dict.fromkeys("\u2212\u2012\u2013\ufe63\uff0d", "-") | dict.fromkeys("\u00a0\u2007\u2009\u202f", " ")
)
"""Typographic minus signs and spaces."""
QUOTED = re.compile(r"\"([^\"]*)\"|'([^']*)'")
HIDDEN = {",": "\ue000", ";": "\ue001", "\t": "\ue002", " ": "\ue003"}
"""Placeholder for a quoted separator while a line is split."""
_HIDE = str.maketrans("".join(HIDDEN), "".join(HIDDEN.values()))
_SHOW = str.maketrans("".join(HIDDEN.values()), "".join(HIDDEN))
MARKS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
OTHERS = {b"PK\x03\x04": "a spreadsheet", b"\x89HDF": "an HDF5 file", b"\x89PNG": "a picture", b"%PDF": "a PDF"}
"""First bytes of common table files that are not text."""
COMMAS = re.compile(r"\s*,\s*")
SPACES = re.compile(r"\s+")
EITHER = re.compile(r"\s*,\s*|\s+")
NOT_WITHIN_NUMBERS = re.compile(r"\s*,\s+|\s+,\s*|\s+")
LONGEST_NAME = 80
HEADINGS = 3
"""Maximum number of lines before the numbers: a title, names and units."""
UNITS = frozenset(
    (
        "s",
        "sec",
        "ms",
        "us",
        "\u03bcs",
        "min",
        "m",
        "cm",
        "mm",
        "um",
        "\u03bcm",
        "in",
        "ft",
        "deg",
        "degrees",
        "°",
        "rad",
        "radians",
        "t/t",
        "%",
        "1",
        "-",
    )
)
"""Units recognised in a row of units, besides text in brackets; `plain` makes the micro sign a Greek letter."""


class ColumnsError(ValueError):
    """Raised when a file lacks the requested columns; one sentence."""


@dataclass(frozen=True)
class Column:
    """A column of a sheet.

    Attributes:
        number: counted from 1.
        name: from the file's heading, or empty.
        unit: from the heading or from a row of units below it, or empty.
        values: cells with their line numbers.
    """

    number: int
    name: str
    unit: str
    cells: tuple[tuple[int, str], ...]

    def __str__(self) -> str:
        return f'column {self.number} ("{self.name}")' if self.name else f"column {self.number}"

    def numbers(self) -> list[float]:
        """The column as numbers.

        Raises:
            ColumnsError: if a cell is not a number.
        """
        for line, cell in self.cells:
            if not NUMBER.fullmatch(cell):
                raise ColumnsError(f"line {line} has no number in column {self.number}: {cell[:40] or 'nothing'}")
        return [_value(cell) for _, cell in self.cells]


def column(columns: list[Column], which: int | str) -> Column:
    """Find a column by its number, or by its name with or without the unit.

    Raises:
        ColumnsError: if there is no such column.
    """
    if isinstance(which, int):
        if which <= len(columns):
            return columns[which - 1]
        line, _ = columns[0].cells[0]
        raise ColumnsError(f"line {line} has no column {which}; the last is {len(columns)}")
    found = [one for one in columns if plain(which) == plain(one.name)]
    found = found or [one for one in columns if plain(which) == bare(one.name)]
    if len(found) > 1:
        raise ColumnsError(f'has several columns "{which}": {", ".join(map(str, found))}; give a number or whole name')
    if found:
        return found[0]
    names = [one.name for one in columns if one.name]
    if not names:
        raise ColumnsError(f'has no column "{which}": its columns have no names; give a number')
    nearest = difflib.get_close_matches(which, names, 1)
    hint = f"did you mean {nearest[0]}?" if nearest else f"its columns are {', '.join(names)}"
    raise ColumnsError(f'has no column "{which}"; {hint}')


def plain(name: str) -> str:
    """A name in lower case without spaces."""
    return SPACES.sub("", name).casefold()


def bare(name: str) -> str:
    """A name in lower case without spaces and unit."""
    return plain(UNIT.sub("", name))


def read_columns(path: Path) -> list[Column]:
    """Read the columns of a text file.

    Numbers are separated by tabs, semicolons, commas or spaces, and may be quoted. They have decimal points, or decimal
    commas if these cannot be mistaken for separators. Comments begin with `#`, `%`, `;`, `//` or `!`. A heading with
    column names may come first, followed by a row of units. A comment directly above the numbers is taken as the
    heading if it names every column.

    Raises:
        ColumnsError: if the file cannot be read, is ambiguous, or its lines have different numbers of columns.
    """
    lines, above = _without_comments(_text(path).translate(ALIKE))
    if not lines:
        raise ColumnsError("not a text file with rows of numbers")
    separator = _separator([text for _, text in lines])
    rows = [(number, _cells(text, separator)) for number, text in lines]
    if all(len(cells) > 1 and not cells[-1] for _, cells in rows[HEADINGS:]):  # a separator at the end of each line
        rows = [(number, cells[:-1] if not cells[-1] else cells) for number, cells in rows]
    first = next((place for place, cell in enumerate(rows[-1][1]) if NUMBER.fullmatch(cell)), 0)
    headings: list[list[str]] = []
    while len(headings) <= HEADINGS and rows and not NUMBER.fullmatch("".join(rows[0][1][first : first + 1])):
        headings.append(rows.pop(0)[1])
    if len(headings) > HEADINGS or not rows:
        raise ColumnsError(f"line {lines[len(headings) - 1][0]} holds no numbers: {lines[len(headings) - 1][1][:40]}")
    width = len(rows[0][1])
    for number, cells in rows:
        if len(cells) != width:
            text = " ".join(cells)[:40]
            raise ColumnsError(f"line {number} has {len(cells)} columns but the first line has {width}: {text}")
    units = headings.pop() if len(headings) > 1 and all(map(_is_unit, headings[-1])) else []
    names = headings.pop() if headings else _cells(above, separator)
    if len(headings) > 1:
        raise ColumnsError(f"line 2 holds no numbers: {lines[1][1][:40]}")
    if separator is COMMAS and len(lines) > len(rows) and width >= 2 * len(names):
        raise ColumnsError(
            f"has {len(names)} names for {width} columns: commas are used both as separators and as decimal signs; "
            "separate numbers with semicolons"
        )
    if len(lines) > len(rows) and len(names) != width and any(map(_unit, names)):
        raise ColumnsError(
            f"has {len(names)} names for {width} columns; give one name per column, or start the heading with #"
        )
    _check_decimals(rows, separator, any(names))
    names = [name[:LONGEST_NAME] for name in names] if len(names) == width else [""] * width
    units = units if len(units) == width else [""] * width
    return [
        Column(
            place + 1,
            names[place],
            _unit(names[place]) or units[place].strip("()[]"),
            tuple((number, cells[place]) for number, cells in rows),
        )
        for place in range(width)
    ]


def _text(path: Path) -> str:
    try:
        content = read_bytes(path, regular=True)
    except FileNotFoundError:
        raise ColumnsError("no such file beside the case") from None
    except OSError as error:
        raise ColumnsError(f"cannot be read: {error.strerror}") from None
    except DocumentError as error:
        raise ColumnsError(str(error)) from None
    for mark, kind in OTHERS.items():
        if content.startswith(mark):
            raise ColumnsError(f"this is {kind}, not a text file; save its columns as CSV")
    coding = next((coding for mark, coding in MARKS.items() if content.startswith(mark)), "utf-8")
    if coding == "utf-8" and b"\0" in content[:2]:
        coding = "utf-16-be" if content[0] == 0 else "utf-16-le"
    try:
        text = content.decode(coding)
    except UnicodeDecodeError:
        text = content.decode("latin-1")  # a name or a degree sign in an older encoding
    if any(c < " " and not c.isspace() for c in text):
        raise ColumnsError("not a text file")
    return text


def _without_comments(text: str) -> tuple[list[tuple[int, str]], str]:
    """The remaining lines with their line numbers, and the last comment before the first of them."""
    found: list[tuple[int, str]] = []
    above = ""
    for number, line in enumerate(text.splitlines(), 1):
        if mark := COMMENT.match(line):
            above = above if found else line[mark.end() :]
        elif rest := BEHIND.sub("", line).strip():
            # An empty first cell above an index column counts as a cell.
            found.append((number, f"\t{rest}" if line.startswith("\t") else rest))
    return found, above.strip()


def _separator(lines: list[str]) -> re.Pattern[str]:
    """The separator of a line."""
    body = [_hidden(line) for line in (lines[2:] or lines)]
    joined = "\n".join(body)
    if all(";" in line for line in body):
        return re.compile(r"\s*;\s*")
    if all("\t" in line for line in body) and not all(re.search(r",\s*\t", line) for line in body):
        return re.compile(r" *\t *")
    if "," not in joined:
        return SPACES
    points = re.search(r"\d\.|\.\d", joined)
    glued = re.search(r"\d,\d", joined)
    apart = all(re.search(r"[^\s,]\s+[^\s,]", line) for line in body)
    if points and glued and apart:
        raise ColumnsError("has both commas and spaces between numbers; use one separator")
    if points:
        return EITHER
    if glued and all(re.search(r"\S\s+\S", line) for line in body):
        return NOT_WITHIN_NUMBERS
    return COMMAS if glued else EITHER


def _hidden(line: str) -> str:
    """A line with its quoted separators masked."""
    return QUOTED.sub(lambda found: (found[1] or found[2] or "").translate(_HIDE), line)


def _cells(line: str, separator: re.Pattern[str]) -> list[str]:
    line = _hidden(line)
    if separator in (SPACES, EITHER, NOT_WITHIN_NUMBERS):
        line = re.sub(r"\s+(?=[(\[])", HIDDEN[" "], line.strip())  # the space before a unit
    return [cell.translate(_SHOW).strip() for cell in separator.split(line)]


def _check_decimals(rows: list[tuple[int, list[str]]], separator: re.Pattern[str], named: bool) -> None:
    """Raise an error if commas may be either decimal signs or separators."""
    if separator is COMMAS:
        fraction = next((cell for _, cells in rows for cell in cells if re.fullmatch(r"0\d+", cell)), None)
        if fraction:
            raise ColumnsError(
                f'has "{fraction}" between commas, which looks like decimals; separate the numbers with semicolons, '
                "or use decimal points"
            )
        width = len(rows[0][1])
        whole = all(cell.lstrip("+-").isdigit() for _, cells in rows for cell in cells)
        if whole and not named and width > 2 and width % 2 == 0:
            raise ColumnsError(
                f"has only whole numbers between commas, in {width} columns; they may be decimals: separate the "
                "numbers with semicolons, or add a heading with column names"
            )
    found = {
        mark: next(((number, cell) for number, cells in rows for cell in cells if _has(mark, cell)), None)
        for mark in ",."
    }
    if found[","] and found["."]:
        number, cell = found[","]
        raise ColumnsError(f"line {number} has {cell}, line {found['.'][0]} has {found['.'][1]}: use one decimal sign")


def _has(mark: str, cell: str) -> bool:
    return mark in cell and NUMBER.fullmatch(cell) is not None


def _value(cell: str) -> float:
    return float(cell.replace(",", ".").lower().replace("d", "e"))


def _unit(name: str) -> str:
    found = UNIT.search(name)
    return (found[1] or found[2] or "").strip() if found else ""


def _is_unit(cell: str) -> bool:
    """Whether a cell may belong to a row of units."""
    return not cell or bool(re.fullmatch(r"[(\[].*[)\]]", cell)) or plain(cell) in UNITS
