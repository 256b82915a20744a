"""The same beat of a bending wing in two models: the vortex wake of UVLM, and the vorticity of Navier-Stokes.

python examples/two_wakes.py two_wakes.png
"""

import sys

import matplotlib as mpl
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

import taichiflap
from taichiflap.case import shipped
from taichiflap.drawing import flow, palette, scene
from taichiflap.plots.style import HOUSE

PAGE = (-0.044, 0.044, -0.064, 0.014)
"""Left, right, bottom and top of a panel, m."""
INSTANTS = (0.125, 0.375, 0.625, 0.875)
"""Of the last beat."""
ACROSS = 700
"""Points of a picture of the vorticity along its longer side."""
LATTICE = ("solver=uvlm", "time.steps_per_period=200")


def compute(periods=3):
    """Results of UVLM and of Navier-Stokes, in memory."""
    viscous = taichiflap.load_case(shipped.FOLDER / "hawkmoth_ns.toml", (f"time.periods={periods}",))
    return [taichiflap.simulate(case) for case in (viscous.override(*LATTICE), viscous)]


def draw(results):
    """Instants of the last beat from left to right, UVLM above Navier-Stokes."""
    colours = ListedColormap(palette.table(palette.LIGHT.flow) / 255.0)
    edges = [1e3 * edge for edge in PAGE]
    with mpl.rc_context(HOUSE):
        figure = Figure(figsize=(7.6, 3.9), layout="constrained")
        for row, result in zip(figure.subplots(2, len(INSTANTS), sharex=True, sharey=True), results, strict=True):
            stored = scene.last_beats(result)
            chosen = stored[[round(turn * (len(stored) - 1)) for turn in INSTANTS]]
            backdrop = flow.Backdrop.of(result, chosen)
            frames = [scene.frame(result, int(index)) for index in chosen]
            strong = np.quantile(np.abs(np.concatenate([[0.0], *(frame.circulation for frame in frames)])), 0.9)
            for ax, frame in zip(row, frames, strict=True):
                if backdrop:
                    found = backdrop.vorticity(frame, PAGE, ACROSS) / backdrop.limit
                    ax.imshow(
                        found, cmap=colours, vmin=-1, vmax=1, extent=edges, origin="lower", interpolation="bicubic"
                    )
                else:
                    colour = frame.circulation / strong
                    ax.scatter(*(1e3 * frame.wake.T), c=colour, cmap=colours, vmin=-1, vmax=1, s=3, linewidths=0)
                ax.plot(*(1e3 * frame.wing.T), color=palette.LIGHT.ink, linewidth=1.6, solid_capstyle="round")
                ax.plot(*(1e3 * frame.wing[0]), "o", color=palette.LIGHT.ink, markersize=3)
                ax.set(xlim=edges[:2], ylim=edges[2:], aspect="equal")
                if result is results[0]:
                    ax.set_title(f"t/T = {frame.beats % 1.0:.3f}", fontsize=8)
            row[0].set_ylabel(f"{result.case.model}\nup (mm)")
        for ax in row:
            ax.set_xlabel("Z (mm)")
    return figure


if __name__ == "__main__":
    draw(compute()).savefig(sys.argv[1] if len(sys.argv) > 1 else "two_wakes.png", dpi=150)
