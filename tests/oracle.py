"""Independent NumPy versions of the solver, written for clarity: no code shared with the kernels.

The time scheme is the documented one (BDF2, geometry from the extrapolated amplitudes), but the loads are plain
functions of the modal rate and acceleration, Kelvin's theorem is a row of the system, and the coupling is found
from the loads themselves instead of from a response matrix.
"""

from dataclasses import dataclass, field

import numpy as np

from taichiflap.case.case import Case
from taichiflap.motion import sampling
from taichiflap.structure import beam


def velocity(points, vortices, core2=0.0):
    """Velocity (points, 2) at points (n, 2), of squared cores `core2`, from vortices (m, 3), or (m, 4) with theirs."""
    out = np.zeros((len(points), 2))
    for i, ((y, z), own) in enumerate(zip(points, np.broadcast_to(core2, len(points)), strict=True)):
        for vy, vz, gamma, *core in vortices:
            r2 = (y - vy) ** 2 + (z - vz) ** 2 + own + sum(core)
            if r2 > 0.0:
                out[i] += gamma / (2 * np.pi * r2) * np.array([vz - z, y - vy])
    return out


def mean_span(span, left, right):
    """Mean of a span, a number or a table, over each of some pieces of the chord: the trapezium rule on a fine grid."""
    if not isinstance(span, tuple):
        return np.full(len(left), span)
    s, value = np.array(span).T
    fine = np.linspace(left, right, 20_001)
    return np.trapezoid(np.interp(fine, s, value), dx=1 / 20_000, axis=0)


@dataclass
class Oracle:
    """Marches one case; `history` holds a dictionary for each step."""

    case: Case
    history: list = field(default_factory=list)

    def __post_init__(self):
        self.modes = beam.modes(self.case.wing)
        self.dt = self.case.step
        k = self.modes.count
        self.q = self.v = self.a = np.zeros(k)
        self.q1 = self.v1 = np.zeros(k)
        self.setup()

    def setup(self):
        """Prepare the state of the fluid."""
        raise NotImplementedError

    def begin(self, n, rule, q_star, v_star, v0):
        """Prepare a step, at the predicted deflection."""
        raise NotImplementedError

    def load(self, v, a):
        """Modal forces of the fluid at modal rates and accelerations."""
        raise NotImplementedError

    def end(self, n):
        """Advance the state of the fluid, and store the step."""
        raise NotImplementedError

    def march(self, steps):
        for n in range(steps + 1):
            self.step(n)
        return self

    def step(self, n):
        dt = self.dt
        zp, zd, zdd, th, thd, thdd = sampling.sample(self.case.motion, np.array([n * dt]))[0, :6]
        self.kinematics = (zp, zd, zdd, th, thd, thdd)
        if n == 0:
            rule, beta = (0.0, 0.0, 0.0), 0.0
            q0, v0, q_star, v_star = self.q, self.v, self.q, self.v
        else:
            rule = (1 / dt, -1 / dt, 0.0) if n == 1 else (1.5 / dt, -2 / dt, 0.5 / dt)
            beta = 1 / rule[0]
            q0 = -(rule[1] * self.q + rule[2] * self.q1) / rule[0]
            v0 = -(rule[1] * self.v + rule[2] * self.v1) / rule[0]
            q_star = self.q + dt * self.v + dt**2 / 2 * self.a
            v_star = self.v + dt * self.a
            self.q1, self.v1 = self.q, self.v
        self.begin(n, rule, q_star, v_star, v0)
        m = self.modes
        k = m.count

        def residual(a):
            v = v0 + beta * a
            q = q0 + beta * v
            inertia = m.lam * zdd * np.cos(th) + m.psi * thdd
            elastic = 2 * m.damping_ratio * m.omega * v + (m.omega**2 - thd**2) * q
            return a + elastic + inertia - self.load(v, a)

        if k:
            base = residual(np.zeros(k))
            jacobian = np.array([residual(e) - base for e in np.eye(k)]).T
            self.a = np.linalg.solve(jacobian, -base)
        self.v = v0 + beta * self.a
        self.q = q0 + beta * self.v
        self.end(n)


class DbetOracle(Oracle):
    """Blade elements with angles of attack, Eqs 17-27."""

    def setup(self):
        c, e = self.case.wing, self.case.dbet.elements
        s = (np.arange(e) + 0.5) / e
        self.y = c.chord * (s - c.pivot)
        self.phi = self.modes.shape(self.y)
        self.area = c.chord / e * mean_span(c.span, s - 0.5 / e, s + 0.5 / e)
        self.mass = np.pi * self.case.fluid.density * c.chord / 4 * self.area * (self.case.dbet.added_mass == "strip")

    def blades(self, w, w_rate):
        """Normal (along e_z) and axial (along e_y) force of every element."""
        _, zd, _, th, thd, _ = self.kinematics
        d, polar, flow = self.case.dbet, self.case.dbet.polar, self.case.fluid
        vy, vz = flow.velocity
        rigid = np.array(
            [
                (zd - vz) * np.sin(th) - vy * np.cos(th) + 0 * self.y,
                (zd - vz) * np.cos(th) + vy * np.sin(th) + self.y * thd,
            ]
        )
        elastic = np.array([-w * thd, w_rate])
        u = rigid + elastic
        angle = np.arctan2(u[1], u[0])
        speed2 = np.sum(u**2, axis=0)
        if d.speed == "truncated":
            speed2 = np.sum(rigid**2 + 2 * rigid * elastic, axis=0)
        lift = polar.lift_max * np.sin(2 * angle)
        drag = (polar.drag_max + polar.drag_min) / 2 - (polar.drag_max - polar.drag_min) / 2 * np.cos(2 * angle)
        pressure = 0.5 * flow.density * speed2 * self.area
        normal = -(drag * np.sin(angle) + lift * np.cos(angle)) * pressure
        axial = -(drag * np.cos(angle) - lift * np.sin(angle)) * pressure
        return normal, axial

    def begin(self, n, rule, q_star, v_star, v_known):
        _, _, zdd, th, thd, thdd = self.kinematics
        self.w = q_star @ self.phi
        self.w_rate = v_star @ self.phi
        self.rigid_accel = zdd * np.cos(th) + self.y * thdd - self.w * thd**2
        eps = 1e-5
        self.normal = self.blades(self.w, self.w_rate)[0]
        ahead, behind = (self.blades(self.w, self.w_rate + s * eps)[0] for s in (1, -1))
        self.slope = (ahead - behind) / (2 * eps)

    def element_normal(self, v, a):
        blades = self.normal + self.slope * (v @ self.phi - self.w_rate)
        return blades - self.mass * (self.rigid_accel + a @ self.phi)

    def load(self, v, a):
        return self.phi @ self.element_normal(v, a)

    def end(self, n):
        normal = self.element_normal(self.v, self.a)
        axial = self.blades(self.w, self.v @ self.phi)[1]
        moment = self.y @ normal - self.w @ axial
        unsteady = -np.sum(self.mass * (self.rigid_accel + self.a @ self.phi))
        force = np.array([normal.sum(), axial.sum(), moment, unsteady])
        self.history.append({"q": self.q, "a": self.a, "force": force})


class BladesOracle(DbetOracle):
    """Blade elements that bend: dense matrices by quadrature over every element, slopes by differences."""

    TERMS = 12
    LAG = ((0.026452, 0.134339, 0.259403, 0.079806), (0.008958, 0.062834, 0.219862, 0.719731))

    def setup(self):
        super().setup()
        case, d = self.case, self.case.dbet
        count, chord = d.elements, case.wing.chord
        self.lean_shape = self.modes.slope(self.y) * (d.frame == "deformed")
        edge = np.arccos(1 - 2 * np.arange(count + 1) / count)
        points, weights = np.polynomial.legendre.leggauss(16)
        half = np.diff(edge)[:, None] / 2
        t, weight = edge[:-1, None] + half * (1 + points), half * weights
        order = np.arange(1, self.TERMS + 1)[:, None, None]
        sines = np.sum(weight * np.sin(t) * np.sin(order * t), axis=2)
        cosines = 2 / np.pi * np.sum(weight * np.cos(order * t), axis=2)
        root = np.sqrt(self.area * count / chord)
        moments = 2 / np.pi * sines * root
        self.potential = np.pi * (chord / 2) ** 2 * moments.T @ (moments / order[:, 0])
        self.mean_wash = np.diff(edge) / np.pi
        lift = np.sum(weight * (1 + np.cos(t)), axis=1) * count / 2
        self.operator = 2 / np.pi * (np.outer(lift, self.mean_wash) - sines.T @ cosines * count / 2)
        self.plate = 2 / np.pi * lift
        self.three_quarters = self.plate[::-1] / count
        self.lag, self.wash = np.zeros(4), 0.0

    def velocities(self, v):
        """Along the normal and the tangent."""
        _, zd, _, th, thd, _ = self.kinematics
        vy, vz = self.case.fluid.velocity
        u_y = (zd - vz) * np.sin(th) - vy * np.cos(th) - self.w * thd
        u_z = (zd - vz) * np.cos(th) + vy * np.sin(th) + self.y * thd + v @ self.phi
        return self.stretch * (u_z - self.lean * u_y), self.stretch * (u_y + self.lean * u_z)

    def separated(self, v):
        u_n, u_t = self.velocities(v)
        polar = self.case.dbet.polar
        angle, pressure = np.arctan2(u_n, u_t), 0.5 * self.case.fluid.density * (u_n**2 + u_t**2)
        lift = polar.lift_max * np.sin(2 * angle)
        drag = polar.drag_min + (polar.drag_max - polar.drag_min) * np.sin(angle) ** 2
        normal = (drag * np.sin(angle) + lift * np.cos(angle)) * pressure
        return normal, (drag * np.cos(angle) - lift * np.sin(angle)) * pressure

    def begin(self, n, rule, q_star, v_star, v_known):
        case, d, rho, chord = self.case, self.case.dbet, self.case.fluid.density, self.case.wing.chord
        _, _, zdd, th, thd, thdd = self.kinematics
        self.w, self.w_rate, self.lean = q_star @ self.phi, v_star @ self.phi, q_star @ self.lean_shape
        self.rigid_accel = zdd * np.cos(th) + self.y * thdd - self.w * thd**2
        self.stretch = 1 / np.sqrt(1 + self.lean**2)
        u_n, u_t = self.velocities(v_star)
        speed = np.hypot(u_n.mean(), u_t.mean())
        angle = np.degrees(np.arcsin(abs(u_n.mean()) / speed))
        z = np.clip((angle - d.stall_deg[0]) / (d.stall_deg[1] - d.stall_deg[0]), 0, 1)
        self.sigma = 1.0 if u_t.mean() > 0 or not d.attached else z * z * (3 - 2 * z)
        self.decay = 0.0 if n == 0 else 2 * speed * case.step / chord
        normal, tangential = self.separated(v_star)
        rotation = d.rotation * np.pi / 4 * rho * chord * thd * speed * np.clip(-u_t.mean() / (0.1 * speed), -1, 1)
        eps = 1e-5
        self.slope = (self.separated_at(self.w_rate + eps) - self.separated_at(self.w_rate - eps)) / (2 * eps)
        self.known = self.sigma * (normal + rotation)
        friction = 0.0
        if case.fluid.viscosity and d.friction == "laminar":
            friction = 1.328 * rho * np.sqrt(case.fluid.viscosity * np.abs(u_t) / chord) * u_t
        self.tangential = self.sigma * tangential + (1 - self.sigma) * friction
        self.lifted = (1 - self.sigma) * np.pi * rho * np.abs(u_t)

    def separated_at(self, w_rate):
        """The normal force for given elastic rates of the elements."""
        phi, self.phi = self.phi, np.eye(len(self.y))
        normal, _ = self.separated(w_rate)
        self.phi = phi
        return normal

    def deficiency(self, v):
        wash = self.three_quarters @ self.velocities(v)[0]
        amplitude, exponent = map(np.array, self.LAG)
        lag = self.lag * np.exp(-exponent * self.decay)
        lag = lag + amplitude * np.exp(-exponent * self.decay / 2) * (wash - self.wash)
        return lag, wash

    def pressure(self, v, a):
        """Force on every element, and its part due to the added mass."""
        case, d = self.case, self.case.dbet
        u_n, _ = self.velocities(v)
        forces = self.known + self.sigma * self.slope * (v @ self.phi - self.w_rate)
        if d.attached:
            lag, _ = self.deficiency(v)
            forces = forces + self.lifted * (self.operator @ u_n - self.plate * lag.sum())
        if d.added_mass == "strip":
            added = -self.mass * (self.rigid_accel + a @ self.phi)
        else:
            _, zd, zdd, th, thd, thdd = self.kinematics
            vy, vz = case.fluid.velocity
            p_y = (zd - vz) * np.sin(th) - vy * np.cos(th)
            p_z = (zd - vz) * np.cos(th) + vy * np.sin(th)
            rate = zdd * np.cos(th) - thd * p_y + self.y * thdd + a @ self.phi
            along = zdd * np.sin(th) + thd * p_z - self.w_rate * thd - self.w * thdd
            rate = rate - (v @ self.lean_shape) * (p_y - self.w * thd) - self.lean * along
            added = -case.fluid.density * (self.potential @ rate)
        return added - self.area * forces, added

    def load(self, v, a):
        return self.phi @ (self.pressure(v, a)[0] - self.area * self.lean * self.tangential)

    def end(self, n):
        case, d = self.case, self.case.dbet
        pressure, added = self.pressure(self.v, self.a)
        tangential = self.area * self.tangential
        if d.frame == "chord" and not d.attached:
            tangential = self.area * self.separated(self.v)[1]
        normal, axial = pressure - self.lean * tangential, -self.lean * pressure - tangential
        moment = self.y @ normal - self.w @ axial
        suction = 0.0
        if d.attached:
            lag, wash = self.deficiency(self.v)
            around = self.mean_wash @ self.velocities(self.v)[0] - lag.sum()
            suction = (1 - self.sigma) * np.pi * case.fluid.density * d.suction * around**2 * self.area.sum()
            self.lag, self.wash = lag, wash
        force = np.array([normal.sum(), axial.sum() - suction, moment, added.sum()])
        self.history.append({"q": self.q, "a": self.a, "force": force})


class UvlmOracle(Oracle):
    """Lumped vortices in inertial coordinates, Kelvin's theorem as the last row of the system (Eqs 28-34)."""

    def setup(self):
        c, u = self.case.wing, self.case.uvlm
        self.cosine, self.whole = u.spacing == "cosine", u.loads == "panels"
        fraction = np.arange(u.panels + 1) / u.panels
        if self.cosine:
            fraction = (1 - np.cos(np.pi * fraction)) / 2
        self.nodes = c.chord * (fraction - c.pivot)
        self.span = mean_span(c.span, fraction[:-1], fraction[1:])
        self.edge_span = c.span[0][1] if isinstance(c.span, tuple) else c.span
        self.phi = self.modes.shape(self.nodes)
        if self.cosine:
            middle = (np.arange(u.panels) + 0.5) / u.panels
            self.places = c.chord * ((1 - np.cos(np.pi * middle)) / 2 - c.pivot), self.nodes[1:]
        else:
            quarter, three = ((1 - s) * self.nodes[:-1] + s * self.nodes[1:] for s in (0.25, 0.75))
            self.places = quarter, three
        self.phi_vortex, self.phi_point = (self.sample(self.modes.shape, y) for y in self.places)
        self.slope_vortex, self.slope_point = (self.sample_slope(y) for y in self.places)
        self.gauss_points = [] if self.whole else list(self.spread())
        self.wake = np.zeros((0, 4))
        self.wake_velocity = np.zeros((0, 2))
        self.before = np.zeros((0, 2))
        self.dropped = 0.0
        self.sums = [np.zeros(u.panels), np.zeros(u.panels)]
        self.total = 0.0
        self.sheds, self.shedding = u.leading_edge == "sheds", False
        self.sheet, self.fresh = np.zeros(0, dtype=int), 0
        self.released, self.edge_wash = [0.0, 0.0], np.zeros(2)
        self.stream = np.array(self.case.fluid.velocity)

    def sample(self, shape, y):
        """Modes at `y`: on the camber line, or on the straight panels between its points."""
        if self.cosine:
            return shape(y)
        return np.array([np.interp(y, self.nodes, phi) for phi in self.phi]).reshape(-1, len(y))

    def sample_slope(self, y):
        if self.cosine:
            return self.modes.slope(y)
        return np.diff(self.phi, axis=1) / np.diff(self.nodes)

    def tangents(self, slope):
        th = self.kinematics[3]
        angle = th + np.arctan(slope)
        tangent = np.stack((np.cos(angle), np.sin(angle)), axis=1)
        return tangent, np.stack((-tangent[:, 1], tangent[:, 0]), axis=1)

    def point(self, y, w):
        zp, th = self.kinematics[0], self.kinematics[3]
        return np.stack((y * np.cos(th) - w * np.sin(th), zp + y * np.sin(th) + w * np.cos(th)), axis=-1)

    def point_velocity(self, y, w, w_rate):
        _, zd, _, th, thd, _ = self.kinematics
        uy = zd * np.sin(th) - w * thd
        uz = zd * np.cos(th) + y * thd + w_rate
        return np.stack((uy * np.cos(th) - uz * np.sin(th), uy * np.sin(th) + uz * np.cos(th)), axis=-1)

    def begin(self, n, rule, q_star, v_star, v_known):
        u, chord = self.case.uvlm, self.case.wing.chord
        self.rule = rule
        if n:
            self.convect()
        self.lay(q_star, v_star)
        edge_rate = v_known @ self.phi[:, -1]
        edge_velocity = self.point_velocity(self.nodes[-1], self.w[-1], edge_rate)
        if u.shedding == "fixed":
            new = self.edges[-1] + u.shedding_distance * chord * self.tangent[-1]
        else:
            flow = self.wake_velocity[self.sheet == 0][-1] if n else self.stream
            step = (0.30 if self.cosine else 0.25) * self.dt * (flow - edge_velocity)
            along = max(step @ self.tangent[-1], 2e-4 * chord)
            new = self.edges[-1] + along * self.tangent[-1] + (step @ self.normal[-1]) * self.normal[-1]
        keep = np.inf if u.wake == "all" else u.wake
        if len(self.wake) >= keep:
            self.dropped += self.wake[0, 2]
            self.wake, self.wake_velocity, self.sheet = self.wake[1:], self.wake_velocity[1:], self.sheet[1:]
        self.new = (*new, 0.0 if u.core_growth else (u.core * chord) ** 2)
        self.of_wake = velocity(self.controls, self.wake) + self.stream
        sources = [(*p, 1.0) for p in self.vortices]
        panels = len(self.controls)
        self.matrix = np.ones((panels + 1, panels + 1))
        for j, source in enumerate(sources):
            self.matrix[:-1, j] = np.sum(velocity(self.controls, [source]) * self.normal, axis=1)
        self.of_new = velocity(self.controls, [self.vortex_of(1.0)])
        self.matrix[:-1, -1] = np.sum(self.of_new * self.normal, axis=1)
        if self.sheds:
            self.place_leading(v_known)
            self.decide(v_star)
        gamma = self.circulation(v_star)
        self.find_slip(gamma)
        self.find_suction(gamma)

    def vortex_of(self, circulation):
        y, z, core2 = self.new
        return (y, z, circulation, core2)

    def convect(self):
        u, chord = self.case.uvlm, self.case.wing.chord
        everything = np.vstack((self.wake, np.column_stack((self.bound, 0 * self.bound[:, 0]))))
        now = velocity(self.wake[:, :2], everything, self.wake[:, 3]) + self.stream
        step = self.dt * now
        old = len(now) - self.fresh
        if u.convection == "second_order":
            step[:old] += self.dt / 2 * (now[:old] - self.wake_velocity)
        self.wake_velocity = now
        self.wake = self.wake.copy()
        self.wake[:, :2] += step
        self.wake[:, 3] += 4.0 * (self.case.fluid.viscosity or 0.0) * self.dt
        if u.core_growth:
            core = np.sqrt(self.wake[:, 3])
            grown = np.minimum(core + u.core_growth * np.hypot(*step.T), u.core * chord)
            self.wake[:, 3] = np.maximum(core, grown) ** 2

    def lay(self, q_star, v_star):
        self.w = q_star @ self.phi
        self.q_star, self.v_star = q_star, v_star
        nodes = self.point(self.nodes, self.w)
        self.side = np.diff(nodes, axis=0)
        self.length = np.hypot(*self.side.T)
        self.edges = nodes
        self.vortices = self.point(self.places[0], q_star @ self.phi_vortex)
        self.controls = self.point(self.places[1], q_star @ self.phi_point)
        self.tangent, self.normal = self.tangents(q_star @ self.slope_point)

    def place_leading(self, v_known):
        """A vortex ahead of the leading edge, as an additional column; without its own row its strength is zero."""
        chord = self.case.wing.chord
        slope = self.q_star @ self.modes.slope(self.nodes[:1])
        (tangent,), (normal,) = self.tangents(slope)
        flow = self.wake_velocity[self.sheet == 1][-1] if self.shedding else self.stream + self.edge_wash
        edge = self.point_velocity(self.nodes[0], self.w[0], v_known @ self.phi[:, 0])
        step = 0.30 * self.dt * (flow - edge)
        along = min(step @ tangent, -2e-4 * chord)
        place = self.edges[0] + along * tangent + (step @ normal) * normal
        self.new_leading = (*place, 1.0, self.new[2])
        self.edge_wash = velocity(self.edges[:1], self.wake)[0]
        self.edge_normal, self.scale = normal, np.hypot(1.0, slope[0]) ** 0.5 / (2 * self.case.uvlm.panels)
        column = np.sum(velocity(self.controls, [self.new_leading]) * self.normal, axis=1)
        sources = [*((*p, 1.0) for p in self.vortices), self.vortex_of(1.0), self.new_leading]
        self.through = [self.scale * velocity(self.edges[:1], [source])[0] @ normal for source in sources]
        size = len(self.matrix)
        self.matrix = np.block([[self.matrix, np.append(column, 1.0)[:, None]], [np.zeros(size), np.ones((1, 1))]])

    def edge_free(self, v):
        """Suction velocity at the leading edge without the lattice's and the new vortices."""
        edge = self.point_velocity(self.nodes[0], self.w[0], v @ self.phi[:, 0])
        return self.scale * (self.edge_wash + self.stream - edge) @ self.edge_normal

    def decide(self, v_star):
        """If the predicted suction exceeds its limit, an additional row that keeps it there."""
        self.shedding = False
        expected = self.edge_free(v_star) + self.circulation(v_star) @ self.through
        limit = self.case.uvlm.suction_limit * self.case.reference_speed
        if abs(expected) > limit or not limit:
            self.shedding, self.target = True, np.copysign(limit, expected)
            self.matrix[-1] = self.through

    def strengths(self, gamma):
        """Circulation of the bound vortices, and of the new one of each edge."""
        count = len(self.vortices)
        return gamma[:count], gamma[count], (gamma[count + 1] if self.sheds else 0.0)

    def shed(self, gamma):
        """The step's new vortices, each with its circulation and core."""
        _, trailing, leading = self.strengths(gamma)
        shed = [self.vortex_of(trailing)]
        if self.shedding:
            y, z, _, core2 = self.new_leading
            shed.append((y, z, leading, core2))
        return np.array(shed)

    def find_slip(self, gamma):
        """Tangential velocity of the fluid: at the points, or at the vortices with the velocity of all others."""
        if self.whole:
            tangential = self.of_wake + self.strengths(gamma)[1] * self.of_new - self.control_velocity(self.v_star)
            self.tangential = np.sum(tangential * self.tangent, axis=1)
            return
        w, rate = self.q_star @ self.phi_vortex, self.v_star @ self.phi_vortex
        circulation = self.strengths(gamma)[0]
        bound = np.column_stack((self.vortices, circulation, 0 * circulation))
        flow = velocity(self.vortices, np.vstack((self.wake, self.shed(gamma), bound))) + self.stream
        tangent, _ = self.tangents(self.q_star @ self.slope_vortex)
        flow = flow - self.point_velocity(self.places[0], w, rate)
        slopes = [np.arctan(self.q_star @ slope) for slope in (self.slope_vortex, self.slope_point)]
        arc = (self.places[1] - self.places[0]) / np.cos(slopes[0])
        curvature = np.sin(slopes[1] - slopes[0]) / arc
        self.tangential = np.sum(flow * tangent, axis=1) + circulation * curvature / (4 * np.pi)

    def find_suction(self, gamma):
        """Force at the leading edge, shape (2,), from the flow through the lattice there."""
        self.suction = np.zeros(2)
        u, chord = self.case.uvlm, self.case.wing.chord
        if not (u.suction or self.sheds):
            return
        slope = self.modes.slope(self.nodes[:1]) if self.cosine else self.slope_vortex[:, :1]
        tangent, normal = self.tangents(self.q_star @ slope)
        circulation = self.strengths(gamma)[0]
        bound = np.column_stack((self.vortices, circulation, 0 * circulation))
        flow = velocity(self.edges[:1], np.vstack((self.wake, self.shed(gamma), bound)))[0] + self.stream
        rate = self.v_star @ self.phi[:, 0]
        through = (flow - self.point_velocity(self.nodes[0], self.w[0], rate)) @ normal[0]
        n = np.arange(u.panels)
        plate = 2.0 * u.panels if self.cosine else np.prod((n + 0.75) / (n + 0.25))
        stretch = np.hypot(1.0, self.q_star @ slope)[0]
        strength = np.pi * self.case.fluid.density * chord * self.edge_span * (through / plate) ** 2 * stretch
        self.suction = -strength * tangent[0]

    def control_velocity(self, v):
        return self.point_velocity(self.places[1], self.q_star @ self.phi_point, v @ self.phi_point)

    def circulation(self, v):
        """Bound circulations and, last, the new vortex's, or those of both edges."""
        rhs = np.append(np.sum((self.control_velocity(v) - self.of_wake) * self.normal, axis=1), self.total)
        if self.sheds:
            rhs = np.append(rhs, self.target - self.edge_free(v) if self.shedding else 0.0)
        return np.linalg.solve(self.matrix, rhs)

    def pieces(self, v):
        """Forces on the wing, their places and the modes there: (n, 2), (n, 2), (modes, n).

        Steady forces at the vortices or panels, pressures of d(Phi)/dt on pieces of the wing between nodes and steps
        of the potential, spread over Gauss points of each piece.
        """
        density = (self.case.fluid.density * self.span)[:, None]
        gamma, _, leading = self.strengths(self.circulation(v))
        jump = self.released[0] + leading
        running = jump + np.cumsum(gamma)
        change = self.rule[0] * running + self.rule[1] * self.sums[0] + self.rule[2] * self.sums[1]
        turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
        if self.whole:
            force = -density * ((self.tangential * gamma / self.length + change)[:, None] * self.side @ turn)
            places = 0.5 * (self.edges[1:] + self.edges[:-1])
            return force, places, 0.5 * (self.phi[:, 1:] + self.phi[:, :-1])
        _, normal = self.tangents(self.q_star @ self.slope_vortex)
        forces, places, modes = (
            [-density * (self.tangential * gamma)[:, None] * normal],
            [self.vortices],
            [self.phi_vortex],
        )
        change_0 = self.rule[0] * jump + self.rule[1] * self.released[0] + self.rule[2] * self.released[1]
        ahead = np.append(change_0, change[:-1])
        th = self.kinematics[3]
        along = np.array([[np.cos(th), np.sin(th)], [-np.sin(th), np.cos(th)]])
        for behind, length, y, phi, slope in self.gauss_points:
            per_length = np.stack((-(self.q_star @ slope), np.ones_like(y)), axis=1)
            forces.append(-density * ((change if behind else ahead) * length)[:, None] * (per_length @ along))
            places.append(self.point(y, self.q_star @ phi))
            modes.append(phi)
        return np.vstack(forces), np.vstack(places), np.hstack(modes)

    def spread(self):
        """Gauss points between nodes and vortices: whether behind the vortex, the length, place, modes and slopes."""
        for behind, left, right in (
            (False, self.nodes[:-1], self.places[0]),
            (True, self.places[0], self.nodes[1:]),
        ):
            for x, weight in zip(*np.polynomial.legendre.leggauss(8), strict=True):
                y = 0.5 * (left + right) + 0.5 * x * (right - left)
                slope = self.modes.slope(y) if self.cosine else self.slope_vortex
                yield behind, 0.5 * weight * (right - left), y, self.sample(self.modes.shape, y), slope

    def load(self, v, a):
        th = self.kinematics[3]
        force, _, phi = self.pieces(v)
        up = np.array([-np.sin(th), np.cos(th)])
        return phi @ (force @ up) + self.phi[:, 0] * (self.suction @ up)

    def friction(self, bound):
        """Blasius's friction of both sides, of each panel, along the chord."""
        fluid, arc = self.case.fluid, self.length.sum()
        mean = self.tangential @ self.length / arc
        sides = np.array([mean - 0.5 * bound / arc, mean + 0.5 * bound / arc])
        factor = 0.664 * fluid.density * ((fluid.viscosity or 0.0) / self.case.wing.chord) ** 0.5
        return factor * np.sum(np.sign(sides) * np.abs(sides) ** 1.5) * self.span * self.length

    def end(self, n):
        zp, th = self.kinematics[0], self.kinematics[3]
        force, places, _ = self.pieces(self.v)
        force, places = np.vstack((force, self.suction)), np.vstack((places, self.edges[0]))
        solved = self.circulation(self.v)
        gamma, _, leading = self.strengths(solved)
        self.bound = np.column_stack((self.vortices, gamma))
        self.wake = np.vstack((self.wake, self.shed(solved)))
        self.fresh = 1 + self.shedding
        self.sheet = np.append(self.sheet, [0, 1][: self.fresh])
        self.released = [self.released[0] + leading, self.released[0]]
        self.sums = [self.released[0] + np.cumsum(gamma), self.sums[0]]
        self.total = gamma.sum()
        chordwise = np.array([np.cos(th), np.sin(th)])
        rubbed = self.friction(gamma.sum())[:, None] * chordwise
        force, places = np.vstack((force, rubbed)), np.vstack((places, self.vortices))
        normal = force @ np.array([-np.sin(th), np.cos(th)])
        axial = force @ np.array([np.cos(th), np.sin(th)])
        arm = places - [0.0, zp]
        moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
        totals = np.array([normal.sum(), axial.sum(), moment.sum()])
        wake = self.wake[:, :3].copy()
        step = {"q": self.q, "a": self.a, "force": totals, "gamma": gamma, "wake": wake}
        if self.sheds:
            step |= {"released": self.released[:1], "suction": [self.edge_free(self.v) + solved @ self.through]}
        self.history.append(step)
