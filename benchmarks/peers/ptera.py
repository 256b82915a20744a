"""PteraSoftware, the flapping-wing lattice that users know: three-dimensional rings of line vortices.

It runs in a Python of its own (`make bench PTERA=/path/to/python`), or in this one where it is installed, so that its
dependencies and ours need not agree. Run as a program, this module needs nothing of taichiflap and prints JSON.
"""

import importlib
import importlib.util
import json
import math
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

MISSING = (
    "PteraSoftware is not installed; put it into an environment of its own (python -m venv ptera; "
    "ptera/bin/pip install pterasoftware) and say: make bench PTERA=ptera/bin/python"
)


def ask(what: str, *settings: dict[str, Any]) -> list[dict[str, Any]] | None:
    """Run `flap` or `plunge` with each of the settings; None where PteraSoftware is not to be had."""
    python = os.environ.get("PTERA") or (sys.executable if importlib.util.find_spec("pterasoftware") else None)
    if python is None:
        return None
    asked = [python, "-m", "benchmarks.peers.ptera", what, json.dumps(settings)]
    root = Path(__file__).parent.parent.parent
    answer = subprocess.run(asked, cwd=root, stdout=subprocess.PIPE, check=True, text=True)
    found: list[dict[str, Any]] = json.loads(answer.stdout.splitlines()[-1])
    return found


def flap(
    chordwise: int = 4, spanwise: int = 6, cycles: int = 2, flap_deg: float = 15.0, twist_deg: float = 5.0
) -> dict[str, Any]:
    """A tapered wing that flaps and twists in a stream, its wake free: seconds, and pairs of point and line vortex."""
    ps: Any = importlib.import_module("pterasoftware")

    wing = _wing(ps, (1.75, 0.5), 5.0, chordwise, spanwise, "NACA2412")
    root, tip = wing.wing_cross_sections
    sections = ps.movements.wing_cross_section_movement.WingCrossSectionMovement
    beating = [
        sections(root),
        sections(
            tip, ampAngles_Wcsp_to_Wcs_ixyz=(flap_deg, twist_deg, 0.0), periodAngles_Wcsp_to_Wcs_ixyz=(1.0, 1.0, 0.0)
        ),
    ]
    solver, _ = _problem(ps, wing, beating, {}, 10.0, num_cycles=cycles)
    return _clocked(solver, prescribed=False)


def plunge(
    chordwise: int, spanwise: int, steps: int, cycles: int, aspect_ratio: float = 20.0, free: bool = False
) -> dict[str, Any]:
    """A plunging rectangular wing at k = 0.5: complex amplitude of the mid-span lift coefficient over the plunge's.

    The fit is over the last cycle, beside a mean; chords and stream are 1, the plunge is 0.01 chords.
    """
    ps: Any = importlib.import_module("pterasoftware")

    amplitude, period = 0.01, 2.0 * math.pi
    wing = _wing(ps, (1.0, 1.0), 0.5 * aspect_ratio, chordwise, spanwise, "NACA0012")
    sections = ps.movements.wing_cross_section_movement.WingCrossSectionMovement
    heave = {
        "ampLer_Gs_Cgs": (0.0, 0.0, amplitude), "periodLer_Gs_Cgs": (0.0, 0.0, period),
        "phaseLer_Gs_Cgs": (0.0, 0.0, 90.0),
    }  # fmt: skip
    still = [sections(section) for section in wing.wing_cross_sections]
    count = steps * cycles + 1
    solver, problem = _problem(ps, wing, still, heave, 1.0, delta_time=period / steps, num_steps=count)
    found = _clocked(solver, prescribed=not free)
    lift = np.array([_mid_span_lift(one.airplanes[0].wings[0].panels) for one in problem.steady_problems])
    last = np.arange(count - steps, count)
    angle = 2.0 * np.pi * last / steps
    base = np.stack((np.cos(angle), np.sin(angle), np.ones(steps)), axis=1)
    cosine, sine, _ = np.linalg.lstsq(base, 2.0 * lift[last] / amplitude, rcond=None)[0]
    return found | {"real": cosine, "imag": -sine}


def _wing(ps: Any, chords: tuple[float, float], half_span: float, chordwise: int, spanwise: int, airfoil: str) -> Any:
    section = ps.geometry.wing_cross_section.WingCrossSection
    foil = ps.geometry.airfoil.Airfoil(airfoil)
    ends = [
        section(foil, spanwise, chords[0], spanwise_spacing="cosine", control_surface_symmetry_type="symmetric"),
        section(
            foil, None, chords[1], (0.5 * (chords[0] - chords[1]), half_span, 0.0),
            control_surface_symmetry_type="symmetric",
        ),
    ]  # fmt: skip
    return ps.geometry.wing.Wing(
        ends, symmetric=True, symmetryNormal_G=(0.0, 1.0, 0.0), symmetryPoint_G_Cg=(0.0, 0.0, 0.0),
        num_chordwise_panels=chordwise, chordwise_spacing="cosine",
    )  # fmt: skip


def _problem(
    ps: Any, wing: Any, sections: list[Any], heave: dict[str, Any], speed: float, **time_steps: Any
) -> tuple[Any, Any]:
    moves = ps.movements
    airplane = ps.geometry.airplane.Airplane([wing])
    wings = [moves.wing_movement.WingMovement(one, sections, **heave) for one in airplane.wings]
    stream = ps.operating_point.OperatingPoint(rho=1.0, vCg__E=speed, alpha=0.0, nu=1e-5)
    movement = moves.movement.Movement(
        [moves.airplane_movement.AirplaneMovement(airplane, wings)],
        moves.operating_point_movement.OperatingPointMovement(stream),
        **time_steps,
    )
    problem = ps.problems.UnsteadyProblem(movement)
    return ps.unsteady_ring_vortex_lattice_method.UnsteadyRingVortexLatticeMethodSolver(problem), problem


def _clocked(solver: Any, prescribed: bool) -> dict[str, Any]:
    sums: Any = importlib.import_module("pterasoftware._aerodynamics_functions")
    count = {"pairs": 0, "in sums": 0.0}

    def counting(loop: Any) -> Any:
        def counted(**given: Any) -> Any:
            began = time.process_time()
            velocity = loop(**given)
            count["in sums"] += time.process_time() - began
            count["pairs"] += len(given["stackP_GP1_CgP1"]) * len(given["stackSlvp_GP1_CgP1"])
            return velocity

        return counted

    names = ("_collapsed_velocities_from_line_vortices", "_expanded_velocities_from_line_vortices")
    plain = {name: getattr(sums, name) for name in names}
    for name, loop in plain.items():
        setattr(sums, name, counting(loop))
    wall, cpu = time.perf_counter(), time.process_time()
    solver.run(prescribed_wake=prescribed, calculate_streamlines=False, show_progress=False)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    for name, loop in plain.items():
        setattr(sums, name, loop)
    return {"wall": wall, "cpu": cpu, "time steps": solver.num_steps, "panels": solver.num_panels, **count}


def _mid_span_lift(panels: Any) -> float:
    """Lift a unit span, up positive, of the strip of panels nearest to the middle; its Z axis points as ours."""
    middle = int(np.argmin([abs(panel.Cpp_GP1_CgP1[1]) for panel in panels[0]]))
    corner = panels[0, middle]
    width = abs(corner.Frpp_GP1_CgP1[1] - corner.Flpp_GP1_CgP1[1])
    return float(sum(panel.forces_GP1[2] for panel in panels[:, middle]) / width)


if __name__ == "__main__":
    run: Any = {"flap": flap, "plunge": plunge}[sys.argv[1]]
    asked = json.loads(sys.argv[2])
    run(**asked[0])  # compiles
    print(json.dumps([{**settings, **run(**settings)} for settings in asked]))
