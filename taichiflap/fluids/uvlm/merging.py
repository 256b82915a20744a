"""Fewer vortices in a wake, at a stated cost at the wing: two become one, or one goes from a full wake.

A full wake gives one up for good, or into its neighbours. A vortex is absorbed by the two that were shed before and
after it from the same edge, its neighbours on the sheet. They take its
circulation in shares that its place between them gives (signed as it is: shares are never of |Gamma|), and the
stronger of them then moves by what the impulse still lacks, so that sum(Gamma), sum(Gamma Y) and sum(Gamma Z) hold.
Where the strengths nearly cancel that move would be long: such vortices are left alone.

What the absorption changes at a distance R is the second moment of the three, Q = sum(Gamma zeta^2) about the vortex
that goes: a velocity of |Q|/(2 pi R^3). The vortex with the least goes first, those near the wing last.

Before that, two neighbours of one sign at a distance d merge at their centroid where what they change at the wing,
`|G1 G2/(G1 + G2)| d^2/(2 pi R^3)` (the same Q), is within an error: `uvlm.merge_error`. Wakes that merge, or take from
two edges, are lists in the order of shedding, not rings: their oldest stands at the first place.
"""

from ...kernels.runtime import View, ti
from ...vortex.sum import CIRCULATION, CORE2, INV_2PI, TINY, Y, Z, vortex_velocity
from .wake import (
    ABSORB_BEYOND,
    ABSORBS,
    BEFORE,
    CAPACITY,
    COUNT,
    DECAY,
    DROPPED,
    HEIGHT,
    LEADING,
    MERGE_BEYOND,
    MERGES,
    OLDEST,
    SHED_A_STEP,
    TRAILING,
    move,
)  # fmt: skip

FAR = 1e30
MERGE_EVERY = 10
"""Steps from one search for vortices to merge to the next."""
YOUNG = 2
"""Steps in which a vortex is too young to merge."""
LONGEST_MOVE = 1.0
"""Longest move of the stronger neighbour, over its distance from the vortex that goes."""


@ti.func
def place_of(wake: View, b, order):
    """Place in the ring of the vortex shed as number `order` of those held."""
    return (wake.ring[b, OLDEST] + order) % wake.ring[b, CAPACITY]


@ti.func
def neighbour(wake: View, b, order, towards):
    """Order of the next vortex from the same edge, `towards` -1 or 1; -1 if there is none."""
    edge = wake.edge[b, place_of(wake, b, order)]
    found = -1
    other = order + towards
    while found < 0 and 0 <= other < wake.ring[b, COUNT]:
        if wake.edge[b, place_of(wake, b, other)] == edge:
            found = other
        other += towards
    return found


@ti.func
def sheet_around(wake: View, b, order):
    """Places of a vortex and of its neighbours on the sheet, the earlier one first; it must have both."""
    earlier, later = neighbour(wake, b, order, -1), neighbour(wake, b, order, 1)
    return place_of(wake, b, order), place_of(wake, b, earlier), place_of(wake, b, later)


@ti.func
def merger(wake: View, b, i, a, c):
    """What absorbing a vortex would do: share of the earlier neighbour, move of the stronger one, Q, feasibility.

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
    """Square of the distance of a vortex from a place, m2."""
    return (wake.vortex[b, Y, i] - y) ** 2 + (wake.vortex[b, Z, i] - z) ** 2


@ti.func
def choose(wake: View, b, y, z):
    """Order of the vortex to absorb; -1 if none can be."""
    chosen = -1
    least = FAR
    for order in range(1, wake.ring[b, COUNT] - 1):
        if neighbour(wake, b, order, -1) >= 0 and neighbour(wake, b, order, 1) >= 0:
            i, a, c = sheet_around(wake, b, order)
            _, _, _, q_y, q_z, possible = merger(wake, b, i, a, c)
            r2 = distance2(wake, b, i, y, z)
            if is_list(wake, b):
                # Merging has put neighbours far apart: one may be near the wing.
                r2 = ti.min(r2, distance2(wake, b, a, y, z), distance2(wake, b, c, y, z))
            cost = ti.sqrt((q_y * q_y + q_z * q_z) / r2) / r2
            if r2 < wake.setting[b, ABSORB_BEYOND] ** 2:
                cost += 0.5 * FAR
            if possible and cost < least:
                chosen, least = order, cost
    return chosen


@ti.func
def make_room(wake: View, b, n, y, z, used: View):
    """See to it that there is room for what step `n` sheds: for one vortex in the oldest place of a full ring.

    (y, z) is a place on the wing. The velocity that is lost there, m/s, adds to what was lost before, which fades over
    a beat as the wake moves away. The kernel holds the absorbing and the lists only where a case needs them.
    """
    listed = False
    if ti.static(used.listing):
        listed = is_list(wake, b)
        if listed:
            if n % MERGE_EVERY == 0 and wake.setting[b, MERGES] > 0.0:
                merge(wake, b, n, y, z)
            shortens = wake.ring[b, COUNT] + ti.cast(wake.setting[b, SHED_A_STEP], ti.i32) > wake.ring[b, CAPACITY]
            if shortens:
                wake.tally[b, Y] = wake.setting[b, DECAY] * wake.tally[b, Y]
                wake.tally[b, Z] = wake.setting[b, DECAY] * wake.tally[b, Z]
            while wake.ring[b, COUNT] + ti.cast(wake.setting[b, SHED_A_STEP], ti.i32) > wake.ring[b, CAPACITY]:
                shorten(wake, b, y, z, used)
    if not listed and wake.ring[b, COUNT] == wake.ring[b, CAPACITY]:
        lost_y, lost_z = loss_of_oldest(wake, b, y, z)
        if ti.static(used.absorbing):
            order = -1
            if wake.setting[b, ABSORBS] > 0.0:
                order = choose(wake, b, y, z)
            if order >= 0:
                lost_y, lost_z = loss_of_merger(wake, b, order, y, z)
                absorb(wake, b, order)
                for m in range(order):
                    move(wake, b, place_of(wake, b, order - m - 1), place_of(wake, b, order - m))
                wake.vortex[b, CIRCULATION, place_of(wake, b, 0)] = 0.0
        wake.tally[b, Y] = wake.setting[b, DECAY] * wake.tally[b, Y] + lost_y
        wake.tally[b, Z] = wake.setting[b, DECAY] * wake.tally[b, Z] + lost_z


@ti.func
def is_list(wake: View, b):
    """Whether a wake is a list, see above."""
    return wake.setting[b, SHED_A_STEP] > 1.0 or wake.setting[b, MERGES] > 0.0


@ti.func
def shorten(wake: View, b, y, z, used: View):
    """Take one vortex from a full list: absorbed by its neighbours, or the oldest for good."""
    order = 0
    lost_y, lost_z = loss_of_oldest(wake, b, y, z)
    dropped = wake.vortex[b, CIRCULATION, 0]
    if ti.static(used.shortening):
        if wake.setting[b, ABSORBS] > 0.0:
            chosen = choose(wake, b, y, z)
            if chosen >= 0:
                lost_y, lost_z = loss_of_merger(wake, b, chosen, y, z)
                absorb(wake, b, chosen)
                order, dropped = chosen, 0.0
    wake.tally[b, DROPPED] = wake.tally[b, DROPPED] + dropped
    wake.tally[b, Y] = wake.tally[b, Y] + lost_y
    wake.tally[b, Z] = wake.tally[b, Z] + lost_z
    for m in range(order + 1, wake.ring[b, COUNT]):
        move(wake, b, m, m - 1)
    wake.ring[b, COUNT] = wake.ring[b, COUNT] - 1


@ti.func
def merge(wake: View, b, n, y, z):
    """Merge neighbours of one sheet and one sign, far from the place (y, z) on the wing, each at most once.

    Circulation and its centroid hold, hence circulation and impulse of the wake.
    """
    kept = 0
    last = ti.Vector([-1, -1])  # place of the last vortex kept of each edge, unless it has just been merged
    for i in range(wake.ring[b, COUNT]):
        edge = wake.edge[b, i]
        other = last[TRAILING]
        if edge == LEADING:
            other = last[LEADING]
        merges = False
        if other >= 0 and wake.birth[b, i] < n - YOUNG:
            merges = merging_costs(wake, b, i, other, y, z) < wake.setting[b, MERGES]
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
    """Velocity (m/s) that merging two vortices changes at (y, z); without bound near the wing, or of unlike signs."""
    gamma_i, gamma_a = wake.vortex[b, CIRCULATION, i], wake.vortex[b, CIRCULATION, a]
    nearest2 = ti.min(distance2(wake, b, i, y, z), distance2(wake, b, a, y, z))
    cost = FAR
    if gamma_i * gamma_a > 0.0 and nearest2 > wake.setting[b, MERGE_BEYOND] ** 2:
        d2 = distance2(wake, b, i, wake.vortex[b, Y, a], wake.vortex[b, Z, a])
        reduced = ti.abs(gamma_i * gamma_a / (gamma_i + gamma_a))
        cost = INV_2PI * reduced * d2 / (nearest2 * ti.sqrt(nearest2))
    return cost


@ti.func
def blend(wake: View, b, i, a):
    """Put two vortices together at the place of one of them, `a`; the core is the larger."""
    gamma = wake.vortex[b, CIRCULATION, i] + wake.vortex[b, CIRCULATION, a]
    share = wake.vortex[b, CIRCULATION, i] / gamma
    for axis in range(2):
        wake.vortex[b, axis, a] = share * wake.vortex[b, axis, i] + (1.0 - share) * wake.vortex[b, axis, a]
    for row in range(BEFORE + 2):
        wake.velocity[b, row, a] = share * wake.velocity[b, row, i] + (1.0 - share) * wake.velocity[b, row, a]
    wake.vortex[b, CIRCULATION, a] = gamma
    wake.vortex[b, CORE2, a] = ti.max(wake.vortex[b, CORE2, i], wake.vortex[b, CORE2, a])
    wake.vortex[b, HEIGHT, a] = 0.0


@ti.func
def velocity_of(wake: View, b, place, gamma, dy, dz):
    """Velocity at (dy, dz) from a vortex of circulation `gamma`, with the core of the one at `place`."""
    return vortex_velocity(gamma, dy, dz, wake.vortex[b, CORE2, place] + TINY)


@ti.func
def loss_of_oldest(wake: View, b, y, z):
    """Velocity of the oldest vortex at (y, z)."""
    i = place_of(wake, b, 0)
    gamma = wake.vortex[b, CIRCULATION, i]
    return velocity_of(wake, b, i, gamma, y - wake.vortex[b, Y, i], z - wake.vortex[b, Z, i])


@ti.func
def loss_of_merger(wake: View, b, order, y, z):
    """Change of the velocity at (y, z): of the three vortices before, less that of the two after."""
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
    """Whether, of the neighbours of a vortex, the one shed earlier is the stronger once they share it."""
    gamma = wake.vortex[b, CIRCULATION, i]
    earlier = wake.vortex[b, CIRCULATION, a] + share * gamma
    later = wake.vortex[b, CIRCULATION, c] + (1.0 - share) * gamma
    return ti.abs(earlier) > ti.abs(later)


@ti.func
def absorb(wake: View, b, order):
    """Let the neighbours of a vortex take it up; it is then to be removed."""
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
