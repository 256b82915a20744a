"""Arrays for the outputs of a block of steps, and each case's share of them.

Each field of the fluid model is a Taichi array, `batch.output.NAME`, with shape (case, frame, ...). All series share
one array, `batch.output.series`, with shape (case, step, series) in the order in which the model declares them.
"""

import functools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..kernels.runtime import ti, view

KINDS = {"f8": "f64", "f4": "f32", "i4": "i32"}
"""Taichi's name of each data type."""


@functools.cache
def output_type(outputs: tuple[Any, ...]) -> Any:
    """The argpack of a model's outputs."""
    fields = [one for one in outputs if one.field]
    members = {
        one.member: ti.types.ndarray(dtype=getattr(ti, KINDS[one.dtype]), ndim=2 + len(one.over)) for one in fields
    }
    members |= {_counter(one.group): ti.types.ndarray(dtype=ti.i32, ndim=2) for one in fields if one.group}
    return ti.types.argpack(series=ti.types.ndarray(dtype=ti.f64, ndim=3), **members)


class Outputs:
    """Arrays for the outputs of a batch.

    Args:
        outputs: outputs of the model.
        sizes: length of every axis, for each case.
        steps, frames: number of rows of a series, and of a field.
    """

    def __init__(self, outputs: tuple[Any, ...], sizes: Sequence[Mapping[str, int]], steps: int, frames: int) -> None:
        self._outputs, self._sizes = outputs, sizes
        most = {axis: max(1, *(size[axis] for size in sizes)) for axis in sizes[0]}
        self._series = [one.name for one in outputs if not one.field]
        arrays = {"series": ti.ndarray(ti.f64, (len(sizes), steps, max(1, len(self._series))))}
        for one in outputs:
            if not one.field:
                continue
            shape = (len(sizes), frames, *(most[axis] for axis in one.over))
            arrays[one.member] = ti.ndarray(getattr(ti, KINDS[one.dtype]), shape)
            if one.group:
                arrays.setdefault(_counter(one.group), ti.ndarray(ti.i32, (len(sizes), frames)))
        self.pack = output_type(outputs)(**arrays)
        self._views = {name: view(values) for name, values in arrays.items()}

    def share(self, b: int, stored: Sequence[Any], steps: int, frames: int) -> dict[str, np.ndarray]:
        """Arrays of a case without the padding of the batch; ragged outputs are concatenated over frames.

        Args:
            stored: outputs that are stored.
            steps: number of filled rows of the series.
            frames: number of filled rows of the fields.
        """
        found = {}
        for one in stored:
            if not one.field:
                found[one.name] = self._views["series"][b, :steps, self._series.index(one.name)].copy()
                continue
            rows = self._views[one.member][b, :frames]
            if one.group:
                counts = self._views[_counter(one.group)][b, :frames]
                found[f"{one.group}/count"] = counts.copy()
                parts = [row[:count] for row, count in zip(rows, counts, strict=True)]
                found[one.name] = np.concatenate([rows[:0].ravel(), *parts])
            else:
                found[one.name] = rows[(slice(None), *(slice(self._sizes[b][axis]) for axis in one.over))].copy()
        return found


def _counter(group: str) -> str:
    return f"{group}_count"
