"""A result in memory: plain arrays with the structure of a result file."""

import functools
from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence
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

    It is computed, and put together of the blocks of a run, when something of it is read for the first time.

    Args:
        name: of the array in each of the blocks.
        kind: type of its numbers; None for that of the first block.
    """

    def __init__(self, blocks: Sequence[MutableMapping[str, Any]], name: str, kind: Any = None) -> None:
        self._blocks, self._name, self._kind = blocks, name, kind

    def __getstate__(self) -> dict[str, Any]:
        """For another process: its numbers, and not how they are computed."""
        return {"_blocks": [{self._name: self.values}], "_name": self._name, "_kind": None}

    @functools.cached_property
    def values(self) -> NDArray[Any]:
        """All of it, not to be changed."""
        parts = [block[self._name] for block in self._blocks]
        whole = np.concatenate(parts) if len(parts) > 1 else np.asarray(parts[0])
        whole = whole if self._kind is None else whole.astype(self._kind, copy=False)
        if len(parts) > 1:
            # The blocks keep no second copy.
            ends = np.cumsum([len(part) for part in parts])
            for block, own in zip(self._blocks, np.split(whole, ends[:-1]), strict=True):
                block[self._name] = own
        return whole

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
        self._arrays: dict[str, Array] = {}
        self._blocks: list[MutableMapping[str, Any]] = []

    def __getstate__(self) -> dict[str, Any]:
        """For another process: its arrays have the numbers of the blocks."""
        nodes, section, sample, contents = self._recipe
        return {**self.__dict__, "_blocks": [], "_recipe": (nodes, section, dict(sample), contents)}

    def lay_out(self, nodes: np.ndarray, section: Modes, sample: Sample, contents: Contents | None = None) -> None:
        """Know what is to come. Arguments as of `Recorder.lay_out`."""
        contents = contents or Contents()
        self._plan = layout.plan(sample, contents)
        self._recipe = nodes, section, sample, contents
        fixed = {name: values for name, (values, _) in layout.axes(nodes, section, contents).items()}
        fixed |= {f"modes/{name}": values for name, values in layout.modes(nodes, section).items()}
        self._arrays = {name: Array([fixed], name) for name in fixed}
        self._arrays |= {name: Array(self._blocks, name, self._kind(name)) for name in self.names}

    def append(self, variables: MutableMapping[str, Any]) -> None:
        """Keep a block, whose variables are read when they are asked for."""
        self._blocks.append(variables)
        self.steps += len(variables["time"])

    def written(self, name: str) -> np.ndarray:
        """All values of a variable with one value per step, at the end of a run."""
        return self._arrays[name].values

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
        return MemoryResult(self, Store(self._arrays), ending)

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
        return {name: self._everything[name] for name in names if name in self._everything}

    @functools.cached_property
    def _everything(self) -> dict[str, Any]:
        return self._recorded.said(self._ending)

    def save(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Write the result to a file, see `Result.save`."""
        if not len(self.file):
            raise ResultError(f"{path}: cannot be saved: the result in memory has been closed")
        self._recorded.write(Path(path), overwrite, self.file, self._ending)
