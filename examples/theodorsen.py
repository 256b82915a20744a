"""A fluid model in one file, `solver = "module:theodorsen"`: linear theory of a thin wing in a stream.

Theodorsen's loads (NACA Report 496, 1935), with the wake's memory as two lags after R. T. Jones (NACA Report 681, 1938;
the error of his fit of Wagner's function is up to 1 %). For small angles to a stream of speed U along the chord c, per
unit span:

    F_c = -pi rho U c L[w]           distributed as the steady load of a flat plate,
    F_r = -pi rho c^2/4 U da/dt      distributed as twice the load of a plate in heave, less the steady one,
    F_a = -pi rho c^2/4 d2h/dt2      distributed as the load of a plate in heave,
    M   = -pi rho c^4/128 d2a/dt2    distributed as the load of a plate that turns about its middle,

where w, da/dt, d2h/dt2 and d2a/dt2 are the upwash, turning rate, heave and turning acceleration of the whole wing, for
elastic modes averages over the chord with the weights of the theory, and L is the lag. `numbers.lift_slope` replaces
2 pi.
"""

import math

import numpy as np

from taichiflap.fluids import kit
from taichiflap.fluids.kit import View, ti

ELEMENTS, ANGLES = 64, 256
SHARES, POLES = (0.165, 0.335), (0.0455, 0.3)
"""Wagner's function is about `1 - sum share exp(-pole s)`, s in half-chords."""

CIRCULATORY, TURNING, HEAVING, COUPLE = range(4)
"""The four distributions, with the amplitudes U L[w], U da/dt, d2h/dt2 and d2a/dt2."""
WASH, RISE, SPIN, TILT, TURN = range(5)
"""Averages of a mode: its value in w, d2h/dt2 and d2a/dt2; its slope in w (times U) and in da/dt."""
CHORD, MIDDLE, REAR = range(3)
"""Columns of `place`, m: the chord, and the distances of its middle and of its rear quarter point behind the pivot."""
NOW, BEFORE, GAIN, KEPT = range(4)
"""Rows of the lags: at the last two steps; and of the coming one, its gain on the upwash and what is left without."""


class Numbers(kit.Table):
    """Keys of `[numbers]` in the case file."""

    lift_slope: float = kit.key(2.0 * math.pi, unit="1/rad", text="slope of the lift coefficient", gt=0)


class Theodorsen(kit.Model):
    name, numbers, elements = "THEODORSEN", Numbers, ELEMENTS

    def flow(self, cases, sections, body, threads):
        return kit.flow_of(prepare, settle, kit.record_pressure, **kit.stacked(map(self.arrays, cases, sections)))

    def arrays(self, case, section):
        """Constants and state of a case; averages over the chord by Gauss and Chebyshev's rule in the angle t of
        `y = c/2 (1 - cos t)`."""
        chord, span, pivot = case.wing.chord, kit.Profile.of(case.wing.span).mean, case.wing.pivot * case.wing.chord
        lift = 0.5 * case.fluid.density * span * chord * self.parameters(case).lift_slope
        mass = 0.25 * math.pi * case.fluid.density * span * chord**2
        scale = -np.array([[lift], [mass], [mass], [mass * chord**2 / 32]])
        cosine = np.cos((np.arange(ANGLES) + 0.5) * math.pi / ANGLES)
        plate, wash, heave = (weights / ANGLES for weights in (1 + cosine, 1 - cosine, 2 * (1 - cosine**2)))
        couple = -8 * cosine * heave / chord
        edge = np.arccos(1.0 - 2.0 * np.arange(ELEMENTS + 1) / ELEMENTS)
        ahead = edge + np.sin(edge), edge - 0.5 * np.sin(2 * edge), -16 / 3 / chord * np.sin(edge) ** 3
        quarter, middle, rear = chord * np.array([0.25, 0.5, 0.75]) - pivot
        forces = [[1, 0, quarter, 0], [1, 0, rear, 0], [1, 0, middle, 1], [0, 0, 1, 0]]

        def loads(plate, heave, couple):
            return scale * np.array([plate, 2 * heave - plate, heave, couple])

        y = chord * (0.5 - 0.5 * cosine) - pivot
        value, slope = section.shape(y), section.slope(y)
        return {
            "work": value @ loads(plate, heave, couple).T,
            "total": scale * forces,
            "pressure": loads(*np.diff(ahead)) * ELEMENTS / (math.pi * span * chord),
            "mean": np.stack([value @ wash, value @ heave, value @ couple, slope @ wash, slope @ heave], axis=1),
            "place": np.array([chord, middle, rear]),
            "stream": np.array(case.fluid.velocity, dtype=float),
            "lag": np.zeros((4, 2)),
            "amplitude": np.zeros((section.count + 1, 4)),
        }


MODEL = Theodorsen()


@ti.func
def upwash(body: View, flow: View, b, n, state: View):
    """The w of the wing at the modal rates of a state."""
    p_y, p_z = kit.pivot_velocity(body, flow.stream, b, n)
    tilt = kit.superpose(flow.mean, body.q_predicted, b, kit.AMPLITUDE, TILT, body.modes[b])
    elastic = kit.superpose(flow.mean, state, b, kit.RATE, WASH, body.modes[b])
    return p_z + body.motion[b, n, kit.PITCH_RATE] * flow.place[b, REAR] + elastic - p_y * tilt


@ti.func
def prepare(body: View, flow: View, b, n, rule):
    p_y, _ = kit.pivot_velocity(body, flow.stream, b, n)
    gain, kept = 1.0, 0.0
    for i in ti.static(range(2)):
        rate = 2.0 * POLES[i] * ti.abs(p_y) / flow.place[b, CHORD]
        scale = 0.0
        if n > 0:
            scale = 1.0 / (rule[kit.C0] + rate)
        flow.lag[b, GAIN, i] = SHARES[i] * rate * scale
        flow.lag[b, KEPT, i] = -scale * (rule[kit.C1] * flow.lag[b, NOW, i] + rule[kit.C2] * flow.lag[b, BEFORE, i])
        gain += flow.lag[b, GAIN, i] - SHARES[i]
        kept += flow.lag[b, KEPT, i]
    turn = body.motion[b, n, kit.PITCH_RATE] + kit.superpose(flow.mean, body.q_free, b, kit.RATE, TURN, body.modes[b])
    accel = body.motion[b, n, kit.PITCH_ACCEL]
    flow.amplitude[b, 0, CIRCULATORY] = -p_y * (gain * upwash(body, flow, b, n, body.q_free) + kept)
    flow.amplitude[b, 0, TURNING] = -p_y * turn
    flow.amplitude[b, 0, HEAVING] = kit.pivot_heave(body, b, n) + flow.place[b, MIDDLE] * accel
    flow.amplitude[b, 0, COUPLE] = accel
    for k in range(body.modes[b]):
        flow.amplitude[b, k + 1, CIRCULATORY] = -p_y * gain * rule[kit.BETA] * flow.mean[b, k, WASH]
        flow.amplitude[b, k + 1, TURNING] = -p_y * rule[kit.BETA] * flow.mean[b, k, TURN]
        flow.amplitude[b, k + 1, HEAVING] = flow.mean[b, k, RISE]
        flow.amplitude[b, k + 1, COUPLE] = flow.mean[b, k, SPIN]
    kit.add_loads(body, flow, b)


@ti.func
def settle(body: View, flow: View, b, n, rule):
    w = upwash(body, flow, b, n, body.q)
    for i in ti.static(range(2)):
        flow.lag[b, BEFORE, i] = flow.lag[b, NOW, i]
        flow.lag[b, NOW, i] = flow.lag[b, GAIN, i] * w + flow.lag[b, KEPT, i]
    kit.settle_loads(body, flow, b)
