"""One step of the Navier-Stokes model in NumPy, written for clarity: dense matrices, FFTs of NumPy, one case.

Lengths in chords, the wing's axes from the pivot, density one. What a bending section's map and modes are is given.
"""

import numpy as np
from numpy.fft import irfft, rfft

from taichiflap.fluids.navier_stokes.grid import areas, positions, slopes


def left(a):
    return np.roll(a, 1, axis=-1)


def right(a):
    return np.roll(a, -1, axis=-1)


def third_order(q, most):
    """Corrections of a flux from second to third order, up to a limit."""
    return q / 12 * np.maximum(1 - abs(q) / 12 / most, 0), np.minimum(abs(q) / 12, most)


class Oracle:
    """The flow about one section, at rest or impulsively started, on the cells of `grid`."""

    def __init__(self, grid, nu, dt, velocity, rate):
        self.grid, self.nu, self.dt = grid, nu, dt
        rows, points = grid.rows, grid.points
        self.k = np.arange(points // 2 + 1)
        self.decay = np.exp(-self.k * grid.drho[:, None])
        with np.errstate(divide="ignore", invalid="ignore"):
            self.weight = np.where(self.k == 0, grid.drho[:, None], (1.0 - self.decay) / self.k)
        self.area, self.corner = grid.area, grid.corner
        self.moved, self.rates = np.zeros_like(self.corner), np.zeros_like(self.corner)
        self.wall = positions(grid.coefficients, np.zeros(1), grid.centres)[0]
        self.slope = slopes(grid.coefficients, grid.centres)
        self.w, self.convection, self.change = (np.zeros((rows, points)) for _ in range(3))
        self.g = np.zeros(points)
        self.flux_rho, self.flux_phi = np.zeros((rows + 1, points)), np.zeros((rows, points))
        # The vortex sheet of an impulsive start, spread over the first row.
        tangent, stream = self.motion(velocity, rate)
        k = self.k[1:]
        asked = self.k * rfft(stream) - rfft(tangent)
        asked[1:] *= k * grid.drho[0] / (1.0 - np.exp(-k * grid.drho[0]))
        asked[-1] = 0.0
        self.w[0] = irfft(asked, points) / grid.drho[0] / self.area[0]
        self.content = self.area * self.w
        self.find_fluxes(0, velocity, rate, tangent, stream)

    def motion(self, velocity, rate):
        """Im(V conj G) and the streamfunction of the rigid wall."""
        tangent = ((velocity + 1j * rate * self.wall) * self.slope.conj()).imag
        stream = velocity.real * self.wall.imag - velocity.imag * self.wall.real - 0.5 * rate * abs(self.wall) ** 2
        return tangent, stream

    def bend(self, n, coefficients):
        """Set a new map."""
        corner = positions(coefficients, self.grid.faces, self.grid.corners)
        moved = corner - self.corner
        self.rates = moved / self.dt if n == 1 else (1.5 * moved - 0.5 * self.moved) / self.dt
        self.corner, self.moved = corner, moved
        self.area = areas(corner, self.grid.drho, self.grid.dphi)
        self.wall = positions(coefficients, np.zeros(1), self.grid.centres)[0]
        self.slope = slopes(coefficients, self.grid.centres)

    def explicit(self):
        """Upwind fluxes of fifth order, lower near the first and last faces: through faces along rho, right faces."""
        w, rows = self.w, self.grid.rows
        through = np.zeros((rows + 1, w.shape[1]))
        for j in range(1, rows):
            q, a, c = self.flux_rho[j], w[j - 1], w[j]
            if j in (1, rows - 1):
                through[j] = 0.5 * q * (a + c)
            elif j in (2, rows - 2):
                wide = w[j - 2] + w[j + 1]
                through[j] = (q * (7 * (a + c) - wide) + abs(q) * (w[j + 1] - w[j - 2] - 3 * (c - a))) / 12
            else:
                far, near = w[j - 3] + w[j + 2], w[j - 2] + w[j + 1]
                fifth = w[j + 2] - w[j - 3] - 5 * (w[j + 1] - w[j - 2]) + 10 * (c - a)
                through[j] = (q * (37 * (a + c) - 8 * near + far) - abs(q) * fifth) / 60
        through[rows] = np.maximum(self.flux_rho[rows], 0.0) * w[-1]
        q, r1, r2, r3, l1, l2 = self.flux_phi, right(w), right(right(w)), np.roll(w, -3, 1), left(w), left(left(w))
        fifth = r3 - l2 - 5 * (r2 - l1) + 10 * (r1 - w)
        return through, (q * (37 * (w + r1) - 8 * (l1 + r2) + (l2 + r3)) - abs(q) * fifth) / 60

    def implicit(self, beta):
        """Central fluxes of the known vorticity with extrapolated face fluxes, and the capped third difference."""
        w, grid = self.w, self.grid
        cap = 0.1 * grid.drho[:, None] * grid.dphi / beta
        through = np.zeros((grid.rows + 1, w.shape[1]))
        for j in range(1, grid.near):
            q = self.ahead_rho[j]
            through[j] = 0.5 * q * (w[j] + w[j - 1])
            if j > 1:
                share, damping = third_order(q, cap[j] * self.area[j - 1])
                through[j] += grid.higher[0][j] * share * (w[j] + w[j - 1] - w[j - 2] - w[j + 1])
                through[j] += damping * (w[j + 1] - w[j - 2] - 3 * (w[j] - w[j - 1]))
        q = self.ahead_phi
        third = right(right(w)) - left(w) - 3 * (right(w) - w)
        share, damping = third_order(q, cap * self.area)
        fourth = w + right(w) - left(w) - right(right(w))
        return through, 0.5 * q * (w + right(w)) + grid.higher[1][:, None] * share * fourth + damping * third

    def transport(self, n, beta):
        """The step without the change of the wall flux; returns the response of the rows to it."""
        grid, spread = self.grid, self.nu * beta
        rows, points = grid.rows, grid.points
        face, row = (share[:, None] for share in grid.blend)
        inverse = 1.0 / (grid.drho[:, None] * grid.dphi)
        rho, phi = self.explicit()
        rho, phi = (1 - face) * rho, (1 - row) * phi
        explicit = (rho[:-1] - rho[1:] + left(phi) - phi) * inverse
        rho, phi = self.implicit(beta)
        rho, phi = face * rho, row * phi
        implicit = (rho[:-1] - rho[1:] + left(phi) - phi) * inverse
        implicit[grid.near :] = 0.0
        upper, lower = (spread * one[:, None] for one in grid.diffusion)
        above = np.vstack((self.w[1:], np.zeros((1, points))))
        below = np.vstack((self.w[:1], self.w[:-1]))
        d = self.change / 3 if n > 1 else 0.0 * self.change
        d = d + self.content - self.area * self.w
        d += beta * (explicit if n == 1 else 2 * explicit - self.convection) + beta * implicit
        d += upper * (above - self.w) - lower * (self.w - below)
        d += spread / grid.dphi**2 * (left(self.w) + right(self.w) - 2 * self.w)
        d[0] += beta / grid.drho[0] * self.g
        self.convection = explicit
        for j in range(grid.near):
            c, h = spread / grid.dphi**2, 0.5 * beta / grid.dphi / grid.drho[j] * row[j, 0]
            matrix = np.diag(self.area[j] + 2 * c)
            for i in range(points):
                matrix[i, (i + 1) % points] -= c - h * self.ahead_phi[j, i]
                matrix[i, i - 1] -= c + h * self.ahead_phi[j, i - 1]
            d[j] = self.area[j] * np.linalg.solve(matrix, d[j])
        response = np.zeros((rows, points))
        felt = grid.reach(self.nu * self.dt)
        for i in range(points):
            diagonal = self.area[:, i] + (upper + lower)[:, 0]
            matrix = np.diag(diagonal)
            closed = np.diag(diagonal[:felt] - np.append(np.zeros(felt - 1), upper[felt - 1, 0]))
            for j in range(rows - 1):
                turn = 0.5 * beta / grid.dphi * face[j + 1, 0] * self.ahead_rho[j + 1, i] if j + 1 <= grid.near else 0.0
                matrix[j, j + 1] -= upper[j, 0] - (turn / grid.drho[j] if j < grid.near else 0.0)
                matrix[j + 1, j] -= lower[j + 1, 0] + (turn / grid.drho[j + 1] if j + 1 < grid.near else 0.0)
                if j + 1 < felt:
                    closed[j, j + 1] -= upper[j, 0]
                    closed[j + 1, j] -= lower[j + 1, 0]
            d[:, i] = np.linalg.solve(matrix, d[:, i])
            response[:felt, i] = np.linalg.solve(closed, np.append(beta / grid.drho[0], np.zeros(felt - 1)))
        self.w = self.w + d
        return response

    def inwards(self, content):
        """A of every wavenumber at every face."""
        source = rfft(content) / content.shape[-1]
        a = np.zeros((self.grid.rows + 1, len(self.k)), complex)
        for j in range(self.grid.rows - 1, -1, -1):
            a[j] = self.decay[j] * a[j + 1] + self.weight[j] * source[j]
        return a

    def find_fluxes(self, n, velocity, rate, tangent, stream):
        """Streamfunction and face fluxes, now and extrapolated."""
        points = self.grid.points
        a = self.inwards(self.content)
        a[:, 0] += -tangent.mean() - a[0, 0]
        psi = np.zeros_like(a)
        psi[0] = rfft(stream) / points
        psi[0, 0] = 0.0
        for j in range(self.grid.rows):
            psi[j + 1] = self.decay[j] * psi[j] + 0.5 * self.weight[j] * (a[j] + a[j + 1])
        shift = np.exp(1j * self.k * np.pi / points)
        shift[-1] = 0.0
        corner = irfft(psi * shift * points, points)
        y, z = self.corner.real, self.corner.imag
        corner -= velocity.real * z - velocity.imag * y - 0.5 * rate * (y * y + z * z)
        rho = corner - left(corner)
        mean, side = 0.5 * (self.rates + left(self.rates)), self.corner - left(self.corner)
        rho -= (mean.conj() * side).imag
        phi = corner[:-1] - corner[1:]
        mean, side = 0.5 * (self.rates[1:] + self.rates[:-1]), self.corner[1:] - self.corner[:-1]
        phi += (mean.conj() * side).imag
        self.ahead_rho = rho if n == 0 else 2 * rho - self.flux_rho
        self.ahead_phi = phi if n == 0 else 2 * phi - self.flux_phi
        self.flux_rho, self.flux_phi = rho, phi

    def step(self, n, velocity, rate, accel, gain, modes=(), guess=(), solve=None):
        """Step `n`.

        Args:
            velocity, rate, accel, gain: of the pivot (complex) and of the pitch angle.
            modes: for each mode its shape and its integral along the chord, at the wall.
            guess: expected modal rates.
            solve: called with load, response to the rates and response to the accelerations; gives both.
        """
        grid, points, dphi = self.grid, self.grid.points, self.grid.dphi
        beta = self.dt if n == 1 else self.dt / 1.5
        before = self.content
        response = self.transport(n, beta)
        tangent, stream = self.motion(velocity, rate)
        bending = sum((v * phi for v, (phi, _) in zip(guess, modes, strict=True)), np.zeros(points))
        acceleration = accel + 1j * gain * self.wall - rate**2 * self.wall - 2.0 * rate * bending
        acceleration = (acceleration * self.slope.conj()).imag
        tangents = [phi * self.slope.real for phi, _ in modes]
        streams = [-integral for _, integral in modes]

        def defect(tangent, stream, content):
            found = self.k * rfft(stream) / points - rfft(tangent) / points - self.inwards(content)[0]
            return np.concatenate((found[1:-1].real, found[1:-1].imag))

        none = np.zeros_like(self.w)
        if n <= 2:  # later ones are of the same matrix until it is made anew
            columns = [
                -defect(np.zeros(points), np.zeros(points), response * self.area * row) for row in np.eye(points)
            ]
            mean, highest = np.full(points, 1.0 / points), (-1.0) ** np.arange(points)
            self.matrix = np.vstack((mean, highest, np.array(columns).T))

        def flux(mean, asked):
            return np.linalg.solve(self.matrix, np.concatenate(([mean, 0.0], asked)))

        fixed = flux(-acceleration.mean() - self.g.mean(), defect(tangent, stream, self.area * self.w))
        by_rate = [flux(0.0, defect(t, s, none)) for t, s in zip(tangents, streams, strict=True)]
        by_accel = [flux(-t.mean(), np.zeros(points - 2)) for t in tangents]

        def pressed_and_rubbed(dg, g, acceleration, w):
            return g + acceleration, self.nu * (w + response[0] * dg) + 0.5 * grid.drho[0] * g

        def modal(rise, tau):
            return np.array([dphi * (rise @ integral + (tau * phi) @ self.slope.real) for phi, integral in modes])

        spin = 2.0 * rate * self.nu
        rise, tau = pressed_and_rubbed(fixed, self.g + fixed, acceleration, self.w[0])
        v, a = np.zeros(0), np.zeros(0)
        if modes:
            zero = np.zeros(points)
            rates = np.array([modal(*pressed_and_rubbed(x, x, zero, zero)) for x in by_rate]).T
            accels = np.array(
                [modal(*pressed_and_rubbed(x, x, t, zero)) for x, t in zip(by_accel, tangents, strict=True)]
            ).T
            v, a = solve(modal(rise, tau - spin), rates, accels)
        dg = (
            fixed
            + sum(x * y for x, y in zip(v, by_rate, strict=True))
            + sum(x * y for x, y in zip(a, by_accel, strict=True))
        )
        acceleration = acceleration + sum(x * y for x, y in zip(a, tangents, strict=True))
        tangent = tangent + sum(x * y for x, y in zip(v, tangents, strict=True))
        stream = stream + sum(x * y for x, y in zip(v, streams, strict=True))
        self.g = self.g + dg
        self.w = self.w + response * dg
        self.content = self.area * self.w
        self.change = self.content - before
        self.find_fluxes(n, velocity, rate, tangent, stream)
        tau = self.nu * (self.w[0] - 2.0 * rate) + 0.5 * grid.drho[0] * self.g
        rise = self.g + acceleration
        gradient = np.fft.fft(-rise)
        gradient[[0, points // 2]] = 0.0
        k = np.fft.fftfreq(points, 1.0 / points)
        k[0] = 1.0
        pressure = np.fft.ifft(gradient / (1j * k)).real
        traction = (-pressure + 1j * tau) * self.slope * dphi
        return traction.sum(), (self.wall.conj() * traction).imag.sum()
