"""Labels and display units of a map's keys and metrics in figures."""

from collections.abc import Sequence

import numpy as np

from .design import Axis
from .file import Map

SCALES = {
    "N": (1e3, "mN"),
    "W": (1e3, "mW"),
    "m": (1e3, "mm"),
    "N W-1": (1.0, "N/W"),
    "Pa": (1e-9, "GPa"),
    "1": (1.0, ""),
}
"""Display units: factor and name."""
LABELS = {
    "force_vertical_mean": "Mean vertical force",
    "lift_mean": "Mean lift",
    "thrust_mean": "Mean thrust",
    "propulsive_efficiency": "Propulsive efficiency",
    "power_mean": "Mean power",
    "lift_per_power": "Lift per power",
    "tip_peak_mean": "Peak tip deflection",
    "wing.youngs_modulus": "Young's modulus",
    "wing.thickness": "Thickness",
    "motion.frequency": "Flapping frequency",
    "motion.plunge.amplitude": "Plunge amplitude",
    "motion.pitch.amplitude_deg": "Pitch amplitude",
}


GROUPS = {
    "Harmonics": ("_harmonic",),
    "Coefficients": ("_coefficient", "reynolds", "strouhal", "reduced_frequency", "over_weight"),
    "Power": ("power", "efficiency", "energy"),
    "Forces": ("force", "lift", "thrust", "drag", "moment"),
    "Bending": ("tip_",),
}
"""Groups of metrics, and words in the names of their members; the first match counts."""
KEY, OTHER = "Key", "Other"


def group(name: str) -> str:
    """Group of a key or a metric."""
    if "." in name or name == "solver":
        return KEY
    return next((one for one, words in GROUPS.items() if any(word in name for word in words)), OTHER)


def grouped(names: Sequence[str], sheet: Map) -> dict[str, str]:
    """Keys and metrics by their menu label, "group: name (unit)", sorted by group."""
    order = (KEY, *reversed(GROUPS), OTHER)
    found = sorted(names, key=lambda name: order.index(group(name)))
    return {f"{group(name)}: {named(name, sheet)}": name for name in found}


def model(sheet: Map) -> str:
    """Fluid model of all cases of a map; empty if it varies."""
    return "" if any(axis.key == "solver" for axis in sheet.design.axes) else sheet.case.model


def named(name: str, sheet: Map) -> str:
    """Axis label of a key or a metric, with its unit."""
    units = sheet.units(name)
    unit = SCALES.get(units, (1.0, units))[1]
    return f"{label(name)} ({unit})" if unit else label(name)


def factor_of(sheet: Map, name: str) -> float:
    """Factor from SI to the display unit of a key or a metric."""
    return SCALES.get(sheet.units(name), (1.0, ""))[0]


def label(name: str) -> str:
    """Name of a key or a metric in words."""
    return LABELS.get(name, name if "." in name else name.replace("_", " "))


def is_log(axis: Axis) -> bool:
    """Whether values suit a logarithmic axis: evenly spaced in logarithm, or over more than a decade."""
    values = np.sort(np.array(axis.values, dtype=float))
    if values[0] <= 0:
        return False
    steps = np.diff(np.log(values))
    return values[-1] > 10 * values[0] or bool(len(steps) > 1 and np.ptp(steps) < 1e-6 * steps.max())
