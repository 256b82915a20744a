"""Warnings about motion tables: wrong units, gaps, and noise amplified by the added mass."""

import itertools
import math
from collections.abc import Iterator

import numpy as np

from ..case.case import Case
from ..case.tables import Points, Table, TablePitch
from ..motion import fourier, sampling
from ..motion.waveforms import Array, table

LONGER = 2.0
"""A table that lasts longer than this multiple of the run suggests a wrong unit of time."""
GAP = 0.3
"""Share of a period without points that gives a warning."""
SEAM = 2.5
"""The same at the ends of the period, in multiples of the longest interval between points."""
ROUGH = 2.5
"""A spline whose acceleration exceeds that of the points' low harmonics by this factor follows noise."""
ROUGH_RUN = 7.0
"""The same for a non-periodic table, relative to the means of `TOGETHER` points; a corner alone gives 5."""
TOGETHER = 3
LOW = 8
"""Number of low harmonics; at most a quarter of the number of points, or a third for few points."""
MOST_LOW, MOST_POINTS = 100, 4000
"""Maximum number of harmonics and points used."""
FAR = 50.0
"""Travel, in chords, beyond any real wing."""
LITTLE = 1.6
"""Pitch, in degrees, below which values may be radians."""
PLUNGING = 0.5
"""Travel, in chords, that is unlikely with so little pitch."""
COARSE = 0.1
"""Share of a table's range by which smoothing may move its points without a warning."""
FINE = 1024


def warnings(case: Case) -> Iterator[str]:
    """Warnings about a case's motion tables and its range of motion, one sentence each."""
    motion = case.motion
    moved = sampling.sample(motion, np.linspace(0.0, case.duration, FINE))
    reach = np.ptp(moved, axis=0) / case.wing.chord
    travelled = max(reach[sampling.PLUNGE], reach[sampling.SURGE])
    for name, travel in (("plunge", motion.plunge), ("pitch", motion.pitch), ("surge", motion.surge)):
        if isinstance(travel, Table):
            points: Points = travel.in_si(motion.frequency)["points"]
            for sentence in itertools.chain(_of_time(case, travel, points), _of_noise(travel, points)):
                yield f"motion.{name} is a table {sentence}"
            far = math.degrees(max(abs(value) for _, value in points))
            if isinstance(travel, TablePitch) and 0.0 < far < LITTLE and travelled > PLUNGING:
                yield (
                    f"motion.{name} stays below {far:.3g} deg while the wing travels {travelled:.2g} chords; "
                    'if its values are radians, give unit = "rad" with its file, or convert them'
                )
    for name, column in (("plunge", sampling.PLUNGE), ("surge", sampling.SURGE)):
        travel = getattr(motion, name)
        if reach[column] > FAR and (travel.repeats or isinstance(travel, Table)):
            yield (
                f"motion.{name} travels {reach[column]:.3g} chords; lengths are in m: "
                'if its values are millimetres, give unit = "mm" with its file, or convert them'
            )


def roughness(points: Points, frequency: float | None) -> tuple[float, int]:
    """Ratio of the acceleration of a spline through points to that of their low harmonics, and the number of harmonics.

    Args:
        points: times in periods with a frequency, else in s. Without a frequency the reference is a spline through the
            means of a few neighbours, and the number is 0.
    """
    times, values = np.array(points).T
    sharp = _accel(points, np.concatenate((times, 0.5 * (times[1:] + times[:-1]))), frequency is not None)
    if frequency is None:
        count = len(times) // TOGETHER
        if count < 2 * TOGETHER:
            return 1.0, 0
        grouped = np.stack((times, values))[:, : count * TOGETHER].reshape(2, count, TOGETHER).mean(axis=2)
        low = _accel(tuple(zip(*grouped.tolist(), strict=True)), grouped[0], False)
        return _ratio(sharp, low), 0
    some = points[:: math.ceil(len(points) / MOST_POINTS)]
    harmonics = max(1, min(max(LOW, len(some) // 4), len(some) // 3, MOST_LOW))
    low = table(np.arange(FINE) / FINE, points=some, frequency=1.0, smooth=harmonics)[:, 2]
    return _ratio(sharp, low), harmonics


def _accel(points: Points, times: Array, repeats: bool) -> Array:
    return table(times, points=points, frequency=1.0 if repeats else None)[:, 2]


def _ratio(sharp: Array, low: Array) -> float:
    most, least = float(np.abs(sharp).max()), float(np.abs(low).max())
    return most / least if least > 1e-9 * most else 1.0


def _of_time(case: Case, travel: Table, points: Points) -> Iterator[str]:
    times = [time for time, _ in points]
    if not travel.repeats:
        if times[-1] > LONGER * case.duration:
            yield (
                f"that lasts to {times[-1]:g} s, but the run ends at {case.duration:g} s; check that its times are in "
                f"seconds{_looks_like(case, travel, times)}"
            )
        return
    gaps = [late - early for early, late in itertools.pairwise(times)]
    seam = times[0] + 1.0 - times[-1]
    longest = max(gaps)
    if seam > GAP or seam > SEAM * longest:
        begin, end = times[-1], times[0] + 1.0
    elif longest > GAP:
        place = gaps.index(longest)
        begin, end = times[place], times[place + 1]
    else:
        return
    yield (
        f"without points between {begin:.3g} and {end:.3g} of the period, so that the curve there is a guess; add "
        "points, and check that its times are periods"
        + ("" if travel.clock == "periods" else f" or {travel.clock}, and motion.frequency")
    )


def _looks_like(case: Case, travel: Table, times: list[float]) -> str:
    last = travel.given[-1][0]
    if all(gap == 1.0 for gap in np.diff(times)):
        return "; they look like row numbers: set time_column"
    if travel.clock == "s" and 1.0 <= 1e-3 * last / case.duration < LONGER:
        return '; they look like ms: give time = "ms"'
    beats = last * case.beat / case.duration
    if travel.clock == "s" and case.periodic and 0.99 <= beats < LONGER:
        return '; they look like periods: give time = "periods"'
    return ""


def _of_noise(travel: Table, points: Points) -> Iterator[str]:
    values = [value for _, value in points]
    reach = max(values) - min(values)
    if reach == 0.0:
        yield f"whose values are all {travel.given[0][1]:g}; check its column"
    elif travel.smoothed:
        found = fourier.series(points, travel.smooth, travel.tolerance)
        count = len(found.terms)
        if travel.tolerance and found.residual > travel.tolerance:
            yield f"whose {count} harmonics, the most it can have, do not reach smooth_error; give smooth = {count}"
        elif found.residual > COARSE * reach:
            share = 100.0 * found.residual / reach
            yield f"whose {count} harmonics miss its points by {share:.2g} % of their range (rms); give a larger smooth"
        if found.blind:
            yield f"with a gap between points that is too long for {count} harmonics; give a smaller smooth"
    else:
        ratio, harmonics = roughness(points, 1.0 if travel.repeats else None)
        if harmonics and ratio > ROUGH:
            yield (
                f"whose spline has {ratio:.2g} times the acceleration of its first {harmonics} harmonics; its points "
                f"are noisy, rounded or too close: smooth them with smooth = {min(harmonics, LOW)}"
            )
        elif not harmonics and ratio > ROUGH_RUN:
            yield (
                f"whose spline has {ratio:.2g} times the acceleration of a smooth curve; its points are noisy, "
                "rounded or too close: smooth them beforehand"
            )
