"""What would pass through in a substep: the moment of a crossing on straight ways."""

from __future__ import annotations

import math

from cloth_core.kernels import kernel, part_kernel
from cloth_core.kernels.closest import closest_weights, separation, toward
from cloth_core.kernels.narrow import gap_on_way, note
from cloth_core.kernels.sides import height

MISS = 1e-6
"""By how much two features may miss each other and still count as meeting, as a share of their size."""
TOUCHING = 1e-9
"""m, what is closer has no side that rounding could not take away."""
GROWTH = 0.1
"""Share of what impacts shall keep by which a pair comes apart that is closer than that already."""
HALVINGS = 60


@part_kernel
def volume(start, end, p, q, r, s, t):
    """Six times the volume of four vertices at the share ``t`` of their way, m^3."""
    ux = start[q, 0] - start[p, 0] + t * (end[q, 0] - start[q, 0] - end[p, 0] + start[p, 0])
    uy = start[q, 1] - start[p, 1] + t * (end[q, 1] - start[q, 1] - end[p, 1] + start[p, 1])
    uz = start[q, 2] - start[p, 2] + t * (end[q, 2] - start[q, 2] - end[p, 2] + start[p, 2])
    vx = start[r, 0] - start[p, 0] + t * (end[r, 0] - start[r, 0] - end[p, 0] + start[p, 0])
    vy = start[r, 1] - start[p, 1] + t * (end[r, 1] - start[r, 1] - end[p, 1] + start[p, 1])
    vz = start[r, 2] - start[p, 2] + t * (end[r, 2] - start[r, 2] - end[p, 2] + start[p, 2])
    wx = start[s, 0] - start[p, 0] + t * (end[s, 0] - start[s, 0] - end[p, 0] + start[p, 0])
    wy = start[s, 1] - start[p, 1] + t * (end[s, 1] - start[s, 1] - end[p, 1] + start[p, 1])
    wz = start[s, 2] - start[p, 2] + t * (end[s, 2] - start[s, 2] - end[p, 2] + start[p, 2])
    return ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx)


@part_kernel
def turning_points(a, b, c, d):
    """Where a cubic with the values ``a``, ``b``, ``c``, ``d`` at 0, 1/3, 2/3 and 1 turns within that, else 1."""
    k3 = 4.5 * (d - 3.0 * c + 3.0 * b - a)
    k2 = 4.5 * (2.0 * a - 5.0 * b + 4.0 * c - d)
    k1 = 0.5 * (-11.0 * a + 18.0 * b - 9.0 * c + 2.0 * d)
    root = k2 * k2 - 3.0 * k3 * k1
    if root < 0.0:
        return 1.0, 1.0
    far = -(k2 + math.copysign(math.sqrt(root), k2))
    first = far / (3.0 * k3) if k3 != 0.0 else 1.0
    second = k1 / far if far != 0.0 else 1.0
    if not 0.0 < first < 1.0:
        first = 1.0
    if not 0.0 < second < 1.0:
        second = 1.0
    return min(first, second), max(first, second)


@part_kernel
def flat_moment(start, end, p, q, r, s, low, high):
    """When between the shares ``low`` and ``high`` of their way four vertices lie in a plane; -1 if never.

    The volume must be monotone in between.
    """
    first, last = volume(start, end, p, q, r, s, low), volume(start, end, p, q, r, s, high)
    if first == 0.0:
        return low
    if (first > 0.0) == (last > 0.0) and last != 0.0:
        return -1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if (volume(start, end, p, q, r, s, middle) > 0.0) == (first > 0.0):
            low = middle
        else:
            high = middle
        if high - low < 1e-12:
            break
    return high


@part_kernel
def meeting(start, end, p, q, r, s, edges, place):
    """The share of their way at which the two features of a pair meet first; -1 if they do not.

    The vertices lie in a plane then (Bridson, Fedkiw and Anderson 2002): a cubic equation. ``place`` (V, 3) m of the
    four is left as it is at that moment.
    """
    first, second = turning_points(
        volume(start, end, p, q, r, s, 0.0), volume(start, end, p, q, r, s, 1.0 / 3.0),
        volume(start, end, p, q, r, s, 2.0 / 3.0), volume(start, end, p, q, r, s, 1.0),
    )  # fmt: skip
    for i in range(3):
        low, high = (0.0, first) if i == 0 else (first, second) if i == 1 else (second, 1.0)
        if low >= high:
            continue
        t = flat_moment(start, end, p, q, r, s, low, high)
        if t < 0.0:
            continue
        size = 0.0
        for a in range(3):
            for v in (p, q, r, s):
                place[v, a] = start[v, a] + t * (end[v, a] - start[v, a])
            size = max(size, abs(place[p, a] - place[r, a]), abs(place[q, a] - place[s, a]))
        if toward(place, p, q, r, s, edges)[3] <= MISS * size:
            return t
    return -1.0


@part_kernel
def impact_normal(start, end, place, p, q, r, s, edges):
    """Direction in which a pair that meets at ``place`` (V, 3) m was apart, and its signed weights there."""
    wp, wq, wr, ws = closest_weights(place, p, q, r, s, edges)
    if edges:
        ux, uy, uz = place[q, 0] - place[p, 0], place[q, 1] - place[p, 1], place[q, 2] - place[p, 2]
        vx, vy, vz = place[s, 0] - place[r, 0], place[s, 1] - place[r, 1], place[s, 2] - place[r, 2]
    else:
        ux, uy, uz = place[r, 0] - place[q, 0], place[r, 1] - place[q, 1], place[r, 2] - place[q, 2]
        vx, vy, vz = place[s, 0] - place[q, 0], place[s, 1] - place[q, 1], place[s, 2] - place[q, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    square = nx * nx + ny * ny + nz * nz
    if square > 0.0:
        gone = height(end, p, q, r, s, wp, wq, wr, ws, nx, ny, nz)
        gone -= height(start, p, q, r, s, wp, wq, wr, ws, nx, ny, nz)
        share = -math.copysign(1.0 / math.sqrt(square), gone)
        nx, ny, nz = nx * share, ny * share, nz * share
    else:
        nx, ny, nz, _ = toward(start, p, q, r, s, edges)
    return wp, wq, wr, ws, nx, ny, nz


@part_kernel
def ways_meet(start, end, p, q, r, s, edges):
    """Whether the boxes of the ways of two features overlap."""
    for a in range(3):
        first, last = min(start[p, a], end[p, a]), max(start[p, a], end[p, a])
        low, high = (
            min(start[r, a], end[r, a], start[s, a], end[s, a]),
            max(start[r, a], end[r, a], start[s, a], end[s, a]),
        )
        if edges:
            first, last = min(first, start[q, a], end[q, a]), max(last, start[q, a], end[q, a])
        else:
            low, high = min(low, start[q, a], end[q, a]), max(high, start[q, a], end[q, a])
        if last < low or first > high:
            return False
    return True


@part_kernel
def may_pass(start, end, p, q, r, s, edges, tangled):
    """Whether no direction is known that parts a pair from ``start`` to ``end``; never of features without a side."""
    first = tangled[p] or (edges and tangled[q])
    second = tangled[r] or tangled[s] or (not edges and tangled[q])
    if first and second:
        return False
    if not ways_meet(start, end, p, q, r, s, edges):
        return False
    nx, ny, nz, distance = toward(start, p, q, r, s, edges)
    return distance > TOUCHING and separation(end, p, q, r, s, edges, nx, ny, nz) <= 0.0


@part_kernel
def add_impact(start, end, place, p, q, r, s, edges, keep, contact, count):
    """Add the pair as a contact that keeps up to ``keep`` m if it would meet; returns the new number."""
    distance = toward(start, p, q, r, s, edges)[3]
    if meeting(start, end, p, q, r, s, edges, place) < 0.0:
        return count
    wp, wq, wr, ws, nx, ny, nz = impact_normal(start, end, place, p, q, r, s, edges)
    return note(contact, count, p, q, r, s, wp, wq, wr, ws, nx, ny, nz, distance + GROWTH * keep, keep)


@kernel
def find_impacts(
    start, end, place, sheet, corner_start, corner, pair, leaf_normal, apart, moved, tangled, keep, contact, count
):
    """List after contact number ``count`` what meets on straight ways from ``start`` to ``end`` (V, 3) m.

    Leaves are passed over if they are ``apart`` (P,) m on the way that was predicted, by more than they ``moved``
    (L,) m from there. Impacts keep ``keep`` m; the other arguments are those of
    :func:`~cloth_core.kernels.narrow.find_contacts`. Returns the number of contacts.
    """
    _rest, _piece, triangles, leaf_start, vertex_start, own_vertex, edge_start, own_edge = sheet
    for m in range(pair.shape[0]):
        a, b = pair[m, 0], pair[m, 1]
        if apart[m] - moved[a] - moved[b] > 0.0:
            continue
        nx, ny, nz = leaf_normal[m, 0], leaf_normal[m, 1], leaf_normal[m, 2]
        if gap_on_way(start, end, corner_start, corner, a, b, nx, ny, nz) > 0.0:
            continue
        for turn in range(1 if a == b else 2):
            first, second = (a, b) if turn == 0 else (b, a)
            for k in range(leaf_start[second], leaf_start[second + 1]):
                q, r, s = triangles[k, 0], triangles[k, 1], triangles[k, 2]
                for i in range(vertex_start[first], vertex_start[first + 1]):
                    p = own_vertex[i]
                    if p != q and p != r and p != s and may_pass(start, end, p, q, r, s, False, tangled):
                        count = add_impact(start, end, place, p, q, r, s, False, keep, contact, count)
        for k in range(edge_start[a], edge_start[a + 1]):
            p, q = own_edge[k, 0], own_edge[k, 1]
            for i in range(k + 1 if a == b else edge_start[b], edge_start[b + 1]):
                r, s = own_edge[i, 0], own_edge[i, 1]
                if p != r and p != s and q != r and q != s and may_pass(start, end, p, q, r, s, True, tangled):
                    count = add_impact(start, end, place, p, q, r, s, True, keep, contact, count)
    return count
