"""Flexibility and kinematics of the hawkmoth in both models: where do DBET and UVLM agree?

    python examples/design_map.py [FOLDER [MODULI PITCHES]]

writes FOLDER/design_map.h5 with figures and prints how often the models agree. The default map of 12 moduli by 13 pitch
amplitudes takes a minute or two on two cores. After an interruption it continues.
"""

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray
from matplotlib.figure import Figure

import taichiflap
from taichiflap.plots import maps as map_plots
from taichiflap.plots.style import HOUSE

CASE = Path(__file__).parent.parent / "cases" / "hawkmoth.toml"
MODULUS, PITCH = "wing.youngs_modulus", "motion.pitch.amplitude_deg"
COMPARED = {"force_vertical_mean": "Mean vertical force", "power_mean": "Mean power", "tip_peak_mean": "Peak tip"}
PAPERS_BLADES = (
    "dbet.coefficients=reade_jankauski",
    "dbet.frame=chord",
    "dbet.added_mass=strip",
    "dbet.attached=false",
    "dbet.rotation=0.0",
)
"""The blade elements of Reade & Jankauski (2020)."""
LEVELS = (0.25, 0.5, 0.8, 1.25, 2.0, 4.0)
AGREE = 0.2
"""Relative difference within which the models count as equal."""


def run(folder: Path, moduli: int = 12, pitches: int = 13, settings: tuple[str, ...] = ()) -> xarray.Dataset:
    """The map of both models over Young's modulus and pitch amplitude."""
    case = taichiflap.load_case(CASE, (*PAPERS_BLADES, *settings))
    vary = {"solver": "dbet,uvlm", MODULUS: f"5e9:60e9:{moduli}:log", PITCH: f"5:45:{pitches}"}
    return taichiflap.sweep(case, vary, folder / "design_map.h5", metrics=[*COMPARED, "lift_per_power"])


def ratio(chart: xarray.Dataset, metric: str) -> xarray.DataArray:
    """UVLM over DBET."""
    return chart[metric].sel(solver="uvlm") / chart[metric].sel(solver="dbet")


def agreement(chart: xarray.Dataset, metric: str) -> xarray.DataArray:
    """Whether the models agree within a fifth."""
    return np.abs(np.log(ratio(chart, metric))) <= np.log(1.0 + AGREE)


def draw(chart: xarray.Dataset) -> Figure:
    """UVLM over DBET for each compared metric; agreement is white."""
    with mpl.rc_context(HOUSE):
        figure = Figure((7.1, 2.5), layout="constrained")
        axes = figure.subplots(1, len(COMPARED), sharey=True)
        for ax, (metric, label) in zip(axes, COMPARED.items(), strict=True):
            values = np.log2(ratio(chart, metric))
            x, y = chart[PITCH], chart[MODULUS] / 1e9
            mesh = ax.pcolormesh(x, y, values, cmap="RdBu_r", vmin=-2, vmax=2, shading="nearest", rasterized=True)
            lines = ax.contour(x, y, values, np.log2(LEVELS), colors="black", linewidths=0.5)
            ax.set_facecolor("0.6")  # cases that failed
            ax.clabel(lines, fmt=lambda level: f"{2**level:.3g}", fontsize=6)
            ax.set(title=label, xlabel="Pitch amplitude (deg)", yscale="log")
            ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
            ax.yaxis.set_minor_formatter(lambda value, _: f"{value:g}" if value in (5, 20, 50) else "")
        axes[0].set_ylabel("Young's modulus (GPa)")
        bar = figure.colorbar(mesh, ax=axes, ticks=[-2, -1, 0, 1, 2], pad=0.01)
        bar.ax.set_yticklabels(["1/4", "1/2", "1", "2", "4"])
        bar.set_label("UVLM / DBET")
    return figure


def main(folder: Path, *counts: int) -> None:
    """Run the study, draw it, and print what it found."""
    folder.mkdir(parents=True, exist_ok=True)
    chart = run(folder, *counts)
    draw(chart).savefig(folder / "design_map-ratio.png", dpi=200)
    with taichiflap.open_map(folder / "design_map.h5") as sheet:
        map_plots.plot(sheet, folder / "design_map", overwrite=True)
    for metric, label in COMPARED.items():
        both = ratio(chart, metric)
        share = 100 * float(agreement(chart, metric).mean())
        print(f"{label}: UVLM / DBET {float(both.min()):.2f} to {float(both.max()):.2f}; within 20 % in {share:.0f} %")
    for solver in ("dbet", "uvlm"):
        best = chart.sel(solver=solver).lift_per_power
        place = best.isel(best.argmax(...))
        print(
            f"{solver}: most lift per power {float(place):.3f} N/W at {float(place[MODULUS]) / 1e9:.3g} GPa,", end=" "
        )
        print(f"{float(place[PITCH]):.3g} deg")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "design_map"), *map(int, sys.argv[2:]))
