"""What a fluid model is: the arrays that it stores, what can be asked of it, and what the march runs.

Everything outside `taichiflap.fluids` works with these three alone:

- `Output`: one array that a model stores. The march makes room for it, the file lays it out, readers find it.
- `Model`: the model without a state. It answers what depends on the model: its outputs, its cost, its words.
- `Flow`: a batch of cases in motion: arrays, and functions of Taichi that the march fuses into one kernel.
"""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ValidationError, create_model

from ..case.case import Case, CaseError
from ..case.messages import describe
from ..case.schema import Section
from ..results.variables import VARIABLES, WAKE_VARIABLES, Variable
from ..structure.beam import Modes

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Output:
    """One array that a model stores.

    Without an axis of its own it is a series, a number at every step; with one it is a field, stored in the frames
    that `output.every` asks for. In a kernel a field is `batch.output.NAME`, with a slash as an underscore, and the
    series are the columns of `batch.output.series`, in the order in which the model declares them.

    Attributes:
        name: in the file and of the result. That of a ragged output is `GROUP/NAME`; `batch.output.GROUP_count` counts
            the entries of each frame, which all outputs of a group share.
        over: the axes besides time: `node`, `panel`, or others that the model's `axes` gives; of a ragged output the
            one along which its frames differ in length.
        units, long_name, symbol, comment: what the file says of it, see `taichiflap.results.variables`.
        dtype: `f8`, `f4` or `i4` of a field; series are `f8`.
        ragged: whether frames differ in length.
    """

    name: str
    over: tuple[str, ...]
    units: str
    long_name: str
    symbol: str = ""
    comment: str = ""
    dtype: str = "f8"
    ragged: bool = False

    @property
    def field(self) -> bool:
        """Whether it is stored in frames instead of at every step."""
        return bool(self.over)

    @property
    def member(self) -> str:
        """Its name in a kernel."""
        return self.name.replace("/", "_")

    @property
    def group(self) -> str:
        """The group of a ragged output, else nothing."""
        return self.name.partition("/")[0] if self.ragged else ""

    @property
    def variable(self) -> Variable:
        """What a file says of it."""
        over = self.over if self.ragged else ("time", *self.over)
        words = self.units, self.long_name, self.symbol, self.comment
        return Variable(over, *words, self.dtype, self.field and not self.ragged)


def standard(*names: str) -> tuple[Output, ...]:
    """Outputs that several models have, by their names in `taichiflap.results.variables`."""
    known = VARIABLES | {f"wake/{name}": one for name, one in WAKE_VARIABLES.items()}
    return tuple(
        Output(
            name, tuple(axis for axis in one.dimensions if axis != "time"), one.units, one.long_name, one.symbol,
            one.comment, one.dtype, ragged="/" in name,
        )
        for name, one in ((name, known[name]) for name in names)
    )  # fmt: skip


WAKE = standard("wake/y", "wake/z", "wake/circulation", "wake/birth")
"""The vortices of a free wake, oldest first."""


@dataclass(frozen=True)
class Axis:
    """An axis of a model's own: where its entries stand, and what that means."""

    values: ArrayLike
    units: str
    long_name: str
    symbol: str = ""


@dataclass(frozen=True)
class Refinement:
    """A key of the case file that a study of convergence doubles.

    Attributes:
        key: such as `uvlm.panels`.
        value: where the case has it.
        per_step: for a key that counts what the steps leave behind: how much a step leaves at most. It is refined with
            the time step, so that it reaches as far back, and never beyond what the whole run leaves.
    """

    key: str
    value: int
    per_step: int = 0


Velocity = Callable[[Array], Array]
"""Velocity of the fluid (m/s, along Y and Z) at points (Y and Z, m), both of shape (2, ...)."""


@dataclass(frozen=True)
class Flow:
    """A batch of cases in motion. The march fuses the functions into one kernel that takes many steps.

    The functions are `ti.func`s of a module, so that equal batches share a kernel. `batch` has the groups by name,
    besides `body` (`taichiflap.march.state`) and `output`, the rows of the outputs.

    Attributes:
        groups: the groups of arrays, each an argpack with a leading case axis. They are the state of the flow.
        types: their argpack types, by the same names.
        prepare: `prepare(batch, b, n, rule)` fills `body.load` and `body.response`, which come zeroed, for step `n`.
        settle: `settle(batch, b, n, rule)`, with the acceleration known, advances the state and sets `body.force`.
        record: `record(batch, b, frame)` writes the fields: `batch.output.NAME[b, frame, ...]`.
        record_step: `record_step(batch, b, row)` writes the series: `batch.output.series[b, row, k]`; None without any.
        uses: what some case of the batch needs, the last argument of `prepare` and `settle` if it is not None, so
            that by `ti.static` the kernel holds nothing else.
        before_step: called with each step from `first` on before the march takes it, to do on all threads what one
            case's thread would be long at.
        first: see `before_step`.
        passes: level of Taichi's passes over its kernels, see `taichiflap.kernels.runtime.passes`.
        reason: `reason(b, step)` says why case `b` of the batch stopped, and the cure, if the model knows; else
        nothing.
    """

    groups: Mapping[str, Any]
    types: Mapping[str, Any]
    prepare: Any
    settle: Any
    record: Any
    record_step: Any = None
    uses: Hashable = None
    before_step: Callable[[int], None] | None = None
    first: int = 0
    passes: int | None = None
    reason: Callable[[int, int], str] | None = None

    @property
    def kernel_key(self) -> Hashable:
        """What decides which kernel marches the batch."""
        functions = self.prepare, self.settle, self.record, self.record_step
        return tuple(self.types.items()), functions, self.uses


class Model:
    """A fluid model, without a state: derive from it, and override what differs.

    Attributes:
        name: in headings.
        outputs: the arrays that it stores; every model has `pressure_jump`.
        numbers: what the table `[numbers]` of the case file may say to a model of one's own, each key with its meaning,
            unit and range; None where it may say anything.
        elements: into how many elements along the chord it divides the wing, unless it has `nodes` of its own.
        draws_flow: whether `velocity` has an answer.
        sheds_behind: whether a wake leaves the trailing edge, so that a stream must not come to that edge first.
    """

    name: ClassVar[str]
    outputs: ClassVar[tuple[Output, ...]] = standard("pressure_jump")
    numbers: ClassVar[type[Section] | None] = None
    elements: ClassVar[int] = 50
    draws_flow: ClassVar[bool] = False
    sheds_behind: ClassVar[bool] = False

    def nodes(self, case: Case) -> Array:
        """Positions of the nodes along the chord, from the pivot, m: the ends of its `elements`, which are equal."""
        return case.wing.chord * (np.arange(self.elements + 1) / self.elements - case.wing.pivot)

    def flow(self, cases: Sequence[Case], sections: Sequence[Modes], body: Any, threads: int | None) -> Flow:
        """A batch at rest.

        Args:
            sections: the modes of each case's wing.
            body: the wings, see `taichiflap.march.state`.
            threads: how many threads may work at once; all of them if None.
        """
        raise NotImplementedError

    def work(self, case: Case, step: int) -> float:
        """Rough cost of a step, in pair interactions (about a nanosecond)."""
        return 50.0 * (len(self.nodes(case)) - 1)

    def settings(self, case: Case) -> list[str]:
        """Its settings in few words, for a line that describes a run: `50 panels`."""
        return []

    def problems(self, case: Case) -> list[str]:
        """What of a case the model cannot compute, one sentence each with the key, its value and the cure."""
        return []

    def completed(self, case: Case) -> Case:
        """The case with what the model chooses where the case leaves it open, such as how many frames a beat has."""
        return case

    def warnings(self, case: Case) -> list[str]:
        """What of a case the model is not good for, one sentence each."""
        return []

    def attached_in(self, case: Case) -> float | None:
        """Degrees of angle of attack beyond which the flow separates, of which the model knows nothing; else None."""
        return None

    def cures(self, case: Case) -> list[str]:
        """What of the model's own settings may help a case that diverged, the likeliest first."""
        return []

    def stride(self, case: Case) -> float:
        """Distance (m) that the trailing edge travels in an automatic time step: the mean length of a panel."""
        return case.wing.chord / (len(self.nodes(case)) - 1)

    def refinements(self, case: Case) -> list[Refinement]:
        """What a study of convergence refines besides the time step, the beats and the modes."""
        return []

    def velocity(self, result: Any, index: int) -> Velocity | None:
        """The flow of a frame of a result, for a picture of it; None where the model knows none.

        What it takes from the file it reads now: the function that it returns may be called by another thread.
        """
        return None

    def parameters(self, case: Case) -> Any:
        """The case's `numbers`, checked, with the defaults of the model's table for what it does not say.

        Raises:
            CaseError: with every problem found.
        """
        given: dict[str, Any] = dict(case.numbers or {})
        if self.numbers is None:
            return given
        # A map keeps all its values as doubles.
        for name, one in self.numbers.model_fields.items():
            if one.annotation is int and isinstance(given.get(name), float) and given[name].is_integer():
                given[name] = int(given[name])
        whole: Any = create_model("Numbers", __base__=Section, numbers=(self.numbers, ...))
        try:
            return whole(numbers=given).numbers
        except ValidationError as error:
            found = [describe(one, {"numbers": given}, whole) for one in error.errors(include_url=False)]
            raise CaseError(case.title or self.name, list(dict.fromkeys(found))) from None

    def outcome(self, case: Case, written: Callable[[str], Any]) -> list[str]:
        """What the model was not good for in a case that has been computed, one sentence each.

        Args:
            written: the values of a variable by its name.
        """
        return []

    def axes(self, case: Case) -> Mapping[str, Axis]:
        """The axes of its outputs that are neither `node` nor `panel`."""
        return {}

    def stored(self, case: Case) -> tuple[Output, ...]:
        """The outputs that a case stores."""
        return self.outputs

    def entries(self, case: Case, step: Any) -> Any:
        """How many entries a ragged output has at a step at most, or at each of an array of steps."""
        return 0

    def counters(self, case: Case, step: int) -> Mapping[str, tuple[ArrayLike, ArrayLike]]:
        """Least and greatest of those integers of its state that change, by `GROUP.NAME`, before a step.

        All others are what the case makes them. The state in a file is held to that before a march goes on from it.
        """
        return {}

    def sizes(self, case: Case) -> dict[str, int]:
        """Length of every axis of its outputs; of a ragged one the most that a frame can have."""
        nodes = len(self.nodes(case))
        own = {name: np.size(axis.values) for name, axis in self.axes(case).items()}
        ragged = {one.over[0]: int(self.entries(case, case.steps)) for one in self.outputs if one.ragged}
        return {"node": nodes, "panel": nodes - 1, "component": 2} | own | ragged

    def totals(self, case: Case) -> dict[str, int]:
        """Room along every ragged axis for all frames of a case."""
        axes = {one.over[0] for one in self.outputs if one.ragged}
        steps = case.step_of(np.arange(case.frames())) if axes else 0
        return {axis: int(np.sum(self.entries(case, steps), dtype=np.int64)) for axis in axes}

    def frame_bytes(self, case: Case) -> float:
        """Size of a frame of its fields."""
        lengths = self.sizes(case)
        shapes = [(one.dtype, [lengths[axis] for axis in one.over]) for one in self.outputs if one.field]
        return float(sum(np.dtype(kind).itemsize * np.prod(shape, dtype=float) for kind, shape in shapes))
