"""Queries of sparse distance fields; :mod:`cloth_core.fields.pool` says what the arrays hold.

All fields of a scene lie in one pool, the tuple of arrays (real, whole, coarse, occupied, brick, node, fine, split,
plane), so that one kernel can ask any of them: field ``f`` is the row of ``real`` and ``whole``.
"""

from __future__ import annotations

import math

from cloth_core.kernels import kernel
from cloth_core.kernels.bits import ones_below
from cloth_core.kernels.contact import box_distance

ORIGIN, LOW, HIGH, VOXEL, NODE_STEP, COARSE_STEP, BAND, REACH = 0, 3, 6, 9, 10, 11, 12, 13
"""Columns of ``real``: low corner of the grid, box around the surface (m each); m of a voxel, of one unit of ``node``
and ``fine``, of one unit of ``coarse``; nothing outside the shell is nearer than the band; m from the object's origin to
the farthest of the surface."""
REALS = 14

SHAPE, COARSE_FIRST, OCCUPIED_FIRST, TANGENT = 0, 3, 4, 5
"""Columns of ``whole``: blocks along x, y, z; where the field begins in ``coarse`` and ``occupied``; 1 for planes."""
WHOLES = 6

NEAR, REFINED, NODES, FIRST = range(4)
"""Words of ``brick``, bit i + 4 j + 16 k for cell or node (i, j, k): cells in the shell; of these the refined (of planes:
the surface voxels), of the others those inside; nodes stored; the first node (or plane) and the first refined cell,
32 bits each."""

OUTSIDE, INSIDE, SURFACE = range(3)
"""Kinds of voxels."""


@kernel
def field_distance(pool, f, x, y, z):
    """Signed distance in m of field ``f`` at a point of the object's frame, negative inside, and a unit normal.

    Within the shell as the field was built: trilinear between exact distances, with its gradient, or from the tangent
    plane of the voxel (paper, eq. 6). Outside beyond the shell: a lower bound, above 0. Inside beyond it: coarsely
    interpolated; the normal leads out.
    """
    real, whole = pool[0], pool[1]
    gap, nx, ny, nz = _box_gap(real[f], x, y, z)
    if gap > real[f, BAND]:
        return gap, nx, ny, nz
    voxel = real[f, VOXEL]
    u, v, w = (x - real[f, ORIGIN]) / voxel, (y - real[f, ORIGIN + 1]) / voxel, (z - real[f, ORIGIN + 2]) / voxel
    i, j, k = int(u), int(v), int(w)
    b, bit = _brick_at(pool, f, i, j, k), (i & 3) + 4 * (j & 3) + 16 * (k & 3)
    if b < 0 or not (pool[4][b, NEAR] >> bit) & 1:
        side = 0 if b < 0 else 1 - 2 * ((pool[4][b, REFINED] >> bit) & 1)
        return _coarse_distance(pool, f, side, 0.25 * u, 0.25 * v, 0.25 * w)
    if whole[f, TANGENT]:
        return _plane_distance(pool, f, b, bit, u - i - 0.5, v - j - 0.5, w - k - 0.5)
    if (pool[4][b, REFINED] >> bit) & 1:
        return _fine_distance(pool, f, b, bit, u - i, v - j, w - k)
    return _voxel_distance(pool, f, b, i, j, k, u - i, v - j, w - k)


@kernel
def voxel_kind(pool, f, x, y, z):
    """:data:`OUTSIDE`, :data:`INSIDE` or :data:`SURFACE` for the voxel of a tangent-plane field around a point."""
    real = pool[0]
    if _box_gap(real[f], x, y, z)[0] > real[f, BAND]:
        return OUTSIDE
    voxel = real[f, VOXEL]
    u, v, w = (x - real[f, ORIGIN]) / voxel, (y - real[f, ORIGIN + 1]) / voxel, (z - real[f, ORIGIN + 2]) / voxel
    i, j, k = int(u), int(v), int(w)
    b, bit = _brick_at(pool, f, i, j, k), (i & 3) + 4 * (j & 3) + 16 * (k & 3)
    if b < 0:
        return INSIDE if _coarse_distance(pool, f, 0, 0.25 * u, 0.25 * v, 0.25 * w)[0] < 0.0 else OUTSIDE
    marked = (pool[4][b, REFINED] >> bit) & 1
    if not (pool[4][b, NEAR] >> bit) & 1:
        return INSIDE if marked else OUTSIDE
    if marked:
        return SURFACE
    return INSIDE if pool[8][_first(pool[4][b, FIRST]) + ones_below(pool[4][b, NEAR], bit), 3] < 0.0 else OUTSIDE


@kernel
def _box_gap(real, x, y, z):
    """Distance in m to the box around the surface, and the direction away from it."""
    hx, hy, hz = 0.5 * (real[HIGH] - real[LOW]), 0.5 * (real[HIGH + 1] - real[LOW + 1]), 0.5 * (real[HIGH + 2] - real[LOW + 2])
    return box_distance(x - real[LOW] - hx, y - real[LOW + 1] - hy, z - real[LOW + 2] - hz, hx, hy, hz)


@kernel
def _first(word):
    """Of the two numbers in a word the high one."""
    return word >> 32


@kernel
def _brick_at(pool, f, i, j, k):
    """The brick that holds voxel (i, j, k), or -1."""
    whole = pool[1]
    block = (i >> 2) + whole[f, SHAPE] * ((j >> 2) + whole[f, SHAPE + 1] * (k >> 2))
    word = whole[f, OCCUPIED_FIRST] + (block >> 6)
    bits, bit = pool[3][word, 0], block & 63
    if not (bits >> bit) & 1:
        return -1
    return pool[3][word, 1] + ones_below(bits, bit)


@kernel
def _trilinear(d000, d100, d010, d110, d001, d101, d011, d111, u, v, w):
    """Interpolation between the corners of a unit cube, the last digit along z, and its gradient."""
    x00, x10, x01, x11 = d100 - d000, d110 - d010, d101 - d001, d111 - d011
    a00, a10, a01, a11 = d000 + u * x00, d010 + u * x10, d001 + u * x01, d011 + u * x11
    y0, y1 = a10 - a00, a11 - a01
    b0, b1 = a00 + v * y0, a01 + v * y1
    x0, x1 = x00 + v * (x10 - x00), x01 + v * (x11 - x01)
    return b0 + w * (b1 - b0), x0 + w * (x1 - x0), y0 + w * (y1 - y0), b1 - b0


@kernel
def _with_unit_normal(distance, gx, gy, gz):
    """A distance and the direction of its gradient."""
    length = math.sqrt(gx * gx + gy * gy + gz * gz)
    if length > 0.0:
        return distance, gx / length, gy / length, gz / length
    return distance, 0.0, 0.0, 1.0


@kernel
def _voxel_distance(pool, f, b, i, j, k, u, v, w):
    """Trilinear in voxel (i, j, k) of brick ``b``, at (u, v, w) in 0 .. 1."""
    low00, high00 = _node_pair(pool, f, b, i, j, k, False, False)
    low10, high10 = _node_pair(pool, f, b, i, j, k, True, False)
    low01, high01 = _node_pair(pool, f, b, i, j, k, False, True)
    low11, high11 = _node_pair(pool, f, b, i, j, k, True, True)
    value, gx, gy, gz = _trilinear(low00, high00, low10, high10, low01, high01, low11, high11, u, v, w)
    return _with_unit_normal(pool[0][f, NODE_STEP] * value, gx, gy, gz)


@kernel
def _node_pair(pool, f, b, i, j, k, next_j, next_k):
    """Two nodes of voxel (i, j, k) of brick ``b`` that are neighbours along x, on one of its four edges so."""
    if (next_j and j & 3 == 3) or (next_k and k & 3 == 3):
        b = _brick_at(pool, f, i, j + next_j, k + next_k)
    row = 4 * ((j + next_j) & 3) + 16 * ((k + next_k) & 3)
    bit = row + (i & 3)
    n = _first(pool[4][b, FIRST]) + ones_below(pool[4][b, NODES], bit)
    low = float(pool[5][n])
    if i & 3 < 3:
        return low, float(pool[5][n + 1])
    b = _brick_at(pool, f, i + 1, j + next_j, k + next_k)
    return low, float(pool[5][_first(pool[4][b, FIRST]) + ones_below(pool[4][b, NODES], row)])


@kernel
def _fine_distance(pool, f, b, bit, u, v, w):
    """Trilinear in the smallest cell around (u, v, w), 0 .. 1, of a refined voxel."""
    fine, split = pool[6], pool[7]
    s = (pool[4][b, FIRST] & 0xFFFFFFFF) + ones_below(pool[4][b, REFINED] & pool[4][b, NEAR], bit)
    while True:
        u, v, w = 2.0 * u, 2.0 * v, 2.0 * w
        i, j, k = min(int(u), 1), min(int(v), 1), min(int(w), 1)
        u, v, w, child = u - i, v - j, w - k, i + 2 * j + 4 * k
        if not (split[s, 0] >> child) & 1:
            break
        s = split[s, 1] + ones_below(split[s, 0], child)
    n = i + 3 * j + 9 * k
    value, gx, gy, gz = _trilinear(
        fine[s, n], fine[s, n + 1], fine[s, n + 3], fine[s, n + 4],
        fine[s, n + 9], fine[s, n + 10], fine[s, n + 12], fine[s, n + 13], u, v, w,
    )  # fmt: skip
    return _with_unit_normal(pool[0][f, NODE_STEP] * value, gx, gy, gz)


@kernel
def _plane_distance(pool, f, b, bit, u, v, w):
    """Distance to the tangent plane of a voxel, (u, v, w) voxels from its centre; of its own side off the surface."""
    plane, voxel = pool[8], pool[0][f, VOXEL]
    p = _first(pool[4][b, FIRST]) + ones_below(pool[4][b, NEAR], bit)
    nx, ny, nz = float(plane[p, 0]), float(plane[p, 1]), float(plane[p, 2])
    distance = plane[p, 3] + voxel * (u * nx + v * ny + w * nz)
    if not (pool[4][b, REFINED] >> bit) & 1:
        distance = min(distance, 0.0) if plane[p, 3] < 0.0 else max(distance, 0.0)
    return distance, nx, ny, nz


@kernel
def _coarse_distance(pool, f, side, u, v, w):
    """Beyond the shell, from the corners of the block around (u, v, w), in blocks from the low corner of the grid.

    ``side`` is 1 outside, -1 inside, 0 if the corners, then all on one side, are to say. Outside, the interpolated
    distance less the most that it can be too large: with d at the corners and weights w of the way to them,
    sum(w d) <= d(x) + sum(w |x - corner|), and the mean of these ways is at most their root mean square.
    """
    whole, coarse, step, band = pool[1], pool[2], pool[0][f, COARSE_STEP], pool[0][f, BAND]
    i, j, k = int(u), int(v), int(w)
    u, v, w = u - i, v - j, w - k
    row = whole[f, SHAPE] + 1
    layer = row * (whole[f, SHAPE + 1] + 1)
    n = whole[f, COARSE_FIRST] + i + row * j + layer * k
    value, gx, gy, gz = _trilinear(
        float(coarse[n]), float(coarse[n + 1]), float(coarse[n + row]), float(coarse[n + row + 1]),
        float(coarse[n + layer]), float(coarse[n + layer + 1]),
        float(coarse[n + layer + row]), float(coarse[n + layer + row + 1]), u, v, w,
    )  # fmt: skip
    distance = step * value
    if side < 0 or (side == 0 and distance < 0.0):
        return _with_unit_normal(min(distance, -band), gx, gy, gz)
    slack = 4.0 * pool[0][f, VOXEL] * math.sqrt(u * (1.0 - u) + v * (1.0 - v) + w * (1.0 - w)) + step
    return _with_unit_normal(max(distance - slack, band), gx, gy, gz)


@kernel
def field_distances(pool, f, points, distance, normal):
    """As :func:`field_distance` for points (N, 3); fills ``distance`` (N,) and ``normal`` (N, 3)."""
    for p in range(points.shape[0]):
        d, nx, ny, nz = field_distance(pool, f, points[p, 0], points[p, 1], points[p, 2])
        distance[p], normal[p, 0], normal[p, 1], normal[p, 2] = d, nx, ny, nz


@kernel
def voxel_kinds(pool, f, points, kind):
    """As :func:`voxel_kind` for points (N, 3); fills ``kind`` (N,)."""
    for p in range(points.shape[0]):
        kind[p] = voxel_kind(pool, f, points[p, 0], points[p, 1], points[p, 2])
