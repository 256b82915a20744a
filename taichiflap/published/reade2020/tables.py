"""Tables of the reproduction's report."""

from collections.abc import Iterator

from ...metrics.summary import Statistic
from ...pages import Table
from .measured import Measured
from .paper import GAIN, TABLE_5, Settings
from .plan import NO_ADDED_MASS, RIGID, ROW, TRUNCATED, UNDAMPED, Runs, key
from .verdict import DEFINITIONS, NAMES, closer, mean_force

WINGS = (("rigid", (RIGID,)), ("flexible", ()))


def beats(runs: Runs) -> int:
    """Number of settled beats behind the statistics."""
    return runs[key("dbet")].summary.beats


def wakes(settings: Settings, runs: Runs) -> Table:
    """Force and tip deflection against the wake."""
    rows = []
    for count in (*settings.wakes, *settings.long_wakes):
        flexible, rigid = (runs[key("uvlm", f"uvlm.wake={count}", *more)].summary for more in ((), (RIGID,)))
        forces = flexible.force_vertical, flexible.force_vertical_normal, rigid.force_vertical
        rows.append((str(count), _milli(flexible.tip_peak), *map(_milli, forces)))
    head = ("Wake vortices", "Tip (mm)", "Mean force, flexible (mN)", "Its wing-normal part (mN)", "Rigid (mN)")
    return Table(head, rows)


def harmonics(runs: Runs) -> Table:
    """First and third harmonics of normal force and tip deflection, and phases against UVLM."""
    rows = []
    for wing, more in WINGS:
        lattice = runs[key("uvlm", *more)]
        shown: list[tuple[str, Measured]] = [("UVLM", lattice), ("DBET", runs[key("dbet", *more)])]
        shown.append(("DBET without added mass", runs[key("dbet", NO_ADDED_MASS, *more)]))
        shown.append(("... and at 1.29 kg/m³", runs[key("dbet", *ROW, *more)]))
        if not more:
            shown.append(("... and undamped", runs[key("dbet", *ROW, UNDAMPED)]))
        for name, run in shown:
            rows.append((f"{name}, {wing}", *_force(run, lattice), *_tip(run, lattice)))
        blades = runs[key("dbet", *more)]
        phase = blades.phase("force_normal", lattice, blades.first_quasi_steady)
        amplitude = f"{1e3 * abs(blades.first_quasi_steady):.2f}"
        third = blades.third["force_normal"] - blades.third["force_normal_unsteady"]
        share = f"{abs(third) / abs(blades.first_quasi_steady):.3f}"
        rows.append((f"DBET less its added-mass part, {wing}", amplitude, f"{phase:+.1f}", share, "", "", "", ""))
    head = (
        "Run", "F_N, 1st harmonic (mN)", "leads UVLM by (deg)", "3rd / 1st",
        "Tip, 1st harmonic (mm)", "leads UVLM by (deg)", "3rd / 1st", "peak after reversal (T)",
    )  # fmt: skip
    return Table(head, [tuple(cell.replace("-", "−") if cell[:1] in "+-" else cell for cell in row) for row in rows])


def _force(run: Measured, lattice: Measured) -> Iterator[str]:
    yield f"{1e3 * abs(run.first['force_normal']):.2f}"
    yield f"{run.phase('force_normal', lattice):+.1f}"
    yield f"{run.third_share('force_normal'):.3f}"


def _tip(run: Measured, lattice: Measured) -> Iterator[str]:
    if not run.case.wing.modes:
        yield from ("", "", "", "")
        return
    yield f"{1e3 * abs(run.first['tip_deflection']):.2f}"
    yield f"{run.phase('tip_deflection', lattice):+.1f}"
    yield f"{run.third_share('tip_deflection'):.3f}"
    yield f"{run.summary.tip_peak_after_reversal:.3f}"


def mean_forces(runs: Runs) -> Table:
    """Table 5 by both definitions, and which of them the printed number matches."""
    rows = []
    for (solver, modes), printed in TABLE_5.items():
        name = f"{NAMES[solver]}, {'flexible' if modes else 'rigid'}"
        values = [f"{1e3 * mean_force(runs, solver, modes, definition):.2f}" for definition in DEFINITIONS]
        match = closer(runs, solver, modes)
        off = mean_force(runs, solver, modes, match) / printed - 1.0
        same = len(set(values)) == 1
        rows.append((name, f"{1e3 * printed:.2f}", *values, "both" if same else DEFINITIONS[match], _percent(off)))
    head = ("Mean vertical force (mN)", "Paper", "Full vector", "Wing-normal part", "The print is nearer to", "Off by")
    return Table(head, rows)


def gains(runs: Runs) -> Table:
    """What flexibility adds, by both definitions and by DBET without added mass."""
    rows = []
    for solver, printed in GAIN.items():
        pairs = [[mean_force(runs, solver, modes, definition) for modes in (1, 0)] for definition in DEFINITIONS]
        rows.append((NAMES[solver], _percent(printed), *(_percent(one / other - 1.0) for one, other in pairs)))
    for name, extra in (("DBET, no added mass, 1.29 kg/m³", ()), ("... and undamped", (UNDAMPED,))):
        flexible, rigid = runs[key("dbet", *ROW, *extra)].summary, runs[key("dbet", *ROW, RIGID)].summary
        pairs = [[getattr(one, definition).mean for one in (flexible, rigid)] for definition in DEFINITIONS]
        rows.append((name, _percent(GAIN["dbet"]), *(_percent(one / other - 1.0) for one, other in pairs)))
    return Table(("Gain by flexibility", "Paper", "Full vector", "Wing-normal part"), rows)


def modes(settings: Settings, runs: Runs) -> Table:
    """Tip deflection and mean force against the number of modes."""
    rows = [
        (f"{NAMES[solver]}, {count}", *_both(runs[key(solver, f"wing.modes={count}")]))
        for solver in NAMES
        for count in settings.modes
    ]
    return Table(("Elastic modes", "Tip (mm)", "Full vector (mN)", "Wing-normal part (mN)"), rows)


def densities(settings: Settings, runs: Runs) -> Table:
    """Tip deflection and mean force against the density of the fluid."""
    rows = [
        (f"{NAMES[solver]} {wing}, {density:g}", *_both(runs[key(solver, f"fluid.density={density}", *more)]))
        for solver in NAMES
        for wing, more in WINGS
        for density in settings.densities
    ]
    return Table(("Density (kg/m³)", "Tip (mm)", "Full vector (mN)", "Wing-normal part (mN)"), rows)


def speeds(runs: Runs) -> Table:
    """The whole square of the speed against the paper's truncated one."""
    shown = (("full", ()), ("truncated", (TRUNCATED,)), ("full, undamped", (UNDAMPED,)))
    rows = [(name, *_both(runs[key("dbet", *more)])) for name, more in shown]
    rows.append(("truncated, undamped", *_both(runs[key("dbet", TRUNCATED, UNDAMPED)])))
    return Table(("Square of the speed, DBET flexible", "Tip (mm)", "Full vector (mN)", "Wing-normal part (mN)"), rows)


def power(runs: Runs) -> Table:
    """Mechanical power, and the mean vertical force per power."""
    rows = []
    for solver, name in NAMES.items():
        for wing, more in WINGS:
            summary = runs[key(solver, *more)].summary
            per = [summary.force_vertical.mean / spent.mean for spent in (summary.power, summary.power_positive)]
            powers = summary.power, summary.power_aerodynamic, summary.power_positive
            rows.append((f"{name} {wing}", *map(_milli, powers), *(f"{1e3 * value:.1f}" for value in per)))
    head = (
        "Wing", "Power (mW)", "against the fluid (mW)", "positive part (mW)", "Force per power (mN/W)",
        "per positive power (mN/W)",
    )  # fmt: skip
    return Table(head, rows)


def _both(run: Measured) -> Iterator[str]:
    yield _milli(run.summary.tip_peak) if run.case.wing.modes else ""
    yield _milli(run.summary.force_vertical)
    yield _milli(run.summary.force_vertical_normal)


def _milli(statistic: Statistic) -> str:
    spread = f"{1e3 * statistic.spread:.2f}"
    return f"{1e3 * statistic.mean:.2f}" + (f" ± {spread}" if float(spread) else "")


def _percent(share: float) -> str:
    return f"{share:+.1%}".replace("-", "−").replace("%", " %")
