"""Push-out from obstacles that are distance fields; as :func:`cloth_core.kernels.contact.push_out`."""

from __future__ import annotations

from cloth_core.kernels import kernel
from cloth_core.kernels.bodies import Bodies, into_frame, out_of_frame
from cloth_core.kernels.contact import LEAST_PUSH, Points, is_at, move, where
from cloth_core.kernels.fields import field_distance


@kernel
def push_out_of_fields(
    position, bodies: Bodies, first_body, real, whole, coarse, occupied, brick, node, fine, split, plane,
    points: Points, begin, end, inverse_mass, shell,
):  # fmt: skip
    """Bring points that are too deep back to the shell: those from ``begin`` up to ``end``, which touch fields.

    The fields are the bodies from ``first_body`` on. Returns the largest distance pushed, m.
    """
    corners, corner, weight, yields = points.corners, points.corner, points.weight, points.yields
    body, depth, wall, left = points.body, points.depth, points.plane, points.left
    pushed, normal = points.pushed, points.normal
    rotation, origin = bodies.rotation, bodies.origin
    most = 0.0
    for p in range(begin, end):
        x, y, z = where(position, corners, corner, weight, p)
        if is_at(left, p, x, y, z):
            continue
        o = body[p]
        x, y, z = into_frame(rotation[o], origin[o], x, y, z)
        nx, ny, nz = wall[p, 0], wall[p, 1], wall[p, 2]
        if nx == 0.0 and ny == 0.0 and nz == 0.0:
            distance, nx, ny, nz = field_distance(
                real, whole, coarse, occupied, brick, node, fine, split, plane, o - first_body, x, y, z
            )
        else:
            distance = nx * x + ny * y + nz * z - wall[p, 3]
        way = shell - depth[p] - distance
        if way > LEAST_PUSH:
            nx, ny, nz = out_of_frame(rotation[o], nx, ny, nz)
            normal[p, 0], normal[p, 1], normal[p, 2] = nx, ny, nz
            move(position, corners, corner, weight, yields, p, inverse_mass, way * nx, way * ny, way * nz)
            pushed[p] += way
            most = max(most, way)
    return most
