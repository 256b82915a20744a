"""The picture of the README: one beat of the hawkmoth, its vorticity in Navier-Stokes beside the wake of the lattice.

    python docs/two_flows.py NS.h5 UVLM.h5

The results are those of `cases/hawkmoth_ns.toml` and of the same file with `solver=uvlm`.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure

import taichiflap
from taichiflap.drawing import flow, palette, scene

PICTURE = Path(__file__).with_name("two_flows.png")
MOMENT = 0.4
"""Beats into the last one."""
ACROSS = 640
"""Points along the longer side of the vorticity's picture."""


def draw(viscous: taichiflap.Result, lattice: taichiflap.Result) -> Figure:
    """Both flows at the same moment of the same beat, on the same page."""
    theme, results = palette.LIGHT, (viscous, lattice)
    beats = np.floor(round(float(viscous.time[-1]) / viscous.case.beat, 9)) - 1.0 + MOMENT
    indices = [int(np.argmin(np.abs(one.field_time / one.case.beat - beats))) for one in results]
    frames = [scene.frame(one, index) for one, index in zip(results, indices, strict=True)]
    backdrop = flow.Backdrop.of(viscous, indices[:1])
    assert backdrop is not None
    dots = scene.bounds(frames[1:], lattice.case)
    both = np.array((scene.bounds(frames[:1], viscous.case, backdrop.box).page, dots.page))
    left, bottom = both[:, ::2].min(axis=0).tolist()
    right, top = both[:, 1::2].max(axis=0).tolist()
    page = left, right, bottom, top
    figure = Figure(figsize=(9.6, 9.6 / 2.0 * (top - bottom) / (right - left) + 0.45), dpi=100, layout="constrained")
    for ax, frame, name in zip(figure.subplots(1, 2), frames, ("Navier-Stokes", "Vortex lattice"), strict=True):
        if len(frame.wake):
            order = np.argsort(np.abs(frame.circulation))
            ax.scatter(
                *frame.wake[order].T, c=frame.circulation[order], s=7.0, linewidths=0.0,
                cmap=ListedColormap(palette.table(theme.anchors) / 255.0),
                norm=Normalize(-dots.circulation, dots.circulation),
            )  # fmt: skip
        else:
            ax.imshow(
                backdrop.picture(frame, page, ACROSS, theme), extent=page, origin="lower", interpolation="bicubic"
            )
        ax.plot(*frame.wing.T, color=theme.ink, linewidth=2.4, solid_capstyle="round")
        ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
        ax.set_axis_off()
        ax.set_title(name, fontsize=13, color=theme.ink)
    return figure


def main() -> None:
    """Draw the picture of two results."""
    with taichiflap.open_result(sys.argv[1]) as viscous, taichiflap.open_result(sys.argv[2]) as lattice:
        draw(viscous, lattice).savefig(PICTURE)
    print(f"{PICTURE} written, {PICTURE.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
