"""A third fluid model in one file, `solver = "module:theodorsen"`: linear theory of a thin wing in a stream.

Theodorsen's loads (NACA Report 496, 1935), with the wake's memory as two lags after R. T. Jones (NACA Report 681, 1938;
the error of his fit of Wagner's function is up to 1 %). For small angles to a stream of speed U along the chord, per
unit span:

    F_c = -pi rho U c L[w]           in the distribution of a flat plate's steady load,
    F_r = -pi rho c^2/4 U da/dt      twice that of a plate in heave, less the steady one,
    F_a = -pi rho c^2/4 d2h/dt2      that of a plate in heave,
    M   = -pi rho c^4/128 d2a/dt2    that of a plate that turns about its middle,

where w, da/dt, d2h/dt2 and d2a/dt2 are the upwash, turning rate, heave and turning acceleration of the whole wing, of
elastic modes their averages over the chord with the weights of the theory, and L is the lag. `numbers.lift_slope`
replaces 2 pi.
"""

import math

import numpy as np

from taichiflap.fluids.kit import (
    ACCEL,
    AMPLITUDE,
    AXIAL,
    BETA,
    C0,
    C1,
    C2,
    MOMENT,
    NORMAL,
    PITCH_ACCEL,
    PITCH_RATE,
    RATE,
    UNSTEADY,
    Model,
    Profile,
    Table,
    View,
    flow_of,
    key,
    most_modes,
    pivot_heave,
    pivot_velocity,
    superpose,
    ti,
)  # fmt: skip

ELEMENTS, ANGLES = 64, 256
SHARES, POLES = (0.165, 0.335), (0.0455, 0.3)
"""Wagner's function is about `1 - sum share exp(-pole s)`, s in half-chords."""

LIFT, MASS, INERTIA, CHORD, AHEAD = range(5)
"""Constants: rho c lift_slope/2, pi rho c^2/4, pi rho c^4/128, times the span; c; pivot behind the leading edge."""
WASH, RISE, SPIN, TILT, TURN = range(5)
"""Averages of a mode: its value in w, d2h/dt2 and d2a/dt2; its slope in w (times U) and in da/dt."""
PLATE, HEAVE, COUPLE, ACCELERATION = range(4)
"""Amplitudes of the three distributions of load, N and N m; and the d2h/dt2 behind them."""


class Numbers(Table):
    """What the case file says in `[numbers]`."""

    lift_slope: float = key(2.0 * math.pi, unit="1/rad", text="change of the lift coefficient with the angle", gt=0)


class Theodorsen(Model):
    name, numbers, elements = "THEODORSEN", Numbers, ELEMENTS

    def flow(self, cases, sections, body, threads):
        """Constants of every case; averages over the chord by Gauss and Chebyshev's rule in `y = c/2 (1 - cos t)`."""
        count, most = len(cases), most_modes(sections)
        constant, spread = np.zeros((count, 5)), np.zeros((count, 3, ELEMENTS))  # spread: pressure of a unit load
        arm, mean = np.zeros((count, most, 3)), np.zeros((count, most, 5))  # arm: work of a unit load on a mode
        cosine = np.cos((np.arange(ANGLES) + 0.5) * math.pi / ANGLES)
        plate, wash, heave = (weights / ANGLES for weights in (1 + cosine, 1 - cosine, 2 * (1 - cosine**2)))
        edge = np.arccos(1.0 - 2.0 * np.arange(ELEMENTS + 1) / ELEMENTS)
        ahead = np.array([edge + np.sin(edge), edge - 0.5 * np.sin(2 * edge), -16 / 3 * np.sin(edge) ** 3]) / math.pi
        for b, (case, section) in enumerate(zip(cases, sections, strict=True)):
            chord, span = case.wing.chord, Profile.of(case.wing.span).mean
            added = case.fluid.density * span * math.pi * chord**2 / 4
            lift = 0.5 * case.fluid.density * span * chord * self.parameters(case).lift_slope
            constant[b] = lift, added, added * chord**2 / 32, chord, case.wing.pivot * chord
            spread[b] = np.diff(ahead) * (ELEMENTS / (span * chord)) * np.array([[1.0], [1.0], [1.0 / chord]])
            y, couple = chord * (0.5 - 0.5 * cosine), -8 * cosine * heave / chord
            value, slope = section.shape(y), section.slope(y)
            arm[b, : section.count] = np.stack([value @ weights for weights in (plate, heave, couple)], axis=1)
            means = value @ wash, value @ heave, value @ couple, slope @ wash, slope @ heave
            mean[b, : section.count] = np.stack(means, axis=1)
        return flow_of(
            prepare, settle, record, constant=constant, spread=spread, arm=arm, mean=mean,
            stream=np.array([case.fluid.velocity for case in cases], dtype=float),
            lag=np.zeros((count, 2, 2)),  # one step earlier, and two
            load=np.zeros((count, most + 1, 4)),  # without modal acceleration, and by that of each mode
            now=np.zeros((count, 4)),  # and in all
        )  # fmt: skip


MODEL = Theodorsen()


@ti.func
def upwash(body: View, flow: View, b, n, state: View):
    """The w of the wing at the modal rates of a state."""
    p_y, p_z = pivot_velocity(body, flow.stream, b, n)
    arm = 0.75 * flow.constant[b, CHORD] - flow.constant[b, AHEAD]
    w = p_z + body.motion[b, n, PITCH_RATE] * arm + superpose(flow.mean, state, b, RATE, WASH, body.modes[b])
    return w - p_y * superpose(flow.mean, body.q_predicted, b, AMPLITUDE, TILT, body.modes[b])


@ti.func
def remember(flow: View, b, i, share, pole, rule, speed):
    """A lag of the coming step: its gain on the upwash, and what is left of it without."""
    rate = 2.0 * pole * ti.abs(speed) / flow.constant[b, CHORD]
    kept = -(rule[C1] * flow.lag[b, 0, i] + rule[C2] * flow.lag[b, 1, i])
    scale = 0.0
    if rule[C0] > 0.0:
        scale = 1.0 / (rule[C0] + rate)
    return share * rate * scale, kept * scale


@ti.func
def load_column(flow: View, b, column, speed, lagged, turn, rise, spin):
    """The three loads, linear in the motion of the wing."""
    sweep = flow.constant[b, MASS] * speed * turn
    flow.load[b, column, PLATE] = sweep - flow.constant[b, LIFT] * speed * lagged
    flow.load[b, column, HEAVE] = -flow.constant[b, MASS] * rise - 2.0 * sweep
    flow.load[b, column, COUPLE] = -flow.constant[b, INERTIA] * spin
    flow.load[b, column, ACCELERATION] = rise


@ti.func
def prepare(body: View, flow: View, b, n, rule):
    modes = body.modes[b]
    p_y, _ = pivot_velocity(body, flow.stream, b, n)
    turn = body.motion[b, n, PITCH_RATE] + superpose(flow.mean, body.q_free, b, RATE, TURN, modes)
    middle = 0.5 * flow.constant[b, CHORD] - flow.constant[b, AHEAD]
    rise = pivot_heave(body, b, n) + middle * body.motion[b, n, PITCH_ACCEL]
    gain = 1.0
    kept = 0.0
    for i in ti.static(range(2)):
        gained, left = remember(flow, b, i, SHARES[i], POLES[i], rule, p_y)
        gain += gained - SHARES[i]
        kept += left
    lagged = gain * upwash(body, flow, b, n, body.q_free) + kept
    load_column(flow, b, 0, -p_y, lagged, turn, rise, body.motion[b, n, PITCH_ACCEL])
    for k in range(modes):
        lagged = gain * rule[BETA] * flow.mean[b, k, WASH]
        turn = rule[BETA] * flow.mean[b, k, TURN]
        load_column(flow, b, k + 1, -p_y, lagged, turn, flow.mean[b, k, RISE], flow.mean[b, k, SPIN])
    for j, m in ti.ndrange(modes, 3):
        body.load[b, j] = body.load[b, j] + flow.arm[b, j, m] * flow.load[b, 0, m]
        for k in range(modes):
            body.response[b, j, k] = body.response[b, j, k] + flow.arm[b, j, m] * flow.load[b, k + 1, m]


@ti.func
def settle(body: View, flow: View, b, n, rule):
    p_y, _ = pivot_velocity(body, flow.stream, b, n)
    w = upwash(body, flow, b, n, body.q)
    for i in ti.static(range(2)):
        gain, kept = remember(flow, b, i, SHARES[i], POLES[i], rule, p_y)
        flow.lag[b, 1, i] = flow.lag[b, 0, i]
        flow.lag[b, 0, i] = gain * w + kept
    for m in range(4):
        total = flow.load[b, 0, m]
        for k in range(body.modes[b]):
            total += flow.load[b, k + 1, m] * body.q[b, ACCEL, k]
        flow.now[b, m] = total
    quarter = 0.25 * flow.constant[b, CHORD]
    body.force[b, NORMAL] = flow.now[b, PLATE] + flow.now[b, HEAVE]
    body.force[b, AXIAL] = 0.0
    body.force[b, MOMENT] = (
        quarter * (flow.now[b, PLATE] + 2.0 * flow.now[b, HEAVE])
        - flow.constant[b, AHEAD] * body.force[b, NORMAL]
        + flow.now[b, COUPLE]
    )
    body.force[b, UNSTEADY] = -flow.constant[b, MASS] * flow.now[b, ACCELERATION]


@ti.func
def record(flow: View, output: View, b, frame):
    for i in range(ELEMENTS):
        pressure = 0.0
        for m in range(3):
            pressure += flow.spread[b, m, i] * flow.now[b, m]
        output.pressure_jump[b, frame, i] = ti.cast(pressure, ti.f32)
