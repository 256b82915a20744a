"""A sweep in a second: peak tip deflection and lift per power over the wing's stiffness, with blade elements.

python examples/stiffness.py stiffness.png
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import taichiflap
from taichiflap.case import shipped
from taichiflap.plots.style import HOUSE

MODULI = np.geomspace(12e9, 120e9, 60)


def compute(moduli=MODULI):
    """Peak tip deflection (m) and mean vertical force over mean power (N/W) at every Young's modulus."""
    case = taichiflap.load_case(shipped.FOLDER / "hawkmoth_dbet.toml")
    results = taichiflap.simulate([case.override(f"wing.youngs_modulus={modulus}") for modulus in moduli])
    found = [taichiflap.summarise(result) for result in results]
    tips = np.array([one.tip_peak.mean for one in found])
    return tips, np.array([one.force_vertical.mean / one.power.mean for one in found])


def draw(path):
    plt.style.use(HOUSE)
    tips, economy = compute()
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.2), layout="constrained")
    left.plot(MODULI / 1e9, 1e3 * tips)
    left.set(xlabel="Young's modulus (GPa)", ylabel="peak tip deflection (mm)")
    right.plot(MODULI / 1e9, economy)
    right.set(xlabel="Young's modulus (GPa)", ylabel="vertical force over power (N/W)")
    figure.savefig(path)


if __name__ == "__main__":
    draw(sys.argv[1] if len(sys.argv) > 1 else "stiffness.png")
