"""Directions that part leaves: most of what lies close together needs no closer look."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import kernel, part_kernel
from cloth_core.kernels.closest import along
from cloth_core.kernels.hierarchy import triangle_normal


@part_kernel
def leaf_gap(x, corner_start, corner, a, b, nx, ny, nz):
    """By how much leaf ``a`` is ahead of leaf ``b`` in a direction at ``x`` (V, 3) m, at least; negative if it is not.

    It is concave on straight ways: if positive at both ends, it is so all the time.
    """
    least, most = np.inf, -np.inf
    for m in range(corner_start[a], corner_start[a + 1]):
        least = min(least, along(x, corner[m], nx, ny, nz))
    for m in range(corner_start[b], corner_start[b + 1]):
        most = max(most, along(x, corner[m], nx, ny, nz))
    return least - most


@part_kernel
def leaf_extent(x, corner_start, corner, a, nx, ny, nz):
    """Least and most of the places of a leaf's corners along a direction, m."""
    least, most = np.inf, -np.inf
    for m in range(corner_start[a], corner_start[a + 1]):
        d = along(x, corner[m], nx, ny, nz)
        least, most = min(least, d), max(most, d)
    return least, most


@kernel
def fit_leaves(before, after, triangles, leaf_start, wanted, face, box, low, high, upward):
    """Boxes ``low`` and ``high`` (L, 3) of leaves on their ways, and where they face before: ``upward`` (L, 3).

    ``face`` (T, 3) are the normals of the triangles, before, and ``box`` (T, 6) where they are on their ways, least and
    most. Of ``wanted`` (L,) leaves alone.
    """
    for leaf in range(leaf_start.shape[0] - 1):
        if not wanted[leaf]:
            continue
        for a in range(3):
            low[leaf, a], high[leaf, a] = np.inf, -np.inf
        x, y, z = 0.0, 0.0, 0.0
        for t in range(leaf_start[leaf], leaf_start[leaf + 1]):
            p, q, r = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            nx, ny, nz = triangle_normal(before, p, q, r)
            face[t, 0], face[t, 1], face[t, 2] = nx, ny, nz
            x, y, z = x + nx, y + ny, z + nz
            for a in range(3):
                least = min(min(before[p, a], before[q, a], before[r, a]), min(after[p, a], after[q, a], after[r, a]))
                most = max(max(before[p, a], before[q, a], before[r, a]), max(after[p, a], after[q, a], after[r, a]))
                box[t, a], box[t, 3 + a] = least, most
                low[leaf, a], high[leaf, a] = min(low[leaf, a], least), max(high[leaf, a], most)
        square = x * x + y * y + z * z
        share = 1.0 / math.sqrt(square) if square > 0.0 else 0.0
        upward[leaf, 0], upward[leaf, 1], upward[leaf, 2] = x * share, y * share, z * share


@kernel
def mark_leaves(pair, wanted):
    """Which leaves are in one of the pairs: ``wanted`` (L,)."""
    wanted[:] = False
    for p in range(pair.shape[0]):
        wanted[pair[p, 0]] = True
        wanted[pair[p, 1]] = True


@part_kernel
def best_direction(before, corner_start, corner, low, high, upward, a, b, enough):
    """The gap from leaf ``b`` to leaf ``a``, and its direction: where they face, or from one middle to the other.

    The first direction to part them by ``enough`` m will do.
    """
    best, bx, by, bz = -np.inf, 0.0, 0.0, 1.0
    for way in range(3):
        if way == 2:
            nx = low[a, 0] + high[a, 0] - low[b, 0] - high[b, 0]
            ny = low[a, 1] + high[a, 1] - low[b, 1] - high[b, 1]
            nz = low[a, 2] + high[a, 2] - low[b, 2] - high[b, 2]
            square = nx * nx + ny * ny + nz * nz
            if square == 0.0:
                continue
            share = 1.0 / math.sqrt(square)
            nx, ny, nz = nx * share, ny * share, nz * share
        else:
            leaf = a if way == 0 else b
            nx, ny, nz = upward[leaf, 0], upward[leaf, 1], upward[leaf, 2]
        first_least, first_most = leaf_extent(before, corner_start, corner, a, nx, ny, nz)
        second_least, second_most = leaf_extent(before, corner_start, corner, b, nx, ny, nz)
        if first_least - second_most > best:
            best, bx, by, bz = first_least - second_most, nx, ny, nz
        if second_least - first_most > best:
            best, bx, by, bz = second_least - first_most, -nx, -ny, -nz
        if best > enough:
            break
    return best, bx, by, bz


@kernel
def part_leaves(before, after, corner_start, corner, low, high, upward, margin, pair, normal, gap):
    """Find a direction ``normal`` (P, 3) that parts each ``pair`` (P, 2) of leaves, and the ``gap`` (P,) m it leaves.

    The gap is the least on the way from ``before`` to ``after`` (V, 3) m.
    """
    for p in range(pair.shape[0]):
        a, b = pair[p, 0], pair[p, 1]
        best, nx, ny, nz = best_direction(before, corner_start, corner, low, high, upward, a, b, margin)
        normal[p, 0], normal[p, 1], normal[p, 2] = nx, ny, nz
        gap[p] = min(best, leaf_gap(after, corner_start, corner, a, b, nx, ny, nz))


@kernel
def farthest(position, other, corner_start, corner, moved):
    """How far the corners of each leaf are from where the ``other`` (V, 3) m has them, at most: ``moved`` (L,) m."""
    for leaf in range(moved.shape[0]):
        most = 0.0
        for m in range(corner_start[leaf], corner_start[leaf + 1]):
            v = corner[m]
            dx, dy, dz = position[v, 0] - other[v, 0], position[v, 1] - other[v, 1], position[v, 2] - other[v, 2]
            most = max(most, dx * dx + dy * dy + dz * dz)
        moved[leaf] = math.sqrt(most)


@kernel
def keep_close(margin, pair, normal, gap):
    """Move those with a gap below ``margin`` m to the front, in their order; returns how many there are."""
    count = 0
    for p in range(pair.shape[0]):
        if gap[p] < margin:
            pair[count, 0], pair[count, 1] = pair[p, 0], pair[p, 1]
            normal[count, 0], normal[count, 1], normal[count, 2] = normal[p, 0], normal[p, 1], normal[p, 2]
            gap[count] = gap[p]
            count += 1
    return count


@kernel
def stray(position, origin, velocity, time):
    """How far the vertices are from where ``velocity`` (V, 3) m/s took them from ``origin`` in ``time`` s, at most.

    But for what they all have in common, in m: the mean of ``position`` (V, 3) less that way.
    """
    count = position.shape[0]
    mx, my, mz = 0.0, 0.0, 0.0
    for v in range(count):
        mx += position[v, 0] - origin[v, 0] - time * velocity[v, 0]
        my += position[v, 1] - origin[v, 1] - time * velocity[v, 1]
        mz += position[v, 2] - origin[v, 2] - time * velocity[v, 2]
    mx, my, mz = mx / count, my / count, mz / count
    most = 0.0
    for v in range(count):
        dx = position[v, 0] - origin[v, 0] - time * velocity[v, 0] - mx
        dy = position[v, 1] - origin[v, 1] - time * velocity[v, 1] - my
        dz = position[v, 2] - origin[v, 2] - time * velocity[v, 2] - mz
        most = max(most, dx * dx + dy * dy + dz * dz)
    return math.sqrt(most)
