"""The verdicts of the reproduction: the paper's statements, our results, and reasons for differences."""

from . import paper, phases, refinement
from .paper import TABLE_5, Settings
from .plan import RIGID, ROW, UNDAMPED, Runs, key
from .verdict import CLOSE, DEFINITIONS, NAMES, Verdict, closer, mean_force


def verdicts(
    settings: Settings, runs: Runs, frequency: float, timings: dict[str, float], machine: str
) -> list[Verdict]:
    """Every verdict; `frequency` is the first natural frequency (Hz), `timings` the seconds of each solver."""
    return [
        Verdict.number("first natural frequency", paper.FREQUENCY, frequency, "Hz", "the mass read as 40 mg"),
        *refinement.verdicts(settings, runs),
        *(_mean_force(runs, solver, modes) for solver, modes in TABLE_5),
        *(_gain(runs, solver) for solver in ("dbet", "uvlm")),
        *(_tip(runs, solver) for solver in ("dbet", "uvlm")),
        *phases.verdicts(runs),
        *_times(timings, machine),
    ]


def _mean_force(runs: Runs, solver: str, modes: int) -> Verdict:
    definition = closer(runs, solver, modes)
    same = solver == "uvlm" and not modes
    remark = "both definitions are one for a rigid plate" if same else f"as the {DEFINITIONS[definition]}"
    what = f"mean vertical force, {NAMES[solver]} {'flexible' if modes else 'rigid'}"
    here = mean_force(runs, solver, modes, definition)
    two_beats = [runs.get(key("uvlm", "uvlm.wake=400", *more)) for more in ((), (RIGID,))]
    if solver == "uvlm" and modes and all(two_beats):
        flexible, rigid = (1e3 * run.summary.force_vertical.mean for run in two_beats if run)
        remark += f" (400 wake vortices give {flexible:.2f} mN, and {rigid:.2f} mN for the rigid wing)"
    return Verdict.number(what, 1e3 * TABLE_5[solver, modes], 1e3 * here, "mN", remark)


def _gain(runs: Runs, solver: str) -> Verdict:
    gains = {
        name: mean_force(runs, solver, 1, definition) / mean_force(runs, solver, 0, definition) - 1.0
        for definition, name in DEFINITIONS.items()
    }
    printed = paper.GAIN[solver]
    reproduced = any(abs((1.0 + gain) / (1.0 + printed) - 1.0) <= CLOSE for gain in gains.values())
    matched = [DEFINITIONS[closer(runs, solver, modes)] for modes in (0, 1)]
    if solver == "dbet":
        row = [runs[key("dbet", *ROW, modes)].summary.force_vertical_normal.mean for modes in (UNDAMPED, RIGID)]
        why = (
            "without added mass and without damping, as Eq. 11 is printed, the normal part grows by "
            f"{row[0] / row[1] - 1.0:+.1%}; here the printed rigid force is nearer to the {matched[0]}, the flexible "
            f"one to the {matched[1]}"
        )
    else:
        nearest = min(gains, key=lambda name: abs(gains[name] - printed))
        why = f"as the {nearest}; Figs 6 and 7 show the {DEFINITIONS['force_vertical_normal']}"
    here = ", ".join(f"{gain:+.0%} ({name})" for name, gain in gains.items())
    return Verdict(f"gain by flexibility, {NAMES[solver]}", f"{printed:+.0%}", here, reproduced, why)


def _tip(runs: Runs, solver: str) -> Verdict:
    summary = runs[key(solver)].summary
    after = (summary.tip_peak_after_reversal or 0.0) - (paper.TIP_TIME - paper.REVERSAL)
    remark = f"it comes {summary.tip_peak_after_reversal:.3f} T after reversal, {after:+.3f} T from the paper's"
    what = f"largest tip deflection, {NAMES[solver]}"
    return Verdict.number(what, 1e3 * paper.TIP, 1e3 * summary.tip_peak.mean, "mm", remark)


def _times(timings: dict[str, float], machine: str) -> list[Verdict]:
    ratio, printed = timings["uvlm"] / timings["dbet"], paper.SOLVE_TIME["uvlm"] / paper.SOLVE_TIME["dbet"]
    return [
        *(
            Verdict(
                f"time of 15 beats, {NAMES[solver]}", f"{paper.SOLVE_TIME[solver]} s", f"{seconds:.3f} s",
                None, f"{paper.SOLVE_TIME[solver] / seconds:.0f} times faster; one thread of {machine}",
            )
            for solver, seconds in timings.items()
        ),
        Verdict(
            "time, UVLM over DBET", f"{printed:.1f}", f"{ratio:.1f}", None,
            f"the faster program is {min(timings, key=lambda solver: timings[solver]).upper()}",
        ),
    ]  # fmt: skip
