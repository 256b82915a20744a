"""Misprints and gaps of the paper's text, with the measured effect of taking each literally."""

from dataclasses import dataclass

import numpy as np

from ...metrics.beats import whole_beats
from ...run.blocks import simulate
from ...structure import beam
from . import literal, paper, rigid_lattice
from .measured import Measured
from .paper import Settings
from .plan import C_FOR_H, IN_PHASE, LATE, MICROGRAMS, RIGID, TRUNCATED, UNDAMPED, Runs, key
from .verdict import mean_force


@dataclass(frozen=True)
class Erratum:
    """A misprint: its place, the printed and the correct form, and the effect of taking it literally.

    Attributes:
        how: `run`, `post-processed` (forces computed again from the stored motion) or `NumPy` (a run of
            `rigid_lattice`, which has the misprint as an option).
    """

    where: str
    printed: str
    meant: str
    effect: str
    how: str


def errata(settings: Settings, runs: Runs) -> list[Erratum]:
    """Every misprint with its effect."""
    flexible, undamped, light = runs[key("dbet")], runs[key("dbet", UNDAMPED)], runs[key("dbet", MICROGRAMS)]
    truncated, lattice, loose = runs[key("dbet", TRUNCATED)], runs[key("uvlm")], runs[key("uvlm", UNDAMPED)]
    thin, thin_rigid = runs[key("uvlm", C_FOR_H)], runs[key("uvlm", C_FOR_H, RIGID)]
    longest = f"uvlm.wake={settings.long_wakes[-1]}"
    whole, whole_rigid = runs[key("uvlm", longest)], runs[key("uvlm", longest, RIGID)]
    frequency = beam.modes(light.case.wing).frequency[0]

    def tip(run: Measured) -> str:
        return f"{1e3 * run.summary.tip_peak.mean:.2f} mm"

    def lift(run: Measured) -> str:
        return f"{1e3 * run.summary.force_vertical.mean:.2f} mN"

    full, normal = (
        mean_force(runs, "uvlm", 1, name) / mean_force(runs, "uvlm", 0, name) - 1.0
        for name in ("force_vertical", "force_vertical_normal")
    )
    return [
        Erratum(
            "Table 1", "mass 40 µg", "40 mg",
            f"first frequency {frequency:.0f} Hz in place of {paper.FREQUENCY:g} Hz; DBET tip {tip(light)} for "
            f"{tip(flexible)}", "run",
        ),
        Erratum(
            "Table 2 and Figs 6-7", "plunge at +90 deg, and reversal at t/T = 0.25 and 0.75",
            "with that phase the stroke reverses at 0 and 0.5", _origin(runs), "run",
        ),
        Erratum(
            "Eq. 11", "no damping", "2 ζ ω dq/dt, with the ratio that Table 1 gives",
            f"tip {tip(undamped)} for {tip(flexible)} (DBET), {tip(loose)} for {tip(lattice)} (UVLM); mean force "
            f"{lift(loose)} for {lift(lattice)} (UVLM)", "run",
        ),
        *_blade_errata(settings),
        Erratum(
            "Eq. 22", "the square of the elastic speed dropped", "the whole square of the local speed",
            f"DBET tip {tip(truncated)} for {tip(flexible)}, mean force {lift(truncated)} for {lift(flexible)}", "run",
        ),
        *_wake_errata(settings, runs),
        _whole_panels(settings),
        Erratum(
            "Eq. 34", "chord c", "span h",
            f"the force times c/h = 0.4: mean force {lift(thin_rigid)} (rigid), {lift(thin)} with tip {tip(thin)} "
            "(flexible)", "run",
        ),
        _pitch_energy(settings),
        Erratum(
            "Table 4", "200 wakes, converged by Fig. 5", "Fig. 5 shows the tip, not the force",
            f"mean force {lift(whole_rigid)} (rigid) and {lift(whole)} (flexible) with {settings.long_wakes[-1]} of "
            f"the wake, for {lift(runs[key('uvlm', RIGID)])} and {lift(lattice)}", "run",
        ),
        Erratum(
            "Table 5", "forces of two definitions in one column", "one definition for all",
            f"the gain by flexibility in UVLM is {full:+.0%} as a full vector and {normal:+.0%} as the wing-normal "
            "part that Figs 6-7 show", "run",
        ),
        Erratum(
            "Eq. 17", "the density of the fluid is never stated", f"{paper.AIR} kg/m3 here",
            "see the table of densities", "run",
        ),
    ]  # fmt: skip


def _blade_errata(settings: Settings) -> list[Erratum]:
    cases = [paper.case(settings, "dbet", *more) for more in ((RIGID,), ())]
    results = simulate(cases)
    try:
        right = [literal.blades(result) for result in results]
        turned = [literal.blades(result, arctangent=True) for result in results]
        cosines = [literal.blades(result, cosines=True) for result in results]
        outside = [literal.blades(result, outside=True) for result in results]
    finally:
        for result in results:
            result.close()

    def compared(theirs: list[literal.Blades]) -> str:
        pairs = zip(("rigid", "flexible"), theirs, right, strict=True)
        values = ", ".join(f"{1e3 * a.vertical:.2f} for {1e3 * b.vertical:.2f} mN ({name})" for name, a, b in pairs)
        return f"mean vertical force of the blades without added mass: {values}"

    how = "post-processed"
    return [
        Erratum(
            "Eq. 18", "an arctangent", "the angle in all four quadrants",
            f"{right[1].backward:.0%} of time and chord has a negative chordwise speed, where it is off by 180 deg: "
            f"{compared(turned)}",
            how,
        ),
        Erratum("Eqs 21-22", "coefficients before the integral", "in it", f"at mid-chord, {compared(outside)}", how),
        Erratum("Eq. 23", "cos A twice", "drag times cos A less lift times sin A", compared(cosines), how),
    ]  # fmt: skip


def _origin(runs: Runs) -> str:
    def forces(*more: str) -> str:
        return " and ".join(
            f"{1e3 * runs[key(solver, *more)].summary.force_vertical.mean:.2f} mN ({solver.upper()})"
            for solver in ("dbet", "uvlm")
        )

    peak = runs[key("dbet", *LATE)].summary.tip_peak_time
    return (
        f"with both motions a quarter of a beat later, mean force {forces(*LATE)} for {forces()}, flexible, and the "
        f"DBET tip's peak at t/T = {peak % 0.5:.3f}; with the plunge of the plots and the pitch of Table 2, "
        f"{forces(IN_PHASE)}"
    )


def _wake_errata(settings: Settings, runs: Runs) -> list[Erratum]:
    case = paper.case(settings, "uvlm", RIGID)
    right = runs[key("uvlm", RIGID)].summary

    def effect(flight: rigid_lattice.Flight) -> str:
        beats = whole_beats(case, flight.time)
        beats = beats.after(len(beats) - right.beats)
        mean = 1e3 * np.mean(flight.vertical[beats.frames])
        peak = 1e3 * np.mean(beats.peaks(flight.normal))
        return (
            f"rigid wing: mean force {mean:.2f} for {1e3 * right.force_vertical.mean:.2f} mN, largest normal force "
            f"{peak:.0f} for {1e3 * right.force_normal_peak.mean:.0f} mN"
        )

    return [
        Erratum(
            "Eq. 32", "the wake's sum runs to the number of panels", "to the number of wake vortices",
            f"with the youngest vortices kept, {effect(rigid_lattice.fly(case, heard=case.uvlm.panels))}", "NumPy",
        ),
        Erratum(
            "Eq. 32, taken further", "a wake that does not move", "a wake that moves with the fluid",
            effect(rigid_lattice.fly(case, still=True)), "NumPy",
        ),
    ]  # fmt: skip


def _whole_panels(settings: Settings) -> Erratum:
    effects = []
    for wing, more in (("rigid", (RIGID,)), ("flexible", ())):
        with simulate(paper.case(settings, "uvlm", *more)) as result:
            printed, meant = literal.whole_panels(result)
        turned = float(np.degrees(np.angle(printed / meant)))
        effects.append(f"{1e3 * abs(printed):.2f} for {1e3 * abs(meant):.2f} mN, {turned:+.1f} deg earlier ({wing})")
    return Erratum(
        "Eq. 33", "the running sum counts all of a panel's circulation", "its vortex is at a quarter of it",
        f"first harmonic of the normal force {', '.join(effects)}", "post-processed",
    )  # fmt: skip


def _pitch_energy(settings: Settings) -> Erratum:
    printed, meant, whole = (1e6 * value for value in literal.pitch_energy(paper.case(settings, "dbet", RIGID)))
    return Erratum(
        "Appendix A, T6", "no rate of pitch", "a factor dθ/dt",
        f"not an energy; in SI numbers at most {printed:.1f} for {meant:.1f} µJ, of {whole:.0f} µJ in all. It holds "
        "no q, so that Eq. 11 stays", "post-processed",
    )  # fmt: skip
