"""A tree of boxes over triangles: the closest one, and how often they wind around a point."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import kernel
from cloth_core.kernels.triangles import closest_point, solid_angle

LEAF = 4
"""Triangles in a leaf at most."""

DEEPEST = 64
"""Room for the branches that a search puts aside: more than the tree can be deep."""

FAR = 3.0
"""Radii away from which a branch counts as one dipole: its share of the winding number is then good to about 1 %."""


@kernel
def build_tree(corner, order, first, last, child):
    """Halve the triangles along the longest side of their centres' box, again and again, down to :data:`LEAF`.

    ``order`` (T,) gets the triangles in the order of the leaves. Branch b holds ``order[first[b]:last[b]]`` and has
    the children ``child[b]`` and the next, or none if that is 0; the arrays have room for (2 T). Returns the number
    of branches. Parents come before their children.
    """
    count = corner.shape[0]
    centre = np.empty((count, 3))
    for t in range(count):
        order[t] = t
        for k in range(3):
            centre[t, k] = (corner[t, 0, k] + corner[t, 1, k] + corner[t, 2, k]) / 3.0
    first[0], last[0], branches, b = 0, count, 1, 0
    while b < branches:
        child[b] = 0
        begin, end = first[b], last[b]
        if end - begin > LEAF:
            mine = order[begin:end].copy()
            longest, axis = -1.0, 0
            for k in range(3):
                low, high = np.inf, -np.inf
                for t in mine:
                    low, high = min(low, centre[t, k]), max(high, centre[t, k])
                if high - low > longest:
                    longest, axis = high - low, k
            order[begin:end] = mine[np.argsort(centre[mine, axis], kind="mergesort")]
            middle = (begin + end) // 2
            child[b] = branches
            first[branches], last[branches] = begin, middle
            first[branches + 1], last[branches + 1] = middle, end
            branches += 2
        b += 1
    return branches


@kernel
def measure_tree(corner, first, last, child, box, dipole):
    """Boxes (B, 6) low and high, and dipoles (B, 7): centre, area vector and radius in m of each branch.

    The dipole is the first term of the winding number far away (Barill and others, "Fast winding numbers for soups
    and clouds", 2018). ``corner`` must be in the order of the leaves; children are measured before parents.
    """
    area = np.zeros(first.shape[0])
    for b in range(first.shape[0] - 1, -1, -1):
        box[b, :3], box[b, 3:], dipole[b] = np.inf, -np.inf, 0.0
        if child[b]:
            for c in range(child[b], child[b] + 2):
                for k in range(3):
                    box[b, k], box[b, 3 + k] = min(box[b, k], box[c, k]), max(box[b, 3 + k], box[c, 3 + k])
                    dipole[b, k] += area[c] * dipole[c, k]
                    dipole[b, 3 + k] += dipole[c, 3 + k]
                area[b] += area[c]
        else:
            for t in range(first[b], last[b]):
                vector = 0.5 * np.cross(corner[t, 1] - corner[t, 0], corner[t, 2] - corner[t, 0])
                size = math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
                area[b] += size
                for k in range(3):
                    for n in range(3):
                        box[b, k], box[b, 3 + k] = min(box[b, k], corner[t, n, k]), max(box[b, 3 + k], corner[t, n, k])
                        dipole[b, k] += size * corner[t, n, k] / 3.0
                    dipole[b, 3 + k] += vector[k]
        radius = 0.0
        for k in range(3):
            dipole[b, k] = dipole[b, k] / area[b] if area[b] > 0.0 else box[b, k]
            radius += max(dipole[b, k] - box[b, k], box[b, 3 + k] - dipole[b, k]) ** 2
        dipole[b, 6] = math.sqrt(radius)


@kernel
def square_to_box(box, x, y, z):
    """Squared distance in m^2 of a point from a box (6,), 0 inside."""
    dx = max(max(box[0] - x, x - box[3]), 0.0)
    dy = max(max(box[1] - y, y - box[4]), 0.0)
    dz = max(max(box[2] - z, z - box[5]), 0.0)
    return dx * dx + dy * dy + dz * dz


@kernel
def closest(corner, hidden, first, last, child, box, root, x, y, z, limit):
    """Closest point of all triangles but the ``hidden``, its triangle (-1: none nearer than ``limit`` m) and part."""
    nearest, which, part = limit * limit, -1, 0
    cx = cy = cz = 0.0
    aside, gap = np.empty(DEEPEST, np.int64), np.empty(DEEPEST)
    aside[0], gap[0], waiting = root, square_to_box(box[root], x, y, z), 1
    while waiting:
        waiting -= 1
        if gap[waiting] >= nearest:
            continue
        b = aside[waiting]
        if child[b]:
            near, far = child[b], child[b] + 1
            near_gap, far_gap = square_to_box(box[near], x, y, z), square_to_box(box[far], x, y, z)
            if far_gap < near_gap:
                near, far, near_gap, far_gap = far, near, far_gap, near_gap
            aside[waiting], gap[waiting] = far, far_gap
            aside[waiting + 1], gap[waiting + 1] = near, near_gap
            waiting += 2
            continue
        for t in range(first[b], last[b]):
            if hidden[t]:
                continue
            qx, qy, qz, there = closest_point(corner[t], x, y, z)
            square = (x - qx) ** 2 + (y - qy) ** 2 + (z - qz) ** 2
            if square < nearest:
                nearest, which, part, cx, cy, cz = square, t, there, qx, qy, qz
    return cx, cy, cz, which, part


@kernel
def winding_number(corner, first, last, child, dipole, root, x, y, z):
    """How often the triangles wind around a point: 1 inside a closed surface, 0 outside, good to a few percent."""
    total = 0.0
    aside = np.empty(DEEPEST, np.int64)
    aside[0], waiting = root, 1
    while waiting:
        waiting -= 1
        b = aside[waiting]
        dx, dy, dz = dipole[b, 0] - x, dipole[b, 1] - y, dipole[b, 2] - z
        square = dx * dx + dy * dy + dz * dz
        if square > (FAR * dipole[b, 6]) ** 2:
            flux = dx * dipole[b, 3] + dy * dipole[b, 4] + dz * dipole[b, 5]
            total += flux / (square * math.sqrt(square))
        elif child[b]:
            aside[waiting], aside[waiting + 1] = child[b], child[b] + 1
            waiting += 2
        else:
            for t in range(first[b], last[b]):
                total += solid_angle(corner[t], x, y, z)
    return total / (4.0 * math.pi)
