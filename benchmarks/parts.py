"""Cost of each part of a UVLM step, measured by repeating it.

Every part is idempotent, so that results stay bit-identical.
"""

import dataclasses
from typing import Any

from taichiflap.fluids.uvlm import Uvlm, lattice, wake
from taichiflap.fluids.uvlm import flow as uvlm
from taichiflap.fluids.uvlm.lattice import PANELS
from taichiflap.kernels.runtime import View, ti

AGAIN = 4
"""How many times more a part is done."""


PARTS = {
    "convect": "pair sums: all vortices on the wake",
    "wash": "pair sums: the wake on the panels",
    "assemble": "assembling the lattice's matrix",
    "eliminate": "solving it",
    "lay": "geometry of the panels",
}


class Repeated(Uvlm):
    """The UVLM, whose step does `part` four times more."""

    def __init__(self, part: str) -> None:
        self._prepare = _doing_again(part)

    def flow(self, *batch: Any) -> Any:
        return dataclasses.replace(super().flow(*batch), prepare=self._prepare)


def _doing_again(part: str) -> Any:
    # A part is done again where all that it reads stands, and what it writes is either the same or written anew.
    @ti.func
    def prepare(batch: View, b, n, rule, used: View):
        flow, wakes = ti.static(uvlm.hold(batch))
        if ti.static(part == "convect"):
            for _ in range(AGAIN if n > 0 else 0):
                # For no time at all, so that nothing moves.
                wake.convect(wakes, flow.panel, flow.size[b, PANELS], flow.scalar, b, n, 0.0, False, False)
        if ti.static(part == "assemble"):
            for _ in range(AGAIN):
                lattice.assemble(batch.body, flow, b, n)
        uvlm.prepare(batch, b, n, rule, used)
        if ti.static(part == "lay"):
            for _ in range(AGAIN):
                lattice.place_panels(batch.body, flow, b, n)
        if ti.static(part == "wash"):
            for _ in range(AGAIN):
                lattice.wake_at_panels(batch.body, flow, wakes, b, n)
        if ti.static(part == "eliminate"):
            for _ in range(AGAIN):
                lattice.assemble(batch.body, flow, b, n)
                lattice.solve(batch.body, flow, b)

    return prepare
