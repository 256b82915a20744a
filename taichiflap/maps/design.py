"""The cases of a study: a grid of values, or a sample of ranges, over any keys of the case file."""

import json
import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case, read_value
from ..case.messages import holds_whole
from ..errors import UserError

EDGE = 0.02
"""Share of a range that counts as its end."""
MOST_CASES = 10_000_000
"""Maximum number of cases of a design; their metrics alone are gigabytes."""

Value = float | int | str


class DesignError(UserError):
    """Raised for an invalid design; one sentence with the option, the problem and the cure."""


@dataclass(frozen=True)
class Axis:
    """A key of the case file and its values; values other than numbers are text as for `--set`."""

    key: str
    values: tuple[Value, ...]

    @property
    def numeric(self) -> bool:
        """Whether the values are numbers, which can form the axis of a chart."""
        return not any(isinstance(value, str) for value in self.values)

    @property
    def order(self) -> NDArray[np.intp]:
        """Indices of the values in rising order, as a picture needs them; of text, as listed."""
        return np.argsort(self.values, kind="stable") if self.numeric else np.arange(len(self.values))


@dataclass(frozen=True)
class Design:
    """The cases of a study, numbered in C order.

    Attributes:
        axes: varied keys and their values.
        grid: if true, every combination of values; otherwise the first values together, the second values together, ...
    """

    axes: tuple[Axis, ...]
    grid: bool = True

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the map: one dimension per key for a grid, one dimension for a sample."""
        counts = tuple(len(axis.values) for axis in self.axes)
        return counts if self.grid else counts[:1]

    @property
    def size(self) -> int:
        """Number of cases."""
        return math.prod(self.shape)

    def point(self, number: int) -> dict[str, Value]:
        """Values of case `number`, by key."""
        places = np.unravel_index(number, self.shape)
        chosen = places if self.grid else [places[0]] * len(self.axes)
        return {axis.key: axis.values[int(i)] for axis, i in zip(self.axes, chosen, strict=True)}

    def settings(self, number: int) -> list[str]:
        """Settings that turn the base case into case `number`, as for `--set`."""
        return _settings(self.point(number))

    def case(self, base: Case, number: int, checked: dict[Any, Any] | None = None) -> Case:
        """Case `number`: the base case with its values.

        Args:
            checked: see `Case.changed`.

        Raises:
            CaseError: if the values are not compatible.
        """
        point = self.point(number)
        return _changed(base, point, ", ".join(_settings(point)), checked)

    def gathered(self, numbers: NDArray[np.intp], table: str) -> NDArray[np.intp]:
        """Numbers of cases in an order in which those of a grid that share the values of a table are together."""
        places = np.unravel_index(numbers, self.shape) if self.grid else ()
        its_own = [place for axis, place in zip(self.axes, places, strict=False) if axis.key.startswith(f"{table}.")]
        return numbers[np.lexsort(its_own)] if its_own else numbers

    def check(self, case: Case) -> None:
        """Check every key and the ends of its range before the first run.

        Raises:
            CaseError: for an unknown key, or a value that it cannot take.
        """
        for _ in self.examples(case):
            pass

    def examples(self, base: Case) -> Iterator[Case]:
        """Cases with each key in turn at the ends of its range, or at each of its non-numeric values.

        Raises:
            CaseError: for an unknown key, or a value that it cannot take.
        """
        first = {axis.key: axis.values[0] for axis in self.axes}
        for axis in self.axes:
            ends = (min(axis.values), max(axis.values)) if axis.numeric else dict.fromkeys(axis.values)
            for value in ends:
                yield _changed(base, {**first, axis.key: value}, "--vary")


def design(case: Case, vary: Mapping[str, Any], sample: str | None = None, seed: int = 0) -> Design:
    """The design that varies some keys of a case.

    Args:
        vary: for each key n values from a to b, `"a:b:n"` or `"a:b:n:log"`; or a list of values, `"v1,v2,..."`; or with
            `sample` a range, `"a:b"` or `"a:b:log"`. Integer keys get whole numbers.
        sample: `"sobol:N"` (scrambled, N a power of two) or `"lhs:N"`, a Latin hypercube; the full grid if None.
        seed: seed of the sample.

    Raises:
        DesignError: for an invalid range or list, or too many cases.
        CaseError: for an unknown key, or a value that it cannot take.
    """
    if not vary:
        raise DesignError("no key varies; give --vary KEY=a:b:n at least once")
    document = case.to_dict()
    specs = {key: Spread.read(key, spec, document) for key, spec in vary.items()}
    if sample is None:
        axes = tuple(Axis(key, spec.values()) for key, spec in specs.items())
    else:
        unit = _unit_points(sample, len(specs), seed)
        axes = tuple(Axis(key, spec.at(column)) for (key, spec), column in zip(specs.items(), unit.T, strict=True))
    made = Design(axes, grid=sample is None)
    if made.size > MOST_CASES:
        raise DesignError(f"--vary: {made.size:,} cases; the limit is {MOST_CASES:,} per design")
    made.check(case)
    return made


def read_vary(options: Sequence[str]) -> dict[str, str]:
    """`KEY=SPEC` options as a dictionary.

    Raises:
        DesignError: for an option without key or value, or a repeated key.
    """
    vary: dict[str, str] = {}
    for option in options:
        key, equals, spec = (part.strip() for part in option.partition("="))
        if not equals or not key or not spec:
            raise DesignError(f"--vary {option}: write KEY=a:b:n, KEY=a:b:n:log or KEY=v1,v2,...")
        if key in vary:
            raise DesignError(f"--vary {option}: {key} is given twice; give all its values in one option")
        vary[key] = spec
    return vary


@dataclass(frozen=True)
class Spread:
    """Specification of one key in `--vary`: a list of values, or a range to which `at` maps the unit interval."""

    label: str
    listed: tuple[Value, ...] = ()
    low: float = 0.0
    high: float = 0.0
    count: int = 0
    log: bool = False
    whole: bool = False

    @classmethod
    def read(cls, key: str, spec: Any, document: Mapping[str, Any]) -> "Spread":
        """Parse the specification of a key; `document` is the base case as nested dictionaries.

        Raises:
            DesignError: if it is invalid.
        """
        label = f"--vary {key}={spec}" if isinstance(spec, str) else f"vary {key}"
        held = _held(document, key)
        whole = holds_whole(key, document, Case)
        if isinstance(spec, str) and ":" in spec and not spec.startswith(("[", '"', "{")):
            return cls._range(label, spec.split(":"), whole)
        if isinstance(spec, str):
            values = _listed(label, spec)
        else:
            values = tuple(_plain(label, value) for value in (spec if np.iterable(spec) else [spec]))
        if not values:
            raise DesignError(f"{label}: no values; give v1,v2,... or a:b:n")
        if any(isinstance(value, str) for value in values):
            values = tuple(str(value) for value in values)
        elif isinstance(held, float) or any(isinstance(value, float) for value in values):
            values = tuple(float(value) for value in values)
        if len(set(values)) < len(values):
            raise DesignError(f"{label}: a value is repeated")
        return cls(label, listed=values)

    @classmethod
    def _range(cls, label: str, parts: list[str], whole: bool) -> "Spread":
        log = parts[-1].strip() == "log"
        numbers = parts[: len(parts) - log]
        try:
            low, high, *rest = (float(part) for part in numbers)
            count = int(numbers[2]) if rest else 0
        except ValueError:
            raise DesignError(f"{label}: write a:b:n or a:b:n:log with plain numbers and a whole number n") from None
        if len(rest) > 1 or not (math.isfinite(low) and math.isfinite(high)):
            raise DesignError(f"{label}: write a:b:n or a:b:n:log with finite numbers")
        if low == high:
            raise DesignError(f"{label}: the range is empty; give two different ends, or a single value")
        if rest and count < 2:
            raise DesignError(f"{label}: {count} values; give at least 2")
        if count > MOST_CASES:
            raise DesignError(f"{label}: {count:,} values; the limit is {MOST_CASES:,} cases per design")
        if log and min(low, high) <= 0:
            raise DesignError(f"{label}: both ends of a log range must be above zero")
        return cls(label, low=low, high=high, count=count, log=log, whole=whole)

    def values(self) -> tuple[Value, ...]:
        """Values along a grid."""
        if self.listed:
            return self.listed
        if not self.count:
            raise DesignError(f"{self.label}: the number of values is missing; write a:b:n, or add --sample sobol:256")
        space = np.geomspace if self.log else np.linspace
        values = self._typed(space(self.low, self.high, self.count))
        if len(set(values)) < len(values):
            raise DesignError(f"{self.label}: the range has fewer whole numbers than values")
        return values

    def at_edge(self, value: Value) -> bool:
        """Whether a value is at an end of the range; always false for a list."""
        if self.listed:
            return False
        scale = math.log if self.log else float
        low, here, high = (scale(float(one)) for one in (self.low, value, self.high))
        return min(abs(here - low), abs(high - here)) <= EDGE * abs(high - low)

    def at(self, unit: np.ndarray) -> tuple[Value, ...]:
        """Values at points of the unit interval, shape (points,)."""
        if self.listed:
            return tuple(self.listed[min(int(u * len(self.listed)), len(self.listed) - 1)] for u in unit)
        if self.count:
            raise DesignError(f"{self.label}: give only the range, a:b or a:b:log")
        if self.log:
            return self._typed(self.low * (self.high / self.low) ** unit)
        return self._typed(self.low + (self.high - self.low) * unit)

    def _typed(self, values: np.ndarray) -> tuple[Value, ...]:
        return tuple(int(v) for v in np.rint(values)) if self.whole else tuple(float(v) for v in values)


def _unit_points(sample: str, dimensions: int, seed: int) -> np.ndarray:
    """Points in the unit cube, shape (points, dimensions)."""
    from scipy.stats import qmc  # noqa: PLC0415 - half a second that a grid does without

    kind, _, text = sample.partition(":")
    count = int(text) if text.isdecimal() else 0
    if kind not in ("sobol", "lhs") or count < 1:
        raise DesignError(f"--sample {sample}: write sobol:N or lhs:N, for example sobol:256")
    if count > MOST_CASES:
        raise DesignError(f"--sample {sample}: the limit is {MOST_CASES:,} cases per design")
    if kind == "lhs":
        return qmc.LatinHypercube(dimensions, seed=seed).random(count)
    power = count.bit_length() - 1
    if count != 2**power:
        near = f"{2**power} or {2 ** (power + 1)}"
        raise DesignError(f"--sample {sample}: the number of Sobol points must be a power of two; use {near}")
    return qmc.Sobol(dimensions, seed=seed).random_base2(power)


def _settings(point: Mapping[str, Value]) -> list[str]:
    return [f"{key}={value}" for key, value in point.items()]


def _changed(base: Case, point: Mapping[str, Value], source: str, checked: dict[Any, Any] | None = None) -> Case:
    return base.changed({key: read_value(v) if isinstance(v, str) else v for key, v in point.items()}, source, checked)


def _held(document: Mapping[str, Any], key: str) -> Any:
    """Value of a dotted key in the base case, or None."""
    value: Any = document
    for name in key.split("."):
        value = value.get(name) if isinstance(value, Mapping) else None
    return value


def _listed(label: str, text: str) -> tuple[Value, ...]:
    try:
        values: list[Any] = tomllib.loads(f"values = [{text}]")["values"]
    except tomllib.TOMLDecodeError:
        try:
            values = [read_value(part.strip()) for part in text.split(",")]
        except ValueError as error:
            raise DesignError(f"{label}: {error}") from None
    return tuple(_plain(label, value) for value in values)


def _plain(label: str, value: Any) -> Value:
    """Numbers unchanged; other values as text that `--set` reads back."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool | str | list | tuple):
        return json.dumps(value) if not isinstance(value, str) or not _bare(value) else value
    if not isinstance(value, int | float) or not math.isfinite(value):
        raise DesignError(f"{label}: {value!r} is not a number, true, false, text or list")
    return value


def _bare(text: str) -> bool:
    try:
        return bool(read_value(text) == text)
    except ValueError:
        return False
