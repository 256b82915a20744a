"""A wing as strips: sections at several radii, marched side by side, and the sum of their forces and powers.

Every strip has the case's section with its own chord and share of the span, and moves according to its radius. Strips
do not interact: spanwise flow, the tip vortex, and bending and twist from root to tip are neglected.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import files
from ..case.case import Case
from ..case.travel import Travel
from ..errors import UserError
from ..metrics.beats import settled_beats
from ..metrics.unsettled import CURE
from ..notation import prefixed
from ..run.blocks import simulate

Array = NDArray[np.float64]
Planform = Sequence[tuple[float, float]]

SERIES = {"force_y": "N", "force_z": "N", "force_vertical": "N", "power": "W", "power_aerodynamic": "W"}
"""Summed series and their units."""
MOST = 200
LEFT_OUT = "interaction of strips: spanwise flow, tip vortex, bending from root to tip"


class StripsError(UserError):
    """Raised for a wing that cannot be divided into strips; one sentence with the cure."""


@dataclass(frozen=True)
class Strip:
    """One strip.

    Attributes:
        radius: distance of its middle from the hinge, m.
        chord: m.
        means: means of the series over the settled beats, by name.
        tip_peak: peak tip deflection, chords.
    """

    radius: float
    chord: float
    means: dict[str, float]
    tip_peak: float


@dataclass(frozen=True)
class Strips:
    """A wing's strips and their sum.

    Attributes:
        strips: strips from root to tip.
        time: times, s, shape (steps + 1,).
        total: sums over the strips, by name of the series, same shape.
        means: means of the sums over the last `beats` whole beats.
        power_positive: mean of the positive part of the summed power, W.
        beats: number of beats of the means, for which every strip has settled.
    """

    strips: tuple[Strip, ...]
    time: Array
    total: dict[str, Array]
    means: dict[str, float]
    power_positive: float
    beats: int

    def write(self, path: Path, overwrite: bool = False) -> None:
        """Write the time series of the sums as CSV.

        Raises:
            OutputError: if the file exists or cannot be written.
        """
        files.check(path, overwrite)
        columns = [("time (s)", self.time), *((f"{name} ({SERIES[name]})", one) for name, one in self.total.items())]
        with files.replacing(path) as file:
            file.write((",".join(name for name, _ in columns) + "\n").encode())
            for row in zip(*(map(repr, one.tolist()) for _, one in columns), strict=True):
                file.write((",".join(row) + "\n").encode())


def strips(
    case: Case,
    radii: int = 5,
    *,
    at: float | None = None,
    root: float = 0.0,
    planform: Planform = (),
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Strips:
    """Run the strips of a wing side by side, and sum them.

    Args:
        case: its `wing.span` is the distance from hinge to tip, and its chord that of the widest strip.
        radii: number of strips of equal width.
        at: share of the span at which plunge and surge are those of the case; they are proportional to the radius. Not
            for measured angles, which have their own radius.
        root: start of the wing as a share of the span.
        planform: chord relative to the case's chord, `(share of the span, factor)`, linear between; 1 everywhere if
            empty.
        threads, progress: as in `simulate`.

    Raises:
        StripsError: for a wing that cannot be divided into strips.
        CaseError: for an invalid strip.
    """
    cases, middles = sections(case, radii, at=at, root=root, planform=planform)
    results = simulate(cases, threads=threads, progress=progress)
    for middle, result in zip(middles, results, strict=True):
        if result.status == "failed":
            raise StripsError(f"the strip at {middle:.3g} m failed: {result.attributes['reason']}")
    beats = min((settled_beats(result) for result in results), key=len)
    if not beats:
        raise StripsError(f"no whole beat for the means; {CURE}")
    last = beats.frames
    total = {name: np.sum([getattr(result, name) for result in results], axis=0) for name in SERIES}
    found = tuple(
        Strip(
            middle,
            result.case.wing.chord,
            {name: float(np.mean(getattr(result, name)[last])) for name in SERIES},
            float(np.abs(result.tip_deflection[last]).max()) / result.case.wing.chord,
        )
        for middle, result in zip(middles, results, strict=True)
    )
    means = {name: float(np.mean(one[last])) for name, one in total.items()}
    positive = float(np.mean(np.maximum(total["power"][last], 0.0)))
    return Strips(found, results[0].time, total, means, positive, len(beats))


def sections(
    case: Case, radii: int, *, at: float | None = None, root: float = 0.0, planform: Planform = ()
) -> tuple[list[Case], list[float]]:
    """Case and mean radius (m) of every strip; see `strips`."""
    length = case.wing.span
    measured = case.motion.measured is not None
    if not isinstance(length, float):
        raise StripsError("wing.span is a table; strips need a number, the distance from hinge to tip")
    if not 1 <= radii <= MOST:
        raise StripsError(f"--radii {radii}: give 1 to {MOST}")
    if not 0.0 <= root < 1.0:
        raise StripsError(f"--root {root:g}: give a share of the span, from 0 to below 1")
    if not measured and at is None:
        raise StripsError("--at is missing: give the share of the span that moves as in the case, e.g. --at 0.6")
    if at is not None and (measured or not 0.0 < at <= 1.0):
        why = (
            "measured angles have their own radius; leave it out"
            if measured
            else "give a share of the span, above 0 and up to 1"
        )
        raise StripsError(f"--at {at:g}: {why}")
    places, factors = _checked(planform)
    edges = np.linspace(root, 1.0, radii + 1)
    middles = 0.5 * (edges[1:] + edges[:-1])
    case = case.resolved()
    found = []
    for middle in middles.tolist():
        chord = case.wing.chord * float(np.interp(middle, places, factors))
        found.append(_strip(case, middle, middle / at if at else 1.0, chord, (1.0 - root) / radii))
    return found, [middle * length for middle in middles.tolist()]


def _strip(case: Case, middle: float, further: float, chord: float, share: float) -> Case:
    wing = case.wing.model_dump(mode="json", exclude_none=True)
    wing |= {"chord": chord, "span": share * wing["span"]}
    for name in ("mass_per_length", "flexural_rigidity"):
        if name in wing:
            wing[name] = _times(wing[name], share)
    wing["point_masses"] = [[s, share * mass] for s, mass in wing["point_masses"]]
    values: dict[str, Any] = {"wing": wing, "output.every": case.steps}
    if case.motion.measured:
        values |= {"motion.measured": case.motion.measured.model_dump(mode="json", exclude_none=True)}
        values["motion.measured"].pop("radius_share", None)
        values["motion.measured"]["radius"] = middle * case.wing.span  # type: ignore[operator]
    else:
        values |= {f"motion.{name}": _further(getattr(case.motion, name), further) for name in ("plunge", "surge")}
    return case.changed(values, f"the strip at {middle:.3g} of the span")


def _further(travel: Travel, factor: float) -> dict[str, Any]:
    """A motion with all lengths multiplied by a factor."""
    keys = travel.model_dump(mode="json", exclude_none=True)
    for name in ("amplitude", "mean", "initial", "smooth_error"):
        if name in keys:
            keys[name] *= factor
    for name, place in (("harmonics", 1), ("points", 1)):
        if name in keys:
            keys[name] = [[*row[:place], factor * row[place], *row[place + 1 :]] for row in keys[name]]
    return keys


def _times(value: Any, factor: float) -> Any:
    return [[s, factor * one] for s, one in value] if isinstance(value, list) else factor * value


def _checked(planform: Planform) -> tuple[list[float], list[float]]:
    places, factors = [place for place, _ in planform] or [0.0], [factor for _, factor in planform] or [1.0]
    if sorted(set(places)) != places or min(places) < 0.0 or max(places) > 1.0 or min(factors) <= 0.0:
        raise StripsError("--planform: give SHARE:CHORD pairs with increasing shares from 0 to 1 and chords above 0")
    return places, factors


def read_planform(text: str) -> list[tuple[float, float]]:
    """`"0:0.6,0.5:1,1:0.3"` as pairs.

    Raises:
        StripsError: if it is invalid.
    """
    try:
        pairs = [tuple(map(float, pair.split(":"))) for pair in text.split(",") if pair.strip()]
        return [(place, factor) for place, factor in pairs]
    except ValueError:
        raise StripsError(f"--planform {text}: write SHARE:CHORD,SHARE:CHORD, e.g. 0:0.6,0.5:1,1:0.3") from None


def lines(found: Strips) -> list[str]:
    """Text summary of the strips and their sum."""
    length, metre = prefixed(found.strips[-1].radius, "m")
    factor, newton = prefixed(max(abs(found.means["force_y"]), abs(found.means["force_z"])), "N")
    power, watt = prefixed(found.means["power"], "W")
    names = (
        f"radius ({metre})",
        f"chord ({metre})",
        f"up ({newton})",
        f"to +Z ({newton})",
        f"power ({watt})",
        "tip (chords)",
    )
    rows = [
        (length * one.radius, length * one.chord, factor * one.means["force_vertical"], factor * one.means["force_z"],
         power * one.means["power"], one.tip_peak)
        for one in found.strips
    ]  # fmt: skip
    sums = found.means
    return [
        f"means over the last {found.beats} beats:",
        "  " + "".join(f"{name:<14}" for name in names).rstrip(),
        *("  " + "".join(f"{value:<14.4g}" for value in row).rstrip() for row in rows),
        f"  vertical force        {factor * sums['force_vertical']:.4g} {newton}, sum of {len(found.strips)} strips",
        f"  force along Z         {factor * sums['force_z']:.4g} {newton}",
        f"  mechanical power      {power * sums['power']:.4g} {watt}",
        f"    positive part alone {power * found.power_positive:.4g} {watt}",
        f"neglected: {LEFT_OUT}",
    ]
