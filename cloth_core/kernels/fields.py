"""Queries of sparse distance fields; :mod:`cloth_core.fields.pool` says what the arrays hold.

All fields of a scene lie in one pool, the tuple of arrays (real, whole, coarse, occupied, brick, node, fine, split,
plane), so that one kernel can ask any of them: field ``f`` is the row of ``real`` and ``whole``.
"""

from __future__ import annotations

import math

from cloth_core.kernels import kernel, part_kernel
from cloth_core.kernels.bits import ones_below
from cloth_core.kernels.bricks import (
    BAND,
    COARSE_FIRST,
    COARSE_STEP,
    FINE_STEP,
    FIRST,
    NEAR,
    NODE_STEP,
    NODES,
    REFINED,
    SHAPE,
    TANGENT,
    VOXEL,
    brick_at,
    first,
    in_voxels,
    way_to_box,
)
from cloth_core.kernels.trilinear import eighth, trilinear, with_unit_normal

OUTSIDE, INSIDE, SURFACE = range(3)
"""Kinds of voxels."""


@part_kernel
def field_distance(real, whole, coarse, occupied, brick, node, fine, split, plane, f, x, y, z):
    """Signed distance in m of field ``f`` at a point of the object's frame, negative inside, and a unit normal.

    Within the shell as the field was built: trilinear between exact distances, with its gradient, or from the tangent
    plane of the voxel (paper, eq. 6). Outside beyond the shell: a lower bound, above 0. Inside beyond it: coarsely
    interpolated; the normal leads out.
    """
    wx, wy, wz = way_to_box(real, f, x, y, z)
    gap = wx * wx + wy * wy + wz * wz + 0.0 * (x + y + z)  # what is not finite has no voxel
    if not gap <= real[f, BAND] * real[f, BAND]:
        return with_unit_normal(math.sqrt(gap), wx, wy, wz)
    u, v, w = in_voxels(real, f, x, y, z)
    i, j, k = int(u), int(v), int(w)
    b, bit = brick_at(whole, occupied, f, i, j, k), (i & 3) + 4 * (j & 3) + 16 * (k & 3)
    if b < 0 or not (brick[b, NEAR] >> bit) & 1:
        side = 0 if b < 0 else 1 - 2 * ((brick[b, REFINED] >> bit) & 1)
        return _coarse_distance(real, whole, coarse, f, side, 0.25 * u, 0.25 * v, 0.25 * w)
    if whole[f, TANGENT]:
        return _plane_distance(real, brick, plane, f, b, bit, u - i - 0.5, v - j - 0.5, w - k - 0.5)
    return _voxel_distance(real, whole, occupied, brick, node, fine, split, f, b, bit, i, j, k, u - i, v - j, w - k)


@part_kernel
def voxel_kind(real, whole, coarse, occupied, brick, node, fine, split, plane, f, x, y, z):
    """:data:`OUTSIDE`, :data:`INSIDE` or :data:`SURFACE` for the voxel of a tangent-plane field around a point."""
    wx, wy, wz = way_to_box(real, f, x, y, z)
    if not wx * wx + wy * wy + wz * wz + 0.0 * (x + y + z) <= real[f, BAND] * real[f, BAND]:
        return OUTSIDE
    u, v, w = in_voxels(real, f, x, y, z)
    i, j, k = int(u), int(v), int(w)
    b, bit = brick_at(whole, occupied, f, i, j, k), (i & 3) + 4 * (j & 3) + 16 * (k & 3)
    if b < 0:
        return INSIDE if _coarse_distance(real, whole, coarse, f, 0, 0.25 * u, 0.25 * v, 0.25 * w)[0] < 0.0 else OUTSIDE
    marked = (brick[b, REFINED] >> bit) & 1
    if not (brick[b, NEAR] >> bit) & 1:
        return INSIDE if marked else OUTSIDE
    if marked:
        return SURFACE
    return INSIDE if plane[first(brick[b, FIRST]) + ones_below(brick[b, NEAR], bit), 3] < 0.0 else OUTSIDE


@part_kernel
def _voxel_distance(real, whole, occupied, brick, node, fine, split, f, b, bit, i, j, k, u, v, w):
    """Trilinear in voxel (i, j, k) of brick ``b``, at (u, v, w) in 0 .. 1, or in the part of it that is refined."""
    d000 = _node(whole, occupied, brick, node, f, i, j, k)
    d100 = _node(whole, occupied, brick, node, f, i + 1, j, k)
    d010 = _node(whole, occupied, brick, node, f, i, j + 1, k)
    d110 = _node(whole, occupied, brick, node, f, i + 1, j + 1, k)
    d001 = _node(whole, occupied, brick, node, f, i, j, k + 1)
    d101 = _node(whole, occupied, brick, node, f, i + 1, j, k + 1)
    d011 = _node(whole, occupied, brick, node, f, i, j + 1, k + 1)
    d111 = _node(whole, occupied, brick, node, f, i + 1, j + 1, k + 1)
    cell = d000, d100, d010, d110, d001, d101, d011, d111, u, v, w
    if (brick[b, REFINED] >> bit) & 1:
        s = (brick[b, FIRST] & 0xFFFFFFFF) + ones_below(brick[b, REFINED] & brick[b, NEAR], bit)
        step = real[f, FINE_STEP]
        cell, s = _part(fine, split, s, step, cell)  # written out to the DEPTH there is
        if s >= 0:
            cell, s = _part(fine, split, s, 0.5 * step, cell)
            if s >= 0:
                cell, s = _part(fine, split, s, 0.25 * step, cell)
    value, gx, gy, gz = trilinear(cell)
    return with_unit_normal(real[f, NODE_STEP] * value, gx, gy, gz)


@part_kernel
def _part(fine, split, s, step, cell):
    """Of refined cell ``s`` the part around a point, and which refined cell that is, or -1."""
    part, n, (d000, d100, d010, d110, d001, d101, d011, d111, u, v, w) = eighth(cell)
    further = (split[s] >> 8) + ones_below(split[s] & 255, part)
    return (
        d000 + step * fine[s, n],
        d100 + step * fine[s, n + 1],
        d010 + step * fine[s, n + 3],
        d110 + step * fine[s, n + 4],
        d001 + step * fine[s, n + 9],
        d101 + step * fine[s, n + 10],
        d011 + step * fine[s, n + 12],
        d111 + step * fine[s, n + 13],
        u,
        v,
        w,
    ), further if (split[s] >> part) & 1 else -1


@part_kernel
def _node(whole, occupied, brick, node, f, i, j, k):
    """Node (i, j, k); its brick is looked up even if it is that of the voxel: a guess gone wrong would cost more."""
    b = brick_at(whole, occupied, f, i, j, k)
    bit = (i & 3) + 4 * (j & 3) + 16 * (k & 3)
    return float(node[first(brick[b, FIRST]) + ones_below(brick[b, NODES], bit)])


@part_kernel
def _plane_distance(real, brick, plane, f, b, bit, u, v, w):
    """Distance to the tangent plane of a voxel, (u, v, w) voxels from its centre; of its own side off the surface."""
    voxel = real[f, VOXEL]
    p = first(brick[b, FIRST]) + ones_below(brick[b, NEAR], bit)
    nx, ny, nz = float(plane[p, 0]), float(plane[p, 1]), float(plane[p, 2])
    distance = plane[p, 3] + voxel * (u * nx + v * ny + w * nz)
    if not (brick[b, REFINED] >> bit) & 1:
        distance = min(distance, 0.0) if plane[p, 3] < 0.0 else max(distance, 0.0)
    return distance, nx, ny, nz


@part_kernel
def _coarse_distance(real, whole, coarse, f, side, u, v, w):
    """Beyond the shell, from the corners of the block around (u, v, w), in blocks from the low corner of the grid.

    ``side`` is 1 outside, -1 inside, 0 if the corners, then all on one side, are to say. Outside, the interpolated
    distance less the most that it can be too large: with d at the corners and weights w of the way to them,
    sum(w d) <= d(x) + sum(w |x - corner|), and the mean of these ways is at most their root mean square.
    """
    step, band = real[f, COARSE_STEP], real[f, BAND]
    i, j, k = int(u), int(v), int(w)
    u, v, w = u - i, v - j, w - k
    row = whole[f, SHAPE] + 1
    layer = row * (whole[f, SHAPE + 1] + 1)
    n = whole[f, COARSE_FIRST] + i + row * j + layer * k
    corners = (
        float(coarse[n]), float(coarse[n + 1]), float(coarse[n + row]), float(coarse[n + row + 1]),
        float(coarse[n + layer]), float(coarse[n + layer + 1]),
        float(coarse[n + layer + row]), float(coarse[n + layer + row + 1]),
    )  # fmt: skip
    value, gx, gy, gz = trilinear((*corners, u, v, w))
    distance = step * value
    if side < 0 or (side == 0 and distance < 0.0):
        return with_unit_normal(min(distance, -band), gx, gy, gz)
    slack = 4.0 * real[f, VOXEL] * math.sqrt(u * (1.0 - u) + v * (1.0 - v) + w * (1.0 - w)) + step
    return with_unit_normal(max(distance - slack, band), gx, gy, gz)


@kernel
def field_distances(real, whole, coarse, occupied, brick, node, fine, split, plane, f, points, distance, normal):
    """As :func:`field_distance` for points (N, 3); fills ``distance`` (N,) and ``normal`` (N, 3)."""
    for p in range(points.shape[0]):
        d, nx, ny, nz = field_distance(
            real, whole, coarse, occupied, brick, node, fine, split, plane, f, points[p, 0], points[p, 1], points[p, 2]
        )
        distance[p], normal[p, 0], normal[p, 1], normal[p, 2] = d, nx, ny, nz


@kernel
def voxel_kinds(real, whole, coarse, occupied, brick, node, fine, split, plane, f, points, kind):
    """As :func:`voxel_kind` for points (N, 3); fills ``kind`` (N,)."""
    for p in range(points.shape[0]):
        kind[p] = voxel_kind(
            real, whole, coarse, occupied, brick, node, fine, split, plane, f, points[p, 0], points[p, 1], points[p, 2]
        )
