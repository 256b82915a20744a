"""A run in words: the lines that `simulate` and `info` print."""

import math
from collections.abc import Iterator
from typing import Any

from .case import Case
from .metrics import FEWEST_BEATS, Statistic, Summary, summarise
from .profile import Profile
from .results import Result
from .sections.motion import Travel

LABEL = 24


def summary_lines(result: Result) -> Iterator[str]:
    """Lines of text that summarise a result, complete or not."""
    case = result.case
    attributes = result.attributes
    yield case.title or "(no title)"
    yield _line("file", f"{result.path or 'in memory'}, {attributes['status']}, {result.frames} frames")
    yield _line("model", _model(case))
    yield _line("wing", _wing(case, result))
    yield _line("motion", _motion(case))
    summary = summarise(result)
    if summary is None:
        yield "no whole beat yet: no statistics" if case.periodic else "not complete: no statistics"
    else:
        yield from _statistics(case, summary)
    if "solve_time" in attributes:
        yield _line("solve time", f"{attributes['solve_time']:.3g} s for {case.steps} steps")
    for warning in filter(None, str(attributes["warnings"]).splitlines()):
        yield f"warning: {warning}"
    if "reason" in attributes:
        yield _line("failed", attributes["reason"])


def _statistics(case: Case, summary: Summary) -> Iterator[str]:
    if case.periodic:
        yield f"over the last {summary.beats} beat{'s' if summary.beats > 1 else ''} (mean ± spread from beat to beat):"
    else:
        yield "over the whole run:"
    if summary.lift and summary.thrust:
        pressure = 0.5 * case.fluid.density * math.hypot(*case.fluid.velocity) ** 2
        scale = pressure * case.wing.chord * Profile.of(case.wing.span).mean
        yield _line("lift across stream", _shown(summary.lift, 1e3, f"mN{_coefficient(summary.lift, scale)}"))
        yield _line("thrust against stream", _shown(summary.thrust, 1e3, f"mN{_coefficient(summary.thrust, scale)}"))
    else:
        yield _line("vertical force", _shown(summary.force_vertical, 1e3, "mN, full vector"))
        yield _line("", _shown(summary.force_vertical_normal, 1e3, "mN, wing-normal part alone"))
    phase = summary.force_normal_phase
    lead = "" if phase is None else f", first harmonic at {phase:+.1f} deg to the stroke"
    yield _line("peak normal force", _shown(summary.force_normal_peak, 1e3, f"mN{lead}"))
    if summary.tip_peak.mean:
        after = summary.tip_peak_after_reversal
        if case.periodic:
            when = f"t/T = {summary.tip_peak_time:.3f}" + ("" if after is None else f", {after:.3f} T after reversal")
        else:
            when = f"t = {summary.tip_peak_time * case.beat:.4g} s"
        yield _line("peak tip deflection", _shown(summary.tip_peak, 1e3, f"mm, at {when}"))
    yield _line("mechanical power", _shown(summary.power, 1e3, "mW"))
    yield _line("  against the fluid", _shown(summary.power_aerodynamic, 1e3, "mW"))
    yield _line("  positive part alone", _shown(summary.power_positive, 1e3, "mW"))
    if summary.wake_lost:
        yield _line("wake left out", f"about {100 * summary.wake_lost:.2g} % of the wing's speed, and of the forces")
    if summary.wake_far_error is not None:
        yield _line("error of the far wake", f"{summary.wake_far_error:.2g} m/s at most, of eight vortices a step")
    if summary.wake_crossings:
        kept = "kept on their side" if case.uvlm.crossing == "reflect" else "let through"
        yield _line("wake upon the wing", f"{summary.wake_crossings} vortices, {kept}")
    unrest = _unrest(summary)
    if unrest:
        yield f"warning: {unrest}"


def _unrest(summary: Summary) -> str:
    """Why the means are not to be trusted yet; nothing if they are, or if nothing repeats."""
    if summary.settled is not False:
        return ""
    if summary.beats < FEWEST_BEATS:
        return "too few beats to tell whether the run has settled: give it more time.periods"
    if summary.force_drift > 2.0 * summary.force_spread:
        return (
            f"not yet periodic: over these beats the mean force drifts by {100 * summary.force_drift:.2g} % "
            "of its rms; give it more time.periods"
        )
    return (
        f"the beats do not repeat: their mean force spreads by {100 * summary.force_spread:.2g} % of its rms; "
        "with more time.periods the mean gets firmer"
    )


def _line(label: str, text: Any) -> str:
    return f"  {label:<{LABEL - 2}}{text}"


def _shown(statistic: Statistic, scale: float, unit: str) -> str:
    spread = f" ± {scale * statistic.spread:.2g}" if statistic.spread else ""
    return f"{scale * statistic.mean:.4g}{spread} {unit}"


def _coefficient(force: Statistic, scale: float) -> str:
    return f", coefficient {force.mean / scale:.4g}" if scale else ""


def _model(case: Case) -> str:
    settings = [case.model]
    if case.solver == "dbet":
        settings += [f"{case.dbet.elements} elements"]
    elif case.solver == "uvlm":
        wake = "all of the wake" if case.uvlm.wake == "all" else f"{case.uvlm.wake} wake vortices"
        settings += [f"{case.uvlm.panels} panels", wake]
    return ", ".join([*settings, f"fluid {case.fluid.density:g} kg/m3"])


def _wing(case: Case, result: Result) -> str:
    size = f"chord {1e3 * case.wing.chord:g} mm, span {_span(case)} mm"
    frequencies = ", ".join(f"{f:.2f}" for f in result.modes.get("frequency", ()))
    return f"{size}, {f'modes at {frequencies} Hz' if frequencies else 'rigid'}"


def _span(case: Case) -> str:
    values = 1e3 * Profile.of(case.wing.span).values
    least, most = (f"{value:g}" for value in (values.min(), values.max()))
    return most if least == most else f"{least} to {most}"


def _motion(case: Case) -> str:
    motion, time = case.motion, case.time
    rate = f"{motion.frequency:g} Hz, " if motion.frequency else ""
    if time.periods is None:
        steps = f"{case.steps} steps of {case.step:.4g} s"
    else:
        steps = f"{time.periods} beats of {case.steps_per_beat:g} steps"
    plunge, pitch = _travel(motion.plunge, 1e3, "mm"), _travel(motion.pitch, 180.0 / math.pi, "deg")
    return f"{rate}plunge {plunge}, pitch {pitch}, {steps}"


def _travel(axis: Travel, scale: float, unit: str) -> str:
    """How far plunge or pitch goes, and how if not harmonically."""
    keys = axis.in_si()
    if "points" in keys:
        values = [scale * value for _, value in keys["points"]]
        return f"{min(values):.3g} to {max(values):.3g} {unit} (table)"
    kind = "" if axis.kind == "harmonic" else f" ({axis.kind})"
    middle = keys.get("mean", keys.get("initial"))
    about = f" about {scale * middle:.3g} {unit}" if middle else ""
    return f"{scale * keys['amplitude']:.3g} {unit}{about}{kind}"
