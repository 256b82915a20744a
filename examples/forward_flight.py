"""Thrust of a plate that plunges in a stream, compared with Garrick's theory of 1936: it is entirely leading-edge
suction.

python examples/forward_flight.py forward_flight.png
"""

import math
import sys

import matplotlib.pyplot as plt
import numpy as np

import taichiflap
from taichiflap.case.case import parse_case
from taichiflap.plots.style import HOUSE
from taichiflap.theory import mean_thrust

CHORD, SPAN, SPEED, PLUNGE = 0.1, 0.4, 0.5, 0.02
FREQUENCIES = (0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0)


def compute(frequencies=FREQUENCIES, steps=80):
    """Mean thrust coefficients divided by the squared plunge amplitude in chords, at reduced frequencies pi f c/U."""
    cases = [
        parse_case(
            {
                "wing": {"chord": CHORD, "span": SPAN, "thickness": 1e-3, "density": 1e3, "modes": 0},
                "motion": {"frequency": k * SPEED / (math.pi * CHORD), "plunge": {"amplitude": PLUNGE * CHORD}},
                "fluid": {"velocity": [SPEED, 0.0], "density": 998.0},
                "uvlm": {"suction": True},
                "time": {"periods": 4, "steps_per_period": steps},
            }
        )
        for k in frequencies
    ]
    scale = 0.5 * 998.0 * SPEED**2 * CHORD * SPAN * PLUNGE**2
    return np.array([-np.mean(result.force_y[-steps:]) / scale for result in taichiflap.simulate(cases)])


def draw(path):
    plt.style.use(HOUSE)
    fine = np.linspace(0.01, 1.05, 100)
    figure, ax = plt.subplots(figsize=(6, 3.5), layout="constrained")
    ax.plot(fine, [mean_thrust(k, plunge=1.0) for k in fine], color="0.6", linewidth=4, label="Garrick")
    ax.plot(FREQUENCIES, compute(), "o", label="UVLM, with suction")
    ax.set(xlabel="reduced frequency, k = πfc/U", ylabel="mean thrust coefficient / (h/c)²")
    ax.legend()
    figure.savefig(path)


if __name__ == "__main__":
    draw(sys.argv[1] if len(sys.argv) > 1 else "forward_flight.png")
