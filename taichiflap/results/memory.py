"""A result in memory: plain arrays with the structure of a result file."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..structure.beam import Modes
from . import layout
from .layout import Contents, Sample
from .reader import FIGURES, FORMAT, Result, ResultError
from .recorder import Recorder
from .variables import FIELD_TIME, VARIABLES, Variable, count_of
from .writer import Writer


class Array:
    """An array with the interface of HDF5 datasets: reading returns a copy."""

    def __init__(self, values: NDArray[Any]) -> None:
        self.values = values
        self.shape, self.dtype = values.shape, values.dtype

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, key: Any) -> NDArray[Any]:
        return np.array(self.values[key])


class Store(Mapping[str, Any]):
    """Arrays by name, with groups by the part of the name before a slash: the content of a file."""

    def __init__(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        self._arrays = {name: Array(values) for name, values in arrays.items()}
        self._groups: dict[str, dict[str, Array]] = {}
        for name, one in self._arrays.items():
            group, slash, member = name.partition("/")
            if slash:
                self._groups.setdefault(group, {})[member] = one

    def __getitem__(self, name: str) -> Any:
        return self._groups[name] if name in self._groups else self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter([*(name for name in self._arrays if "/" not in name), *self._groups])

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __contains__(self, name: object) -> bool:
        return name in self._arrays or name in self._groups

    def close(self) -> None:
        """Release all arrays."""
        self._arrays.clear()
        self._groups.clear()


class Memory(Recorder):
    """Records one result in memory."""

    def __init__(self, case: Case, warnings: list[str]) -> None:
        super().__init__(case, warnings)
        self._arrays: dict[str, NDArray[Any]] = {}

    def lay_out(self, nodes: np.ndarray, section: Modes, sample: Sample, contents: Contents | None = None) -> None:
        """Allocate all arrays. Same arguments as `Recorder.lay_out`."""
        contents = contents or Contents()
        self._plan = layout.plan(sample, contents)
        self._recipe = nodes, section, sample, contents
        for name, (values, _) in layout.axes(nodes, section, contents).items():
            self._arrays[name] = values
        for name, values in layout.modes(nodes, section).items():
            self._arrays[f"modes/{name}"] = values
        rows = layout.rows(self.case)
        for name in layout.times(self.case):
            self._arrays[name] = np.full(rows[name], np.nan)
        for name, one in self._plan.items():
            along = one.axes(self.case.output.every)[0]
            shape = (contents.room[along],) if "/" in name else (rows[along], *sample[name].shape[1:])
            self._arrays[name] = np.empty(shape, one.dtype)
        for group in layout.groups(self._plan):
            counted = count_of(group)
            length = rows[counted.axes(self.case.output.every)[0]]
            self._arrays[f"{group}/count"] = np.zeros(length, counted.dtype)

    def _filled(self, name: str) -> NDArray[Any]:
        """Recorded rows of a variable."""
        group, slash, member = name.partition("/")
        if slash and member != "count":
            return self._arrays[name][: self._entries.get(group, 0)]
        field = bool(slash) or name == FIELD_TIME or (name in self._plan and self._plan[name].field)
        return self._arrays[name][: self.case.frames(self.steps) if field else self.steps]

    def _put(self, name: str, first: int, values: np.ndarray) -> None:
        self._arrays[name][first : first + len(values)] = values

    def written(self, name: str) -> np.ndarray:
        """Recorded values of a variable with one value per step."""
        return self._arrays[name][: self.steps]

    def finish(
        self,
        status: str = "complete",
        figures: Mapping[str, float] | None = None,
        reason: str = "",
        warnings: Sequence[str] = (),
    ) -> Result:
        """The result, open for reading. Same arguments as `Recorder.finish`."""
        ending = {"status": status, "figures": dict(figures or {}), "reason": reason, "warnings": list(warnings)}
        ragged = {name: self._filled(name) for name in self._plan if "/" in name}
        return MemoryResult(self, Store(self._arrays | ragged), ending)

    @property
    def own(self) -> dict[str, Variable]:
        """Variables over time that only the fluid model defines."""
        every = self.case.output.every
        names = sorted(name for name in self._plan if name not in VARIABLES and "/" not in name)
        return {name: replace(self._plan[name], dimensions=self._plan[name].axes(every)) for name in names}

    def said(self, ending: Mapping[str, Any]) -> dict[str, Any]:
        """Attributes of the result at the end of the run."""
        about = {"warnings": "\n".join([*self._warnings, *ending["warnings"]])}
        about |= {name: ending[name] for name in ("status", "reason")}
        figures = dict.fromkeys(FIGURES, np.nan) | ending["figures"]
        return {**layout.words(self.case, self.began, self._recipe[3]), "taichiflap_format": FORMAT, **about, **figures}

    def write(self, path: Path, overwrite: bool, ending: Mapping[str, Any]) -> None:
        """Write the recorded data to a file.

        Raises:
            ResultError: when the file exists already, or cannot be written.
        """
        writer = Writer(self.case, path, self._warnings, overwrite)
        writer.began = self.began
        try:
            writer.lay_out(*self._recipe)
            writer.append({name: self._filled(name) for name in self.names})
            writer.finish(**ending).close()
        except BaseException:
            writer.abandon()
            raise


class MemoryResult(Result):
    """A result without a file. It has the same interface as one from a file; `save` writes it."""

    def __init__(self, recorded: Memory, arrays: Store, ending: Mapping[str, Any]) -> None:
        self._recorded, self._ending = recorded, ending
        super().__init__(arrays)

    @property
    def case(self) -> Case:
        """The case that was computed, overrides included."""
        return self._recorded.case

    @property
    def _own(self) -> dict[str, Variable]:
        return self._recorded.own

    def _said(self, names: Iterable[str]) -> dict[str, Any]:
        said = self._recorded.said(self._ending)
        return {name: said[name] for name in names if name in said}

    def save(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Write the result to a file, see `Result.save`."""
        if not len(self.file):
            raise ResultError(f"{path}: cannot be saved: the result in memory has been closed")
        self._recorded.write(Path(path), overwrite, self._ending)
