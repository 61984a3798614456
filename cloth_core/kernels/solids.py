"""Exact signed distance to solids: closed surfaces of triangles and analytic shapes, and to the union of several.

Here ``surfaces`` is the tuple of arrays (corner (T, 3, 3) m, normal (T, 7, 3), hidden (T,), first, last, child, box,
dipole, root (S,), by_winding (S,)): the trees of :mod:`cloth_core.kernels.tree` one after the other, one root for
each surface. ``shapes`` is the tuple (kind (K,), size (K, 3), rotation (K, 3, 3), origin (K, 3)) of the contact
kernels.
"""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import kernel
from cloth_core.kernels.contact import distance_in_world
from cloth_core.kernels.tree import closest, square_to_box, winding_number


@kernel
def surface_distance(surfaces, s, x, y, z, limit):
    """Signed distance in m to surface ``s``, closest point and normal there; ``limit`` if nothing is as near.

    The side is that of the angle-weighted pseudonormal at the closest point (Baerentzen and Aanaes, "Signed distance
    computation using the angle weighted pseudonormal", 2005). Where that is zero (next to a triangle without area,
    or where surfaces touch in an edge) or edge on, and everywhere on a surface that passes through itself
    (``by_winding``), the winding number decides.
    """
    corner, normal, hidden, first, last, child, box, dipole, root, by_winding = surfaces
    cx, cy, cz, t, part = closest(corner, hidden, first, last, child, box, root[s], x, y, z, limit)
    if t < 0:
        return limit, x, y, z, 0.0, 0.0, 0.0
    nx, ny, nz = normal[t, part, 0], normal[t, part, 1], normal[t, part, 2]
    dx, dy, dz = x - cx, y - cy, z - cz
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    side = dx * nx + dy * ny + dz * nz
    if distance > 0.0 and (by_winding[s] or abs(side) <= 1e-6 * distance):
        side = 0.5 - winding_number(corner, first, last, child, dipole, root[s], x, y, z)
    if nx == 0.0 and ny == 0.0 and nz == 0.0:
        nx, ny, nz = normal[t, 0, 0], normal[t, 0, 1], normal[t, 0, 2]
    return math.copysign(distance, side), cx, cy, cz, nx, ny, nz


@kernel
def solid_distance(surfaces, shapes, x, y, z):
    """Signed distance in m to the union of all solids, closest point and outward normal there.

    The least of the distances to each: exact outside, and inside wherever solids do not overlap; where they do, the
    surface is no nearer.
    """
    kind, size, rotation, origin = shapes
    least = np.inf
    cx, cy, cz, nx, ny, nz = x, y, z, 0.0, 0.0, 1.0
    for k in range(kind.shape[0]):
        distance, ux, uy, uz = distance_in_world(kind[k], size[k], rotation[k], origin[k], x, y, z)
        if distance < least:
            least, nx, ny, nz = distance, ux, uy, uz
            cx, cy, cz = x - distance * ux, y - distance * uy, z - distance * uz
    for s in range(surfaces[8].shape[0]):
        gap = math.sqrt(square_to_box(surfaces[6][surfaces[8][s]], x, y, z))
        if gap > 0.0 and gap >= least:
            continue
        limit = least if gap > 0.0 else np.inf
        distance, qx, qy, qz, ux, uy, uz = surface_distance(surfaces, s, x, y, z, limit)
        if distance < least:
            least, cx, cy, cz, nx, ny, nz = distance, qx, qy, qz, ux, uy, uz
    return least, cx, cy, cz, nx, ny, nz


@kernel
def solid_distances(surfaces, shapes, points, distance, closest_point, normal):
    """As :func:`solid_distance` for points (N, 3); fills ``distance`` (N,), ``closest_point`` and ``normal`` (N, 3)."""
    for p in range(points.shape[0]):
        d, cx, cy, cz, nx, ny, nz = solid_distance(surfaces, shapes, points[p, 0], points[p, 1], points[p, 2])
        distance[p] = d
        closest_point[p, 0], closest_point[p, 1], closest_point[p, 2] = cx, cy, cz
        normal[p, 0], normal[p, 1], normal[p, 2] = nx, ny, nz


@kernel
def buried(surfaces, inside):
    """Mark in ``inside`` (T,) the triangles whose outer side is inside their own surface: it passes through itself."""
    corner, normal, _, first, last, child, _, dipole, root, _ = surfaces
    for t in range(corner.shape[0]):
        # The closer, the less another sheet can be between; the solid angle of the triangle itself is exact.
        step = 1e-5 * math.sqrt(np.linalg.norm(np.cross(corner[t, 1] - corner[t, 0], corner[t, 2] - corner[t, 0])))
        x = (corner[t, 0, 0] + corner[t, 1, 0] + corner[t, 2, 0]) / 3.0 + step * normal[t, 0, 0]
        y = (corner[t, 0, 1] + corner[t, 1, 1] + corner[t, 2, 1]) / 3.0 + step * normal[t, 0, 1]
        z = (corner[t, 0, 2] + corner[t, 1, 2] + corner[t, 2, 2]) / 3.0 + step * normal[t, 0, 2]
        inside[t] = winding_number(corner, first, last, child, dipole, root[0], x, y, z) > 0.5
