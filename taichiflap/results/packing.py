"""A finished result written again with its large fields compressed.

While a run goes on, every field has its place in the file from the start, so that a crash leaves all frames readable.
Compressed frames have no place known in advance: they are written into a second file, which then takes the name of the
result.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

import h5py

from . import hdf


def pack(
    source: Path, draft: Path, lay_out: Callable[..., object], names: Sequence[str], packed: Sequence[str]
) -> None:
    """Write a finished result to `draft` with some fields compressed.

    Args:
        source: the finished result.
        lay_out: `layout.Layout` of the result; called with the file and `packed`.
        names: variables over time.
        packed: those of them to compress.

    Raises:
        OSError: if it cannot be written.
    """
    guard = hdf.Guarded(draft)
    try:
        with h5py.File(source, "r", locking=False) as whole, hdf.create(guard) as file:
            lay_out(file, packed=packed)
            for name in whole.attrs:
                file.attrs.create(name, whole.attrs[name], dtype=whole.attrs.get_id(name).dtype)
            for name in names:
                if name in packed:
                    for frame in range(len(whole[name])):
                        file[name][frame] = whole[name][frame]
                else:
                    file[name][...] = whole[name][...]
        guard.check()
    finally:
        guard.close()
