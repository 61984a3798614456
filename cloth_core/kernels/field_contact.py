"""Push-out from obstacles that are distance fields; as :func:`cloth_core.kernels.contact.push_out`."""

from __future__ import annotations

from cloth_core.kernels import kernel
from cloth_core.kernels.bodies import Bodies, into_frame, out_of_frame
from cloth_core.kernels.contact import LEAST_PUSH, Points, is_at, push, where
from cloth_core.kernels.fields import field_distance

SEEN = 0.02
"""Of the shell: a point that has moved by less since the field was asked is where its tangent plane says. Sweeps move
points by less and less; that saves nine questions in ten, and no sweep corrects what another voxel's slope says."""


@kernel
def _ask(
    rotation, origin, first_body, real, whole, coarse, occupied, brick, node, fine, split, plane, o, wall, x, y, z, seen
):
    """Ask the field of body ``o``, or the ``wall`` (4,) that a fast point may not cross, for the place x, y, z."""
    seen[0], seen[1], seen[2] = x, y, z
    x, y, z = into_frame(rotation[o], origin[o], x, y, z)
    nx, ny, nz = wall[0], wall[1], wall[2]
    if nx == 0.0 and ny == 0.0 and nz == 0.0:
        seen[3], nx, ny, nz = field_distance(
            real, whole, coarse, occupied, brick, node, fine, split, plane, o - first_body, x, y, z
        )
    else:
        seen[3] = nx * x + ny * y + nz * z - wall[3]
    seen[4], seen[5], seen[6] = out_of_frame(rotation[o], nx, ny, nz)


@kernel
def push_out_of_fields(
    position, bodies: Bodies, first_body, real, whole, coarse, occupied, brick, node, fine, split, plane,
    points: Points, begin, end, inverse_mass, shell, seen,
):  # fmt: skip
    """Bring points that are too deep back to the shell: those from ``begin`` up to ``end``, which touch fields.

    The fields are the bodies from ``first_body`` on. ``seen`` (P, 7) holds what was last asked of each point: where it
    was, its distance in m and the normal; NaN for nothing. Returns the largest distance pushed, m.
    """
    corners, corner, weight, yields = points.corners, points.corner, points.weight, points.yields
    body, depth, wall, left = points.body, points.depth, points.plane, points.left
    pushed, normal, shift, above = points.pushed, points.normal, points.shift, points.gap
    rotation, origin = bodies.rotation, bodies.origin
    most, little = 0.0, (SEEN * shell) ** 2
    for p in range(begin, end):
        x, y, z = where(position, corners, corner, weight, p)
        if is_at(left, p, x, y, z):
            continue
        dx, dy, dz = x - seen[p, 0], y - seen[p, 1], z - seen[p, 2]
        if not dx * dx + dy * dy + dz * dz < little:
            dx = dy = dz = 0.0
            _ask(
                rotation, origin, first_body, real, whole, coarse, occupied, brick, node, fine, split, plane,
                body[p], wall[p], x, y, z, seen[p],
            )  # fmt: skip
        nx, ny, nz = seen[p, 4], seen[p, 5], seen[p, 6]
        distance = seen[p, 3] + nx * dx + ny * dy + nz * dz
        way = shell - depth[p] - distance
        above[p] = max(0.0, -way)
        normal[p, 0], normal[p, 1], normal[p, 2] = nx, ny, nz
        if way > LEAST_PUSH:
            push(position, corners, corner, weight, yields, p, inverse_mass, way, nx, ny, nz, pushed, shift)
            most = max(most, way)
    return most
