"""The unsteady vortex lattice: a lumped-vortex lattice on the deformed camber line, with a free wake."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...case.case import Case
from ...structure.beam import Modes
from ..interface import WAKE, Array, Flow, Model, Output, standard
from . import stations


class Uvlm(Model):
    """The vortex lattice (`[uvlm]`)."""

    name = "UVLM"
    outputs = (
        *standard("circulation", "panel_circulation", "pressure_jump"),
        *WAKE,
        *standard("wake_crossings", "wake_lost", "wake_far_error"),
    )

    def nodes(self, case: Case) -> Array:
        return stations.stations(case).node

    def stored(self, case: Case) -> tuple[Output, ...]:
        return tuple(one for one in self.outputs if one.name != "wake_far_error" or case.uvlm.far_error)

    def entries(self, case: Case, step: Any) -> Any:
        return np.minimum(np.asarray(step) + 1, stations.ring_size(case))

    def work(self, case: Case, step: int) -> float:
        panels, vortices = case.uvlm.panels, float(self.entries(case, step))
        return (vortices + panels) ** 2 + panels**3 / 10.0

    def flow(self, cases: Sequence[Case], sections: Sequence[Modes], body: Any, threads: int | None) -> Flow:
        from .flow import flow  # noqa: PLC0415 - Taichi, for a run alone

        return flow(cases, sections, body, threads)


MODEL = Uvlm()
