"""What of a cloth is worth a closer look at a distance field: a few questions, most of which say no."""

from __future__ import annotations

import math

from cloth_core.kernels import part_kernel
from cloth_core.kernels.bodies import into_frame, out_of_frame
from cloth_core.kernels.bricks import HIGH, LOW
from cloth_core.kernels.fields import field_distance

TIP = 0.1
"""Volume between the normals at the corners of a triangle from which a tip may be below it."""


@part_kernel
def misses(real, f, rotation, origin, low, high, near):
    """Whether the box from ``low`` to ``high`` (3,) is more than ``near`` m from the upright box around a field."""
    for a in range(3):
        middle, half = origin[a], 0.0
        for b in range(3):
            middle += rotation[a, b] * 0.5 * (real[f, LOW + b] + real[f, HIGH + b])
            half += abs(rotation[a, b]) * 0.5 * (real[f, HIGH + b] - real[f, LOW + b])
        if low[a] - (middle + half) > near or (middle - half) - high[a] > near:
            return True
    return False


@part_kernel
def between_vertices(
    real, whole, coarse, occupied, brick, node, fine, split, plane, f, rotation, origin,
    start, i, j, distance, normal, spacing, touch,
):  # fmt: skip
    """What an edge meets between two vertices, in m.

    Between two samples the surface is taken to bend outwards: then distances lie above the tangents at both. What
    cannot be nearer than one and a half times ``touch`` is not looked at.

    Returns:
        How near the surface comes at the least; how much nearer than the vertices' own distances, evened out along the
        edge, have it; the same where it is nearer than ``touch``.
    """
    x, y, z = into_frame(rotation, origin, start[i, 0], start[i, 1], start[i, 2])
    ex, ey, ez = into_frame(rotation, origin, start[j, 0], start[j, 1], start[j, 2])
    ex, ey, ez = ex - x, ey - y, ez - z
    length = math.sqrt(ex * ex + ey * ey + ez * ez)
    parts = max(1, math.ceil(length / spacing))
    here, least, sag, sag_there = distance[i], math.inf, 0.0, 0.0
    falls = (ex * normal[i, 0] + ey * normal[i, 1] + ez * normal[i, 2]) / parts
    for s in range(1, parts + 1):
        share = s / parts
        if 0.5 * (here + distance[j] - (1.0 - share + 1.0 / parts) * length) >= 1.5 * touch:  # all that is left of it
            break
        there, nx, ny, nz = distance[j], normal[j, 0], normal[j, 1], normal[j, 2]
        if s < parts:
            there, nx, ny, nz = field_distance(
                real, whole, coarse, occupied, brick, node, fine, split, plane, f,
                x + share * ex, y + share * ey, z + share * ez,
            )  # fmt: skip
        rises = (ex * nx + ey * ny + ez * nz) / parts
        lowest, at = there, share
        if falls < 0.0 < rises:
            ahead = (here - there + rises) / (rises - falls)
            lowest, at = here + falls * ahead, share + (ahead - 1.0) / parts
        below = distance[i] + at * (distance[j] - distance[i]) - lowest
        least, sag = min(least, lowest), max(sag, below)
        if lowest < touch:
            sag_there = max(sag_there, below)
        here, falls = there, rises
    return least, sag, sag_there


@part_kernel
def may_meet_tip(start, rotation, i, j, k, distance, normal, touch, fast, band):
    """Whether the surface is so curved below a triangle, both ways, that it may touch there first.

    A slow one must also come nearer than ``touch`` m in its middle, as the tangents at its corners have it; of a fast
    one, normals farther than ``band`` m from the surface are too coarse to tell.
    """
    if fast and max(distance[i], distance[j], distance[k]) > band:
        return True
    x = normal[j, 1] * normal[k, 2] - normal[j, 2] * normal[k, 1]
    y = normal[j, 2] * normal[k, 0] - normal[j, 0] * normal[k, 2]
    z = normal[j, 0] * normal[k, 1] - normal[j, 1] * normal[k, 0]
    if abs(normal[i, 0] * x + normal[i, 1] * y + normal[i, 2] * z) <= TIP:
        return False
    highest = -math.inf
    for v in (i, j, k):
        x = (start[i, 0] + start[j, 0] + start[k, 0]) / 3.0 - start[v, 0]
        y = (start[i, 1] + start[j, 1] + start[k, 1]) / 3.0 - start[v, 1]
        z = (start[i, 2] + start[j, 2] + start[k, 2]) / 3.0 - start[v, 2]
        nx, ny, nz = out_of_frame(rotation, normal[v, 0], normal[v, 1], normal[v, 2])
        highest = max(highest, distance[v] + x * nx + y * ny + z * nz)
    return fast or highest < touch
