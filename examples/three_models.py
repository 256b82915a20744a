"""A bending wing in a stream by three fluid models: two of the package, and `theodorsen.py` beside this script.

python examples/three_models.py three_models.png
"""

import sys

import matplotlib.pyplot as plt

import taichiflap
from taichiflap.case.case import parse_case
from taichiflap.plots.style import HOUSE

MODELS = {"uvlm": ("UVLM", "-"), "module:theodorsen": ("Theodorsen", "--"), "dbet": ("DBET", "-")}
"""Name and line of each."""
CASE = {
    "wing": {"chord": 0.1, "span": 0.3, "thickness": 1e-3, "density": 1e3, "youngs_modulus": 2e8, "modes": 1},
    "motion": {"frequency": 2.0, "plunge": {"amplitude": 0.005}},
    "fluid": {"velocity": [2.0, 0.0]},
    "time": {"periods": 5, "steps_per_period": 100},
}


def compute():
    """One result a model."""
    return [taichiflap.simulate(parse_case({"solver": solver, **CASE})) for solver in MODELS]


def draw(path):
    plt.style.use(HOUSE)
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.2), layout="constrained")
    for result, (name, line) in zip(compute(), MODELS.values(), strict=True):
        beat = slice(-101, None)
        turns = result.time[beat] / result.case.beat - 4.0
        left.plot(turns, 1e3 * result.force_normal[beat], line)
        right.plot(turns, 1e3 * result.tip_deflection[beat], line, label=name)
    left.set(xlabel="t/T", ylabel="normal force (mN)")
    right.set(xlabel="t/T", ylabel="tip deflection (mm)")
    right.legend()
    figure.savefig(path)


if __name__ == "__main__":
    draw(sys.argv[1] if len(sys.argv) > 1 else "three_models.png")
