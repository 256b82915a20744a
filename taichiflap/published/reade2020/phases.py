"""Verdicts on phases and third harmonics, and the search for one DBET setting that agrees with all of the paper."""

import math
from collections.abc import Iterator

from ...structure import beam
from ...structure.chordwise import Profile
from . import paper
from .measured import Measured
from .paper import DENSITY_OF_THE_ROW, TABLE_5
from .plan import NO_ADDED_MASS, RIGID, ROW, TRUNCATED, UNDAMPED, Runs, key
from .verdict import CLOSE, DEFINITIONS, Verdict

NORMAL, TIP = "force_normal", "tip_deflection"
NEAR_PHASE = 5.0
"""Tolerance of a phase, degrees."""
NEAR_TIME = 0.01
"""Tolerance of the time of the peak, beats."""
NEAR_FORCE, NEAR_GAIN = 0.05, 0.02
"""Relative tolerances of a mean force, and of its gain by flexibility."""

SETTINGS: tuple[tuple[str, tuple[str, ...], tuple[str, ...]], ...] = (
    ("as the tables say", (), ()),
    ("undamped", (UNDAMPED,), ()),
    ("truncated speed", (TRUNCATED,), ()),
    ("truncated speed, undamped", (TRUNCATED, UNDAMPED), ()),
    ("no added mass", (NO_ADDED_MASS,), (NO_ADDED_MASS,)),
    (f"no added mass, {DENSITY_OF_THE_ROW} kg/m3", ROW, ROW),
    (f"no added mass, undamped, {DENSITY_OF_THE_ROW} kg/m3", (*ROW, UNDAMPED), ROW),
)
"""DBET by name: what is changed for the flexible wing, and for the rigid one."""


def verdicts(runs: Runs) -> list[Verdict]:
    """Phase of the normal force, flexible and rigid; its size; the third harmonic; all of it at once."""
    return [_flexible(runs), _rigid(runs), _larger(runs), _third(runs), _whole(runs)]


def _lag(run: Measured, lattice: Measured) -> float:
    """Phase lag of a run's normal force relative to another's, degrees."""
    return -run.phase(NORMAL, lattice)


def _turned(lag: float, without: float) -> str:
    if lag < 0.0 < without:
        return "the added mass turns the sign"
    return "the added mass does not turn the sign" if lag < 0.0 else "the sign is the paper's"


def _flexible(runs: Runs) -> Verdict:
    blades, lattice = runs[key("dbet")], runs[key("uvlm")]
    lag = _lag(blades, lattice)
    less = -blades.phase(NORMAL, lattice, blades.first_quasi_steady)
    truncated = _lag(runs[key("dbet", TRUNCATED)], lattice)
    bare = _lag(runs[key("dbet", *ROW)], lattice)
    return Verdict(
        "normal force, flexible: DBET lags UVLM by", f"{paper.FORCE_LAG:.0f} deg", f"{lag:+.1f} deg",
        abs(lag - paper.FORCE_LAG) < NEAR_PHASE,
        f"{_turned(lag, min(less, bare))}: {truncated:+.1f} deg with Eq. 22's truncated speed, {less:+.1f} deg for the "
        f"same run's force without its added-mass part, and {bare:+.1f} deg for DBET without added mass at "
        f"{DENSITY_OF_THE_ROW} kg/m3",
    )  # fmt: skip


def _rigid(runs: Runs) -> Verdict:
    lattice = runs[key("uvlm", RIGID)]
    lag, bare = (_lag(runs[key("dbet", *more, RIGID)], lattice) for more in ((), (NO_ADDED_MASS,)))
    return Verdict(
        "normal force, rigid: DBET lags UVLM", "yes, a little", f"{lag:+.1f} deg", lag > 0.0,
        f"{_turned(lag, bare)}: {bare:+.1f} deg without it",
    )  # fmt: skip


def _larger(runs: Runs) -> Verdict:
    blades, lattice = (1e3 * abs(runs[key(solver, RIGID)].first[NORMAL]) for solver in ("dbet", "uvlm"))
    return Verdict(
        "normal force, rigid: UVLM is the larger", "yes", f"{lattice:.1f} against {blades:.1f} mN", lattice > blades,
        "amplitudes of the first harmonic",
    )  # fmt: skip


def _third(runs: Runs) -> Verdict:
    blades, lattice = runs[key("dbet")], runs[key("uvlm")].third_share(TIP)
    share = blades.third_share(TIP)
    case = blades.case
    dry, order = beam.modes(case.wing).frequency[0], 3.0 / case.beat
    area = case.wing.chord * Profile.of(case.wing.span).mean
    mass_ratio = math.pi * case.fluid.density * case.wing.chord * area / (4.0 * beam.modes(case.wing).mass)
    wet = dry / math.sqrt(1.0 + mass_ratio)
    tried = []
    for name, more in (
        ("without added mass", (NO_ADDED_MASS,)),
        ("and undamped, as Eq. 11 is printed,", (*ROW, UNDAMPED)),
    ):
        other = runs[key("dbet", *more)].third_share(TIP)
        tried.append(f"{name} {other:.3f}, {'more than' if other > lattice else 'not more than'} UVLM")
    return Verdict(
        "tip: DBET has the larger third harmonic", "yes", f"{share:.3f} against {lattice:.3f} of the first",
        share > lattice,
        f"{'; '.join(tried)}. The third harmonic is at {order:g} Hz, {abs(dry / order - 1.0):.0%} from the dry wing's "
        f"{dry:.0f} Hz and {abs(wet / order - 1.0):.0%} from the {wet:.0f} Hz that added mass makes of it",
    )  # fmt: skip


def _whole(runs: Runs) -> Verdict:
    """The DBET setting that agrees with most statements of the paper, and the statements it misses."""
    scores = [
        (name, definition, list(_statements(runs, flexible, rigid, definition)))
        for name, flexible, rigid in SETTINGS
        for definition in DEFINITIONS
    ]
    name, definition, statements = max(scores, key=lambda score: sum(agrees for _, agrees in score[2]))
    agree = [text for text, agrees in statements if agrees]
    differ = [text for text, agrees in statements if not agrees]
    return Verdict(
        "the whole of the paper's DBET at once", f"all {len(statements)} of its statements",
        f"{len(agree)} of {len(statements)}", not differ,
        f"the best of {len(scores)} settings, {name}, {DEFINITIONS[definition]}. Agree: {', '.join(agree)}. "
        + (f"Do not: {', '.join(differ)}" if differ else ""),
    )  # fmt: skip


def _statements(
    runs: Runs, flexible: tuple[str, ...], rigid: tuple[str, ...], definition: str
) -> Iterator[tuple[str, bool]]:
    run, plate, lattice = runs[key("dbet", *flexible)], runs[key("dbet", *rigid, RIGID)], runs[key("uvlm")]
    for name, one, modes in (("rigid", plate, 0), ("flexible", run, 1)):
        force = getattr(one.summary, definition).mean
        off = abs(force / TABLE_5["dbet", modes] - 1.0)
        yield f"{name} mean force {1e3 * force:.2f} mN", off <= NEAR_FORCE
    growth = getattr(run.summary, definition).mean / getattr(plate.summary, definition).mean - 1.0
    yield f"gain {growth:+.1%}", abs(growth - paper.GAIN["dbet"]) <= NEAR_GAIN
    yield f"flexible lag {_lag(run, lattice):+.1f} deg", abs(_lag(run, lattice) - paper.FORCE_LAG) < NEAR_PHASE
    still = _lag(plate, runs[key("uvlm", RIGID)])
    yield f"rigid lag {still:+.1f} deg", still > 0.0
    share = run.third_share(TIP)
    yield f"third harmonic {share:.3f} of the first", share > lattice.third_share(TIP)
    peak = run.summary.tip_peak.mean
    yield f"tip {1e3 * peak:.2f} mm", abs(peak / paper.TIP - 1.0) <= CLOSE
    time = (run.summary.tip_peak_after_reversal or 0.0) + paper.REVERSAL
    yield f"its time t/T {time:.3f}", abs(time - paper.TIP_TIME) <= NEAR_TIME
