"""A finished result written again with its large fields compressed.

While a run goes on, every field has its place in the file from the start, so that a crash leaves all frames readable.
Compressed frames have no place known in advance: they are written into a second file, which then takes the name of the
result.
"""

from pathlib import Path
from typing import Any

import h5py

from . import hdf, layout


def pack(source: Path, draft: Path, recipe: tuple[Any, ...], names: list[str], packed: list[str]) -> None:
    """Write a finished result to `draft` with some fields compressed.

    Args:
        source: the finished result.
        recipe: what `layout.Layout` needs besides the file.
        names: variables over time.
        packed: those of them to compress.

    Raises:
        OSError: if it cannot be written.
    """
    guard = hdf.Guarded(draft)
    try:
        with h5py.File(source, "r", locking=False) as whole, hdf.create(guard) as file:
            layout.Layout(file, *recipe, packed=packed)
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
