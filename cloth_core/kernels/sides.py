"""On which side of a triangle a vertex is, or an edge of another edge, and where above it."""

from __future__ import annotations

import math

from cloth_core.kernels import part_kernel
from cloth_core.kernels.closest import between, edge_edge, vertex_triangle

STEEP = 0.3
"""Least height of what comes from beside a feature, as a share of its distance, for its side to be known."""
INSIDE = 1e-9


@part_kernel
def across(x, p, q, r, s, wp, wq, wr, ws, nx, ny, nz):
    """How far the points of a pair are apart beside a direction, m."""
    dx, dy, dz = between(x, p, q, r, s, wp, wq, wr, ws)
    up = dx * nx + dy * ny + dz * nz
    return math.sqrt(max(0.0, dx * dx + dy * dy + dz * dz - up * up))


@part_kernel
def height(x, p, q, r, s, wp, wq, wr, ws, nx, ny, nz):
    """How far the points of a pair are apart along a direction, m."""
    dx, dy, dz = between(x, p, q, r, s, wp, wq, wr, ws)
    return dx * nx + dy * ny + dz * nz


@part_kernel
def is_beyond(x, p, q, r, nx, ny, nz, inside, margin):
    """Whether vertex ``p`` is more than ``margin`` m beyond the side from ``q`` to ``r``, along a plane of unit normal.

    ``inside`` is the sign of the turn in which the sides of the triangle go around that normal.
    """
    ex, ey, ez = x[r, 0] - x[q, 0], x[r, 1] - x[q, 1], x[r, 2] - x[q, 2]
    dx, dy, dz = x[p, 0] - x[q, 0], x[p, 1] - x[q, 1], x[p, 2] - x[q, 2]
    turn = inside * ((ey * dz - ez * dy) * nx + (ez * dx - ex * dz) * ny + (ex * dy - ey * dx) * nz)
    return turn < 0.0 and turn * turn > margin * margin * (ex * ex + ey * ey + ez * ez)


@part_kernel
def is_beside(x, p, q, r, s, nx, ny, nz, inside, margin):
    """Whether a side of the triangle tells that vertex ``p`` is more than ``margin`` m beside it; corners it cuts."""
    return (
        is_beyond(x, p, q, r, nx, ny, nz, inside, margin)
        or is_beyond(x, p, r, s, nx, ny, nz, inside, margin)
        or is_beyond(x, p, s, q, nx, ny, nz, inside, margin)
    )


@part_kernel
def face_weights(start, end, p, q, r, s, up, nx, ny, nz, thickness):
    """Shares of a triangle's corners in the point that vertex ``p`` is above, and whether there is one.

    At the ``start`` if it is above the triangle then, else at the ``end``, if its side of the plane can be told from
    the height ``up`` m at the start.
    """
    a, b, c = vertex_triangle(start, p, q, r, s)
    beside = across(start, p, q, r, s, 1.0, -a, -b, -c, nx, ny, nz)
    above = beside <= thickness
    if not above and up > STEEP * beside:
        a, b, c = vertex_triangle(end, p, q, r, s)
        above = across(end, p, q, r, s, 1.0, -a, -b, -c, nx, ny, nz) <= thickness
    return above, a, b, c


@part_kernel
def edge_shares(start, end, p, q, r, s, up, nx, ny, nz):
    """How far along two edges they cross, and whether they do; at the start or at the end as for a face."""
    a, b = edge_edge(start, p, q, r, s)
    crosses = INSIDE < a < 1.0 - INSIDE and INSIDE < b < 1.0 - INSIDE
    if not crosses and up > STEEP * across(start, p, q, r, s, 1.0 - a, a, b - 1.0, -b, nx, ny, nz):
        a, b = edge_edge(end, p, q, r, s)
        crosses = INSIDE < a < 1.0 - INSIDE and INSIDE < b < 1.0 - INSIDE
    return crosses, a, b
