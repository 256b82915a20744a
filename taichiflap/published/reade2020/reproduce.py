"""Reproduction of the paper: every case of Reade & Jankauski (2020) next to the printed numbers, and further cases."""

import contextlib
import os
from pathlib import Path

from ... import files, pages
from ..._version import __version__
from ...pages import Block, Figure, Heading, Paragraph, Table
from ...structure import beam
from . import archive, drawings, models, models_page, paper, plan, tables
from .measured import Progress, machine
from .paper import Settings
from .verdict import Verdict
from .verdicts import verdicts

STAGES = (0.8, 0.05, 0.07, 0.08)
"""Shares of the time that computing, timing, drawing and the rest take."""
OF_MODELS = 0.9
"""Share of the time that the wing in every model takes, where it is computed too."""
REPORT, PAGE, DATA = "report.md", "report.html", "data.h5"


def reproduce(
    folder: Path,
    *,
    settings: Settings | None = None,
    every_model: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> list[Verdict]:
    """Compute everything and write figures (PNG, SVG), data (HDF5) and a report (Markdown, HTML) into a folder.

    Args:
        folder: created if it does not exist.
        settings: extent of the computation; by default the paper's settings and further ones.
        every_model: rerun the wing in every model, which takes tens of minutes; by default stored results are shown.
        overwrite: write into a folder that is not empty.
        progress: callback of the fraction of the work done.

    Returns:
        The verdicts that open the report.

    Raises:
        OutputError: when the folder cannot be written, or holds files.
        StudyError: when a case fails.
    """
    settings = settings or Settings()
    prepare(folder, overwrite)
    if every_model:
        first, progress = _stages(progress, (OF_MODELS, 1.0 - OF_MODELS))
        wings = models.compute(folder / models.KNOWN, first)
    else:
        wings = models.known()
    computing, timing, drawing, rest = _stages(progress, STAGES)
    runs = plan.compute(settings, computing)
    timing(0.0)
    timings = plan.timings(settings)
    frequency = float(beam.modes(paper.case(settings, "dbet").wing).frequency[0])
    found = verdicts(settings, runs, frequency, timings, machine())
    drawings.draw(settings, runs, folder, drawing)
    rest(0.0)
    archive.write(folder / DATA, runs, {f"solve_time_{solver}": seconds for solver, seconds in timings.items()})
    models_page.write(wings, folder)
    blocks = [*_blocks(settings, runs, found), *models_page.closing(wings)]
    for name, text in ((REPORT, pages.markdown(blocks)), (PAGE, pages.html(blocks, folder))):
        with files.replacing(folder / name) as file:
            file.write(text.encode())
    rest(1.0)
    return found


def _stages(progress: Progress | None, shares: tuple[float, ...]) -> list[Progress]:
    """The progress of each part of the work as a share of all of it."""
    starts = [sum(shares[:number]) for number in range(len(shares))]

    def stage(start: float, share: float) -> Progress:
        return lambda done: progress(start + share * done) if progress is not None else None

    return [stage(start, share) for start, share in zip(starts, shares, strict=True)]


def prepare(folder: Path, overwrite: bool) -> None:
    """Create the folder, and check it before the computation.

    Raises:
        OutputError: when it cannot be written, or holds files.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()) and not overwrite:
            raise files.OutputError(
                f"{folder}: is not empty; use --overwrite to replace its files, or -o to write elsewhere"
            )
        trial = folder / f".{os.getpid()}.part"
        with contextlib.suppress(FileNotFoundError):
            trial.touch()
            trial.unlink()
    except OSError as error:
        raise files.OutputError(f"{folder}: cannot be written: {error.strerror or error}") from None


def _blocks(settings: Settings, runs: plan.Runs, found: list[Verdict]) -> list[Block]:
    reproduced = sum(verdict.reproduced is True for verdict in found)
    compared = sum(verdict.reproduced is not None for verdict in found)
    return [
        Heading(1, "The paper reproduced"),
        Paragraph(
            "Reade & Jankauski, Deformable blade element and unsteady vortex lattice fluid-structure interaction "
            "modeling of a 2D flapping wing (ASME IDETC 2020, DETC2020-22638), computed again and compared with the "
            "printed values. This page is written by `taichiflap reproduce`."
        ),
        Paragraph(
            f"Every case runs {settings.periods} beats of {settings.steps_per_period} steps in a fluid of {paper.AIR} "
            f"kg/m³ unless stated otherwise. Numbers are over the last {tables.beats(runs)} beats; ± is the standard "
            "deviation between beats. The full vector is the total force of the fluid. The wing-normal part is its "
            "component along the normal of the undeformed wing, which the paper's figures show."
        ),
        Paragraph(f"{paper.described(settings)} Version {__version__}."),
        Heading(2, f"Verdicts: {reproduced} of {compared} reproduced"),
        Table(
            ("Quantity", "Paper", "Here", "Verdict", "Difference, or reason"),
            [(one.what, one.printed, one.here, one.state, one.why) for one in found],
        ),
        Heading(2, "Convergence: Figs 4 and 5, and what they missed"),
        Figure("figure4", "Tip deflection, as in the paper, and mean force against the number of blade elements."),
        Figure("figure5", "The same for UVLM against panels and wake vortices, in the paper's ranges."),
        Figure(
            "wake",
            "Longer wakes, up to the whole wake. Dashed: one beat of wake, as in the paper.",
        ),
        tables.wakes(settings, runs),
        Heading(2, "Forces over a beat: Figs 6 and 7"),
        Figure(
            "figure6",
            "Normal force on the rigid wing over the last beat, with the paper's origin of time. Spikes are due to "
            "wake vortices that pass close to the wing; as in the paper, they have no core.",
        ),
        Figure("figure7", "Tip deflection and normal force of the flexible wing over the last beat."),
        tables.harmonics(runs),
        Figure("cause", "Effect of the added mass on the phase between the models."),
        Heading(2, "Mean vertical force: Table 5"),
        Figure("table5", "The paper's values and both definitions."),
        tables.mean_forces(runs),
        tables.gains(runs),
        Heading(2, "Beyond the paper: modes, density, speed"),
        tables.modes(settings, runs),
        Figure("density", "The density that the paper does not state. Dotted: the numbers of Table 5."),
        tables.densities(settings, runs),
        tables.speeds(runs),
        Heading(2, "Beyond the paper: power"),
        Paragraph(
            "Mechanical power of the actuator, the power delivered to the fluid, the positive part alone (the power "
            "of an actuator without energy storage), and the mean vertical force (full vector) per power."
        ),
        tables.power(runs),
    ]
