"""Reduction of the number of wake vortices, with a controlled error at the wing: merging and absorption.

A full wake drops its oldest vortex, or lets two neighbours absorb one. The neighbours are the vortices shed before and
after it from the same edge. They share its circulation according to its position between them, and the stronger
neighbour moves so that sum(Gamma), sum(Gamma Y) and sum(Gamma Z) are conserved. Vortices whose absorption would need a
long move, because the strengths nearly cancel, are left alone.

At a distance R absorption changes the velocity by |Q|/(2 pi R^3), where Q = sum(Gamma zeta^2) is the change of the
second moment of the three vortices about the absorbed one. The vortex with the smallest change is absorbed first, those
near the wing last.

Merging comes first: two neighbours of the same sign at a distance d merge at their centroid if the change at the wing,
`|G1 G2/(G1 + G2)| d^2/(2 pi R^3)` (the same Q), is below `uvlm.merge_error`. Wakes that merge, or that two edges shed
into, are lists in the order of shedding instead of rings: their oldest vortex is the first.
"""

from ...kernels.runtime import View, ti
from ...vortex.sum import CIRCULATION, CORE2, INV_2PI, TINY, Y, Z, vortex_velocity
from .wake import (
    ABSORB_BEYOND,
    ABSORBS,
    CAPACITY,
    COUNT,
    DECAY,
    DROPPED,
    HEIGHT,
    LEADING,
    LOST_Y,
    LOST_Z,
    MERGE_BEYOND,
    MERGES,
    OLDEST,
    ROWS,
    SHED_A_STEP,
    SHED_AT,
    SHED_FROM,
    TRAILING,
    VELOCITY,
    move,
)  # fmt: skip

FAR = 1e30
MERGE_EVERY = 10
"""Number of steps between searches for vortices to merge."""
YOUNG = 2
"""Number of steps before a new vortex may merge."""
LONGEST_MOVE = 1.0
"""Maximum move of the stronger neighbour, relative to its distance from the absorbed vortex."""


@ti.func
def place_of(wake: View, b, order):
    """Index in the ring of the `order`-th oldest vortex."""
    return (wake.ring[b, OLDEST] + order) % wake.ring[b, CAPACITY]


@ti.func
def neighbour(wake: View, b, order, towards):
    """Order of the next vortex from the same edge in the direction `towards`, -1 or 1; -1 if none."""
    edge = wake.origin[b, SHED_FROM, place_of(wake, b, order)]
    found = -1
    other = order + towards
    while found < 0 and 0 <= other < wake.ring[b, COUNT]:
        if wake.origin[b, SHED_FROM, place_of(wake, b, other)] == edge:
            found = other
        other += towards
    return found


@ti.func
def sheet_around(wake: View, b, order):
    """Indices of a vortex and of its two neighbours on the sheet, the earlier one first."""
    earlier, later = neighbour(wake, b, order, -1), neighbour(wake, b, order, 1)
    return place_of(wake, b, order), place_of(wake, b, earlier), place_of(wake, b, later)


@ti.func
def merger(wake: View, b, i, a, c):
    """Effect of absorbing a vortex: share of the earlier neighbour, move of the stronger one, Q, and feasibility.

    Two vectors are complex numbers Y + i Z here: the move, m, and Q, m4/s.

    Args:
        i, a, c: see `sheet_around`.
    """
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
    earlier = stronger_is_earlier(wake, b, i, a, c, share)
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
def distance2(wake: View, b, i, y, z):
    """Squared distance of a vortex from a point, m2."""
    return (wake.vortex[b, Y, i] - y) ** 2 + (wake.vortex[b, Z, i] - z) ** 2


@ti.func
def choose(wake: View, b, y, z):
    """Order of the vortex to absorb; -1 if none is possible."""
    chosen = -1
    least = FAR
    for order in range(1, wake.ring[b, COUNT] - 1):
        if neighbour(wake, b, order, -1) >= 0 and neighbour(wake, b, order, 1) >= 0:
            i, a, c = sheet_around(wake, b, order)
            _, _, _, q_y, q_z, possible = merger(wake, b, i, a, c)
            r2 = distance2(wake, b, i, y, z)
            if is_list(wake, b):
                # After merging, neighbours may be far apart, and one may be near the wing.
                r2 = ti.min(r2, distance2(wake, b, a, y, z), distance2(wake, b, c, y, z))
            cost = ti.sqrt((q_y * q_y + q_z * q_z) / r2) / r2
            if r2 < wake.scalar[b, ABSORB_BEYOND] ** 2:
                cost += 0.5 * FAR
            if possible and cost < least:
                chosen, least = order, cost
    return chosen


@ti.func
def make_room(wake: View, b, n, y, z, used: View):
    """Make room for the vortices shed at step `n`; in a full ring, at the position of the oldest.

    (y, z) is a point on the wing. The velocity lost there, m/s, is added to earlier losses, which decay over a beat as
    the wake moves away. The kernel contains absorption and lists only if a case needs them.
    """
    listed = False
    if ti.static(used.listing):
        listed = is_list(wake, b)
        if listed:
            if n % MERGE_EVERY == 0 and wake.scalar[b, MERGES] > 0.0:
                merge(wake, b, n, y, z)
            shortens = wake.ring[b, COUNT] + ti.cast(wake.scalar[b, SHED_A_STEP], ti.i32) > wake.ring[b, CAPACITY]
            if shortens:
                wake.scalar[b, LOST_Y] = wake.scalar[b, DECAY] * wake.scalar[b, LOST_Y]
                wake.scalar[b, LOST_Z] = wake.scalar[b, DECAY] * wake.scalar[b, LOST_Z]
            while wake.ring[b, COUNT] + ti.cast(wake.scalar[b, SHED_A_STEP], ti.i32) > wake.ring[b, CAPACITY]:
                shorten(wake, b, y, z, used)
    if not listed and wake.ring[b, COUNT] == wake.ring[b, CAPACITY]:
        lost_y, lost_z = loss_of_oldest(wake, b, y, z)
        if ti.static(used.absorbing):
            order = -1
            if wake.scalar[b, ABSORBS] > 0.0:
                order = choose(wake, b, y, z)
            if order >= 0:
                lost_y, lost_z = loss_of_merger(wake, b, order, y, z)
                absorb(wake, b, order)
                for m in range(order):
                    move(wake, b, place_of(wake, b, order - m - 1), place_of(wake, b, order - m))
                wake.vortex[b, CIRCULATION, place_of(wake, b, 0)] = 0.0
        wake.scalar[b, LOST_Y] = wake.scalar[b, DECAY] * wake.scalar[b, LOST_Y] + lost_y
        wake.scalar[b, LOST_Z] = wake.scalar[b, DECAY] * wake.scalar[b, LOST_Z] + lost_z


@ti.func
def is_list(wake: View, b):
    """Whether a wake is a list instead of a ring."""
    return wake.scalar[b, SHED_A_STEP] > 1.0 or wake.scalar[b, MERGES] > 0.0


@ti.func
def shorten(wake: View, b, y, z, used: View):
    """Remove one vortex from a full list: one that its neighbours absorb, or the oldest."""
    order = 0
    lost_y, lost_z = loss_of_oldest(wake, b, y, z)
    dropped = wake.vortex[b, CIRCULATION, 0]
    if ti.static(used.shortening):
        if wake.scalar[b, ABSORBS] > 0.0:
            chosen = choose(wake, b, y, z)
            if chosen >= 0:
                lost_y, lost_z = loss_of_merger(wake, b, chosen, y, z)
                absorb(wake, b, chosen)
                order, dropped = chosen, 0.0
    wake.scalar[b, DROPPED] = wake.scalar[b, DROPPED] + dropped
    wake.scalar[b, LOST_Y] = wake.scalar[b, LOST_Y] + lost_y
    wake.scalar[b, LOST_Z] = wake.scalar[b, LOST_Z] + lost_z
    for m in range(order + 1, wake.ring[b, COUNT]):
        move(wake, b, m, m - 1)
    wake.ring[b, COUNT] = wake.ring[b, COUNT] - 1


@ti.func
def merge(wake: View, b, n, y, z):
    """Merge neighbours of the same sheet and sign, far from the point (y, z) on the wing, each at most once.

    Circulation and its centroid are conserved, and hence the circulation and impulse of the wake.
    """
    kept = 0
    last = ti.Vector([-1, -1])  # index of the last vortex kept from each edge, unless it has just been merged
    for i in range(wake.ring[b, COUNT]):
        edge = wake.origin[b, SHED_FROM, i]
        other = last[TRAILING]
        if edge == LEADING:
            other = last[LEADING]
        merges = False
        if other >= 0 and wake.origin[b, SHED_AT, i] < n - YOUNG:
            merges = merging_costs(wake, b, i, other, y, z) < wake.scalar[b, MERGES]
        if merges:
            blend(wake, b, i, other)
            other = -1
        else:
            other = kept
            if kept < i:
                move(wake, b, i, kept)
            kept += 1
        if edge == LEADING:
            last[LEADING] = other
        else:
            last[TRAILING] = other
    wake.ring[b, COUNT] = kept


@ti.func
def merging_costs(wake: View, b, i, a, y, z):
    """Change of the velocity (m/s) at (y, z) if two vortices merge; infinite near the wing or for opposite signs."""
    gamma_i, gamma_a = wake.vortex[b, CIRCULATION, i], wake.vortex[b, CIRCULATION, a]
    nearest2 = ti.min(distance2(wake, b, i, y, z), distance2(wake, b, a, y, z))
    cost = FAR
    if gamma_i * gamma_a > 0.0 and nearest2 > wake.scalar[b, MERGE_BEYOND] ** 2:
        d2 = distance2(wake, b, i, wake.vortex[b, Y, a], wake.vortex[b, Z, a])
        reduced = ti.abs(gamma_i * gamma_a / (gamma_i + gamma_a))
        cost = INV_2PI * reduced * d2 / (nearest2 * ti.sqrt(nearest2))
    return cost


@ti.func
def blend(wake: View, b, i, a):
    """Merge vortex `i` into `a`, at the centroid; the larger core is kept."""
    gamma = wake.vortex[b, CIRCULATION, i] + wake.vortex[b, CIRCULATION, a]
    share = wake.vortex[b, CIRCULATION, i] / gamma
    for axis in range(2):
        wake.vortex[b, axis, a] = share * wake.vortex[b, axis, i] + (1.0 - share) * wake.vortex[b, axis, a]
    for row in range(VELOCITY, ROWS):
        wake.vortex[b, row, a] = share * wake.vortex[b, row, i] + (1.0 - share) * wake.vortex[b, row, a]
    wake.vortex[b, CIRCULATION, a] = gamma
    wake.vortex[b, CORE2, a] = ti.max(wake.vortex[b, CORE2, i], wake.vortex[b, CORE2, a])
    wake.vortex[b, HEIGHT, a] = 0.0


@ti.func
def velocity_of(wake: View, b, place, gamma, dy, dz):
    """Velocity at (dy, dz) from a vortex of circulation `gamma`, with the core of the one at `place`."""
    return vortex_velocity(gamma, dy, dz, wake.vortex[b, CORE2, place] + TINY)


@ti.func
def loss_of_oldest(wake: View, b, y, z):
    """Velocity induced by the oldest vortex at (y, z)."""
    i = place_of(wake, b, 0)
    gamma = wake.vortex[b, CIRCULATION, i]
    return velocity_of(wake, b, i, gamma, y - wake.vortex[b, Y, i], z - wake.vortex[b, Z, i])


@ti.func
def loss_of_merger(wake: View, b, order, y, z):
    """Change of the velocity at (y, z) by an absorption: three vortices before minus two after."""
    i, a, c = sheet_around(wake, b, order)
    share, move_y, move_z, _, _, _ = merger(wake, b, i, a, c)
    gamma = wake.vortex[b, CIRCULATION, i]
    lost_y, lost_z = velocity_of(wake, b, i, gamma, y - wake.vortex[b, Y, i], z - wake.vortex[b, Z, i])
    earlier = stronger_is_earlier(wake, b, i, a, c, share)
    for side in ti.static(range(2)):
        m = ti.select(side == 0, a, c)
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
def stronger_is_earlier(wake: View, b, i, a, c, share):
    """Whether the earlier of a vortex's neighbours is the stronger after absorbing it."""
    gamma = wake.vortex[b, CIRCULATION, i]
    earlier = wake.vortex[b, CIRCULATION, a] + share * gamma
    later = wake.vortex[b, CIRCULATION, c] + (1.0 - share) * gamma
    return ti.abs(earlier) > ti.abs(later)


@ti.func
def absorb(wake: View, b, order):
    """Let the neighbours absorb a vortex, which the caller then removes."""
    i, a, c = sheet_around(wake, b, order)
    share, move_y, move_z, _, _, _ = merger(wake, b, i, a, c)
    gamma = wake.vortex[b, CIRCULATION, i]
    gamma_a = wake.vortex[b, CIRCULATION, a] + share * gamma
    gamma_c = wake.vortex[b, CIRCULATION, c] + (1.0 - share) * gamma
    moved = ti.select(stronger_is_earlier(wake, b, i, a, c, share), a, c)
    wake.vortex[b, CIRCULATION, a] = gamma_a
    wake.vortex[b, CIRCULATION, c] = gamma_c
    wake.vortex[b, Y, moved] = wake.vortex[b, Y, moved] + move_y
    wake.vortex[b, Z, moved] = wake.vortex[b, Z, moved] + move_z
