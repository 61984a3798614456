"""Directions that part leaves: most of what lies close together needs no closer look."""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from cloth_core.kernels import inline_kernel, kernel, shared_kernel
from cloth_core.kernels.closest import along
from cloth_core.kernels.hierarchy import NORMAL, PLACE

SHARES = 2
"""Of a loop over pairs, one for each thread of a small machine."""


@inline_kernel
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


@inline_kernel
def leaf_extent(x, corner_start, corner, a, nx, ny, nz):
    """Least and most of the places of a leaf's corners along a direction, m."""
    least, most = np.inf, -np.inf
    for m in range(corner_start[a], corner_start[a + 1]):
        d = along(x, corner[m], nx, ny, nz)
        least, most = min(least, d), max(most, d)
    return least, most


@kernel
def best_direction(before, corner_start, corner, low, high, a, b, enough):
    """The gap from leaf ``b`` to leaf ``a``, and its direction: a normal of theirs, or that of their middles.

    ``low`` and ``high`` (N, 9) are the boxes of patches. The first to part them by ``enough`` m will do.
    """
    best, bx, by, bz = -np.inf, 0.0, 0.0, 1.0
    first = (low.shape[0] - 1) // 2
    i, j = first + a, first + b
    for way in range(3):
        m, k, sign = (j if way == 1 else i), (PLACE if way == 2 else NORMAL), (-1.0 if way == 2 else 0.0)
        nx = low[m, k] + high[m, k] + sign * (low[j, k] + high[j, k])
        ny = low[m, k + 1] + high[m, k + 1] + sign * (low[j, k + 1] + high[j, k + 1])
        nz = low[m, k + 2] + high[m, k + 2] + sign * (low[j, k + 2] + high[j, k + 2])
        square = nx * nx + ny * ny + nz * nz
        if square == 0.0:
            continue
        share = 1.0 / math.sqrt(square)
        nx, ny, nz = nx * share, ny * share, nz * share
        first_least, first_most = leaf_extent(before, corner_start, corner, a, nx, ny, nz)
        second_least, second_most = leaf_extent(before, corner_start, corner, b, nx, ny, nz)
        if first_least - second_most > best:
            best, bx, by, bz = first_least - second_most, nx, ny, nz
        if second_least - first_most > best:
            best, bx, by, bz = second_least - first_most, -nx, -ny, -nz
        if best > enough:
            break
    return best, bx, by, bz


@shared_kernel
def part_leaves(before, after, corner_start, corner, low, high, margin, pair, normal, gap, apart):
    """Find a direction ``normal`` (P, 3) that parts each ``pair`` (P, 2) of leaves, and the ``gap`` (P,) m it leaves.

    The gap is the least on the way from ``before`` to ``after`` (V, 3) m. ``apart`` (P,) is what it is before.
    """
    count = pair.shape[0]
    for share in prange(SHARES):
        for p in range(count * share // SHARES, count * (share + 1) // SHARES):
            a, b = pair[p, 0], pair[p, 1]
            best, nx, ny, nz = best_direction(before, corner_start, corner, low, high, a, b, 2.0 * margin)
            normal[p, 0], normal[p, 1], normal[p, 2] = nx, ny, nz
            apart[p] = best
            gap[p] = min(best, leaf_gap(after, corner_start, corner, a, b, nx, ny, nz))


@kernel
def keep_close(margin, pair, normal, gap, apart):
    """Move those with a gap below ``margin`` m to the front, in their order; returns how many there are."""
    count = 0
    for p in range(pair.shape[0]):
        if gap[p] < margin:
            pair[count, 0], pair[count, 1] = pair[p, 0], pair[p, 1]
            normal[count, 0], normal[count, 1], normal[count, 2] = normal[p, 0], normal[p, 1], normal[p, 2]
            gap[count], apart[count] = gap[p], apart[p]
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
