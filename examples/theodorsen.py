"""A third fluid model in one file, `solver = "module:theodorsen"`: linear theory of a thin wing in a stream.

Theodorsen's loads (NACA Report 496, 1935), with the wake's memory in two lags after R. T. Jones (NACA Report 681, 1938;
his fit of Wagner's function is off by up to 1 %). For small angles to a stream of speed U along the chord, a unit span:

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

from taichiflap.errors import UserError
from taichiflap.fluids.interface import Flow, Model
from taichiflap.kernels.arrays import array, zeros
from taichiflap.kernels.runtime import Floats2, Floats3, View, ti
from taichiflap.march.state import (
    ACCEL,
    AMPLITUDE,
    AXIAL,
    BETA,
    C0,
    C1,
    C2,
    MOMENT,
    NORMAL,
    RATE,
    UNSTEADY,
    most_modes,
    pivot_heave,
    pivot_velocity,
    superpose,
)
from taichiflap.motion.sampling import PITCH_ACCEL, PITCH_RATE
from taichiflap.structure.chordwise import Profile

ELEMENTS = 64
ANGLES = 256
SHARES, POLES = (0.165, 0.335), (0.0455, 0.3)
"""Wagner's function is about `1 - sum share exp(-pole s)`, s in half-chords."""

LIFT, MASS, INERTIA, CHORD, AHEAD = range(5)
"""Constants: rho c lift_slope/2, pi rho c^2/4, pi rho c^4/128, times the span; c; pivot behind the leading edge."""
WASH, RISE, SPIN, TILT, TURN = range(5)
"""Averages of a mode: its value in w, d2h/dt2 and d2a/dt2; its slope in w (times U) and in da/dt."""
PLATE, HEAVE, COUPLE, ACCELERATION = range(4)
"""Amplitudes of the three distributions of load, N and N m; and the d2h/dt2 behind them."""

Loads = ti.types.argpack(
    constant=Floats2,
    stream=Floats2,
    spread=Floats3,  # (case, distribution, element): pressure of a unit load
    arm=Floats3,  # (case, mode, distribution): work of a unit load on a mode
    mean=Floats3,  # (case, mode, average)
    lag=Floats3,  # (case, 2, lag): one step earlier, and two
    load=Floats3,  # (case, column, 4): the loads without modal acceleration, and by that of each mode
    now=Floats2,  # and in all
)


def flow(cases, sections):
    """Constants of every case; the averages over the chord by Gauss and Chebyshev's rule in `y = c/2 (1 - cos t)`."""
    count, most = len(cases), most_modes(sections)
    constant, spread = np.zeros((count, 5)), np.zeros((count, 3, ELEMENTS))
    arm, mean = np.zeros((count, most, 3)), np.zeros((count, most, 5))
    cosine = np.cos((np.arange(ANGLES) + 0.5) * math.pi / ANGLES)
    plate, wash, heave = (weights / ANGLES for weights in (1 + cosine, 1 - cosine, 2 * (1 - cosine**2)))
    edge = np.arccos(1.0 - 2.0 * np.arange(ELEMENTS + 1) / ELEMENTS)
    ahead = np.array([edge + np.sin(edge), edge - 0.5 * np.sin(2 * edge), -16 / 3 * np.sin(edge) ** 3]) / math.pi
    for b, (case, section) in enumerate(zip(cases, sections, strict=True)):
        numbers, chord, span = case.numbers or {}, case.wing.chord, Profile.of(case.wing.span).mean
        if numbers.keys() - {"lift_slope"}:
            raise UserError(f"numbers = {numbers}: this model knows lift_slope only")
        couple = -8 * cosine * heave / chord
        added = case.fluid.density * span * math.pi * chord**2 / 4
        lift = 0.5 * case.fluid.density * span * chord * numbers.get("lift_slope", 2 * math.pi)
        constant[b] = lift, added, added * chord**2 / 32, chord, case.wing.pivot * chord
        spread[b] = np.diff(ahead) * (ELEMENTS / (span * chord)) * np.array([[1.0], [1.0], [1.0 / chord]])
        y = chord * (0.5 - 0.5 * cosine)
        value, slope = section.shape(y), section.slope(y)
        arm[b, : section.count] = np.stack([value @ weights for weights in (plate, heave, couple)], axis=1)
        means = value @ wash, value @ heave, value @ couple, slope @ wash, slope @ heave
        mean[b, : section.count] = np.stack(means, axis=1)
    stream = array([case.fluid.velocity for case in cases], float)
    loads = Loads(
        constant=array(constant), stream=stream, spread=array(spread), arm=array(arm), mean=array(mean),
        lag=zeros(ti.f64, count, 2, 2), load=zeros(ti.f64, count, most + 1, 4),
        now=zeros(ti.f64, count, 4),
    )  # fmt: skip
    return Flow({"flow": loads}, {"flow": Loads}, prepare, settle, record)


@ti.func
def upwash(body: View, flow: View, b, n, state: View):
    """The w of the wing at the modal rates of a state."""
    p_y, p_z = pivot_velocity(body, flow.stream, b, n)
    arm = 0.75 * flow.constant[b, CHORD] - flow.constant[b, AHEAD]
    w = p_z + body.motion[b, n, PITCH_RATE] * arm + superpose(flow.mean, state, b, RATE, WASH, body.modes[b])
    return w - p_y * superpose(flow.mean, body.q_guess, b, AMPLITUDE, TILT, body.modes[b])


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
def prepare(batch: View, b, n, rule):
    load_modes(batch.body, batch.flow, b, n, rule)


@ti.func
def load_modes(body: View, flow: View, b, n, rule):
    modes = body.modes[b]
    p_y, _ = pivot_velocity(body, flow.stream, b, n)
    turn = body.motion[b, n, PITCH_RATE] + superpose(flow.mean, body.q_known, b, RATE, TURN, modes)
    middle = 0.5 * flow.constant[b, CHORD] - flow.constant[b, AHEAD]
    rise = pivot_heave(body, b, n) + middle * body.motion[b, n, PITCH_ACCEL]
    gain = 1.0
    kept = 0.0
    for i in ti.static(range(2)):
        gained, left = remember(flow, b, i, SHARES[i], POLES[i], rule, p_y)
        gain += gained - SHARES[i]
        kept += left
    lagged = gain * upwash(body, flow, b, n, body.q_known) + kept
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
def settle(batch: View, b, n, rule):
    sum_loads(batch.body, batch.flow, b, n, rule)


@ti.func
def sum_loads(body: View, flow: View, b, n, rule):
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
def record(batch: View, b, frame):
    for i in range(ELEMENTS):
        pressure = 0.0
        for m in range(3):
            pressure += batch.flow.spread[b, m, i] * batch.flow.now[b, m]
        batch.film.pressure_jump[b, frame, i] = ti.cast(pressure, ti.f32)


class Theodorsen(Model):
    name = "THEODORSEN"

    def nodes(self, case):
        return case.wing.chord * (np.arange(ELEMENTS + 1) / ELEMENTS - case.wing.pivot)

    def work(self, case, step):
        return 100.0

    def flow(self, cases, sections, body, threads):
        return flow(cases, sections)


MODEL = Theodorsen()
