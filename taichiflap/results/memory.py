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
from .variables import VARIABLES, Variable, count_of
from .writer import Writer


class Array:
    """An array with the interface of HDF5 datasets: reading returns a copy.

    It is put together of the blocks that a run leaves when something of it is read for the first time.
    """

    def __init__(self, blocks: list[NDArray[Any]], kind: Any = None) -> None:
        self._blocks, self._kind = blocks, kind

    @property
    def values(self) -> NDArray[Any]:
        """All of it, not to be changed."""
        if len(self._blocks) > 1 or self._kind is not None:
            whole = np.concatenate(self._blocks) if len(self._blocks) > 1 else self._blocks[0]
            self._blocks[:] = [whole if self._kind is None else whole.astype(self._kind, copy=False)]
            self._kind = None
        return self._blocks[0]

    @property
    def shape(self) -> tuple[int, ...]:
        return self.values.shape

    @property
    def dtype(self) -> np.dtype[Any]:
        return self.values.dtype

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, key: Any) -> NDArray[Any]:
        return np.array(self.values[key])


class Store(Mapping[str, Any]):
    """Arrays by name, with groups by the part of the name before a slash: the content of a file."""

    def __init__(self, arrays: Mapping[str, Array]) -> None:
        self._arrays = dict(arrays)
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
        self._fixed: dict[str, Array] = {}
        self._blocks: dict[str, list[NDArray[Any]]] = {}

    def lay_out(self, nodes: np.ndarray, section: Modes, sample: Sample, contents: Contents | None = None) -> None:
        """Know what is to come. Arguments as of `Recorder.lay_out`."""
        contents = contents or Contents()
        self._plan = layout.plan(sample, contents)
        self._recipe = nodes, section, sample, contents
        fixed = {name: values for name, (values, _) in layout.axes(nodes, section, contents).items()}
        fixed |= {f"modes/{name}": values for name, values in layout.modes(nodes, section).items()}
        self._fixed = {name: Array([values]) for name, values in fixed.items()}
        self._blocks = {name: [] for name in self.names}

    def _put(self, name: str, first: int, values: np.ndarray) -> None:
        self._blocks[name].append(values)

    def written(self, name: str) -> np.ndarray:
        """Recorded values of a variable with one value per step."""
        blocks = self._blocks[name]
        blocks[:] = [np.concatenate(blocks)] if len(blocks) > 1 else blocks
        return blocks[0]

    def _kind(self, name: str) -> str:
        """Type of the numbers of what is appended, as a file has it."""
        if name in self._plan:
            return self._plan[name].dtype
        group, slash, _ = name.partition("/")
        return count_of(group).dtype if slash else "f8"

    def finish(
        self,
        status: str = "complete",
        figures: Mapping[str, float] | None = None,
        reason: str = "",
        warnings: Sequence[str] = (),
    ) -> Result:
        """The result, open for reading. Same arguments as `Recorder.finish`."""
        ending = {"status": status, "figures": dict(figures or {}), "reason": reason, "warnings": list(warnings)}
        found = {name: Array(blocks, self._kind(name)) for name, blocks in self._blocks.items()}
        return MemoryResult(self, Store(self._fixed | found), ending)

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

    def write(self, path: Path, overwrite: bool, arrays: Mapping[str, Any], ending: Mapping[str, Any]) -> None:
        """Write what was recorded, `arrays`, to a file.

        Raises:
            ResultError: when the file exists already, or cannot be written.
        """
        writer = Writer(self.case, path, self._warnings, overwrite)
        writer.began = self.began
        try:
            writer.lay_out(*self._recipe)
            writer.append({name: arrays[name].values for name in self.names})
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
        self._recorded.write(Path(path), overwrite, self.file, self._ending)
