"""Effect of flexibility on the hawkmoth's force: one beat of the flexible wing and of a rigid wing.

python examples/flexible_and_rigid.py flexible_and_rigid.png
"""

import sys

import matplotlib.pyplot as plt

import taichiflap
from taichiflap.case import shipped
from taichiflap.plots.style import HOUSE


def compute(*settings):
    """Results of the flexible and the rigid wing, with the paper's vortex lattice."""
    case = taichiflap.load_case(shipped.FOLDER / "hawkmoth.toml", settings)
    return taichiflap.simulate([case, case.override("wing.modes=0")])


def gain(results):
    """Mean vertical force of the flexible wing over that of the rigid one."""
    flexible, rigid = (taichiflap.summarise(result).force_vertical.mean for result in results)
    return flexible / rigid


def draw(path):
    plt.style.use(HOUSE)
    results = compute()
    figure, (top, bottom) = plt.subplots(2, figsize=(6, 5), sharex=True, layout="constrained")
    for result, name in zip(results, ("flexible", "rigid"), strict=True):
        beat = slice(-round(result.case.steps_per_beat) - 1, None)
        turns = (result.time[beat] - result.time[beat][0]) / result.case.beat
        top.plot(turns, 1e3 * result.force_vertical[beat], label=name)
        bottom.plot(turns, 1e3 * result.tip_deflection[beat], label=name)
    top.set_title(f"bending multiplies the mean vertical force by {gain(results):.2f}", fontsize=10)
    top.set_ylabel("vertical force (mN)")
    bottom.set(ylabel="tip deflection (mm)", xlabel="t/T after reversal")
    top.legend()
    figure.savefig(path)


if __name__ == "__main__":
    draw(sys.argv[1] if len(sys.argv) > 1 else "flexible_and_rigid.png")
