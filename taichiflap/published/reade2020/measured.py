"""Stored data of a run: statistics, harmonics and the last beat."""

import contextlib
import math
import platform
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ... import fluids
from ...case.case import Case
from ...errors import UserError
from ...metrics.beats import settled_beats
from ...metrics.summary import Summary, summarise
from ...metrics.waves import harmonic
from ...results.reader import Result
from ...run.blocks import simulate

Array = NDArray[np.float64]
Progress = Callable[[float], None]
"""Callback of the fraction of the work done, 0 to 1."""

SERIES = (
    "tip_deflection",
    "force_normal",
    "force_normal_unsteady",
    "force_axial",
    "force_vertical",
    "force_vertical_normal",
    "power",
    "power_aerodynamic",
    "power_inertial",
)
"""Variables whose last beat is stored."""


class StudyError(UserError):
    """Raised if a case of the study failed."""


@dataclass(frozen=True)
class Measured:
    """A run in numbers, SI units.

    Attributes:
        case: what was run.
        summary: statistics over the settled beats.
        solve_time: time of marching, s, without compilation.
        time: t/T within the last beat, in (0, 1], shape (frames,).
        beat: the last beat of every name in `SERIES`, shape (frames,).
        first, third: complex amplitude of the first and third harmonic of each, over the settled beats.
    """

    case: Case
    summary: Summary
    solve_time: float
    time: Array
    beat: dict[str, Array]
    first: dict[str, complex]
    third: dict[str, complex]

    @property
    def quasi_steady(self) -> Array:
        """The last beat of the normal force without its share from acceleration, N."""
        return self.beat["force_normal"] - self.beat["force_normal_unsteady"]

    def phase(self, name: str, other: "Measured", own: complex | None = None) -> float:
        """Phase lead of the first harmonic over the other run's, degrees in (-180, 180]; `own` replaces this run's."""
        ratio = (self.first[name] if own is None else own) / other.first[name]
        return round(math.degrees(math.atan2(ratio.imag, ratio.real)), 9) + 0.0

    def third_share(self, name: str) -> float:
        """Amplitude of the third harmonic as a share of the first's."""
        return abs(self.third[name]) / abs(self.first[name])

    @property
    def first_quasi_steady(self) -> complex:
        """First harmonic of the normal force without its share from acceleration, N."""
        return self.first["force_normal"] - self.first["force_normal_unsteady"]


def measure(result: Result) -> Measured:
    """The numbers of a run.

    Raises:
        StudyError: if the run failed, or has no whole beat.
    """
    case, summary = result.case, summarise(result)
    if result.status != "complete" or summary is None:
        raise StudyError(f"{case.title}: {result.attributes.get('reason', 'no whole beat to measure')}")
    beats = settled_beats(result)
    frames, last = beats.frames, beats.last
    series = {name: getattr(result, name) for name in SERIES}
    turns = result.time / case.beat
    return Measured(
        case=case,
        summary=summary,
        solve_time=float(result.attributes["solve_time"]),
        time=turns[last] - round(turns[last][-1]) + 1.0,
        beat={name: values[last] for name, values in series.items()},
        first={name: harmonic(case, result.time[frames], values[frames]) for name, values in series.items()},
        third={name: harmonic(case, result.time[frames], values[frames], 3) for name, values in series.items()},
    )


def run(cases: Sequence[Case], progress: Progress | None = None, threads: int | None = None) -> list[Measured]:
    """Compute cases of one solver side by side and measure them.

    Raises:
        StudyError: if one of them failed.
    """
    tell = None if progress is None else lambda done, total: progress(done / total)
    results = simulate(cases, threads=threads, progress=tell)
    try:
        return [measure(result) for result in results]
    finally:
        for result in results:
            result.close()


def machine() -> str:
    """Name of the processor."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def work(cases: Sequence[Case]) -> float:
    """Approximate cost of computing cases, in pair interactions."""
    return sum(fluids.load(case.solver).work(case, case.steps // 2) * case.steps for case in cases)
