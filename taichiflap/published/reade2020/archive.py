"""Data of the report: one HDF5 file with one group per run.

It is separate from `taichiflap.results`, since it stores statistics and last beats of many runs.
"""

from pathlib import Path

import h5py
import numpy as np

from ... import files
from ..._version import __version__
from ...results.variables import VARIABLES
from .plan import Runs


def write(path: Path, runs: Runs, attributes: dict[str, float]) -> None:
    """Write every run: its case, the means and spreads over settled beats, and the last beat.

    Args:
        attributes: further attributes of the study, stored at the root.

    Raises:
        OutputError: if the file cannot be written.
    """
    with files.standing_in(path) as draft, h5py.File(draft, "w") as file:
        file.attrs.update({"source": f"taichiflap {__version__}", "title": "the paper reproduced", **attributes})
        for number, (key, run) in enumerate(runs.items()):
            group = file.create_group(f"{number:03d} {' '.join(key)}")
            group.attrs.update({"case": run.case.to_toml(), "beats": run.summary.beats})
            summary = vars(run.summary)
            for name, value in summary.items():
                if hasattr(value, "spread"):
                    group.attrs[name] = value.mean
                    group.attrs[f"{name}_spread"] = value.spread
                elif value is not None and not isinstance(value, dict):
                    group.attrs[name] = value
            time = group.create_dataset("turns", data=run.time)
            time.attrs.update({"units": "1", "long_name": "t/T within the last beat"})
            time.make_scale("turns")
            for name, values in run.beat.items():
                dataset = group.create_dataset(name, data=np.asarray(values))
                dataset.attrs.update({"units": VARIABLES[name].units, "long_name": VARIABLES[name].long_name})
                dataset.dims[0].attach_scale(time)
