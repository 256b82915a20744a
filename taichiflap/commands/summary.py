"""Text summary of a run, printed by `simulate` and `info`."""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from .. import fluids
from ..case.case import Case
from ..case.measured import Measured
from ..case.motion import HarmonicPlunge, Motion
from ..case.travel import Travel
from ..metrics.summary import Statistic, Summary, summarise
from ..metrics.uncertainty import FEWEST_BEATS
from ..metrics.unsettled import unsettled
from ..motion import fourier
from ..motion import measured as angles
from ..notation import prefixed, printable
from ..results.reader import Result
from ..scored import nearest
from ..structure.chordwise import Profile

LABEL = 24


def summary_lines(result: Result, said: Collection[str] = ()) -> Iterator[str]:
    """Lines that summarise a result, complete or partial.

    Args:
        said: warnings and reasons printed already.
    """
    return map(printable, _lines(result, said))


def _lines(result: Result, said: Collection[str]) -> Iterator[str]:
    case = result.case
    attributes = result.attributes
    yield case.title or "(no title)"
    status = "running or interrupted" if result.status == "running" else result.status
    yield _line("file", f"{result.path or 'in memory'}, {status}, {_extent(result)}")
    yield _line("model", _model(case))
    yield _line("wing", _wing(case, result))
    yield motion_line(case)
    failed = result.status == "failed"
    summary = None if failed else summarise(result)
    if summary:
        yield from _statistics(case, summary)
        yield _line("nearest scored case", attributes.get("nearest_scored") or nearest.sentence(case))
    elif failed:
        yield "the run failed: no statistics"
    elif case.periodic:
        none = "less than a beat" if result.status == "complete" else "no whole beat yet"
        yield f"{none}: no statistics"
    else:
        yield "not complete: no statistics"
    if "solve_time" in attributes:
        done = case.steps if result.status == "complete" else max(0, len(result.time) - 1)
        yield _line("solve time", f"{attributes['solve_time']:.3g} s for {done} steps")
    if summary and unsettled(summary):
        yield f"warning: {unsettled(summary)}"
    for warning in str(attributes["warnings"]).splitlines():
        if warning not in said:
            yield f"warning: {warning}"
    if "reason" in attributes and attributes["reason"] not in said:
        yield f"failed: {attributes['reason']}"


def _extent(result: Result) -> str:
    """Number of stored steps and frames."""
    if result.case.output.every == 1:
        return f"{result.frames} frames"
    return f"{result.steps} steps, fields in {result.frames} frames"


def motion_line(case: Case) -> str:
    """A line on the motion of the wing and the duration of the run."""
    return _line("motion", _motion(case))


def _statistics(case: Case, summary: Summary) -> Iterator[str]:
    if case.periodic:
        beats = f"{summary.beats} beat{'s' if summary.beats > 1 else ''}"
        known = "mean ± standard error"
        if summary.beats < FEWEST_BEATS:
            known = f"means; a standard error takes {FEWEST_BEATS} beats"
        yield f"over the last {beats} ({known}):"
    else:
        yield "over the whole run:"
    forces = [one for one in (summary.force_vertical, summary.force_normal_peak, summary.lift, summary.thrust) if one]
    force = _Unit.of("N", *forces)
    if summary.lift and summary.thrust:
        yield _line("lift across stream", force.shown(summary.lift))
        yield _line("thrust against stream", force.shown(summary.thrust))
    else:
        yield _line("vertical force", f"{force.shown(summary.force_vertical)}, full vector")
        yield _line("", f"{force.shown(summary.force_vertical_normal)}, wing-normal part alone")
    phase = summary.force_normal_phase
    lead = "" if phase is None else f", first harmonic at {phase:+.1f} deg to the stroke"
    yield _line("peak normal force", force.shown(summary.force_normal_peak) + lead)
    if summary.tip_peak.mean:
        after = summary.tip_peak_after_reversal
        if case.periodic:
            when = f"t/T = {summary.tip_peak_time:.3f}" + ("" if after is None else f", {after:.3f} T after reversal")
        else:
            when = f"t = {summary.tip_peak_time * case.beat:.4g} s"
        yield _line("peak tip deflection", f"{_Unit.of('m', summary.tip_peak).shown(summary.tip_peak)}, at {when}")
    power = _Unit.of("W", summary.power, summary.power_aerodynamic, summary.power_positive)
    yield _line("mechanical power", power.shown(summary.power))
    yield _line("  against the fluid", power.shown(summary.power_aerodynamic))
    yield _line("  positive part alone", power.shown(summary.power_positive))
    yield from _coefficients(case, summary)
    yield from _economy(case, summary)
    if summary.wake_lost:
        yield _line("wake left out", f"about {100 * summary.wake_lost:.2g} % of the wing's speed, and of the forces")
    if summary.wake_far_error is not None:
        yield _line("error of the far wake", f"{summary.wake_far_error:.2g} m/s at most, of eight vortices a step")
    if summary.wake_crossings:
        yield _line("wake-wing crossings", str(summary.wake_crossings))


def _line(label: str, text: Any) -> str:
    return f"  {label:<{LABEL - 2}}{text}"


@dataclass(frozen=True)
class _Unit:
    """Display unit of some values: the multiple of a unit that suits the largest, and the factor to it."""

    factor: float
    name: str

    @classmethod
    def of(cls, unit: str, *statistics: Statistic) -> "_Unit":
        return cls(*prefixed(max(abs(one.mean) for one in statistics), unit))

    def shown(self, statistic: Statistic) -> str:
        return f"{statistic.shown(self.factor)} {self.name}"


def _coefficients(case: Case, summary: Summary) -> Iterator[str]:
    """Coefficients with what they are made with, and the numbers that say which flows are alike."""
    named = {
        "C_L": summary.lift_coefficient, "C_D": summary.drag_coefficient, "C_T": summary.thrust_coefficient,
        "C_P": summary.power_coefficient,
    }  # fmt: skip
    known = [f"{name} {one.mean:.4g}" for name, one in named.items() if one]
    if known:
        speed = f"{summary.reference_speed:.4g} m/s, {'the stream' if case.fluid.streams else 'rms at mid-chord'}"
        yield _line("coefficients", ", ".join(known))
        yield _line("  reference", f"U = {speed}; S = {summary.reference_area:.4g} m2, chord times span")
    alike = {"Re": summary.reynolds, "k": summary.reduced_frequency, "St": summary.strouhal}
    if found := [f"{name} {value:.3g}" for name, value in alike.items() if value is not None]:
        yield _line("similarity", ", ".join(found))
    if summary.angle_of_attack_mean is not None:
        yield _line(
            "angle of attack",
            f"mean {summary.angle_of_attack_mean:.3g} deg, rms {summary.angle_of_attack_rms:.3g} deg, geometric",
        )
    if summary.wing_tip_speed is not None:
        yield _line("mean wing tip speed", f"U_tip = {summary.wing_tip_speed:.3g} m/s")


def _economy(case: Case, summary: Summary) -> Iterator[str]:
    """What the force costs, and whether it carries the body."""
    if summary.propulsive_efficiency is not None:
        yield _line("propulsive efficiency", f"{summary.propulsive_efficiency:.4g}")
    lift = summary.lift or summary.force_vertical
    if lift.mean > 0.0 and summary.power.mean > 0.0:
        yield _line("power loading", f"{lift.mean / summary.power.mean:.3g} N/W")
    if summary.lift_over_weight is not None and case.body.mass:
        factor, unit = prefixed(1e3 * case.body.mass, "g")
        mass = f"{factor * 1e3 * case.body.mass:g} {unit}"
        wings = f"{case.body.wings} wings" if case.body.wings > 1 else "1 wing"
        yield _line("lift over weight", f"{summary.lift_over_weight:.3g}, {wings} under {mass}")


def _model(case: Case) -> str:
    model = fluids.known(case.solver)
    settings = [case.model, *(model.settings(case) if model else [])]
    return ", ".join([*settings, f"fluid {case.fluid.density:g} kg/m3"])


def _wing(case: Case, result: Result) -> str:
    factor, unit = prefixed(case.wing.chord, "m")
    size = f"chord {factor * case.wing.chord:g} {unit}, span {_span(case)}"
    frequencies = ", ".join(f"{f:.4g}" for f in result.modes.get("frequency", ()))
    return f"{size}, {f'modes at {frequencies} Hz' if frequencies else 'rigid'}"


def _span(case: Case) -> str:
    values = Profile.of(case.wing.span).values
    factor, unit = prefixed(values.max(), "m")
    least, most = (f"{factor * value:g}" for value in (values.min(), values.max()))
    return f"{most if least == most else f'{least} to {most}'} {unit}"


def _motion(case: Case) -> str:
    motion, time = case.motion, case.time
    rate = f"{motion.frequency:g} Hz, " if motion.frequency else ""
    if time.periods is None:
        steps = f"{case.steps} steps of {case.step:.4g} s"
    else:
        beats = f"{time.periods} beat{'s' if time.periods > 1 else ''}"
        steps = f"{beats} of {case.steps_per_beat:g} steps"
    if motion.measured:
        return f"{rate}{_measured(motion.measured, motion.frequency or 0.0)}, {steps}"
    plunge, pitch = _travel(motion, motion.plunge, "m"), _travel(motion, motion.pitch, "deg")
    surge = f", surge {_travel(motion, motion.surge, 'm')}" if motion.surge != HarmonicPlunge() else ""
    return f"{rate}plunge {plunge}, pitch {pitch}{surge}, {steps}"


def _measured(measured: Measured, frequency: float) -> str:
    """Range of the measured angles, residual of their harmonics, and spread between beats."""
    found = []
    for name, fit in angles.fits(measured, frequency).items():
        low, high = fit.reach
        spread = "" if fit.spread is None else f", spread {fit.spread:.2g}"
        found.append(f"{name} {low:.3g} to {high:.3g} deg (residual {fit.series.residual:.2g}{spread})")
    return f"{', '.join(found)}, {measured.smooth} harmonics"


def _travel(motion: Motion, axis: Travel, unit: str) -> str:
    """Range of plunge or pitch, its kind if not harmonic, and the number of its higher harmonics."""
    keys = axis.in_si(motion.frequency)
    more = keys.get("harmonics", ())
    sizes = (
        [value for _, value in keys["points"]] if "points" in keys else [keys["amplitude"], *(a for _, a, _ in more)]
    )
    far = max(map(abs, sizes))
    scale, unit = (180.0 / math.pi, unit) if unit == "deg" else prefixed(far, unit)
    if "points" in keys:
        values = [scale * value for _, value in keys["points"]]
        found = fourier.series(**keys) if "smooth" in keys else None
        near = f", {_harmonics(found.terms)}, rms residual {scale * found.residual:.2g} {unit}" if found else ""
        return f"{min(values):.3g} to {max(values):.3g} {unit} (table{near})"
    kind = "" if axis.kind == "harmonic" else f" ({axis.kind})"
    middle = keys.get("mean", keys.get("initial"))
    about = f" about {scale * middle:.3g} {unit}" if middle else ""
    terms = f" and {_harmonics(more)}" if more else ""
    return f"{scale * keys['amplitude']:.3g} {unit}{terms}{about}{kind}"


def _harmonics(terms: Sequence[Any]) -> str:
    return f"{len(terms)} harmonic{'s' if len(terms) > 1 else ''}"
