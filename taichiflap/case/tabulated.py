"""Tabulated motion: points are read from a text or CSV file into the case, which then needs no other file."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .columns import Column, ColumnsError, bare, column, plain, read_columns

POINTS = {"plunge": "points", "pitch": "points_deg", "surge": "points"}
"""Key that holds each motion's points."""
OF_FILE = ("file", "column", "time_column", "unit")
"""Keys that describe how a table is read from a file. After reading, the case holds the points instead."""
OF_ANGLES = ("file", "time_column", "stroke", "deviation", "rotation", "unit")
"""The same keys for measured angles."""
CALLED = {
    "stroke": ("stroke", "positional", "position", "phi", "φ", "ϕ", "sweep", "flap", "flapping"),
    "deviation": ("deviation", "elevation", "theta", "θ", "ϑ", "dev"),
    "rotation": ("rotation", "pitch", "alpha", "α", "feathering", "psi", "ψ", "attack", "angleofattack", "aoa", "rot"),
}
"""Recognised names of the columns of angles, to which `angle` may be added."""
TIMES = dict.fromkeys(("s", "sec", "secs", "second", "seconds"), "s")
TIMES |= dict.fromkeys(("ms", "msec", "millisecond", "milliseconds"), "ms")
TIMES |= dict.fromkeys(("-", "t/t", "period", "periods", "beat", "beats", "cycle", "cycles"), "periods")
LENGTHS = {
    prefix + name: factor
    for prefix, factor in (("", 1.0), ("centi", 1e-2), ("milli", 1e-3))
    for name in ("metre", "metres", "meter", "meters")
} | {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
ANGLES = {"deg": 1.0, "degree": 1.0, "degrees": 1.0, "°": 1.0}
ANGLES |= dict.fromkeys(("rad", "rads", "radian", "radians"), math.degrees(1.0))
FOREIGN = frozenset(
    plain(unit)
    for unit in (
        "ns", "us", "µs", "min", "h", "nm", "um", "µm", "dm", "km", "in", "inch", "ft", "mrad", "rev", "turns", "%",
        "frame", "frames", "hz", "m/s", "cm/s", "mm/s", "deg/s", "°/s", "rad/s",
    )
)  # fmt: skip
"""Units that are recognised but not supported."""
CALLED_TIME = ("t", "time", "times", "t/t", "zeit", "temps", "tiempo", "tempo")


class PointsError(ValueError):
    """Raised for a table file that cannot be used; one sentence with the key and the file."""


@dataclass(frozen=True)
class Origin:
    """Files of a case's motion tables, so that they are read again when a key changes.

    Attributes:
        folder: folder of relative names; None for a case from a result or map, which opens no file.
        tables: keys `OF_FILE` of each motion that names a file.
    """

    folder: Path | None = None
    tables: dict[str, dict[str, Any]] = field(default_factory=dict)


def with_points(document: Mapping[str, Any], folder: Path) -> tuple[dict[str, Any], Origin]:
    """The document with each motion's `file` replaced by its points, and the origin of the points.

    Args:
        folder: folder of relative names.

    Raises:
        PointsError: if a file is missing or invalid.
    """
    motion = document.get("motion")
    if not isinstance(motion, Mapping):
        return dict(document), Origin(folder)
    read, origins = {}, {}
    sheets: dict[str, list[Column]] = {}
    for name, key in (*POINTS.items(), ("measured", "angles_deg")):
        table = motion.get(name)
        if not isinstance(table, Mapping) or not (table.get("kind") == "table" or name == "measured"):
            continue
        given = {k: table[k] for k in of_file(name) if k in table}
        if not isinstance(table.get("file"), str):
            lonely = next((k for k in given if k != "file"), None)
            if lonely:
                raise PointsError(
                    f'motion.{name}.{lonely} = {_shown(given[lonely])}: no file is named; give file = "..."'
                )
            continue
        rest = {k: v for k, v in table.items() if k not in of_file(name)}
        if key in rest:
            raise PointsError(f"motion.{name}: has both {key} and file; give one of them")
        file = given["file"]
        try:
            if file not in sheets:
                sheets[file] = read_columns(folder / file)
            read[name] = rest | (_angles if name == "measured" else _points)(name, table, sheets[file])
        except ColumnsError as error:
            raise PointsError(f'motion.{name}.file = "{file}": {error}') from None
        origins[name] = given
    return {**document, "motion": {**motion, **read}}, Origin(folder, origins)


def reopened(motion: dict[str, Any], keys: Collection[str], origin: Origin) -> dict[str, Any]:
    """A motion whose points are read from their file again if one of the dotted `keys` changes how they are read.

    Args:
        motion: the table `[motion]` as a dictionary, including points.
    """
    opened = dict(motion)
    for name, given in origin.tables.items():
        if any(f"motion.{name}.{k}" in keys for k in of_file(name)) and isinstance(opened.get(name), dict):
            points = POINTS.get(name, "angles_deg")
            opened[name] = {k: v for k, v in opened[name].items() if k != points} | given
    return opened


def of_file(name: str) -> tuple[str, ...]:
    """Keys that describe how a motion or the measured angles are read from a file."""
    return OF_ANGLES if name == "measured" else OF_FILE


def _points(name: str, table: Mapping[str, Any], columns: list[Column]) -> dict[str, Any]:
    """Points of a motion, and the unit of their times if the file states one."""
    times = _time_column(table, columns)
    values = _value_column(name, table, columns, times)
    scales = ANGLES if name == "pitch" else LENGTHS
    scale = scales[_unit(values, table.get("unit"), scales, "an angle" if name == "pitch" else "a length")]
    found: dict[str, Any] = {
        POINTS[name]: [[time, scale * value] for time, value in zip(times.numbers(), values.numbers(), strict=True)]
    }
    periodic = table.get("periodic") is True
    unit = _clock(times) if "time" not in table else ""
    # "-" means a fraction of a beat in a periodic motion only.
    unstated = "" if periodic or plain(times.unit) != "-" else unit
    return found | ({"time": unit} if unit not in ("", "periods" if periodic else "s", unstated) else {})


def _angles(name: str, table: Mapping[str, Any], columns: list[Column]) -> dict[str, Any]:
    """Measured angles, and the unit of their times if the file states one."""
    times = _time_column(table, columns)
    chosen = _angle_columns(table, columns, times)
    found = [times.numbers()]
    for one in chosen:
        scale = ANGLES[_unit(one, table.get("unit"), ANGLES, "an angle")] if one else 0.0
        found.append([scale * value for value in one.numbers()] if one else [0.0] * len(found[0]))
    unit = _clock(times) if "time" not in table else ""
    return {"angles_deg": [list(row) for row in zip(*found, strict=True)]} | ({"time": unit} if unit else {})


def _angle_columns(table: Mapping[str, Any], columns: list[Column], times: Column) -> list[Column | None]:
    """The columns of stroke, deviation (None if absent) and rotation."""
    others = [one for one in columns if one is not times]
    named = {
        angle: [one for one in others if bare(one.name).removesuffix("angle") in names]
        for angle, names in CALLED.items()
    }
    order = dict(zip(CALLED if len(others) == len(CALLED) else ("stroke", "rotation"), others, strict=False))
    called = any(named.values())
    found: dict[str, Column | None] = {}
    for angle in CALLED:
        if angle in table:
            found[angle] = column(columns, _whole(angle, table[angle]))
        elif len(named[angle]) > 1:
            raise ColumnsError(
                f"several columns may be {angle}: {', '.join(map(str, named[angle]))}; give {angle} = a number or name"
            )
        elif called or len(others) > len(CALLED):
            found[angle] = named[angle][0] if named[angle] else None
        else:
            found[angle] = order.get(angle)
        if found[angle] is None and angle != "deviation":
            names = ", ".join(f"{one.number}: {one.name}" if one.name else str(one.number) for one in columns)
            raise ColumnsError(
                f"cannot tell which column is {angle}; its columns are {names}; give {angle} = a number or name"
            )
    chosen = [one.number for one in found.values() if one]
    if len({times.number, *chosen}) <= len(chosen):
        raise ColumnsError(
            "the same column is used twice: time "
            + ", ".join([str(times.number), *(f"{angle} {one.number}" for angle, one in found.items() if one)])
            + "; give the number or name of each"
        )
    return list(found.values())


def _clock(times: Column) -> str:
    """Unit of the times if the file states one, else empty."""
    stated = times.unit or times.name
    if plain(stated) in FOREIGN:
        raise ColumnsError(f"{times} has times in {stated}; give them in s, ms or periods")
    return TIMES.get(plain(stated), "")


def _time_column(table: Mapping[str, Any], columns: list[Column]) -> Column:
    given = table.get("time_column")
    if given is None:
        named = [one for one in columns if plain(one.name) in CALLED_TIME or bare(one.name) in CALLED_TIME]
        return named[0] if named else columns[0]
    return column(columns, _whole("time_column", given))


def _value_column(name: str, table: Mapping[str, Any], columns: list[Column], times: Column) -> Column:
    given = table.get("column")
    if given is not None:
        found = column(columns, _whole("column", given))
        if found is times:
            raise ColumnsError(f"{found} is the time; give the {name} column")
        return found
    others = [one for one in columns if one.number > times.number] or [one for one in columns if one is not times]
    if not others:
        raise ColumnsError(f"line {times.cells[0][0]} has only one column; two are needed")
    if bare(others[0].name) in POINTS and bare(others[0].name) != name:
        raise ColumnsError(f"{others[0]} is not the {name}; give the {name} column by number or name: column = ...")
    return others[0]


def _unit(values: Column, given: Any, scales: Mapping[str, float], kind: str) -> str:
    if given is not None:
        if plain(str(given)) not in scales:
            raise ColumnsError(f'unit = "{given}" is not {kind}; give {" or ".join(_usual(scales))}')
        return plain(str(given))
    unit = plain(values.unit)
    if unit in scales:
        return unit
    if unit in ANGLES or unit in LENGTHS or unit in FOREIGN or TIMES.get(unit) in ("s", "ms"):
        raise ColumnsError(
            f"{values} is in {values.unit}, which is not {kind} in a supported unit; give another column, or convert "
            "it to "
            f"{' or '.join(_usual(scales))} and say so by unit"
        )
    return "deg" if "deg" in scales else "m"


def _usual(scales: Mapping[str, float]) -> list[str]:
    return ["deg", "rad"] if "deg" in scales else ["m", "cm", "mm"]


def _whole(key: str, given: Any) -> int | str:
    """A column's number or name as given in the case file."""
    if isinstance(given, str) and given.strip():
        return given.strip()
    if isinstance(given, int) and not isinstance(given, bool) and given >= 1:
        return given
    raise ColumnsError(f"{key} = {_shown(given)}: must be a name or a whole number >= 1, e.g. 2")


def _shown(value: Any) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)
