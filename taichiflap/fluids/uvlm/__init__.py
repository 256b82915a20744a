"""The unsteady vortex lattice: a lumped-vortex lattice on the deformed camber line, with a free wake."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...case.case import Case
from ...motion.gust import gust_velocity
from ...motion.sampling import sample, typical_angle
from ...structure.beam import Modes
from ..interface import WAKE, Array, Flow, Model, Output, Refinement, Velocity, standard
from . import stations

ATTACHED = 20.0
"""Angle of attack, in degrees, up to which the flow stays attached at a sharp leading edge."""
FEWEST_BEATS, MOMENTS = 20, 512
"""Minimum number of beats for the mean of a separated flow in hover; times per beat at which the motion is sampled."""
SPREAD = 0.08
"""Minimum core radius in pictures of the flow, chords."""


class Uvlm(Model):
    """The vortex lattice (`[uvlm]`)."""

    name = "UVLM"
    draws_flow = True
    sheds_behind = True
    outputs = (
        *standard("circulation", "panel_circulation", "pressure_jump"),
        *WAKE,
        *standard("wake/edge"),
        *standard(
            "wake_crossings",
            "wake_lost",
            "wake_far_error",
            "suction_velocity",
            "leading_edge_circulation",
            "trailing_edge_circulation",
            "leading_edge_sheds",
        ),
    )

    def nodes(self, case: Case) -> Array:
        return stations.stations(case).node

    def stored(self, case: Case) -> tuple[Output, ...]:
        left = set() if stations.sheds(case) else {one.name for one in self.outputs if "edge" in one.name}
        if not case.uvlm.far_error:
            left.add("wake_far_error")
        if not stations.has_edge(case):
            left.add("suction_velocity")
        return tuple(one for one in self.outputs if one.name not in left)

    def entries(self, case: Case, step: Any) -> Any:
        return np.minimum(stations.shed_a_step(case) * (np.asarray(step) + 1), stations.ring_size(case))

    def counters(self, case: Case, step: int) -> Mapping[str, tuple[Any, Any]]:
        size, last = stations.ring_size(case), min(step, case.steps + 1) - 1
        count, place = int(self.entries(case, last)), size - 1
        # In the order of the columns of `wake.ring`.
        ring = (size, 0, 0, 0, 0, 0, 0), (size, count, place, place, last + 1, np.iinfo("i4").max, place)
        return {"wake.ring": ring, "wake.origin": (0, [[last], [1]])}  # in the order of its rows

    def work(self, case: Case, step: int) -> float:
        panels, vortices = case.uvlm.panels, float(self.entries(case, step))
        return (vortices + panels) ** 2 + panels**3 / 10.0

    def settings(self, case: Case) -> list[str]:
        wake = "whole wake" if case.uvlm.wake == "all" else f"{case.uvlm.wake} wake vortices"
        edge = f"leading edge sheds above suction limit {case.uvlm.suction_limit:g}"
        return [f"{case.uvlm.panels} panels", wake, *([edge] if stations.sheds(case) else [])]

    def warnings(self, case: Case) -> list[str]:
        if not stations.sheds(case):
            return []
        uvlm, found = case.uvlm, []
        largest = np.pi / (2.0 * uvlm.panels)
        if uvlm.core < largest:
            found.append(
                f"uvlm.core = {uvlm.core:g} chords is smaller than the largest panel, {largest:.2g}; vortices that "
                "pass the wing make the force noisy: use a larger core or more uvlm.panels"
            )
        middle = (0.5 - case.wing.pivot) * case.wing.chord
        times = case.duration - case.beat * np.linspace(0.0, 1.0, MOMENTS)
        angle = typical_angle(sample(case.motion, times), middle, case.fluid.velocity)
        if uvlm.suction_limit == 0.0 and case.fluid.streams and angle < ATTACHED:
            found.append(
                f"uvlm.suction_limit = 0 sheds at every angle, but at {angle:.2g} deg the flow would stay attached "
                "and lift is far too high; use a limit such as 0.1"
            )
        beats = case.time.periods
        if beats and not case.fluid.streams and beats < FEWEST_BEATS:
            found.append(
                f"time.periods = {beats}: beats of a separated flow in hover differ by about 25 %; use at least "
                f"{FEWEST_BEATS} for a mean with a standard error"
            )
        return found

    def attached_in(self, case: Case) -> float | None:
        return None if stations.sheds(case) else ATTACHED

    def cures(self, case: Case) -> list[str]:
        near = "a uvlm.core such as 0.02 (a vortex may have come too close to the wing)"
        return [] if case.uvlm.core else [near]

    def refinements(self, case: Case) -> list[Refinement]:
        found = [Refinement("uvlm.panels", case.uvlm.panels)]
        if case.uvlm.wake != "all":
            found.append(Refinement("uvlm.wake", case.uvlm.wake, per_step=stations.shed_a_step(case)))
        return found

    def vortices(self, result: Any, index: int) -> Array:
        """Y, Z (m) and circulation (m2/s) of the bound vortices and then the wake vortices of a frame, shape (3,
        vortex).
        """
        wake, node = result.wake(index), np.asarray(result.frame("node_position", index), dtype=float)
        at = stations.stations(result.case)
        share = (at.vortex - at.node[:-1]) / np.diff(at.node)
        bound = node[:-1] + share[:, None] * np.diff(node, axis=0)
        shed = np.stack([wake[name] for name in ("y", "z", "circulation")])
        return np.concatenate((np.vstack((bound.T, result.frame("panel_circulation", index))), shed), axis=1)

    def velocity(self, result: Any, index: int) -> Velocity:
        case, vortices = result.case, self.vortices(result, index)
        core = max(SPREAD, case.uvlm.core) * case.wing.chord

        def flow(points: Array) -> Array:
            from ...vortex.sum import induced_velocity  # noqa: PLC0415 - Taichi, for a picture of the flow alone

            stream = np.asarray(case.fluid.velocity).reshape(2, *(1,) * (points.ndim - 1))
            gust = gust_velocity(case.fluid, float(result.field_time[index]), *points)
            return induced_velocity(points, vortices, core) + stream + gust

        return flow

    def flow(self, cases: Sequence[Case], sections: Sequence[Modes], body: Any, threads: int | None) -> Flow:
        from .flow import flow  # noqa: PLC0415 - Taichi, for a run alone

        return flow(cases, sections, body, threads)


MODEL = Uvlm()
