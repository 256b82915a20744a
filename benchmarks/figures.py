"""The figures: time against size with the limit of the hardware, and cost against error."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from taichiflap.kernels.runtime import available_threads

from .accuracy import WITHIN, Point
from .pairs import PairRates
from .wakes import StepTimes, exponent


def draw_sizes(rates: PairRates, steps: StepTimes, path: Path) -> None:
    """Pair sums of a cloud on itself, and steps of the march, against the number of vortices."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.6), layout="constrained")
    for name, of in rates.rate.items():
        sizes = np.array(list(of))
        left.loglog(
            sizes, sizes**2 / np.array(list(of.values())) * 1e3, "k-" if name == "C loop" else "o--", label=name
        )
    left.set(xlabel="Vortices", ylabel="Time of a pair sum, one thread (ms)", title="Pair sums")
    for name, times in steps.items():
        sizes = np.array(list(times))
        label = f"ours, {name}; exponent {exponent(times):.2f} from 3,200 up"
        right.loglog(sizes, 1e3 * np.array(list(times.values())), "o--", label=label)
    threads = available_threads()
    limit = 1e3 * sizes.astype(float) ** 2 / (rates.limit() * threads)
    right.loglog(sizes, limit, "k-", label=f"direct sum, C loop, {threads} threads")
    right.set(xlabel="Wake vortices", ylabel="Time of a step (ms)", title="A step of the march")
    _finish(figure, (left, right), path)


def draw_accuracy(points: list[Point], path: Path) -> None:
    """Error of amplitude and phase against processor time."""
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 4.6), layout="constrained")
    for who in dict.fromkeys(point.who for point in points):
        mine = [point for point in points if point.who == who]
        seconds = [point.seconds for point in mine]
        axes[0].loglog(seconds, [abs(point.amplitude) for point in mine], "o--", label=who)
        axes[1].loglog(seconds, [abs(point.phase) for point in mine], "o--", label=who)
    axes[0].axhline(WITHIN, color="0.5", lw=0.8)
    axes[0].set(xlabel="Processor time (s)", ylabel="Error of the amplitude (%)", title="Theodorsen, plunge, k = 0.5")
    axes[1].set(xlabel="Processor time (s)", ylabel="Error of the phase (deg)", title="The same runs")
    _finish(figure, axes, path)


def _finish(figure: plt.Figure, axes: object, path: Path) -> None:
    for axis in np.atleast_1d(np.asarray(axes)):
        axis.grid(True, which="major", alpha=0.3)
        axis.legend(frameon=False, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.17))
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)
