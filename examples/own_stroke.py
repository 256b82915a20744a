"""A custom stroke: hover with a triangular stroke and quick pitch reversals, seen from the side.

python examples/own_stroke.py own_stroke.png
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import taichiflap
from taichiflap.case import shipped
from taichiflap.plots.style import HOUSE

STROKE = (
    'motion.plunge={ kind = "triangle", amplitude = 0.02, phase_deg = 90.0, sharpness = 0.9 }',
    'motion.pitch={ kind = "trapezoid", amplitude_deg = 45.0, sharpness = 2.0 }',
    "wing.youngs_modulus=60e9",
)


def compute(*settings):
    """The result, by blade elements."""
    case = taichiflap.load_case(shipped.FOLDER / "hawkmoth_dbet.toml", (*STROKE, *settings))
    return taichiflap.simulate(case)


def draw(path):
    plt.style.use(HOUSE)
    result = compute()
    beat = round(result.case.steps_per_beat)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3), layout="constrained", width_ratios=(2, 1))
    for frame in range(0, beat // 2 + 1, beat // 24):
        y, z = 1e3 * result.node_position[-beat - 1 + frame].T
        axes[0].plot(z, -y, color=plt.cm.viridis(2.0 * frame / beat))
        axes[0].plot(z[0], -y[0], "ko", markersize=3)
    axes[0].set(xlabel="Z (mm)", ylabel="up (mm)", aspect="equal", title="half a beat, dark to light; dots: pivot")
    turns = np.arange(beat + 1) / beat
    axes[1].plot(turns, 1e3 * result.force_vertical[-beat - 1 :])
    axes[1].set(xlabel="t/T", ylabel="vertical force (mN)")
    figure.savefig(path)


if __name__ == "__main__":
    draw(sys.argv[1] if len(sys.argv) > 1 else "own_stroke.png")
