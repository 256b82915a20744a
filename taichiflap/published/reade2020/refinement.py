"""Verdicts on the paper's statements about convergence: blade elements, panels, wake vortices, time step."""

from . import paper
from .paper import Settings
from .plan import RIGID, Runs, halved, key
from .verdict import NAMES, Verdict

SAME = 0.01
"""Changes below this count as zero."""


def verdicts(settings: Settings, runs: Runs) -> list[Verdict]:
    """One on each of Figs 4 and 5, and two on the time step."""
    return [_elements(settings, runs), _panels(settings, runs), _wakes(settings, runs), *_steps(settings, runs)]


def _tip(runs: Runs, *wanted: str) -> float:
    return runs[key(*wanted)].summary.tip_peak.mean


def _force(runs: Runs, *wanted: str) -> float:
    return runs[key(*wanted)].summary.force_vertical.mean


def _elements(settings: Settings, runs: Runs) -> Verdict:
    final = _tip(runs, "dbet", f"dbet.elements={settings.elements[-1]}")
    beyond = [count for count in settings.elements if count >= paper.ENOUGH_ELEMENTS]
    change = max(abs(_tip(runs, "dbet", f"dbet.elements={count}") / final - 1.0) for count in beyond)
    return Verdict(
        "Fig. 4, tip beyond 5 elements", "changes < 1 %", f"changes {change:.2%}", change < SAME,
        f"from {beyond[0]} to {settings.elements[-1]} elements",
    )  # fmt: skip


def _panels(settings: Settings, runs: Runs) -> Verdict:
    finest = ("uvlm", f"uvlm.panels={settings.panels[-1]}")
    panels = [("uvlm", f"uvlm.panels={count}") for count in settings.panels]
    tips = max(abs(_tip(runs, *one) / _tip(runs, *finest) - 1.0) for one in panels)
    forces = max(abs(_force(runs, *one) / _force(runs, *finest) - 1.0) for one in panels)
    return Verdict(
        "Fig. 5, tip against panels", "converges quickly", f"within {tips:.1%}", tips < 0.05,
        f"over {settings.panels[0]} to {settings.panels[-1]} panels; the mean force is off by up to {forces:.1%}",
    )  # fmt: skip


def _wakes(settings: Settings, runs: Runs) -> Verdict:
    last, longest = (f"uvlm.wake={count}" for count in (settings.wakes[-1], settings.long_wakes[-1]))
    drift = _tip(runs, "uvlm", last) / _tip(runs, "uvlm") - 1.0
    tip = _tip(runs, "uvlm", longest) / _tip(runs, "uvlm") - 1.0
    lift, rigid = (_force(runs, "uvlm", longest, *more) / _force(runs, "uvlm", *more) - 1.0 for more in ((), (RIGID,)))
    return Verdict(
        "Fig. 5, tip against wakes", "converged at 200", f"{drift:+.1%} from 200 to {settings.wakes[-1]}",
        abs(drift) < 2.0 * SAME,
        f'with wake = "{settings.long_wakes[-1]}" the tip changes by {tip:+.0%} and the mean force by {lift:+.0%} '
        f"(flexible) and {rigid:+.0%} (rigid)",
    )  # fmt: skip


def _steps(settings: Settings, runs: Runs) -> list[Verdict]:
    found = []
    for solver, count in (("dbet", None), ("uvlm", 200), ("uvlm", 400)):
        changes = {
            "tip": _tip(runs, solver, *halved(settings, count)) / _tip(runs, solver) - 1.0,
            "mean force": _force(runs, solver, *halved(settings, count)) / _force(runs, solver) - 1.0,
            "rigid": _force(runs, solver, *halved(settings, count), RIGID) / _force(runs, solver, RIGID) - 1.0,
        }
        worst = max(map(abs, changes.values()))
        kept = f", {count} vortices kept" if count else ""
        share = count / (2 * settings.steps_per_period) if count else 0.0
        found.append(
            Verdict(
                f"half the time step, {NAMES[solver]}{kept}", "no impact", f"tip {changes['tip']:+.1%}", worst < SAME,
                f"mean force {changes['mean force']:+.1%} (flexible), {changes['rigid']:+.1%} (rigid)"
                + (f"; the wake is then {share:g} of a beat long, for {2 * share if count == 200 else share:g}"
                   if count else ""),
            )
        )  # fmt: skip
    return found
