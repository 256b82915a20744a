"""A growing map of the points of a search, each computed only once."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from .. import disk
from .._version import __version__
from ..case.case import Case
from ..kernels.runtime import check_threads
from ..maps import file as maps
from ..maps.design import Axis, Design, Value
from ..maps.file import MapError
from ..maps.outcome import Outcome
from ..metrics.names import METRICS
from .sweep import Progress, fill

Point = tuple[Value, ...]


class Ledger:
    """Outcomes of all requested points; a file keeps them between runs.

    Args:
        case: the base case.
        first: first point to compute, by key; it defines the varied keys.
        metrics: metrics stored for every point.
        path: the map file; in memory if None. A file with the same case and keys is continued.
        cluster, threads: as in `sweep`.
        overwrite: replace a file of another study.

    Raises:
        MapError: if the file belongs to another study, or cannot be written.
    """

    def __init__(
        self,
        case: Case,
        first: Mapping[str, Value],
        metrics: Sequence[str],
        path: Path | None,
        *,
        cluster: str | None = None,
        threads: int | None = None,
        overwrite: bool = False,
    ) -> None:
        check_threads(threads)
        self.keys = tuple(first)
        self.cluster, self.threads = cluster, threads
        if path is not None and not disk.trouble(path) and path.exists() and not path.is_dir() and not overwrite:
            self.sheet = maps.open_map(path, write=True)
            self._check(case, metrics)
        else:
            design = Design(tuple(Axis(key, (value,)) for key, value in first.items()), grid=False)
            self.sheet = maps.create(path, case, design, {name: METRICS[name] for name in metrics})
        self.sheet.case = case  # it has the files of its tables, which a map lacks
        columns = [axis.values for axis in self.sheet.design.axes]
        self._numbers: dict[Point, int] = {point: i for i, point in enumerate(zip(*columns, strict=True))}
        self._found: dict[int, Outcome] = {}
        self._read(range(self.sheet.design.size))

    def __enter__(self) -> "Ledger":
        return self

    def __exit__(self, *_: object) -> None:
        self.sheet.close()

    def outcomes(self, points: Sequence[Point], progress: Progress | None = None) -> list[Outcome]:
        """Outcomes of some points, in the order of `keys`; new points are computed together.

        Raises:
            UserError: as in `sweep`.
        """
        new = [point for point in dict.fromkeys(points) if point not in self._numbers]
        if new:
            axes = [Axis(key, values) for key, values in zip(self.keys, zip(*new, strict=True), strict=True)]
            self._numbers.update(zip(new, self.sheet.extend(axes), strict=True))
        numbers = [self._numbers[point] for point in points]
        missing = [number for number in numbers if number not in self._found]
        if missing:
            fill(self.sheet, cluster=self.cluster, threads=self.threads, progress=progress)
            self._read(missing)
        return [self._found[number] for number in numbers]

    def _read(self, numbers: Sequence[int]) -> None:
        for number, outcome in zip(numbers, self.sheet.outcomes(numbers), strict=True):
            if outcome is not None:
                self._found[number] = outcome

    def _check(self, case: Case, metrics: Sequence[str]) -> None:
        sheet = self.sheet
        same = sheet.case.to_dict() == case.to_dict() and sheet.metrics == list(metrics)
        if sheet.design.grid or not same or tuple(axis.key for axis in sheet.design.axes) != self.keys:
            reason = "of another case, --set or keys"
        elif sheet.version != __version__:
            reason = f"of taichiflap {sheet.version}"
        else:
            return
        sheet.close()
        raise MapError(
            f"{sheet.path}: holds a study {reason}; name another file with -o, or use --overwrite to replace it"
        )
