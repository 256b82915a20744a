"""All names that an external fluid model needs from this package."""

import functools
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..case.case import Case
from ..case.schema import CaseTable as Table
from ..case.schema import key
from ..kernels.arrays import array
from ..kernels.runtime import View, ti
from ..march.state import (
    ACCEL,
    AMPLITUDE,
    AXIAL,
    BETA,
    C0,
    C1,
    C2,
    COSINE,
    MOMENT,
    NORMAL,
    RATE,
    SINE,
    UNSTEADY,
    most_modes,
    pivot_heave,
    pivot_velocity,
    superpose,
)
from ..motion.sampling import PITCH, PITCH_ACCEL, PITCH_RATE, PLUNGE, PLUNGE_ACCEL, PLUNGE_RATE
from ..structure.beam import Modes
from ..structure.chordwise import Profile
from .distributions import add_loads, record_pressure, settle_loads
from .interface import WAKE, Axis, Flow, FlowField, Model, Output, Refinement, standard

__all__ = [
    "ACCEL", "AMPLITUDE", "AXIAL", "BETA", "C0", "C1", "C2", "COSINE", "MOMENT", "NORMAL", "PITCH", "PITCH_ACCEL",
    "PITCH_RATE", "PLUNGE", "PLUNGE_ACCEL", "PLUNGE_RATE", "RATE", "SINE", "UNSTEADY", "WAKE", "Axis", "Case", "Flow",
    "FlowField", "Model", "Modes", "Output", "Profile", "Refinement", "Table", "View", "add_loads", "flow_of", "key",
    "most_modes", "pivot_heave", "pivot_velocity", "record_pressure", "settle_loads", "stacked", "standard",
    "superpose", "ti",
]  # fmt: skip


def flow_of(prepare: Any, settle: Any, record: Any, record_step: Any = None, **arrays: np.ndarray) -> Flow:
    """Make a `Flow` whose arrays form one group, `flow`.

    Args:
        prepare, settle: `ti.func`s of `(body, flow, b, n, rule)`; see `Flow`.
        record: `ti.func` of `(flow, output, b, frame)`, for fields.
        record_step: `ti.func` of `(flow, output, b, row)`, for series.
        arrays: initial values, floats or integers, with a leading case axis.
    """
    kinds = tuple((name, values.dtype.kind, values.ndim) for name, values in arrays.items())
    group = _group(kinds)
    batch = group(**{name: array(values) for name, values in arrays.items()})
    return Flow({"flow": batch}, {"flow": group}, *_unpacked(prepare, settle, record, record_step))


def stacked(cases: Iterable[Mapping[str, ArrayLike]]) -> dict[str, np.ndarray]:
    """The arrays of a batch, for `flow_of`, from those of each case.

    Args:
        cases: arrays of each case by name. All cases have the same names and dimensions; shorter axes are padded with
            zeros, and no axis is empty.
    """
    every = list(cases)
    made = {}
    for name in every[0]:
        values = [np.asarray(arrays[name]) for arrays in every]
        longest = np.maximum(1, np.max([one.shape for one in values], axis=0))
        made[name] = np.zeros((len(every), *longest.astype(int)), np.result_type(*values))
        for row, one in zip(made[name], values, strict=True):
            row[tuple(map(slice, one.shape))] = one
    return made


@functools.cache
def _group(kinds: tuple[tuple[str, str, int], ...]) -> Any:
    return ti.types.argpack(
        **{name: ti.types.ndarray(ti.f64 if kind == "f" else ti.i32, ndim) for name, kind, ndim in kinds}
    )


@functools.cache
def _unpacked(prepare: Any, settle: Any, record: Any, record_step: Any) -> tuple[Any, ...]:
    """The functions with the arguments that the march passes."""

    @ti.func
    def prepare_batch(batch: View, b, n, rule):
        prepare(batch.body, batch.flow, b, n, rule)

    @ti.func
    def settle_batch(batch: View, b, n, rule):
        settle(batch.body, batch.flow, b, n, rule)

    @ti.func
    def record_batch(batch: View, b, frame):
        record(batch.flow, batch.output, b, frame)

    @ti.func
    def record_batch_step(batch: View, b, row):
        record_step(batch.flow, batch.output, b, row)

    return prepare_batch, settle_batch, record_batch, record_batch_step if record_step else None
