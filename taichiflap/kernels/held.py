"""Arrays whose shapes a kernel reads once.

At every access Taichi reads the array's shape from memory and computes the address anew, since for all that the
compiler knows a store to another array may have changed the shape. A shape in local variables cannot change, so that
the compiler computes the addresses of a loop before it.
"""

import collections
from collections.abc import Sequence
from typing import Any

from .runtime import ti


class HeldArray(tuple[Any, ...]):
    """An array within a kernel, and the lengths of its axes except the first, which are local variables."""

    __slots__ = ()

    def __new__(cls, array: Any, lengths: Sequence[Any]) -> "HeldArray":
        return super().__new__(cls, (array, lengths))

    @classmethod
    def of(cls, array: Any) -> "HeldArray":
        """An array with the shape that it has now; call it inside `ti.static`."""
        if isinstance(array, cls):
            return array
        return cls(array, [length(array, axis) for axis in range(1, len(array.shape))])

    def __getitem__(self, at: Any) -> Any:
        array, lengths = self
        place, *rest = at
        for length, index in zip(lengths, rest, strict=True):
            place = place * length + index
        # Behind zeros the last index is the whole offset.
        return ti.lang.impl.subscript(None, array, *[0] * len(rest), place)


def length(array: Any, axis: int) -> Any:
    """The length of an array's axis as a local variable; call it inside `ti.static`."""
    return ti.lang.impl.expr_init(array.shape[axis])


def held(group: Any, *alike: Sequence[str], **known: Sequence[Any]) -> Any:
    """A group of arrays within a kernel, some of them as `HeldArray`; call it inside `ti.static`.

    Args:
        alike: names of arrays of the same shape, which is read once for all of them.
        known: lengths of the axes of other arrays except the first.
    """
    arrays = {name: group[name] for name in group.keys}
    for names in alike:
        _, lengths = HeldArray.of(arrays[names[0]])
        known |= dict.fromkeys(names, lengths)
    arrays |= {name: HeldArray(arrays[name], lengths) for name, lengths in known.items()}
    # `ti.static` lets only tuples pass.
    return collections.namedtuple("Held", arrays)(**arrays)
