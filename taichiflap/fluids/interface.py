"""The interface of fluid models: stored arrays, properties of the model, and functions for the march.

All code outside `taichiflap.fluids` sees a model through these classes:

- `Output`: one array that a model stores. The march, the file layout and the readers all follow from it.
- `Axis`, `Refinement`, `FlowField`: the coordinate of an output, a setting for `converge`, the flow of a frame.
- `Model`: the model without a state: its outputs, cost, checks and texts.
- `Flow`: the state of a batch of cases: arrays, and Taichi functions that the march fuses into one kernel.
"""

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ValidationError, create_model

from ..case.case import Case, CaseError
from ..case.messages import describe
from ..case.schema import CaseTable
from ..results.variables import VARIABLES, WAKE_VARIABLES, Variable
from ..structure.beam import Modes

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Output:
    """One array that a model stores.

    An output without axes is a series, one number per step. An output with axes is a field, stored every `output.every`
    steps. In a kernel a field is `batch.output.NAME`, with slashes replaced by underscores. Series are the columns of
    `batch.output.series`, in the order of declaration.

    Attributes:
        name: in the file and the result. A ragged output is named `GROUP/NAME`; `batch.output.GROUP_count` holds the
            number of entries in each frame, shared by all outputs of the group.
        over: axes besides time: `node`, `panel`, or others from the model's `axes`. For a ragged output, the axis whose
            length differs between frames.
        units, long_name, symbol, comment: attributes in the file, see `taichiflap.results.variables`.
        dtype: `f8`, `f4` or `i4` for a field; series are `f8`.
        ragged: whether the length differs between frames.
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
        """Whether it is a field, stored in frames instead of at every step."""
        return bool(self.over)

    @property
    def member(self) -> str:
        """Its name in a kernel."""
        return self.name.replace("/", "_")

    @property
    def group(self) -> str:
        """Group of a ragged output; empty for others."""
        return self.name.partition("/")[0] if self.ragged else ""

    @property
    def variable(self) -> Variable:
        """Its description in a file."""
        over = self.over if self.ragged else ("time", *self.over)
        words = self.units, self.long_name, self.symbol, self.comment
        return Variable(over, *words, self.dtype, self.field and not self.ragged)


def standard(*names: str) -> tuple[Output, ...]:
    """Standard outputs, by their names in `taichiflap.results.variables`."""
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
    """An axis defined by a model: the positions of its entries, and their meaning."""

    values: ArrayLike
    units: str
    long_name: str
    symbol: str = ""


@dataclass(frozen=True)
class Refinement:
    """A key of the case file that `converge` doubles.

    Attributes:
        key: such as `uvlm.panels`.
        value: its value in the case.
        per_step: for a key that counts what steps produce, such as wake vortices: the maximum number per step. It is
            refined together with the time step, so that it covers the same time, up to the total of the run.
    """

    key: str
    value: int
    per_step: int = 0


Velocity = Callable[[Array], Array]
"""Velocity of the fluid (m/s, along Y and Z) at points (Y and Z, m), both of shape (2, ...)."""


Sampled = Callable[[Array], Array]
"""A scalar of the flow at points (Y and Z, m, shape (2, ...)), of shape (...)."""


@dataclass(frozen=True)
class FlowField:
    """The flow of one frame of a result, as functions of points in the inertial frame. Inside the section it is NaN.

    Attributes:
        velocity: m/s.
        vorticity: 1/s, positive counter-clockwise in (Y, Z); None where it is the curl of the velocity alone.
        streamfunction: psi, m2/s, the velocity being (d psi/dZ, -d psi/dY); None where the model has none.
    """

    velocity: Velocity
    vorticity: Sampled | None = None
    streamfunction: Sampled | None = None


@dataclass(frozen=True)
class Flow:
    """The state of a batch of cases, and its functions, which the march fuses into one kernel for many steps.

    The functions are module-level `ti.func`s, so that similar batches share a kernel. `batch` contains the groups by
    name, `body` (`taichiflap.march.state`) and `output`, the arrays of the outputs.

    Attributes:
        groups: the arrays of the flow's state, as argpacks with a leading case axis.
        types: argpack types of the groups.
        prepare: `prepare(batch, b, n, rule)` adds to `body.load` and `body.response`, which start at zero, for step
            `n`.
        settle: `settle(batch, b, n, rule)`, advances the state with the known acceleration and sets `body.force`.
        record: `record(batch, b, frame)` writes the fields: `batch.output.NAME[b, frame, ...]`.
        record_step: `record_step(batch, b, row)` writes the series: `batch.output.series[b, row, k]`; None if there are
            none.
        uses: features needed by any case of the batch. If not None, it is the last argument of `prepare` and `settle`,
            which can leave out unused code with `ti.static`.
        before_step: called before each step from `first` on, for work that uses all threads for one case.
        first: see `before_step`.
        passes: optimisation level of Taichi's compiler, see `taichiflap.kernels.runtime.passes`.
        reason: `reason(b, step)` returns why case `b` of the batch stopped, with a cure; empty if the model does not
            know.
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
        """Key of the compiled kernel that marches the batch."""
        functions = self.prepare, self.settle, self.record, self.record_step
        return tuple(self.types.items()), functions, self.uses


class Model:
    """Base class of fluid models, without a state. Override what differs from the defaults.

    Attributes:
        name: display name.
        outputs: stored arrays; every model has `pressure_jump`.
        numbers: class of the table `[numbers]` in the case file of an external model, each key with its description,
            unit and range; None accepts any keys.
        elements: number of equal elements along the chord, unless the model defines `nodes`.
        draws_flow: whether the model defines `velocity`.
        stores_vorticity: whether a result contains the vorticity of the fluid, which pictures then show.
        sheds_behind: whether the wake is shed from the trailing edge only; warns if the stream reaches that edge first.
    """

    name: ClassVar[str]
    outputs: ClassVar[tuple[Output, ...]] = standard("pressure_jump")
    numbers: ClassVar[type[CaseTable] | None] = None
    elements: ClassVar[int] = 50
    draws_flow: ClassVar[bool] = False
    stores_vorticity: ClassVar[bool] = False
    sheds_behind: ClassVar[bool] = False

    def nodes(self, case: Case) -> Array:
        """Positions of the nodes along the chord, from the pivot, m; by default the ends of equal `elements`."""
        return case.wing.chord * (np.arange(self.elements + 1) / self.elements - case.wing.pivot)

    def flow(self, cases: Sequence[Case], sections: Sequence[Modes], body: Any, threads: int | None) -> Flow:
        """The flow of a batch at rest.

        Args:
            sections: the modes of each case's wing.
            body: the wings, see `taichiflap.march.state`.
            threads: number of threads; None for all.
        """
        raise NotImplementedError

    def work(self, case: Case, step: int) -> float:
        """Approximate cost of a step, in pair interactions (about one nanosecond each)."""
        return 50.0 * (len(self.nodes(case)) - 1)

    def memory(self, case: Case) -> float:
        """Size of its state in a batch, bytes; by default that of ten frames of its fields."""
        return 10.0 * self.frame_bytes(case)

    def settings(self, case: Case) -> list[str]:
        """Its main settings, for the line that describes a run: `50 panels`."""
        return []

    def problems(self, case: Case) -> list[str]:
        """Reasons why the model cannot compute a case, one sentence each with the key, its value and the cure."""
        return []

    def completed(self, case: Case) -> Case:
        """The case with the model's own defaults filled in, such as the number of frames per beat."""
        return case

    def warnings(self, case: Case) -> list[str]:
        """Warnings about a case outside the model's range of validity, one sentence each."""
        return []

    def attached_in(self, case: Case) -> float | None:
        """Angle of attack (deg) above which the flow separates, for models of attached flow; else None."""
        return None

    def cures(self, case: Case) -> list[str]:
        """Model settings that may help a diverged case, most likely first."""
        return []

    def stride(self, case: Case) -> float:
        """Distance (m) that the trailing edge travels in an automatic time step: the mean length of a panel."""
        return case.wing.chord / (len(self.nodes(case)) - 1)

    def refinements(self, case: Case) -> list[Refinement]:
        """Keys that `converge` refines besides the time step, the beats and the modes."""
        return []

    def velocity(self, result: Any, index: int) -> Velocity | None:
        """Velocity field of a frame of a result, for pictures; None if the model has none.

        It reads the file before it returns, since the returned function may be called by another thread.
        """
        return None

    def field(self, result: Any, index: int) -> FlowField | None:
        """The flow field of a frame; None if the model has none. The file is read as for `velocity`."""
        velocity = self.velocity(result, index)
        return FlowField(velocity) if velocity else None

    def parameters(self, case: Case) -> Any:
        """The case's `numbers`, checked, with the defaults of the model's table.

        Raises:
            CaseError: with every problem found.
        """
        given: dict[str, Any] = dict(case.numbers or {})
        if self.numbers is None:
            return given
        # A map stores all values as doubles.
        for name, one in self.numbers.model_fields.items():
            if one.annotation is int and isinstance(given.get(name), float) and given[name].is_integer():
                given[name] = int(given[name])
        whole: Any = create_model("Numbers", __base__=CaseTable, numbers=(self.numbers, ...))
        try:
            return whole(numbers=given).numbers
        except ValidationError as error:
            found = [describe(one, {"numbers": given}, whole) for one in error.errors(include_url=False)]
            raise CaseError(case.title or self.name, list(dict.fromkeys(found))) from None

    def outcome(self, case: Case, written: Callable[[str], Any]) -> list[str]:
        """Warnings about a computed case, one sentence each.

        Args:
            written: returns the values of a variable by name.
        """
        return []

    def axes(self, case: Case) -> Mapping[str, Axis]:
        """Axes of its outputs other than `node` and `panel`."""
        return {}

    def stored(self, case: Case) -> tuple[Output, ...]:
        """Outputs that are stored for a case."""
        return self.outputs

    def entries(self, case: Case, step: Any) -> Any:
        """Maximum number of entries of a ragged output at a step, or at each of an array of steps."""
        return 0

    def counters(self, case: Case, step: int) -> Mapping[str, tuple[ArrayLike, ArrayLike]]:
        """Minimum and maximum of the changing integers of its state before a step, by `GROUP.NAME`.

        All other integers follow from the case. A state read from a file is checked against these bounds.
        """
        return {}

    def sizes(self, case: Case) -> dict[str, int]:
        """Length of every axis of its outputs; for a ragged axis the maximum over all frames."""
        nodes = len(self.nodes(case))
        own = {name: np.size(axis.values) for name, axis in self.axes(case).items()}
        ragged = {one.over[0]: int(self.entries(case, case.steps)) for one in self.outputs if one.ragged}
        return {"node": nodes, "panel": nodes - 1, "component": 2} | own | ragged

    def totals(self, case: Case) -> dict[str, int]:
        """Total length of every ragged axis over all frames of a case."""
        axes = {one.over[0] for one in self.outputs if one.ragged}
        steps = case.step_of(np.arange(case.frames())) if axes else 0
        return {axis: int(np.sum(self.entries(case, steps), dtype=np.int64)) for axis in axes}

    def frame_bytes(self, case: Case) -> float:
        """Size of a frame of its fields."""
        lengths = self.sizes(case)
        shapes = [(one.dtype, [lengths[axis] for axis in one.over]) for one in self.outputs if one.field]
        return float(sum(np.dtype(kind).itemsize * math.prod(shape) for kind, shape in shapes))
