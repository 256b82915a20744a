"""Where a run's variables go, block by block: what the result file and the result in memory have in common."""

import time
from collections.abc import Mapping, MutableMapping, Sequence
from typing import Any

import numpy as np

from ..case.case import Case
from ..structure.beam import Modes
from . import layout
from .checkpoint import Checkpoint
from .layout import Contents, Sample
from .reader import Result
from .variables import FIELD_TIME, Variable


class Recorder:
    """Records one result: construct, `lay_out`, `append` block by block, `finish`.

    Attributes:
        case: what is being computed.
        steps: how many steps are recorded.
        began: when the run began, in seconds since the epoch.
    """

    def __init__(self, case: Case, warnings: list[str]) -> None:
        self.case = case
        self.steps = 0
        self.began = time.time()
        self._warnings = warnings
        self._plan: dict[str, Variable] = {}
        self._entries: dict[str, int] = {}

    def lay_out(self, nodes: np.ndarray, section: Modes, sample: Sample, contents: Contents | None = None) -> None:
        """Give everything its place.

        Args:
            nodes: chordwise positions of the nodes, m.
            section: the wing's modes.
            sample: what `append` will get, of any number of frames, none included.
            contents: what the fluid model adds.
        """
        raise NotImplementedError

    @property
    def names(self) -> list[str]:
        """Names of what is appended: the times, the variables, and the counts of ragged groups."""
        groups = [f"{group}/count" for group in layout.groups(self._plan)]
        return [*layout.times(self.case), *self._plan, *groups]

    def append(self, variables: MutableMapping[str, Any]) -> None:
        """Add a block of steps, and of the frames among them."""
        frames = self.case.frames(self.steps)
        blocks: dict[str, tuple[int, np.ndarray]] = {}
        for name, one in self._plan.items():
            group = name.partition("/")[0]
            if group != name:
                blocks[name] = self._entries.get(group, 0), variables[name]
                blocks[f"{group}/count"] = frames, variables[f"{group}/count"]
            else:
                blocks[name] = frames if one.field else self.steps, variables[name]
        if FIELD_TIME in layout.times(self.case):
            blocks[FIELD_TIME] = frames, variables[FIELD_TIME]
        # Its time says that a step is whole, so nothing of it, or of its frame, may come later.
        blocks["time"] = self.steps, variables["time"]
        for name, (first, values) in blocks.items():
            self._put(name, first, values)
        self.steps += len(variables["time"])
        for group in layout.groups(self._plan):
            added = int(np.sum(variables[f"{group}/count"], dtype=np.int64))
            self._entries[group] = self._entries.get(group, 0) + added

    def _put(self, name: str, first: int, values: np.ndarray) -> None:
        """Record rows of a variable, from row `first` on."""
        raise NotImplementedError

    def written(self, name: str) -> np.ndarray:
        """What was appended of a variable of one value a step."""
        raise NotImplementedError

    @property
    def due(self) -> bool:
        """Whether it is time to `keep` the state of the run."""
        return False

    def keep(self, state: Checkpoint) -> None:
        """Store what a resumed run needs to go on from here."""

    def finish(
        self,
        status: str = "complete",
        figures: Mapping[str, float] | None = None,
        reason: str = "",
        warnings: Sequence[str] = (),
    ) -> Result:
        """End the record, and open it for reading.

        Args:
            status: `complete` or `failed`.
            figures: numbers of `reader.FIGURES`, by their names.
            reason: why the run failed.
            warnings: what makes its outcome implausible.
        """
        raise NotImplementedError

    def abandon(self) -> None:
        """End the record as it stands."""


class Recorded:
    """What a recorder was given, as a result gives it."""

    def __init__(self, recorder: Recorder) -> None:
        self.case = recorder.case
        self.variables = recorder.names
        self._recorder = recorder

    def __getattr__(self, name: str) -> Any:
        return self._recorder.written(name)
