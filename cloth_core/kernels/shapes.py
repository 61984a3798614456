"""Signed distances of the analytic shapes, each in a frame of its own."""

from __future__ import annotations

import math

from cloth_core.kernels import kernel

PLANE, SPHERE, BOX, CAPSULE, ELLIPSOID = range(5)


@kernel
def ellipsoid_distance(x, y, z, rx, ry, rz):
    """Signed distance to an ellipsoid of semi-axes ``rx, ry, rz``, and the outward normal.

    The closest point solves one equation in one unknown, here by Newton on its convex branch (after
    Eberly, "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid").
    """
    small = min(rx, min(ry, rz))
    square = small * small
    # On a plane of symmetry inside there is no unique answer; a nudge chooses one.
    tiny = 1e-9 * small
    ax, ay, az = max(abs(x), tiny), max(abs(y), tiny), max(abs(z), tiny)
    qx, qy, qz = rx * rx / square - 1.0, ry * ry / square - 1.0, rz * rz / square - 1.0
    gx, gy, gz = rx * ax / square, ry * ay / square, rz * az / square
    s = 0.0
    if qx == 0.0:
        s = gx
    if qy == 0.0:
        s = max(s, gy)
    if qz == 0.0:
        s = max(s, gz)
    # Convex and falling from here on: Newton climbs to the root from below and cannot overshoot.
    for _ in range(64):
        ux, uy, uz = gx / (s + qx), gy / (s + qy), gz / (s + qz)
        excess = ux * ux + uy * uy + uz * uz - 1.0
        if excess < 1e-14:
            break
        s += 0.5 * excess / (ux * ux / (s + qx) + uy * uy / (s + qy) + uz * uz / (s + qz))
    cx, cy, cz = (qx + 1.0) * ax / (s + qx), (qy + 1.0) * ay / (s + qy), (qz + 1.0) * az / (s + qz)
    gap = math.sqrt((ax - cx) ** 2 + (ay - cy) ** 2 + (az - cz) ** 2)
    nx, ny, nz = cx / (rx * rx), cy / (ry * ry), cz / (rz * rz)
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    outside = (x / rx) ** 2 + (y / ry) ** 2 + (z / rz) ** 2 > 1.0
    return (
        gap if outside else -gap,
        math.copysign(nx / length, x),
        math.copysign(ny / length, y),
        math.copysign(nz / length, z),
    )


@kernel
def box_distance(x, y, z, hx, hy, hz):
    """Signed distance to a box of half edges ``hx, hy, hz``, and the direction out of it."""
    ox, oy, oz = abs(x) - hx, abs(y) - hy, abs(z) - hz
    if ox <= 0.0 and oy <= 0.0 and oz <= 0.0:
        if ox >= oy and ox >= oz:
            return ox, math.copysign(1.0, x), 0.0, 0.0
        if oy >= oz:
            return oy, 0.0, math.copysign(1.0, y), 0.0
        return oz, 0.0, 0.0, math.copysign(1.0, z)
    ox, oy, oz = max(ox, 0.0), max(oy, 0.0), max(oz, 0.0)
    distance = math.sqrt(ox * ox + oy * oy + oz * oz)
    return (
        distance,
        math.copysign(ox / distance, x),
        math.copysign(oy / distance, y),
        math.copysign(oz / distance, z),
    )


@kernel
def signed_distance(kind, size, x, y, z):
    """Signed distance in m of a point in the obstacle's frame, negative inside, and the outward unit normal."""
    if kind == PLANE:
        return z, 0.0, 0.0, 1.0
    if kind == BOX:
        return box_distance(x, y, z, size[0], size[1], size[2])
    if kind == ELLIPSOID:
        return ellipsoid_distance(x, y, z, size[0], size[1], size[2])
    if kind == CAPSULE:
        z -= min(max(z, -size[1]), size[1])
    length = math.sqrt(x * x + y * y + z * z)
    if length > 0.0:
        return length - size[0], x / length, y / length, z / length
    return -size[0], 1.0, 0.0, 0.0
