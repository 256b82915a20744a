"""The page of the paper's wing in every model, and what it says of the paper's Table 5."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure as Drawing

from ... import files, pages
from ...pages import Block, Figure, Heading, Paragraph, Table
from .drawings import DBET, INK, MUTED, RESOLUTION, STYLE, UVLM, WIDTH
from .models import BEATS, BLOCK, KNOWN, MODELS, PHASES, PITCHES, STARTS, Found, Kept
from .paper import TABLE_5

NAME = "models"
REFERENCE = "navier-stokes"
COLOURS = {
    "dbet-paper": DBET, "dbet": DBET, "uvlm-paper": UVLM, "uvlm": UVLM, "uvlm-sheds": UVLM, REFERENCE: INK,
}  # fmt: skip
DASHES = {"dbet-paper": ":", "dbet": "-", "uvlm-paper": ":", "uvlm": "-", "uvlm-sheds": "--", REFERENCE: "-"}


def write(found: Found, folder: Path) -> None:
    """Write the page (Markdown, HTML) and its figures into a folder.

    Raises:
        OutputError: when the system refuses.
    """
    with mpl.rc_context(STYLE):
        for name, figure in ((f"{NAME}-forces", forces(found)), (f"{NAME}-histories", histories(found))):
            for kind in ("png", "svg"):
                with files.replacing(folder / f"{name}.{kind}") as file:
                    metadata = {"Date": None} if kind == "svg" else None
                    figure.savefig(file, format=kind, dpi=RESOLUTION, metadata=metadata)
    blocks = page_of(found)
    for kind, text in (("md", pages.markdown(blocks)), ("html", pages.html(blocks, folder))):
        with files.replacing(folder / f"{NAME}.{kind}") as file:
            file.write(text.encode())


def page_of(found: Found) -> list[Block]:
    """The page."""
    viscous = next(model for model in MODELS if model.name == REFERENCE)
    return [
        Heading(1, "The same wing in four models"),
        Paragraph(
            "The hawkmoth's wing of Reade & Jankauski (2020), rigid and flexible, with the paper's 15 deg of pitch "
            "and with 45 deg, in four models: blade elements (DBET), the vortex lattice (UVLM), the lattice with a "
            "shedding leading edge, and the Navier-Stokes equations. The models have their default settings, except "
            "where the paper's are named."
        ),
        Paragraph(
            f"Every wing runs {BEATS} beats of 200 steps twice, with start-ups of {STARTS[0]:g} and {STARTS[1]:g} "
            f"beats; in Navier-Stokes {viscous.beats} beats of {viscous.steps:,} steps, {len(viscous.starts)} times. "
            "The Navier-Stokes section has a thickness of 4 % of the chord, and 8 % if it is flexible, since a "
            "thinner one bends too far for the grid in some beats. The fluid is air (1.225 kg/m³, 1.5e-5 m²/s); the "
            "Reynolds number of the mean speed is 2,667. Numbers are means over the settled beats of all runs; ± is "
            f"the standard error, from blocks of {BLOCK} beats. Times are processor time of one core. Those of UVLM "
            "were measured beside other programs and are up to several times too long. `taichiflap reproduce` writes "
            f"this page from {KNOWN}, which `taichiflap reproduce --models` computes."
        ),
        Heading(2, "Consequences for Table 5"),
        *map(Paragraph, answers(found)),
        table_5(found),
        Heading(2, "Mean vertical force"),
        Figure(
            f"{NAME}-forces",
            "Mean vertical force of the rigid wing (open symbols) and the flexible wing (filled symbols); bars are "
            "two standard errors. Crosses: the paper's Table 5.",
        ),
        *(block for pitch in PITCHES for block in (Heading(3, f"{pitch:g} deg of pitch"), wing_table(found, pitch))),
        Heading(2, "Over a beat"),
        Figure(f"{NAME}-histories", "The flexible wing, mean of all settled beats. The stroke reverses at 0 and 0.5."),
        Heading(2, "Limits"),
        Paragraph(
            "In a two-dimensional flow vortices stay too strong. The section is an ellipse with 4 or 8 % of the "
            "chord instead of the wing's 0.2 %, which reduces the lift. Beats of the separated flow differ: two runs "
            "with different grids or start-ups diverge from each other after about three beats, so that only means "
            "can be compared."
        ),
    ]


def answers(found: Found) -> list[str]:
    """What the viscous flow says of the paper's numbers and of its belief."""
    rigid, flexible = (found[REFERENCE, PITCHES[0], modes] for modes in (0, 1))
    gain, error = _gain(found, REFERENCE, PITCHES[0])
    nearest = [
        min(("dbet", "uvlm"), key=lambda solver: abs(TABLE_5[solver, one.modes] - one.force))
        for one in (rigid, flexible)
    ]
    away = {solver: abs(TABLE_5[solver, 1] / TABLE_5[solver, 0] - 1.0 - gain) / error for solver in ("dbet", "uvlm")}
    printed = (
        "The paper trusts DBET, which gains 7 % of force by flexibility, and regards UVLM's 116 % as a severe "
        f"overprediction. In the viscous flow the force is {_force(rigid)} mN for the rigid wing and "
        f"{_force(flexible)} mN for the flexible one. This gain of {_percent(gain, error)} differs by "
        f"{away['uvlm']:.1f} standard errors from UVLM's and by {away['dbet']:.1f} from DBET's."
    )
    near = (
        f"Of the printed forces, {nearest[1].upper()}'s {1e3 * TABLE_5[nearest[1], 1]:.2f} mN is closer for the "
        f"flexible wing, and {nearest[0].upper()}'s {1e3 * TABLE_5[nearest[0], 0]:.2f} mN for the rigid one."
    )
    return [f"{printed} {near}"]


def table_5(found: Found) -> Table:
    """The paper's Table 5 beside the viscous flow."""
    rows = []
    for modes, wing in ((0, "rigid"), (1, "flexible")):
        here = [_force(found[name, PITCHES[0], modes]) for name in ("dbet-paper", "uvlm-paper", REFERENCE)]
        printed = [f"{1e3 * TABLE_5[solver, modes]:.2f}" for solver in ("dbet", "uvlm")]
        rows.append((wing, printed[0], here[0], printed[1], here[1], here[2]))
    gains = [_percent(*_gain(found, name, PITCHES[0])) for name in ("dbet-paper", "uvlm-paper", REFERENCE)]
    rows.append(("gain", "+7 %", gains[0], "+116 %", gains[1], gains[2]))
    head = (
        "Mean vertical force (mN)", "DBET, Table 5", "DBET, here", "UVLM, Table 5", "UVLM, here", "Navier-Stokes",
    )  # fmt: skip
    return Table(head, rows)


def wing_table(found: Found, pitch: float) -> Table:
    """Every model at an amplitude of pitch."""
    rows = []
    for model in MODELS:
        rigid, flexible = (found[model.name, pitch, modes] for modes in (0, 1))
        rows.append((
            model.label, _force(rigid), _force(flexible), _percent(*_gain(found, model.name, pitch)),
            _milli(flexible.tip, 2), _milli(flexible.tip_peak, 2), _milli(rigid.power, 1), _milli(flexible.power, 1),
            f"{rigid.beats} and {flexible.beats}", f"{rigid.seconds:.2g}",
            f"{flexible.seconds:.2g}",
        ))  # fmt: skip
    head = (
        "Model", "Rigid (mN)", "Flexible (mN)", "Gain", "Tip, 1st harmonic (mm)", "largest (mm)",
        "Power, rigid (mW)", "flexible (mW)", "Beats", "Time a beat, rigid (s)", "flexible (s)",
    )  # fmt: skip
    return Table(head, rows)


def forces(found: Found) -> Drawing:
    """Mean vertical forces, a row a model."""
    figure = Drawing(figsize=(WIDTH, 2.6), layout="constrained")
    axes = figure.subplots(1, len(PITCHES), sharey=True)
    rows = {model.name: len(MODELS) - 1 - at for at, model in enumerate(MODELS)}
    for ax, pitch in zip(axes, PITCHES, strict=True):
        for model in MODELS:
            for modes in (0, 1):
                one = found[model.name, pitch, modes]
                colour = COLOURS[model.name]
                ax.errorbar(
                    1e3 * one.force, rows[model.name], xerr=2e3 * one.force_error, fmt="o", color=colour, capsize=2,
                    markersize=5, mfc=colour if modes else "white",
                )  # fmt: skip
        if pitch == PITCHES[0]:
            for (solver, _), printed in TABLE_5.items():
                ax.plot(1e3 * printed, rows[f"{solver}-paper"] + 0.28, "x", color=MUTED, markersize=4)
        ax.set(xlim=(0, None), xlabel="Mean vertical force (mN)", title=f"{pitch:g} deg of pitch")
        ax.grid(axis="x", color="#eceff2")
        ax.set_axisbelow(True)
    axes[0].set_yticks(list(rows.values()), [model.label for model in MODELS])
    axes[0].set_ylim(-0.6, len(MODELS) - 0.4)
    return figure


def histories(found: Found) -> Drawing:
    """The flexible wing over a beat."""
    figure = Drawing(figsize=(WIDTH, 4.4), layout="constrained")
    axes = figure.subplots(2, len(PITCHES), sharex=True, sharey="row")
    time = (np.arange(PHASES) + 1) / PHASES
    labels = {"force_normal": "Normal force (mN)", "tip_deflection": "Tip deflection (mm)"}
    for column, pitch in enumerate(PITCHES):
        for ax, (name, label) in zip(axes[:, column], labels.items(), strict=True):
            for model in MODELS:
                one = found[model.name, pitch, 1]
                if name not in one.histories:
                    continue
                values = 1e3 * np.array(one.histories[name])
                width = 1.8 if model.name == REFERENCE else 1.0
                ax.plot(
                    np.append(0.0, time), np.append(values[-1], values), DASHES[model.name], linewidth=width,
                    color=COLOURS[model.name], label=model.label,
                )  # fmt: skip
            ax.axhline(0.0, color=MUTED, linewidth=0.5, zorder=1)
            ax.set(xlim=(0, 1))
            if not column:
                ax.set_ylabel(label)
        axes[0, column].set_title(f"{pitch:g} deg of pitch")
        axes[1, column].set_xlabel("t/T")
    handles, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3)
    return figure


def _gain(found: Found, name: str, pitch: float) -> tuple[float, float]:
    """What flexibility adds to the mean vertical force, and its standard error."""
    rigid, flexible = (found[name, pitch, modes] for modes in (0, 1))
    ratio = flexible.force / rigid.force
    return ratio - 1.0, ratio * float(np.hypot(rigid.force_error / rigid.force, flexible.force_error / flexible.force))


def _force(one: Kept) -> str:
    error = f"{1e3 * one.force_error:.2f}"
    return f"{1e3 * one.force:.2f}" + (f" ± {error}" if float(error) else "")


def _milli(value: float | None, digits: int) -> str:
    return "" if value is None else f"{1e3 * value:.{digits}f}"


def _percent(share: float, error: float) -> str:
    text = f"{100.0 * share:+.0f}".replace("-", "−")
    return f"{text} ± {100.0 * error:.0f} %" if round(100.0 * error) else f"{text} %"


def closing(found: Found) -> list[Any]:
    """What the report of the paper says last of Table 5."""
    return [
        Heading(2, "Table 5 in a viscous flow"),
        *map(Paragraph, answers(found)),
        table_5(found),
        Paragraph(
            "± is the standard error. [The same wing in four models](models.md) describes the runs of the last "
            "column, and more wings."
        ),
    ]
