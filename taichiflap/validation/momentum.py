"""The force from the momentum of the flow: a check of the lattice's loads that is independent of pressure.

In a fluid at rest far away the impulse of all vortices, on a thin wing and in its wake, is `I = rho span sum(Gamma (Z,
-Y))` and `A = -rho span/2 sum(Gamma (Y^2 + Z^2))` about the origin; the loads on the wing are `-dI/dt` and `-dA/dt`
(Saffman, Vortex Dynamics, 1992, sections 3.2 and 3.5), including leading-edge suction.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import fluids
from ..case.case import Case
from ..fluids.uvlm import wake
from ..kernels.runtime import view
from ..march.march import March
from ..march.state import AXIAL, MOMENT, NORMAL
from ..motion.sampling import PITCH, PLUNGE
from ..vortex.sum import CIRCULATION, Y, Z

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Balance:
    """A run's impulse and loads at every step; columns: along Y, along Z, about the origin.

    Attributes:
        time: s, shape (steps + 1,).
        impulse: of the fluid, N s and N m s, shape (steps + 1, 3).
        load: of the fluid on the wing, N and N m, shape (steps + 1, 3).
    """

    time: Array
    impulse: Array
    load: Array

    def means(self, first: int, last: int) -> tuple[Array, Array]:
        """Mean load from step `first` to `last`, from the change of impulse and from the loads."""
        span = self.time[last] - self.time[first]
        by_momentum = (self.impulse[first] - self.impulse[last]) / span
        return by_momentum, np.trapezoid(self.load[first : last + 1], self.time[first : last + 1], axis=0) / span

    def error(self, first: int, last: int) -> Array:
        """Root-mean-square difference between load and `-dI/dt`, relative to the load."""
        between = slice(first, last + 1)
        asked = -np.gradient(self.impulse, self.time, axis=0)[between]
        load = self.load[between]
        return np.sqrt(np.mean((load - asked) ** 2, axis=0) / np.mean(load**2, axis=0))


def balance(case: Case) -> Balance:
    """Run a UVLM case with uniform span in a fluid at rest, without dropping wake vortices.

    Raises:
        ValueError: if these sums do not apply to the case, or its wake does not conserve impulse.
    """
    span, kept = case.wing.span, case.uvlm.wake == "all" or case.uvlm.old_wake == "absorb"
    if isinstance(span, tuple) or case.fluid.streams or not kept:
        raise ValueError("the balance is that of a uniform span, in a fluid at rest, with all of its wake")
    march = March([case], fluids.load("uvlm"))
    impulse, load = [], []
    while not march.done:
        load.append(march.advance(1)[0]["force"][0])
        impulse.append(_impulse(case.fluid.density * span, march))
    time: Array = case.step * np.arange(case.steps + 1, dtype=np.float64)
    return Balance(time, np.array(impulse), _inertial(march.motion[0][: case.steps + 1], np.array(load)))


def _impulse(scale: float, march: March) -> tuple[float, float, float]:
    wakes = march.groups["wake"]
    count = int(view(wakes.ring)[0, wake.COUNT])
    bound = view(march.groups["flow"].panel)[0, :, : march.cases[0].uvlm.panels]
    y, z, circulation = (np.append(bound[row], view(wakes.vortex)[0, row, :count]) for row in (Y, Z, CIRCULATION))
    return scale * (circulation @ z), -scale * (circulation @ y), -0.5 * scale * (circulation @ (y**2 + z**2))


def _inertial(motion: Array, force: Array) -> Array:
    """Loads along Y, Z and about the origin, from those in wing axes and about the pivot."""
    cosine, sine = np.cos(motion[:, PITCH]), np.sin(motion[:, PITCH])
    along_y = force[:, AXIAL] * cosine - force[:, NORMAL] * sine
    along_z = force[:, AXIAL] * sine + force[:, NORMAL] * cosine
    return np.stack((along_y, along_z, force[:, MOMENT] - motion[:, PLUNGE] * along_y), axis=1)
