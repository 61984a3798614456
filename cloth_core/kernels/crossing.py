"""Which voxels the surface passes through (paper, 4.2.1)."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import kernel
from cloth_core.kernels.contact import distance_in_world
from cloth_core.kernels.tree import DEEPEST


@kernel
def mark_surface(surfaces, shapes, origin, size, block, near, surface):
    """Bits of ``surface`` (N,) of the voxels ``near`` in the blocks ``block`` (N, 3) that the surface passes through.

    For the triangles of surfaces that is exact; of analytic shapes, whose surface has no corners to be missed, voxels
    count whose own corners are not all on one side.
    """
    for n in range(block.shape[0]):
        surface[n] = 0
        for cell in range(64):
            if (near[n] >> cell) & 1:
                x = origin[0] + size * (4 * block[n, 0] + cell % 4 + 0.5)
                y = origin[1] + size * (4 * block[n, 1] + cell // 4 % 4 + 0.5)
                z = origin[2] + size * (4 * block[n, 2] + cell // 16 + 0.5)
                if _triangles_in(surfaces, x, y, z, 0.5 * size) or _shapes_in(shapes, x, y, z, 0.5 * size):
                    surface[n] |= 1 << cell


@kernel
def _triangles_in(surfaces, x, y, z, half):
    """Whether any triangle that counts touches the cube around a point."""
    corner, _, hidden, first, last, child, box, _, root, _ = surfaces
    aside = np.empty(DEEPEST, np.int64)
    for s in range(root.shape[0]):
        aside[0], waiting = root[s], 1
        while waiting:
            waiting -= 1
            b = aside[waiting]
            if x + half < box[b, 0] or y + half < box[b, 1] or z + half < box[b, 2]:
                continue
            if x - half > box[b, 3] or y - half > box[b, 4] or z - half > box[b, 5]:
                continue
            if child[b]:
                aside[waiting], aside[waiting + 1] = child[b], child[b] + 1
                waiting += 2
                continue
            for t in range(first[b], last[b]):
                if not hidden[t] and meets_cube(corner[t], x, y, z, half):
                    return True
    return False


@kernel
def _shapes_in(shapes, x, y, z, half):
    """Whether the corners of the cube around a point, and the point, are on both sides of any analytic shape."""
    kind, size, rotation, origin = shapes
    for k in range(kind.shape[0]):
        side = distance_in_world(kind[k], size[k], rotation[k], origin[k], x, y, z)[0] < 0.0
        for corner in range(8):
            a = x + half * (2 * (corner % 2) - 1)
            b = y + half * (2 * (corner // 2 % 2) - 1)
            c = z + half * (2 * (corner // 4) - 1)
            if (distance_in_world(kind[k], size[k], rotation[k], origin[k], a, b, c)[0] < 0.0) != side:
                return True
    return False


@kernel
def meets_cube(corner, x, y, z, half):
    """Whether the triangle ``corner`` (3, 3) touches the cube around a point, ``half`` its edge.

    By the thirteen axes that can part a box and a triangle (Akenine-Moeller, "Fast 3D triangle-box overlap
    testing", 2001).
    """
    for axis in range(13):
        nx, ny, nz = _parting_axis(corner, axis)
        reach = half * (abs(nx) + abs(ny) + abs(nz))
        low = high = nx * (corner[0, 0] - x) + ny * (corner[0, 1] - y) + nz * (corner[0, 2] - z)
        for n in range(1, 3):
            along = nx * (corner[n, 0] - x) + ny * (corner[n, 1] - y) + nz * (corner[n, 2] - z)
            low, high = min(low, along), max(high, along)
        if low > reach or high < -reach:
            return False
    return True


@kernel
def _parting_axis(corner, axis):
    """The three of the box, the triangle's normal, and the nine products of their edges."""
    if axis < 3:
        return 1.0 * (axis == 0), 1.0 * (axis == 1), 1.0 * (axis == 2)
    a = (axis - 4) % 3
    b = (a + 1) % 3
    ux, uy, uz = corner[b, 0] - corner[a, 0], corner[b, 1] - corner[a, 1], corner[b, 2] - corner[a, 2]
    if axis == 3:
        wx, wy, wz = corner[1, 0] - corner[2, 0], corner[1, 1] - corner[2, 1], corner[1, 2] - corner[2, 2]
        return uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
    which = (axis - 4) // 3
    if which == 0:
        return 0.0, -uz, uy
    if which == 1:
        return uz, 0.0, -ux
    return -uy, ux, 0.0
