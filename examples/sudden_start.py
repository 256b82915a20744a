"""A suddenly started plate: the wake delays its lift, as calculated by Wagner in 1925.

python examples/sudden_start.py sudden_start.png
"""

import math
import sys

import matplotlib.pyplot as plt
import numpy as np

import taichiflap
from taichiflap.case.case import parse_case
from taichiflap.plots.style import HOUSE
from taichiflap.theory import wagner

CHORD, SPEED, ANGLE = 0.1, 1.0, 1.0


def compute(chords=10.0, step=0.05):
    """Distances s (half-chords) and the fraction of the steady lift."""
    case = parse_case(
        {
            "wing": {"chord": CHORD, "span": 1.0, "thickness": 1e-3, "density": 1e3, "modes": 0},
            "motion": {"pitch": {"mean_deg": ANGLE}},
            "fluid": {"velocity": [SPEED, 0.0]},
            "time": {"duration": chords * CHORD / SPEED, "step": step * CHORD / SPEED},
        }
    )
    with taichiflap.simulate(case) as result:
        steady = math.pi * case.fluid.density * SPEED**2 * CHORD * math.sin(math.radians(ANGLE))
        return 2.0 * SPEED * result.time / CHORD, -result.force_normal / steady


def draw(path):
    plt.style.use(HOUSE)
    s, lift = compute()
    figure, ax = plt.subplots(figsize=(6, 3.5), layout="constrained")
    ax.plot(s, [wagner(one) for one in s], color="0.6", linewidth=4, label="Wagner")
    ax.plot(s[1:], lift[1:], label="UVLM, 20 panels")
    ax.set(xlabel="distance travelled, s = 2Ut/c (half-chords)", ylabel="lift over steady lift", ylim=(0.0, 1.0))
    ax.legend(loc="lower right")
    figure.savefig(path)
    print("largest difference beyond s = 1:", np.abs(lift - np.vectorize(wagner)(s))[s > 1.0].max())


if __name__ == "__main__":
    draw(sys.argv[1] if len(sys.argv) > 1 else "sudden_start.png")
