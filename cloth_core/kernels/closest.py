"""Closest points of two features of a surface: a vertex and a triangle, or two edges.

A pair is a row of four vertices: the vertex and the corners of the triangle, or the ends of one edge and those of the
other. Its weights are signed: they take the point on the second feature from the point on the first.
"""

from __future__ import annotations

import math

from cloth_core.kernels import part_kernel

PARALLEL = 1e-10
"""Square of the sine of the angle below which two edges count as parallel."""


@part_kernel
def vertex_triangle(x, p, a, b, c):
    """Shares of the corners ``a``, ``b`` and ``c`` in the point of the triangle that is closest to vertex ``p``.

    By regions of the triangle (Ericson 2005, "Real-Time Collision Detection", 5.1.5).
    """
    abx, aby, abz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    acx, acy, acz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    apx, apy, apz = x[p, 0] - x[a, 0], x[p, 1] - x[a, 1], x[p, 2] - x[a, 2]
    bb = abx * abx + aby * aby + abz * abz
    bc = abx * acx + aby * acy + abz * acz
    cc = acx * acx + acy * acy + acz * acz
    d1 = abx * apx + aby * apy + abz * apz
    d2 = acx * apx + acy * apy + acz * apz
    if d1 <= 0.0 and d2 <= 0.0:
        return 1.0, 0.0, 0.0
    d3, d4 = d1 - bb, d2 - bc
    if d3 >= 0.0 and d4 <= d3:
        return 0.0, 1.0, 0.0
    d5, d6 = d1 - bc, d2 - cc
    if d6 >= 0.0 and d5 <= d6:
        return 0.0, 0.0, 1.0
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        s = d1 / (d1 - d3)
        return 1.0 - s, s, 0.0
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        s = d2 / (d2 - d6)
        return 1.0 - s, 0.0, s
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        s = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return 0.0, 1.0 - s, s
    share = 1.0 / (va + vb + vc)
    return 1.0 - (vb + vc) * share, vb * share, vc * share


@part_kernel
def edge_edge(x, i, j, k, l):  # noqa: E741 - a row of four
    """How far along ``i`` to ``j`` and ``k`` to ``l`` the closest points of two edges are (Ericson 2005, 5.1.9)."""
    ux, uy, uz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
    vx, vy, vz = x[l, 0] - x[k, 0], x[l, 1] - x[k, 1], x[l, 2] - x[k, 2]
    rx, ry, rz = x[i, 0] - x[k, 0], x[i, 1] - x[k, 1], x[i, 2] - x[k, 2]
    a = ux * ux + uy * uy + uz * uz
    e = vx * vx + vy * vy + vz * vz
    b = ux * vx + uy * vy + uz * vz
    c = ux * rx + uy * ry + uz * rz
    f = vx * rx + vy * ry + vz * rz
    s, t = 0.0, 0.0
    if a <= 0.0:
        return 0.0, min(max(f / e, 0.0), 1.0) if e > 0.0 else 0.0
    if e <= 0.0:
        return min(max(-c / a, 0.0), 1.0), 0.0
    space = a * e - b * b
    if space > PARALLEL * a * e:
        s = min(max((b * f - c * e) / space, 0.0), 1.0)
    t = (b * s + f) / e
    if t < 0.0:
        t = 0.0
        s = min(max(-c / a, 0.0), 1.0)
    elif t > 1.0:
        t = 1.0
        s = min(max((b - c) / a, 0.0), 1.0)
    return s, t


@part_kernel
def closest_weights(x, p, q, r, s, edges):
    """Signed weights of the four vertices of a pair at its closest points, of two ``edges`` or not."""
    if edges:
        a, b = edge_edge(x, p, q, r, s)
        return 1.0 - a, a, b - 1.0, -b
    a, b, c = vertex_triangle(x, p, q, r, s)
    return 1.0, -a, -b, -c


@part_kernel
def between(x, p, q, r, s, wp, wq, wr, ws):
    """Vector from the second point of a pair to the first, of ``x`` (V, 3) with signed weights."""
    return (
        wp * x[p, 0] + wq * x[q, 0] + wr * x[r, 0] + ws * x[s, 0],
        wp * x[p, 1] + wq * x[q, 1] + wr * x[r, 1] + ws * x[s, 1],
        wp * x[p, 2] + wq * x[q, 2] + wr * x[r, 2] + ws * x[s, 2],
    )


@part_kernel
def toward(x, p, q, r, s, edges):
    """Unit vector from the second feature of a pair to the first, and their distance in m; no vector if they meet."""
    wp, wq, wr, ws = closest_weights(x, p, q, r, s, edges)
    dx, dy, dz = between(x, p, q, r, s, wp, wq, wr, ws)
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    share = 1.0 / distance if distance > 0.0 else 0.0
    return dx * share, dy * share, dz * share, distance


@part_kernel
def along(x, v, nx, ny, nz):
    """How far vertex ``v`` is in a direction."""
    return x[v, 0] * nx + x[v, 1] * ny + x[v, 2] * nz


@part_kernel
def separation(x, p, q, r, s, edges, nx, ny, nz):
    """By how much the first feature of a pair is ahead of the second in a direction, at least, in m.

    Where it is positive at both ends of straight ways it is so all the time, since it is concave; so features that a
    direction parts at both ends do not meet.
    """
    a, b, c, d = along(x, p, nx, ny, nz), along(x, q, nx, ny, nz), along(x, r, nx, ny, nz), along(x, s, nx, ny, nz)
    if edges:
        return min(a, b) - max(c, d)
    return a - max(b, max(c, d))
