"""The paper's wing in every model, at two amplitudes of pitch, rigid and flexible: runs, and what is kept of them.

Separated flows do not repeat from beat to beat, and neighbouring beats are alike. Every case therefore runs several
times, from different starts, and the standard error of a mean is that of the means of blocks of beats.
"""

import json
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import files
from ...case.case import Case, parse_case
from ...metrics.beats import settled_beats
from ...metrics.waves import harmonic
from ...run.blocks import simulate
from . import paper
from .measured import StudyError

Array = NDArray[np.float64]

AIR_VISCOSITY = 1.5e-5
"""m2/s."""
PITCHES = (15.0, 45.0)
"""Amplitudes of pitch, deg: the paper's, and one at which a rigid wing lifts well."""
STARTS = (1.0, 2.0)
"""Periods of the start-ups of a wing's runs."""
BEATS = 14
"""Of each run."""
BLOCK = 3
"""Beats of a block, beyond which they are taken as independent."""
PHASES = 50
"""Times of a beat at which histories are kept."""
HISTORIES = ("force_vertical", "force_normal", "tip_deflection")
KNOWN = "models.json"


@dataclass(frozen=True)
class Model:
    """A model with its settings.

    Attributes:
        name: in files.
        label: in tables and figures.
        solver: of the case file.
        settings: what it changes of the case.
        papers: whether it has the paper's settings instead of the model's own.
        steps: time steps a beat.
        bending: what it changes besides for a flexible wing.
        starts: periods of the start-ups of its runs.
        beats: of each run.
    """

    name: str
    label: str
    solver: str
    settings: tuple[str, ...] = ()
    papers: bool = False
    steps: int = 200
    bending: tuple[str, ...] = ()
    starts: tuple[float, ...] = STARTS
    beats: int = BEATS

    def case(self, pitch: float, modes: int, start: float = STARTS[0]) -> Case:
        """The paper's wing in this model.

        Args:
            pitch: amplitude, deg.
            modes: 0 is a rigid wing.
            start: periods of the start-up.
        """
        document = paper.case(paper.Settings(), "dbet" if self.solver == "dbet" else "uvlm").to_dict()
        if not self.papers:
            document.pop("dbet"), document.pop("uvlm")
        document |= {"solver": self.solver, "time": {"periods": self.beats, "steps_per_period": self.steps}}
        document["fluid"] |= {"viscosity": AIR_VISCOSITY}
        wing = (f"wing.modes={modes}", f"motion.pitch.amplitude_deg={pitch}", f"motion.start_up_periods={start}")
        return parse_case(document).override(*self.settings, *(self.bending if modes else ()), *wing, title="")


MODELS = (
    Model("dbet-paper", "DBET, paper's settings", "dbet", papers=True),
    Model("dbet", "DBET", "dbet"),
    Model("uvlm-paper", "UVLM, paper's settings", "uvlm", papers=True),
    Model("uvlm", "UVLM", "uvlm"),
    Model("uvlm-sheds", "UVLM, leading edge sheds", "uvlm", ("uvlm.leading_edge=sheds",)),
    Model(
        "navier-stokes", "Navier-Stokes", "navier_stokes", steps=2000,
        bending=("navier_stokes.thickness=0.08",), starts=(1.0, 2.0, 2.5, 3.0), beats=24,
    ),
)  # fmt: skip
"""In the order of tables and figures. A flexible section of 4 % of the chord bends too far for its map in some beats,
with 1,000 steps a beat."""


@dataclass(frozen=True)
class Kept:
    """What is kept of a wing's runs in a model, SI units.

    Attributes:
        model: its name.
        pitch: amplitude, deg.
        modes: 0 is a rigid wing.
        forces: mean vertical force of every settled beat of each run, N.
        normal: the share of their mean that is along the wing's normal, N; None, as some others, if it was not kept.
        power: mean mechanical power, W.
        tip: amplitude of the first harmonic of the tip's deflection, m.
        tip_peak: mean over the beats of the largest deflection in each, m.
        seconds: processor time of a beat on one core, s.
        histories: by variable, its mean over all settled beats at `PHASES` times of the beat.
    """

    model: str
    pitch: float
    modes: int
    forces: list[list[float]]
    normal: float | None
    power: float | None
    tip: float | None
    tip_peak: float
    seconds: float
    histories: dict[str, list[float]]

    @property
    def key(self) -> tuple[str, float, int]:
        """Model, pitch and modes."""
        return self.model, self.pitch, self.modes

    @property
    def beats(self) -> int:
        """Settled beats of all runs."""
        return sum(map(len, self.forces))

    @property
    def force(self) -> float:
        """Mean vertical force, N."""
        return float(np.mean(np.concatenate(self.forces)))

    @property
    def force_error(self) -> float:
        """Its standard error, N: from the means of blocks of beats, none of which spans two runs."""
        blocks = [
            float(np.mean(run[first : first + BLOCK]))
            for run in self.forces
            for first in range(len(run) % BLOCK, len(run), BLOCK)
        ]
        return float(np.std(blocks, ddof=1) / np.sqrt(len(blocks)))


Found = dict[tuple[str, float, int], Kept]


def wings() -> Iterator[tuple[float, int]]:
    """Amplitudes of pitch with numbers of modes."""
    for pitch in PITCHES:
        for modes in (0, 1):
            yield pitch, modes


def measure(model: Model, pitch: float, modes: int) -> Kept:
    """Run a wing in a model, on one core.

    Raises:
        StudyError: when a run fails.
    """
    forces, histories, means, spent = [], [], [], 0.0
    for start in model.starts:
        case = model.case(pitch, modes, start)
        # The kernels, compiled or fetched, are no part of a beat.
        simulate(case.override("time.periods=1"), threads=1).close()
        before = time.process_time()
        with simulate(case.override(f"output.every={case.steps}"), threads=1) as result:
            spent += time.process_time() - before
            if result.status != "complete":
                raise StudyError(f"{model.label}, {pitch:g} deg, {modes} modes: {result.attributes.get('reason')}")
            beats = settled_beats(result)
            forces.append(beats.means(result.force_vertical).tolist())
            tips = beats.peaks(result.tip_deflection).mean()
            first = abs(harmonic(case, result.time[beats.frames], result.tip_deflection[beats.frames]))
            means.append([
                beats.means(result.force_vertical_normal).mean(), beats.means(result.power).mean(), first, tips,
            ])  # fmt: skip
            shape = len(beats), PHASES, model.steps // PHASES
            histories.append(
                [getattr(result, name)[beats.frames].reshape(shape)[..., -1].mean(0) for name in HISTORIES]
            )
    normal, power, tip, tip_peak = np.mean(means, axis=0)
    drawn = dict(zip(HISTORIES, np.mean(histories, axis=0), strict=True))
    return Kept(
        model.name, pitch, modes, [[_rounded(value) for value in run] for run in forces],
        _rounded(normal), _rounded(power), _rounded(tip), _rounded(tip_peak),
        _rounded(spent / len(model.starts) / model.beats, 3),
        {name: [_rounded(value) for value in values] for name, values in drawn.items()},
    )  # fmt: skip


def compute(path: Path, progress: Callable[[float], None] | None = None) -> Found:
    """Run every wing in every model on one core, and store each result in a file at once.

    Raises:
        StudyError: when a run fails.
    """
    found: Found = {}
    cells = [(model, *wing) for model in MODELS for wing in wings()]
    for number, (model, pitch, modes) in enumerate(cells):
        kept = measure(model, pitch, modes)
        found[kept.key] = kept
        with files.replacing(path) as file:
            file.write(json.dumps([asdict(one) for one in found.values()], indent=1).encode())
        if progress is not None:
            progress((number + 1) / len(cells))
    return found


def read(text: str) -> Found:
    """What `compute` has kept."""
    rows: list[dict[str, Any]] = json.loads(text)
    kept = [Kept(**row) for row in rows]
    return {one.key: one for one in kept}


@cache
def known() -> Found:
    """What came out when this version was made.

    By `compute`; but the runs of Navier-Stokes were made by sixteen processes, and the first five beats of each were
    dropped. Of them forces, largest deflections and times were kept.
    """
    return read(resources.files(__package__).joinpath(KNOWN).read_text("utf-8"))


def _rounded(value: float, digits: int = 5) -> float:
    return float(f"{value:.{digits}g}")
