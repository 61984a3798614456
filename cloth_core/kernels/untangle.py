"""What crosses already: where, and which way out.

No side is right for such features; those of the rest of the cloth would only keep them where they are. The line along
which two surfaces cross gets shorter instead, until it is gone (Volino and Magnenat-Thalmann 2006, "Resolving surface
collisions through intersection contour minimization").
"""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import kernel, part_kernel
from cloth_core.kernels.hierarchy import triangle_normal


@part_kernel
def runs_through(x, p, q, a, b, c):
    """Whether the edge from ``p`` to ``q`` runs through the triangle ``a``, ``b``, ``c``."""
    nx, ny, nz = triangle_normal(x, a, b, c)
    first = (x[p, 0] - x[a, 0]) * nx + (x[p, 1] - x[a, 1]) * ny + (x[p, 2] - x[a, 2]) * nz
    last = (x[q, 0] - x[a, 0]) * nx + (x[q, 1] - x[a, 1]) * ny + (x[q, 2] - x[a, 2]) * nz
    if (first > 0.0) == (last > 0.0) or first == last:
        return False
    t = first / (first - last)
    px, py, pz = x[p, 0] + t * (x[q, 0] - x[p, 0]), x[p, 1] + t * (x[q, 1] - x[p, 1]), x[p, 2] + t * (x[q, 2] - x[p, 2])
    inside = 0
    for k in range(3):
        i, j = (a, b) if k == 0 else (b, c) if k == 1 else (c, a)
        ex, ey, ez = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        dx, dy, dz = px - x[i, 0], py - x[i, 1], pz - x[i, 2]
        turn = (ey * dz - ez * dy) * nx + (ez * dx - ex * dz) * ny + (ex * dy - ey * dx) * nz
        inside += turn > 0.0
    return inside == 3


@part_kernel
def on_both_sides(x, t, u, triangles, face):
    """Whether triangle ``t`` has corners on both sides of triangle ``u``, or on it."""
    least, most = np.inf, -np.inf
    a = triangles[u, 0]
    for k in range(3):
        v = triangles[t, k]
        up = (x[v, 0] - x[a, 0]) * face[u, 0] + (x[v, 1] - x[a, 1]) * face[u, 1] + (x[v, 2] - x[a, 2]) * face[u, 2]
        least, most = min(least, up), max(most, up)
    return least <= 0.0 <= most


@kernel
def find_crossings(x, triangles, leaf_start, face, pair, gap, crossing):
    """List the edges that run through triangles; an edge of two triangles comes twice.

    Args:
        x: (V, 3) m.
        triangles: (T, 3), as the leaves have them.
        leaf_start: (L + 1,).
        face: (T, 3) normals.
        pair: (P, 2) leaves that may meet.
        gap: (P,) m between them; what is parted does not cross.
        crossing: (N, 6) to be written: ends of the edge, third corner of its triangle, corners of the other one.

    Returns:
        Their number; only so many as there is room for are listed.
    """
    count = 0
    for m in range(pair.shape[0]):
        if gap[m] > 0.0:
            continue
        a, b = pair[m, 0], pair[m, 1]
        for t in range(leaf_start[a], leaf_start[a + 1]):
            for u in range(t + 1 if a == b else leaf_start[b], leaf_start[b + 1]):
                if not (on_both_sides(x, t, u, triangles, face) and on_both_sides(x, u, t, triangles, face)):
                    continue
                for turn in range(2):
                    one, other = (t, u) if turn == 0 else (u, t)
                    d, e, f = triangles[other, 0], triangles[other, 1], triangles[other, 2]
                    for k in range(3):
                        p, q, r = triangles[one, k], triangles[one, (k + 1) % 3], triangles[one, (k + 2) % 3]
                        if p == d or p == e or p == f or q == d or q == e or q == f:
                            continue
                        if runs_through(x, p, q, d, e, f):
                            if count < crossing.shape[0]:
                                for n, v in enumerate((p, q, r, d, e, f)):
                                    crossing[count, n] = v
                            count += 1
    return count


@kernel
def way_out(x, crossing, inverse_mass, farthest, tangled, way, weight):
    """Move what crosses so that the line of crossing gets shorter, ``farthest`` m at most; ``x`` (V, 3) m in place.

    An edge E through a triangle of normal N ends two segments of the line, or one at a border, of directions R into its
    own triangles. Moved by d, its piercing point goes d - (N.d) / (N.E) E, so that the line shortens fastest along the
    sum of R - (E.R) / (N.E) N. ``tangled`` (V,) is set where something crosses; ``way`` (V, 3) and ``weight`` (V,) are
    room for sums.
    """
    tangled[:] = False
    way[:] = 0.0
    weight[:] = 0.0
    for c in range(crossing.shape[0]):
        p, q, o = crossing[c, 0], crossing[c, 1], crossing[c, 2]
        i, j, k = crossing[c, 3], crossing[c, 4], crossing[c, 5]
        for n in range(6):
            tangled[crossing[c, n]] = True
        nx, ny, nz = triangle_normal(x, i, j, k)
        mx, my, mz = triangle_normal(x, p, q, o)
        ex, ey, ez = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
        length = math.sqrt(ex * ex + ey * ey + ez * ez)
        rx, ry, rz = ny * mz - nz * my, nz * mx - nx * mz, nx * my - ny * mx
        sine = math.sqrt(rx * rx + ry * ry + rz * rz)
        if length == 0.0 or sine == 0.0:
            continue
        ex, ey, ez = ex / length, ey / length, ez / length
        inward = (x[o, 0] - x[p, 0]) * rx + (x[o, 1] - x[p, 1]) * ry + (x[o, 2] - x[p, 2]) * rz
        inward -= ((x[o, 0] - x[p, 0]) * ex + (x[o, 1] - x[p, 1]) * ey + (x[o, 2] - x[p, 2]) * ez) * (
            ex * rx + ey * ry + ez * rz
        )
        share = math.copysign(1.0 / sine, inward)
        rx, ry, rz = rx * share, ry * share, rz * share
        across = ex * nx + ey * ny + ez * nz
        if abs(across) < 0.1:
            across = math.copysign(0.1, across)
        lean = (ex * rx + ey * ry + ez * rz) / across
        gx, gy, gz = rx - lean * nx, ry - lean * ny, rz - lean * nz
        for n in range(6):
            v = crossing[c, n]
            side = 0.0 if n == 2 or inverse_mass[v] == 0.0 else 1.0 if n < 2 else -1.0
            way[v, 0] += side * gx
            way[v, 1] += side * gy
            way[v, 2] += side * gz
            weight[v] += abs(side)
    for v in range(x.shape[0]):
        size = math.sqrt(way[v, 0] ** 2 + way[v, 1] ** 2 + way[v, 2] ** 2)
        if size > 0.0:
            # Where segments balance, on a line that is nearly straight, what is left of them still tells the way.
            go = farthest / math.sqrt(size * size + 0.25 * weight[v] * weight[v])
            for a in range(3):
                x[v, a] += go * way[v, a]
