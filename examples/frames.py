"""The labelled sketch of frames, signs, pitch and angle of attack.

    python examples/frames.py docs/theory/frames.svg

The position of the wing is computed by `taichiflap.motion`.
"""

import sys

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Arc

import taichiflap
from taichiflap.case.case import parse_case
from taichiflap.drawing import palette
from taichiflap.motion import sampling
from taichiflap.plots.style import HOUSE

PITCH = 35.0
"""Pitch of the drawn wing, degrees."""
INK, BLUE, ORANGE, GREEN = palette.LIGHT.ink, *palette.LINES, palette.LIGHT.force


def pose():
    """Leading edge, trailing edge and velocity on the page (Z to the right, up upwards), in chords, in mid-stroke."""
    wing = {"chord": 1.0, "span": 1.0, "modes": 0, "mass_per_length": 1.0, "flexural_rigidity": 1.0}
    motion = {"frequency": 1.0, "plunge": {"amplitude": 1.0, "phase_deg": 90.0}, "pitch": {"amplitude_deg": PITCH}}
    case = parse_case({"wing": wing, "motion": motion, "time": {"periods": 1, "steps_per_period": 100}})
    z, z_rate, _, theta, _, _, y, y_rate, _ = sampling.sample(case.motion, np.array([0.25]))[0]
    leading = np.array([z, -y])
    return leading, leading + np.array([np.sin(theta), -np.cos(theta)]), np.array([z_rate, -y_rate])


def arrow(ax, foot, vector, text, colour=INK, place=(4, 4), width=1.1):
    foot, end = np.asarray(foot, float), np.asarray(foot, float) + vector
    ax.annotate(
        "", end, foot, arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": width, "shrinkA": 0, "shrinkB": 0}
    )
    ax.annotate(text, end, place, textcoords="offset points", color=colour, va="center")


def arc(ax, centre, size, start, end, text, colour, place):
    ax.add_patch(Arc(centre, size, size, theta1=min(start, end), theta2=max(start, end), color=colour, linewidth=1.1))
    middle = np.radians(0.5 * (start + end))
    at = np.asarray(centre) + 0.5 * size * np.array([np.cos(middle), np.sin(middle)])
    ax.annotate(text, at, place, textcoords="offset points", color=colour, va="center")


def draw():
    """The sketch."""
    leading, trailing, velocity = pose()
    along = trailing - leading
    normal = np.array([-along[1], along[0]])  # e_z is e_y turned by 90 degrees, counter-clockwise on the page too
    with mpl.rc_context(HOUSE | {"text.parse_math": True}):
        figure = Figure(figsize=(6.4, 3.9), layout="constrained")
        ax = figure.subplots()
        ax.axis("off")
        ax.plot([-1.5, 1.45], [0, 0], ":", color=INK, linewidth=0.9)
        ax.annotate("stroke plane (horizontal)", (1.45, 0), (0, 6), textcoords="offset points", ha="right")
        ax.plot([0, 0], [0, -1.15], "--", color=palette.LIGHT.muted, linewidth=0.8)
        ax.plot(*np.stack((leading, trailing)).T, color=INK, linewidth=2.6, solid_capstyle="round")
        ax.plot(*leading, "o", color=INK, markersize=7)
        ax.annotate("leading edge, pivot O", leading, (8, -11), textcoords="offset points")
        ax.annotate("trailing edge", trailing, (10, 2), textcoords="offset points")
        arrow(ax, leading + 0.62 * along, 0.38 * along, "$e_y$", BLUE, (2, -9))
        arrow(ax, leading + 0.62 * along, 0.38 * normal, "$e_z$, normal force", BLUE, (6, 3))
        way = velocity / np.hypot(*velocity)
        arrow(ax, leading, 0.75 * way, "motion of the pivot", ORANGE, (-66, -10))
        chord = np.degrees(np.arctan2(along[1], along[0]))
        arc(ax, leading, 1.5, -90.0, chord, f"pitch θ > 0\n(here {PITCH:g}°)", BLUE, (-74, -16))
        # Between the way the pivot goes and the chord's leading end, drawn beyond the leading edge.
        ax.plot(*np.stack((leading, leading - 0.6 * along)).T, "--", color=palette.LIGHT.muted, linewidth=0.8)
        arc(ax, leading, 0.9, chord + 180.0, 180.0, f"angle of attack\n90° − |θ| = {90 - PITCH:g}°", ORANGE, (-92, 16))
        foot = np.array([-2.5, -0.65])
        arrow(ax, foot, [0.6, 0.0], "Z, plunge: along the stroke", INK, (4, 0))
        arrow(ax, foot, [0.0, -0.6], "Y, surge: down", INK, (6, -2))
        ax.annotate("X, span: out of the page", foot, (-4, 8), textcoords="offset points")
        ax.plot(*foot, "o", color=INK, markersize=4, fillstyle="none")
        arrow(ax, [-2.2, 0.95], [0.0, -0.55], "gravity", GREEN, (6, 8))
        arrow(ax, [-1.55, 0.4], [0.0, 0.55], "vertical force > 0:\nup, −Y", GREEN, (6, 2))
        ax.add_patch(Arc((1.75, -0.75), 0.4, 0.4, theta1=-60, theta2=200, color=INK, linewidth=1.0))
        end = np.radians(200.0)
        at = np.array([1.75, -0.75]) + 0.2 * np.array([np.cos(end), np.sin(end)])
        arrow(ax, at, 0.01 * np.array([-np.sin(end), np.cos(end)]), "", INK, width=0.0)
        ax.annotate("angles and\ncirculation > 0", (1.75, -1.08), ha="center", va="top")
        ax.set(xlim=(-2.75, 2.3), ylim=(-1.45, 1.15), aspect="equal")
    return figure


if __name__ == "__main__":
    out = sys.argv[1] if len(sys.argv) > 1 else "frames.svg"
    with mpl.rc_context(HOUSE | {"text.parse_math": True}):
        draw().savefig(out, metadata={"Date": None} if out.endswith("svg") else None, dpi=200)
    print(f"{out} written, taichiflap {taichiflap.__version__}")
