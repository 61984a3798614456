"""Which triangles may meet within a while: boxes around patches, fitted to where these are and how they move.

Boxes have nine extents: of the places, of the ways they go, and of the normals before and after. Ways are compared, not
added up: what falls together does not approach. Patches whose normals point to one side cannot touch themselves, nor a
neighbour of that kind (Volino and Magnenat-Thalmann 1994, "Efficient self-collision detection on smoothly discretized
surface animations using geometrical shape regularity"), so that a cloth without folds costs next to nothing.
"""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import kernel, part_kernel

PLACE, WAY, NORMAL, EXTENTS = 0, 3, 6, 9
UPRIGHT = 0.5
"""Least cosine between a patch's mean normal and any of its normals, for it to be called smooth."""
SQUEEZED = 0.4
"""Share of its area at rest."""
DEEP = 4096
"""Room for the patches still to be looked at: more than four to every level of any tree."""


@part_kernel
def triangle_normal(x, p, q, r):
    """Unit normal, or zero where there is no area."""
    ux, uy, uz = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
    vx, vy, vz = x[r, 0] - x[p, 0], x[r, 1] - x[p, 1], x[r, 2] - x[p, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    square = nx * nx + ny * ny + nz * nz
    share = 1.0 / math.sqrt(square) if square > 0.0 else 0.0
    return nx * share, ny * share, nz * share


@part_kernel
def doubled_area(x, p, q, r):
    """Twice the area of a triangle, m^2."""
    ux, uy, uz = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
    vx, vy, vz = x[r, 0] - x[p, 0], x[r, 1] - x[p, 1], x[r, 2] - x[p, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return math.sqrt(nx * nx + ny * ny + nz * nz)


@kernel
def fit_triangles(before, after, triangles, area, low, high):
    """Boxes (T, 9) of the triangles on the ways of their corners from ``before`` to ``after`` (V, 3) m.

    What is squeezed to a ``SQUEEZED`` share of its ``area`` (T,) m^2 at rest faces anywhere: in its own plane, too, a
    cloth may be pushed upon itself.
    """
    for t in range(triangles.shape[0]):
        p, q, r = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        for a in range(3):
            low[t, a] = min(before[p, a], before[q, a], before[r, a])
            high[t, a] = max(before[p, a], before[q, a], before[r, a])
            u, v, w = after[p, a] - before[p, a], after[q, a] - before[q, a], after[r, a] - before[r, a]
            low[t, WAY + a] = min(u, v, w)
            high[t, WAY + a] = max(u, v, w)
        first = triangle_normal(before, p, q, r)
        second = triangle_normal(after, p, q, r)
        for a in range(3):
            low[t, NORMAL + a] = min(first[a], second[a])
            high[t, NORMAL + a] = max(first[a], second[a])
        if min(doubled_area(before, p, q, r), doubled_area(after, p, q, r)) < 2.0 * SQUEEZED * area[t]:
            low[t, NORMAL:] = -1.0
            high[t, NORMAL:] = 1.0


@kernel
def fit_patches(triangle_low, triangle_high, leaf_start, low, high):
    """Boxes (N, 9) of all patches, from the leaves up."""
    leaves = leaf_start.shape[0] - 1
    for n in range(low.shape[0] - 1, -1, -1):
        leaf = n - (leaves - 1)
        for a in range(EXTENTS):
            least, most = np.inf, -np.inf
            if leaf >= 0:
                for m in range(leaf_start[leaf], leaf_start[leaf + 1]):
                    least = min(least, triangle_low[m, a])
                    most = max(most, triangle_high[m, a])
            else:
                least = min(low[2 * n + 1, a], low[2 * n + 2, a])
                most = max(high[2 * n + 1, a], high[2 * n + 2, a])
            low[n, a], high[n, a] = least, most


@part_kernel
def are_smooth(low, high, a, b, c):
    """Whether one direction is in front of all normals of the boxes ``a``, ``b`` and ``c``."""
    least, square = 0.0, 0.0
    for k in range(NORMAL, EXTENTS):
        below, above = min(low[a, k], low[b, k], low[c, k]), max(high[a, k], high[b, k], high[c, k])
        mean = 0.5 * (below + above)
        square += mean * mean
        least += mean * mean - abs(mean) * 0.5 * (above - below)
    return least > UPRIGHT * math.sqrt(square)


@part_kernel
def may_meet(low, high, a, other_low, other_high, b, margin):
    """Whether boxes come within ``margin`` m of each other on their ways, along each axis for itself."""
    for k in range(3):
        least = min(0.0, other_low[b, WAY + k] - high[a, WAY + k])
        most = max(0.0, other_high[b, WAY + k] - low[a, WAY + k])
        if other_low[b, k] + least > high[a, k] + margin or other_high[b, k] + most < low[a, k] - margin:
            return False
    return True


@part_kernel
def is_beside(beside_start, beside, a, b):
    """Whether patches ``a`` and ``b`` have an edge in common."""
    for m in range(beside_start[a], beside_start[a + 1]):
        if beside[m] == b:
            return True
    return False


@part_kernel
def are_joined(compact, beside_start, beside, low, high, a, b):
    """Whether a patch beside both ``a`` and ``b`` is smooth with them: they meet at a corner, and all is one piece."""
    for m in range(beside_start[a], beside_start[a + 1]):
        c = beside[m]
        if compact[c] and is_beside(beside_start, beside, c, b) and are_smooth(low, high, a, b, c):
            return True
    return False


@kernel
def meeting_leaves(leaves, compact, beside_start, beside, low, high, margin, pair):
    """List the pairs of ``leaves`` that may come within ``margin`` m of each other, in a fixed order.

    A leaf that is not smooth is paired with itself.

    Returns:
        Their number; only so many as ``pair`` (P, 2) has room for are listed, as numbers from 0.
    """
    count = 0
    todo = np.empty((DEEP, 2), np.int32)
    todo[0] = 0
    waiting = 1
    while waiting > 0:
        waiting -= 1
        a, b = todo[waiting, 0], todo[waiting, 1]
        if a != b and not may_meet(low, high, a, low, high, b, margin):
            continue
        if compact[a] and compact[b] and are_smooth(low, high, a, b, a):
            if a == b or is_beside(beside_start, beside, a, b):
                continue
            if are_joined(compact, beside_start, beside, low, high, a, b):
                continue
        if a >= leaves - 1:
            if count < pair.shape[0]:
                pair[count, 0], pair[count, 1] = a - (leaves - 1), b - (leaves - 1)
            count += 1
            continue
        for i in range(1, 3):
            for j in range(i if a == b else 1, 3):
                todo[waiting, 0], todo[waiting, 1] = 2 * a + i, 2 * b + j
                waiting += 1
    return count
