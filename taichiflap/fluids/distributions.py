"""Loads as a sum of fixed distributions along the chord, with amplitudes that are linear in the modal acceleration.

Column 0 of the amplitudes holds those without modal acceleration, column k + 1 those per unit acceleration of mode k.
`settle_amplitudes` then sets column 0 to the amplitudes at the step's acceleration. A model whose loads are nothing
else has these arrays in its group `flow`, each with a leading case axis:

- `amplitude` (column, distribution), set by `prepare`;
- `work` (mode, distribution): modal force of a unit amplitude;
- `total` (distribution, 4): its forces, in the order of `body.force`;
- `pressure` (distribution, element): its pressure jump.
"""

from ..kernels.runtime import View, ti
from ..march.state import ACCEL


@ti.func
def add_loads(body: View, flow: View, b):
    """Add all distributions to the modal force and its response."""
    for j, m in ti.ndrange(body.modes[b], flow.total.shape[1]):
        add_load(body, flow.amplitude, b, j, m, flow.work[b, j, m], body.modes[b])


@ti.func
def add_load(body: View, amplitude: View, b, j, m, work, modes):
    """Add distribution `m` to the modal force of mode `j`, on which a unit amplitude does `work`."""
    body.load[b, j] = body.load[b, j] + work * amplitude[b, 0, m]
    for k in range(modes):
        body.response[b, j, k] = body.response[b, j, k] + work * amplitude[b, k + 1, m]


@ti.func
def settle_loads(body: View, flow: View, b):
    """Amplitudes and forces at the step's modal acceleration."""
    settle_amplitudes(body, flow.amplitude, b, 0, flow.total.shape[1], body.modes[b])
    for c in range(4):
        body.force[b, c] = 0.0
        for m in range(flow.total.shape[1]):
            body.force[b, c] = body.force[b, c] + flow.total[b, m, c] * flow.amplitude[b, 0, m]


@ti.func
def settle_amplitudes(body: View, amplitude: View, b, first, last, modes):
    """Set column 0 of the amplitudes `first` to `last - 1` to their values at the step's modal acceleration."""
    for m in range(first, last):
        for k in range(modes):
            amplitude[b, 0, m] = amplitude[b, 0, m] + amplitude[b, k + 1, m] * body.q[b, ACCEL, k]


@ti.func
def record_pressure(flow: View, output: View, b, frame):
    """Store the pressure jump."""
    for i in range(flow.pressure.shape[2]):
        pressure = 0.0
        for m in range(flow.pressure.shape[1]):
            pressure += flow.pressure[b, m, i] * flow.amplitude[b, 0, m]
        output.pressure_jump[b, frame, i] = ti.cast(pressure, ti.f32)
