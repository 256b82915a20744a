"""The map of a graded wing: mean vertical force, and force for its power, against frequency ratio and grading.

    python examples/graded_wing.py docs/graded_wing.svg

The hawkmoth's wing and stroke with a stiffness that decreases linearly along the chord by a factor, scaled so that the
first natural frequency is a multiple of the flapping frequency. After Reade & Jankauski's study of graded rigidity
(2022).
"""

import sys
from pathlib import Path

import numpy as np

import taichiflap
from taichiflap.plots.style import HOUSE
from taichiflap.structure import beam

CASE = Path(__file__).parent.parent / "cases" / "graded_wing.toml"
PAPERS_BLADES = (
    "dbet.coefficients=reade_jankauski",
    "dbet.frame=chord",
    "dbet.added_mass=strip",
    "dbet.attached=false",
    "dbet.rotation=0.0",
)
"""The blade elements of Reade & Jankauski (2020)."""
RATIOS = (2.0, 2.25, 2.5, 2.75, 3.0, 3.25, 3.5, 4.0, 5.0, 6.0)
FALLS = (1.0, 0.3, 0.1, 0.03)
"""Stiffness at the trailing edge over that at the leading edge."""


def graded(case, ratio, fall):
    """The case with graded stiffness, and its first natural frequency at `ratio` times the flapping frequency."""
    unit = case.override(f"wing.flexural_rigidity=[[0.0, 1e-6], [1.0, {1e-6 * fall}]]")
    first = beam.modes(unit.wing).frequency[0]
    root = 1e-6 * (ratio * case.motion.frequency / first) ** 2
    return case.override(f"wing.flexural_rigidity=[[0.0, {root}], [1.0, {root * fall}]]")


def maps(solver, ratios=RATIOS, falls=FALLS, settings=()):
    """Mean vertical force over the rigid wing's and the same for force over power, shape (2, falls, ratios)."""
    case = taichiflap.load_case(CASE, (f"solver={solver}", "output.every=2", *PAPERS_BLADES, *settings))
    cases = [graded(case, ratio, fall) for fall in falls for ratio in ratios]
    rigid, *found = (
        (summary.force_vertical.mean, summary.force_vertical.mean / summary.power_positive.mean)
        for summary in map(taichiflap.summarise, taichiflap.simulate([case.override("wing.modes=0"), *cases]))
    )
    return (np.array(found) / rigid).T.reshape(2, len(falls), len(ratios))


def draw(path):
    """Compute both maps and draw them."""
    import matplotlib.pyplot as plt  # noqa: PLC0415

    plt.style.use(HOUSE)
    figure, axes = plt.subplots(2, 2, figsize=(9, 7), sharex=True, layout="constrained")
    for column, solver in zip(axes.T, ("dbet", "uvlm"), strict=True):
        found = maps(solver)
        for ax, values, name in zip(column, found, ("mean vertical force", "force over positive power"), strict=True):
            for fall, line in zip(FALLS, values, strict=True):
                ax.plot(RATIOS, line, "o-", markersize=3, label=f"{fall:g}")
            ax.axhline(1.0, color="0.6", linewidth=0.8)
            ax.set_title(f"{solver.upper()}: {name}, over the rigid wing's", fontsize=9)
        print(solver, np.array2string(found, precision=3))
    for ax in axes[1]:
        ax.set_xlabel("first natural frequency over flapping frequency")
    axes[0, 0].legend(title="stiffness, trailing over leading edge", fontsize=8, title_fontsize=8)
    figure.savefig(path)


if __name__ == "__main__":
    draw(sys.argv[1] if len(sys.argv) > 1 else "graded_wing.svg")
