"""Who touches in a substep: vertices in front of triangles, edges across edges, as linear constraints.

A constraint is normal . (sum of weight * position) >= target, over the four vertices of a pair. It stands in the plane
of the triangle (of both edges) at the start of the substep, where nothing crosses, on the side where the pair is then.
The direction between closest points would not do: a vertex that slides on to the next triangle would be held back.
"""

from __future__ import annotations

import math

from cloth_core.kernels import kernel, part_kernel
from cloth_core.kernels.closest import toward
from cloth_core.kernels.parting import best_direction, leaf_gap
from cloth_core.kernels.sides import edge_shares, face_weights, height, is_beside

EDGES = 0.5
"""Share of the thickness that edges keep from each other: faces carry, edges but stop what comes between them."""
SLACK = 0.25
"""Share of the thickness from which on a pair is listed: sweeps may yet bring it closer."""
OWN_SHARE = 0.5
"""Share of their distance at rest that neighbours in the mesh keep at most."""
PARALLEL = 1e-3
"""Square of the sine of the angle between two edges below which they have no side."""


@part_kernel
def own_thickness(rest, piece, p, q, r, s, edges, thickness, far):
    """Distance in m that a pair shall keep: less than at rest if it is of one ``piece`` and no ``far`` m apart."""
    square = (rest[p, 0] - rest[r, 0]) ** 2 + (rest[p, 1] - rest[r, 1]) ** 2 + (rest[p, 2] - rest[r, 2]) ** 2
    if piece[p] == piece[r] and square < far * far:
        return min(thickness, OWN_SHARE * toward(rest, p, q, r, s, edges)[3])
    return thickness


@part_kernel
def least_height(up, later, ahead):
    """Of a pair at the ends of the ``ahead`` substeps that take it from ``up`` to ``later`` m, if it goes evenly."""
    return min(later, up + (later - up) / ahead)


@part_kernel
def note(contact, c, p, q, r, s, wp, wq, wr, ws, nx, ny, nz, reached, most):
    """Write contact number ``c`` if there is room for it, to keep what is ``reached`` but at ``most``; the next number.

    What it keeps grows as the pair comes apart.
    """
    vertex, weight, normal, target, keep = contact
    if c < target.shape[0]:
        vertex[c, 0], vertex[c, 1], vertex[c, 2], vertex[c, 3] = p, q, r, s
        weight[c, 0], weight[c, 1], weight[c, 2], weight[c, 3] = wp, wq, wr, ws
        normal[c, 0], normal[c, 1], normal[c, 2] = nx, ny, nz
        target[c], keep[c] = min(reached, most), most
    return c + 1


@part_kernel
def box_gap(low, high, a, b):
    """The most by which boxes ``a`` and ``b`` are apart along an axis, m; negative if they overlap."""
    return max(
        max(low[b, 0] - high[a, 0], low[a, 0] - high[b, 0]),
        max(low[b, 1] - high[a, 1], low[a, 1] - high[b, 1]),
        max(low[b, 2] - high[a, 2], low[a, 2] - high[b, 2]),
    )


@part_kernel
def add_faces(start, end, sheet, fit, first, second, thickness, far, recover, tangled, contact, ahead, count):
    """Add the contacts of the vertices of leaf ``first`` with the triangles of leaf ``second``; returns how many."""
    rest, piece, triangles, leaf_start, vertex_start, own_vertex, _edge_start, _own_edge = sheet
    face, box, box_low, box_high, _upward = fit
    listed = (1.0 + SLACK) * thickness
    for m in range(vertex_start[first], vertex_start[first + 1]):
        p = own_vertex[m]
        lx, hx = min(start[p, 0], end[p, 0]) - listed, max(start[p, 0], end[p, 0]) + listed
        ly, hy = min(start[p, 1], end[p, 1]) - listed, max(start[p, 1], end[p, 1]) + listed
        lz, hz = min(start[p, 2], end[p, 2]) - listed, max(start[p, 2], end[p, 2]) + listed
        if hx < box_low[second, 0] or hy < box_low[second, 1] or hz < box_low[second, 2]:
            continue
        if lx > box_high[second, 0] or ly > box_high[second, 1] or lz > box_high[second, 2]:
            continue
        for t in range(leaf_start[second], leaf_start[second + 1]):
            if hx < box[t, 0] or hy < box[t, 1] or hz < box[t, 2] or lx > box[t, 3] or ly > box[t, 4] or lz > box[t, 5]:
                continue
            q, r, s = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            nx, ny, nz = face[t, 0], face[t, 1], face[t, 2]
            if p == q or p == r or p == s or (tangled[p] and (tangled[q] or tangled[r] or tangled[s])):
                continue
            up = height(start, p, q, r, s, 1.0, -1.0, 0.0, 0.0, nx, ny, nz)
            inside = math.copysign(1.0, up)
            mx, my, mz, up = inside * nx, inside * ny, inside * nz, inside * up
            # The triangle turns little: a first guess of the height at the end.
            if up > listed and height(end, p, q, r, s, 1.0, -1.0, 0.0, 0.0, mx, my, mz) > listed + 0.5 * up:
                continue
            if is_beside(start, p, q, r, s, mx, my, mz, inside, thickness):
                if is_beside(end, p, q, r, s, mx, my, mz, inside, thickness):
                    continue
            above, a, b, c = face_weights(start, end, p, q, r, s, up, mx, my, mz, thickness)
            if not above or up <= 0.0:
                continue
            if least_height(up, height(end, p, q, r, s, 1.0, -a, -b, -c, mx, my, mz), ahead) < listed:
                keep = own_thickness(rest, piece, p, q, r, s, False, thickness, far)
                count = note(contact, count, p, q, r, s, 1.0, -a, -b, -c, mx, my, mz, up + recover, keep)
    return count


@part_kernel
def add_edges(start, end, sheet, first, second, thickness, far, recover, tangled, contact, ahead, count):
    """Add the contacts of the edges of leaf ``first`` with those of leaf ``second``; returns how many there are."""
    rest, piece, _, _, _, _, edge_start, own_edge = sheet
    keep = EDGES * thickness
    listed = (1.0 + SLACK) * keep
    for k in range(edge_start[first], edge_start[first + 1]):
        p, q = own_edge[k, 0], own_edge[k, 1]
        for m in range(k + 1 if first == second else edge_start[second], edge_start[second + 1]):
            r, s = own_edge[m, 0], own_edge[m, 1]
            if p == r or p == s or q == r or q == s or ((tangled[p] or tangled[q]) and (tangled[r] or tangled[s])):
                continue
            ux, uy, uz = start[q, 0] - start[p, 0], start[q, 1] - start[p, 1], start[q, 2] - start[p, 2]
            vx, vy, vz = start[s, 0] - start[r, 0], start[s, 1] - start[r, 1], start[s, 2] - start[r, 2]
            nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            square = nx * nx + ny * ny + nz * nz
            if square < PARALLEL * (ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz) or square == 0.0:
                continue
            up = height(start, p, q, r, s, 1.0, 0.0, -1.0, 0.0, nx, ny, nz)
            share = math.copysign(1.0 / math.sqrt(square), up)
            nx, ny, nz, up = nx * share, ny * share, nz * share, up * share
            if up > listed and height(end, p, q, r, s, 1.0, 0.0, -1.0, 0.0, nx, ny, nz) > listed + 0.5 * up:
                continue
            crosses, a, b = edge_shares(start, end, p, q, r, s, up, nx, ny, nz)
            if crosses and up > 0.0:
                if least_height(up, height(end, p, q, r, s, 1.0 - a, a, b - 1.0, -b, nx, ny, nz), ahead) < listed:
                    own = own_thickness(rest, piece, p, q, r, s, True, keep, far)
                    count = note(contact, count, p, q, r, s, 1.0 - a, a, b - 1.0, -b, nx, ny, nz, up + recover, own)
    return count


@part_kernel
def gap_on_way(start, end, corner_start, corner, a, b, nx, ny, nz):
    """The least gap from leaf ``b`` to leaf ``a`` along a direction on their way, m."""
    return min(
        leaf_gap(start, corner_start, corner, a, b, nx, ny, nz),
        leaf_gap(end, corner_start, corner, a, b, nx, ny, nz),
    )


@kernel
def find_contacts(
    start, end, sheet, fit, corner_start, corner, pair, leaf_normal, gap, apart, strayed,
    thickness, far, recover, tangled, contact, ahead,
):  # fmt: skip
    """List who may touch on the way from ``start`` to about ``end`` (V, 3) m, of the leaves in ``pair`` (P, 2).

    Returns their number; only as many as there is room for are written.

    Args:
        start: where nothing crosses.
        end: as predicted, for so many substeps ``ahead``.
        sheet: of :class:`~cloth_core.physics.features.Features`.
        fit: what :func:`~cloth_core.kernels.parting.fit_leaves` made: faces, boxes of both, directions.
        corner_start: (L + 1,) see :class:`~cloth_core.meshing.patches.Patches`.
        corner: see there.
        pair: leaves that may meet.
        leaf_normal: (P, 3) from the second to the first; turned where it parts them no more.
        gap: (P,) m along it, as it was, as long as vertices do not stray.
        apart: (P,) m of gap on this way, at least, to be written.
        strayed: m, how far they did.
        thickness: m to be kept.
        far: m, at rest, within which a pair may keep less.
        recover: m, by which what is too close comes apart.
        tangled: (V,) vertices without a side.
        contact: vertex (C, 4), weight (C, 4), normal (C, 3), target (C,), keep (C,) to be written.
        ahead: substeps that the contacts shall do for.
    """
    _, _, box_low, box_high, upward = fit
    listed, count = (1.0 + SLACK) * thickness, 0
    for p in range(pair.shape[0]):
        now = gap[p] - 2.0 * strayed
        apart[p] = now
        if now > listed:
            continue
        a, b = pair[p, 0], pair[p, 1]
        now = box_gap(box_low, box_high, a, b)
        if now > listed:
            apart[p] = now
            continue
        nx, ny, nz = leaf_normal[p, 0], leaf_normal[p, 1], leaf_normal[p, 2]
        now = gap_on_way(start, end, corner_start, corner, a, b, nx, ny, nz)
        if now < EDGES * listed:
            best, nx, ny, nz = best_direction(start, corner_start, corner, box_low, box_high, upward, a, b, listed)
            best = min(best, leaf_gap(end, corner_start, corner, a, b, nx, ny, nz))
            if best > now:
                now = best
                leaf_normal[p, 0], leaf_normal[p, 1], leaf_normal[p, 2] = nx, ny, nz
        apart[p] = now
        if now > listed:
            continue
        for turn in range(1 if a == b else 2):
            i, j = (a, b) if turn == 0 else (b, a)
            count = add_faces(start, end, sheet, fit, i, j, thickness, far, recover, tangled, contact, ahead, count)
        if now < EDGES * listed:
            count = add_edges(start, end, sheet, a, b, thickness, far, recover, tangled, contact, ahead, count)
    return count
