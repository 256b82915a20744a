"""The numbers of a summary, each of several runs at once: single runs and studies have one implementation.

A column is a `Statistics`, a list with a number or None for each run, or None if it is defined for none of them. The
harmonics are a dictionary of lists.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..case.case import Case
from ..march.reference import Reference
from ..motion.stream import in_stream
from .beats import Beats, whole_beats
from .reduced import OF_BEATS, WAVING, Some, reduce
from .similarity import Similarity
from .statistic import Statistics
from .waves import after_reversal, phase

REPEATS_WITHIN = 0.01
"""A run is settled if the mean forces of its beats agree within this share of the root-mean-square force."""
FEWEST_BEATS = 3
"""Minimum number of settled beats for this test."""
FIRST_MODE = 0.25
"""Mean over the chord of the squared first mode of a clamped plate, with tip value 1."""
GRAVITY = 9.80665
"""Standard acceleration of gravity, m/s2."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Group:
    """Runs with the same steps, beats and variables.

    Attributes:
        members: their numbers.
        scales: their reference values.
        beats: the beats of which some are summarised.
        end: time of their last frame, s.
        numbers: see `reduced.reduce`.
    """

    members: list[int]
    cases: Sequence[Case]
    scales: Sequence[Reference]
    beats: Beats
    end: float
    numbers: dict[str, Array]

    def with_others(self, others: Sequence["Group"]) -> "Group":
        """All of them together."""
        every = [self, *others]
        members, cases, scales = ([one for of in every for one in getattr(of, name)] for name in EACH)
        joined = {name: np.concatenate([one.numbers[name] for one in every]) for name in self.numbers}
        return Group(members, cases, scales, self.beats, self.end, joined)

    def settling(self) -> Iterator["Group"]:
        """Groups of those that drop as many beats, whose values of these beats are left out."""
        dropped = self.numbers["dropped"]
        for count in dict.fromkeys(dropped.tolist()):
            rows = np.flatnonzero(dropped == count)
            numbers = {name: one[rows] for name, one in self.numbers.items()}
            numbers |= {name: numbers[name][..., count:] for name in ("of_beats", "squares")}
            members, cases, scales = ([getattr(self, name)[i] for i in rows.tolist()] for name in EACH)
            yield Group(members, cases, scales, self.beats.after(count), self.end, numbers)


EACH = "members", "cases", "scales"
"""What a group has of each run."""


def columns(parts: Iterable[Any], beats: Beats | None = None) -> Iterator[tuple[list[int], dict[str, Any]]]:
    """Columns by the names of the summary's attributes, for groups of runs; none for runs without a whole beat.

    Args:
        parts: runs, some at a time: objects with the attributes of a result that a summary reads, the variables of
            shape (runs, steps); with `cases` and `scales`, their reference values; and with `at`, which gives the same
            at some of the steps. Either all of a part are in a free stream or none, and likewise with something that
            moves.
        beats: beats to summarise; the settled beats of each if None.
    """
    groups: dict[Any, list[Group]] = {}
    first = 0
    for runs in parts:
        clocks: dict[tuple[float, float], list[int]] = {}
        for b, case in enumerate(runs.cases):
            clocks.setdefault((case.step, case.beat), []).append(b)
        for clock, members in clocks.items():
            time, numbers = runs.time[members[0]], [first + b for b in members]
            whole = whole_beats(runs.cases[members[0]], time) if beats is None else beats
            if not whole:
                yield numbers, {}
                continue
            some = Some(runs, members, whole)
            end = float(time[whole.frames.stop - 1])
            group = Group(numbers, some.cases, some.scales, whole, end, reduce(some, beats is None))
            groups.setdefault((*clock, len(time), *runs.variables), []).append(group)
        first += len(runs.cases)
    for one, *others in groups.values():
        for group in one.with_others(others).settling():
            yield group.members, _columns(group)


def _columns(runs: Group) -> dict[str, Any]:
    """Columns of runs that drop as many beats."""
    case, periodic, numbers = runs.cases[0], runs.cases[0].periodic, runs.numbers
    of_beats = dict(zip(OF_BEATS, np.moveaxis(numbers["of_beats"], 1, 0), strict=True))
    forces = of_beats["force_y"], of_beats["force_z"]
    if case.fluid.streams:
        along = [in_stream(*one) for one in zip(runs.cases, *forces, strict=True)]
        of_beats["lift"], of_beats["thrust"] = map(np.array, zip(*along, strict=True))
    found: dict[str, Any] = {"lift": None, "thrust": None, **Statistics.each(of_beats)}
    drifts, spreads = _unrest(np.stack(forces, axis=1), runs.beats.force_size(numbers["squares"]))
    few = len(runs.beats) < FEWEST_BEATS
    settled = [not few and max(one) <= REPEATS_WITHIN for one in zip(drifts, spreads, strict=True)]
    waves = dict(zip(WAVING, np.moveaxis(numbers["waves"], 1, 0).tolist(), strict=True)) if periodic else {}
    alike = [vars(Similarity.of(*one)) for one in zip(runs.cases, runs.scales, strict=True)]
    peak_times = numbers["tip_peak_time"].tolist()
    return {
        **found,
        **_coefficients(runs, found),
        **{name: [one[name] for one in alike] for name in alike[0]},
        "lift_over_weight": _over_weight(runs.cases, found["force_vertical"].mean.tolist()),
        "strouhal": _strouhal(runs) if "extent" in numbers else None,
        "beats": [len(runs.beats)] * len(runs.cases),
        "settled": settled if periodic else None,
        "force_drift": drifts,
        "force_spread": spreads,
        "force_normal_phase": _phases(runs, waves["force_normal"]) if waves else None,
        "tip_peak_time": [_fraction(one) for one in peak_times] if periodic else peak_times,
        "tip_peak_after_reversal": [after_reversal(*one) for one in zip(runs.cases, peak_times, strict=True)],
        "force_coefficient_peak": _force_coefficients(runs) if "steady" in numbers else None,
        "energy_residual": _listed(numbers, "energy_residual"),
        "wake_lost": _wake_lost(runs) if "wake_lost" in numbers else None,
        "wake_far_error": _listed(numbers, "wake_far_error"),
        "wake_crossings": _listed(numbers, "wake_crossings"),
        "harmonics": waves,
    }


def _listed(numbers: Mapping[str, Array], name: str) -> list[Any] | None:
    return numbers[name].tolist() if name in numbers else None


def _coefficients(runs: Group, found: Mapping[str, Any]) -> dict[str, Any]:
    """Coefficients and efficiency, with their reference values."""
    sizes, powers = (np.array([getattr(scale, name) for scale in runs.scales]) for name in ("force", "power"))
    lift, thrust, power = found["lift"] or found["force_vertical"], found["thrust"], found["power"]
    drag = thrust and Statistics(-thrust.mean, thrust.spread, thrust.error)
    forces = {"lift_coefficient": lift, "drag_coefficient": drag, "thrust_coefficient": thrust}
    coefficients = {name: one.over(sizes) if one and sizes.all() else None for name, one in forces.items()}
    speeds = [scale.speed for scale in runs.scales]
    each = zip(thrust.mean.tolist(), speeds, power.mean.tolist(), strict=True) if thrust else ()
    efficiencies = [pull * speed / spent if spent > 0.0 else None for pull, speed, spent in each]
    return {
        **coefficients,
        "power_coefficient": power.over(powers) if powers.all() else None,
        "propulsive_efficiency": efficiencies or None,
        "reference_speed": speeds,
        "reference_area": [scale.area for scale in runs.scales],
    }


def _over_weight(cases: Sequence[Case], lifts: Sequence[float]) -> list[float | None]:
    """See `Summary.lift_over_weight`."""
    bodies = zip((case.body for case in cases), lifts, strict=True)
    return [body.wings * lift / (body.mass * GRAVITY) if body.mass else None for body, lift in bodies]


def _strouhal(runs: Group) -> list[float | None]:
    """See `Summary.strouhal`."""
    each = zip(runs.cases, runs.numbers["extent"].tolist(), strict=True)
    return [case.motion.frequency * extent / math.hypot(*case.fluid.velocity) for case, extent in each]


def _force_coefficients(runs: Group) -> list[float | None]:
    """See `Summary.force_coefficient_peak`."""
    numbers, chords = runs.numbers, np.array([case.wing.chord for case in runs.cases])
    squares = numbers["speed"] ** 2 + numbers["turning"] * chords**2 / 12.0 + numbers["bending"] * FIRST_MODE
    areas = np.array([case.fluid.density * scale.area for case, scale in zip(runs.cases, runs.scales, strict=True)])
    each = zip(numbers["steady"].tolist(), (0.5 * areas * squares).tolist(), strict=True)
    return [steady / size if size else None for steady, size in each]


def _wake_lost(runs: Group) -> list[float]:
    """Velocity lost with the wake, relative to the speed of mid-chord through the fluid."""
    each = zip(runs.numbers["wake_lost"].tolist(), runs.numbers["speed"].tolist(), strict=True)
    return [lost / speed if speed else 0.0 for lost, speed in each]


def _unrest(forces: Array, sizes: Array) -> tuple[list[float], list[float]]:
    """Drift and spread of the mean forces of beats, shape (runs, 2, beats), relative to the `sizes` of the runs."""
    count = forces.shape[-1]
    if count < 2:
        return [0.0] * len(forces), [0.0] * len(forces)
    place = np.arange(count) - 0.5 * (count - 1)
    slopes = (forces * place).sum(axis=-1) / (place**2).sum()
    drifts = np.hypot(slopes[:, 0], slopes[:, 1]) * (count - 1)
    spreads = np.sqrt(np.var(forces, axis=-1).sum(axis=-1))
    drift, spread = (np.divide(one, sizes, out=np.zeros(len(sizes)), where=sizes > 0.0) for one in (drifts, spreads))
    return drift.tolist(), spread.tolist()


def _phases(runs: Group, waves: Sequence[Sequence[complex]]) -> list[float | None]:
    """See `Summary.force_normal_phase`."""
    return [phase(case, runs.end, wave[0]) for case, wave in zip(runs.cases, waves, strict=True)]


def _fraction(value: float) -> float:
    """`value` modulo 1, with round-off below 1 taken as zero."""
    rest = value % 1.0
    return 0.0 if math.isclose(rest, 1.0) else rest
