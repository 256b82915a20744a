"""Independent NumPy versions of the solver, written for clarity: no code shared with the kernels.

The time scheme is the documented one (BDF2, geometry from the extrapolated amplitudes), but the loads are plain
functions of the modal rate and acceleration, Kelvin's theorem is a row of the system, and the coupling is found
from the loads themselves instead of from a response matrix.
"""

from dataclasses import dataclass, field

import numpy as np

from taichiflap import beam, motion
from taichiflap.case import Case


def velocity(points, vortices, core2=0.0):
    """Velocity (points, 2) at points (n, 2) from vortices (m, 3)."""
    out = np.zeros((len(points), 2))
    for i, (y, z) in enumerate(points):
        for vy, vz, gamma in vortices:
            r2 = (y - vy) ** 2 + (z - vz) ** 2 + core2
            if r2 > 0.0:
                out[i] += gamma / (2 * np.pi * r2) * np.array([vz - z, y - vy])
    return out


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

    def march(self, steps):
        for n in range(steps + 1):
            self.step(n)
        return self

    def step(self, n):
        dt = self.dt
        zp, zd, zdd, th, thd, thdd = motion.sample(self.case.motion, np.array([n * dt]))[0]
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
        self.y = c.chord * (np.arange(e) + 0.5) / e
        self.phi = self.modes.shape(self.y)
        self.area = c.chord * c.span / e
        self.mass = np.pi * self.case.fluid.density * c.chord / 4 * self.area * self.case.dbet.added_mass

    def blades(self, w, w_rate):
        """Normal (along e_z) and axial (along e_y) force of every element."""
        _, zd, _, th, thd, _ = self.kinematics
        d, flow = self.case.dbet, self.case.fluid
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
        lift = d.lift_max * np.sin(2 * angle)
        drag = (d.drag_max + d.drag_min) / 2 - (d.drag_max - d.drag_min) / 2 * np.cos(2 * angle)
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
        force = np.array([normal.sum(), axial.sum(), moment, -self.mass * np.sum(self.rigid_accel + self.a @ self.phi)])
        self.history.append({"q": self.q, "a": self.a, "force": force})


class UvlmOracle(Oracle):
    """Lumped vortices in inertial coordinates, Kelvin's theorem as the last row of the system (Eqs 28-34)."""

    def setup(self):
        c, u = self.case.wing, self.case.uvlm
        self.nodes = c.chord * np.arange(u.panels + 1) / u.panels
        self.phi = self.modes.shape(self.nodes)
        self.core2 = (u.core * c.chord) ** 2
        self.wake = np.zeros((0, 3))
        self.wake_velocity = np.zeros((0, 2))
        self.dropped = 0.0
        self.sums = [np.zeros(u.panels), np.zeros(u.panels)]
        self.total = 0.0
        self.stream = np.array(self.case.fluid.velocity)

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
            everything = np.vstack((self.wake, self.bound))
            self.wake_velocity = velocity(self.wake[:, :2], everything, self.core2) + self.stream
            self.wake = self.wake.copy()
            self.wake[:, :2] += self.dt * self.wake_velocity
        self.w = q_star @ self.phi
        self.w_rate_star = v_star @ self.phi
        nodes = self.point(self.nodes, self.w)
        side = np.diff(nodes, axis=0)
        self.length = np.hypot(*side.T)
        self.tangent = side / self.length[:, None]
        self.normal = np.stack((-self.tangent[:, 1], self.tangent[:, 0]), axis=1)
        self.vortices = nodes[:-1] + 0.25 * side
        self.controls = nodes[:-1] + 0.75 * side
        edge_rate = v_known @ self.phi[:, -1]
        edge_velocity = self.point_velocity(self.nodes[-1], self.w[-1], edge_rate)
        if u.shedding == "fixed":
            new = nodes[-1] + u.shedding_distance * chord * self.tangent[-1]
        else:
            flow = self.wake_velocity[-1] if n else self.stream
            step = 0.25 * self.dt * (flow - edge_velocity)
            along = max(step @ self.tangent[-1], 2e-4 * chord)
            new = nodes[-1] + along * self.tangent[-1] + (step @ self.normal[-1]) * self.normal[-1]
        keep = np.inf if u.wake == "all" else u.wake
        if len(self.wake) >= keep:
            self.dropped += self.wake[0, 2]
            self.wake, self.wake_velocity = self.wake[1:], self.wake_velocity[1:]
        self.new = new
        self.wash = velocity(self.controls, self.wake, self.core2) + self.stream
        sources = [(*p, 1.0) for p in self.vortices]
        panels = len(self.controls)
        self.matrix = np.ones((panels + 1, panels + 1))
        for j, source in enumerate(sources):
            self.matrix[:-1, j] = np.sum(velocity(self.controls, [source]) * self.normal, axis=1)
        self.of_new = velocity(self.controls, [(*new, 1.0)], self.core2)
        self.matrix[:-1, -1] = np.sum(self.of_new * self.normal, axis=1)
        self.slip = None
        gamma = self.circulation(v_star)
        slip = self.wash + gamma[-1] * self.of_new - self.control_velocity(v_star)
        self.slip = np.sum(slip * self.tangent, axis=1)

    def control_velocity(self, v):
        nodes = self.point_velocity(self.nodes, self.w, v @ self.phi)
        return 0.25 * nodes[:-1] + 0.75 * nodes[1:]

    def circulation(self, v):
        """Bound circulations and, last, the new vortex's."""
        rhs = np.sum((self.control_velocity(v) - self.wash) * self.normal, axis=1)
        return np.linalg.solve(self.matrix, np.append(rhs, self.total))

    def panel_force(self, v):
        gamma = self.circulation(v)[:-1]
        running = np.cumsum(gamma)
        change = self.rule[0] * running + self.rule[1] * self.sums[0] + self.rule[2] * self.sums[1]
        pressure = -self.case.fluid.density * (self.slip * gamma / self.length + change)
        return (pressure * self.length * self.case.wing.span)[:, None] * self.normal

    def load(self, v, a):
        th = self.kinematics[3]
        along_normal = self.panel_force(v) @ np.array([-np.sin(th), np.cos(th)])
        return 0.5 * (self.phi[:, :-1] + self.phi[:, 1:]) @ along_normal

    def end(self, n):
        th = self.kinematics[3]
        force = self.panel_force(self.v)
        gamma = self.circulation(self.v)
        self.bound = np.column_stack((self.vortices, gamma[:-1]))
        self.wake = np.vstack((self.wake, (*self.new, gamma[-1])))
        self.sums = [np.cumsum(gamma[:-1]), self.sums[0]]
        self.total = gamma[:-1].sum()
        normal = force @ np.array([-np.sin(th), np.cos(th)])
        axial = force @ np.array([np.cos(th), np.sin(th)])
        y, w = (0.5 * (x[1:] + x[:-1]) for x in (self.nodes, self.w))
        totals = np.array([normal.sum(), axial.sum(), y @ normal - w @ axial])
        self.history.append({"q": self.q, "a": self.a, "force": totals, "gamma": gamma[:-1], "wake": self.wake.copy()})
