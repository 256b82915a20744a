"""Room in a full wake: one vortex goes, either for good or into its neighbours, and what that costs at the wing.

A vortex is absorbed by the two that were shed before and after it, its neighbours on the sheet. They take its
circulation in shares that its place between them gives (signed as it is: shares are never of |Gamma|), and the
stronger of them then moves by what the impulse still lacks, so that sum(Gamma), sum(Gamma Y) and sum(Gamma Z) hold.
Where the strengths nearly cancel that move would be long: such vortices are left alone.

What the absorption changes at a distance R is the second moment of the three, Q = sum(Gamma zeta^2) about the vortex
that goes: a velocity of |Q|/(2 pi R^3). The vortex with the least goes first, those near the wing last.
"""

from ...kernels.runtime import View, ti
from ...vortex.sum import CIRCULATION, CORE2, INV_2PI, TINY, Y, Z
from .wake import ABSORB_BEYOND, ABSORBS, COUNT, FADE, GAP, KEEP, OLDEST

FAR = 1e30
LONGEST_MOVE = 1.0
"""Longest move of the stronger neighbour, over its distance from the vortex that goes."""


@ti.func
def place_of(wake: View, b, order):
    """Place in the ring of the vortex shed as number `order` of those held."""
    return (wake.ring[b, OLDEST] + order) % wake.ring[b, KEEP]


@ti.func
def merger(wake: View, b, order):
    """What absorbing a vortex would do: share of the earlier neighbour, move of the stronger one, Q, feasibility.

    Two vectors are complex numbers Y + i Z here: the move, m, and Q, m4/s.
    """
    i, a, c = place_of(wake, b, order), place_of(wake, b, order - 1), place_of(wake, b, order + 1)
    gamma = wake.vortex[b, CIRCULATION, i]
    a_y, a_z = wake.vortex[b, Y, a] - wake.vortex[b, Y, i], wake.vortex[b, Z, a] - wake.vortex[b, Z, i]
    c_y, c_z = wake.vortex[b, Y, c] - wake.vortex[b, Y, i], wake.vortex[b, Z, c] - wake.vortex[b, Z, i]
    side2 = (c_y - a_y) ** 2 + (c_z - a_z) ** 2
    share = 0.5
    if side2 > 0.0:
        share = ti.math.clamp((c_y * (c_y - a_y) + c_z * (c_z - a_z)) / side2, 0.0, 1.0)
    lack_y, lack_z = -gamma * (share * a_y + (1.0 - share) * c_y), -gamma * (share * a_z + (1.0 - share) * c_z)
    before_a, before_c = wake.vortex[b, CIRCULATION, a], wake.vortex[b, CIRCULATION, c]
    gamma_a, gamma_c = before_a + share * gamma, before_c + (1.0 - share) * gamma
    q_y = -before_a * (a_y * a_y - a_z * a_z) - before_c * (c_y * c_y - c_z * c_z)
    q_z = -2.0 * (before_a * a_y * a_z + before_c * c_y * c_z)
    earlier = stronger_is_earlier(wake, b, order, share)
    strongest = ti.select(earlier, gamma_a, gamma_c)
    move_y, move_z = 0.0, 0.0
    possible = ti.abs(strongest) > 0.0
    if possible:
        move_y, move_z = lack_y / strongest, lack_z / strongest
    reach2 = ti.select(earlier, a_y * a_y + a_z * a_z, c_y * c_y + c_z * c_z)
    possible = possible and move_y * move_y + move_z * move_z <= LONGEST_MOVE**2 * reach2
    if earlier:
        a_y, a_z = a_y + move_y, a_z + move_z
    else:
        c_y, c_z = c_y + move_y, c_z + move_z
    q_y += gamma_a * (a_y * a_y - a_z * a_z) + gamma_c * (c_y * c_y - c_z * c_z)
    q_z += 2.0 * (gamma_a * a_y * a_z + gamma_c * c_y * c_z)
    return share, move_y, move_z, q_y, q_z, possible


@ti.func
def choose(wake: View, b, y, z):
    """Order of the vortex to absorb; -1 if none can be."""
    chosen = -1
    least = FAR
    for order in range(1, wake.ring[b, COUNT] - 1):
        i = place_of(wake, b, order)
        _, _, _, q_y, q_z, possible = merger(wake, b, order)
        r2 = (wake.vortex[b, Y, i] - y) ** 2 + (wake.vortex[b, Z, i] - z) ** 2
        cost = ti.sqrt((q_y * q_y + q_z * q_z) / r2) / r2
        if r2 < wake.setting[b, ABSORB_BEYOND] ** 2:
            cost += 0.5 * FAR
        if possible and cost < least:
            chosen, least = order, cost
    return chosen


@ti.func
def make_room(wake: View, b, y, z, absorbing: View):
    """If the ring is full, see to it that its oldest place can be had.

    (y, z) is a place on the wing. The velocity that is lost there, m/s, adds to what was lost before, which fades over
    a beat as the wake moves away. The kernel holds the absorbing only where a case needs it.
    """
    if wake.ring[b, COUNT] == wake.ring[b, KEEP]:
        lost_y, lost_z = loss_of_oldest(wake, b, y, z)
        if ti.static(absorbing):
            order = -1
            if wake.setting[b, ABSORBS] > 0.0:
                order = choose(wake, b, y, z)
            if order >= 0:
                lost_y, lost_z = loss_of_merger(wake, b, order, y, z)
                absorb(wake, b, order)
        wake.tally[b, Y] = wake.setting[b, FADE] * wake.tally[b, Y] + lost_y
        wake.tally[b, Z] = wake.setting[b, FADE] * wake.tally[b, Z] + lost_z


@ti.func
def velocity_of(wake: View, b, place, gamma, dy, dz):
    """Velocity at (dy, dz) from a vortex of circulation `gamma`, with the core of the one at `place`."""
    strength = INV_2PI * gamma / (dy * dy + dz * dz + wake.vortex[b, CORE2, place] + TINY)
    return -dz * strength, dy * strength


@ti.func
def loss_of_oldest(wake: View, b, y, z):
    """Velocity of the oldest vortex at (y, z)."""
    i = place_of(wake, b, 0)
    gamma = wake.vortex[b, CIRCULATION, i]
    return velocity_of(wake, b, i, gamma, y - wake.vortex[b, Y, i], z - wake.vortex[b, Z, i])


@ti.func
def loss_of_merger(wake: View, b, order, y, z):
    """Change of the velocity at (y, z): of the three vortices before, less that of the two after."""
    i = place_of(wake, b, order)
    share, move_y, move_z, _, _, _ = merger(wake, b, order)
    gamma = wake.vortex[b, CIRCULATION, i]
    lost_y, lost_z = velocity_of(wake, b, i, gamma, y - wake.vortex[b, Y, i], z - wake.vortex[b, Z, i])
    earlier = stronger_is_earlier(wake, b, order, share)
    for side in ti.static(range(2)):
        m = place_of(wake, b, order - 1 + 2 * side)
        dy, dz = y - wake.vortex[b, Y, m], z - wake.vortex[b, Z, m]
        before = wake.vortex[b, CIRCULATION, m]
        after = before + ti.select(side == 0, share, 1.0 - share) * gamma
        moves = ti.select(earlier == (side == 0), 1.0, 0.0)
        was_y, was_z = velocity_of(wake, b, m, before, dy, dz)
        is_y, is_z = velocity_of(wake, b, m, after, dy - moves * move_y, dz - moves * move_z)
        lost_y += was_y - is_y
        lost_z += was_z - is_z
    return lost_y, lost_z


@ti.func
def stronger_is_earlier(wake: View, b, order, share):
    """Whether, of the neighbours of a vortex, the one shed earlier is the stronger once they share it."""
    gamma = wake.vortex[b, CIRCULATION, place_of(wake, b, order)]
    earlier = wake.vortex[b, CIRCULATION, place_of(wake, b, order - 1)] + share * gamma
    later = wake.vortex[b, CIRCULATION, place_of(wake, b, order + 1)] + (1.0 - share) * gamma
    return ti.abs(earlier) > ti.abs(later)


@ti.func
def absorb(wake: View, b, order):
    """Let the neighbours of a vortex take it up, and all older ones move up one place: the oldest is then empty."""
    share, move_y, move_z, _, _, _ = merger(wake, b, order)
    i, a, c = place_of(wake, b, order), place_of(wake, b, order - 1), place_of(wake, b, order + 1)
    gamma = wake.vortex[b, CIRCULATION, i]
    gamma_a = wake.vortex[b, CIRCULATION, a] + share * gamma
    gamma_c = wake.vortex[b, CIRCULATION, c] + (1.0 - share) * gamma
    moved = ti.select(stronger_is_earlier(wake, b, order, share), a, c)
    wake.vortex[b, CIRCULATION, a] = gamma_a
    wake.vortex[b, CIRCULATION, c] = gamma_c
    wake.vortex[b, Y, moved] = wake.vortex[b, Y, moved] + move_y
    wake.vortex[b, Z, moved] = wake.vortex[b, Z, moved] + move_z
    for m in range(order):
        to, source = place_of(wake, b, order - m), place_of(wake, b, order - m - 1)
        for row in range(GAP + 1):
            wake.vortex[b, row, to] = wake.vortex[b, row, source]
        for row in range(4):
            wake.velocity[b, row, to] = wake.velocity[b, row, source]
        wake.birth[b, to] = wake.birth[b, source]
    wake.vortex[b, CIRCULATION, place_of(wake, b, 0)] = 0.0
