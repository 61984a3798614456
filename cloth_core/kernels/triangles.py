"""One point and one triangle: the closest point of it, and the solid angle that it fills."""

from __future__ import annotations

import math

from cloth_core.kernels import kernel

FACE, EDGE_AB, EDGE_BC, EDGE_CA, CORNER_A, CORNER_B, CORNER_C = range(7)
"""The part of a triangle that a closest point lies on."""


@kernel
def closest_point(corner, x, y, z):
    """Closest point of the triangle ``corner`` (3, 3) to a point, and the part of it that it lies on.

    By the Voronoi regions of the triangle's parts (Ericson, Real-Time Collision Detection, 5.1.5); the triangle
    must have an area.
    """
    ax, ay, az = corner[0, 0], corner[0, 1], corner[0, 2]
    ux, uy, uz = corner[1, 0] - ax, corner[1, 1] - ay, corner[1, 2] - az
    wx, wy, wz = corner[2, 0] - ax, corner[2, 1] - ay, corner[2, 2] - az
    px, py, pz = x - ax, y - ay, z - az
    d1, d2 = ux * px + uy * py + uz * pz, wx * px + wy * py + wz * pz
    if d1 <= 0.0 and d2 <= 0.0:
        return ax, ay, az, CORNER_A
    uu, uw, ww = ux * ux + uy * uy + uz * uz, ux * wx + uy * wy + uz * wz, wx * wx + wy * wy + wz * wz
    d3, d4 = d1 - uu, d2 - uw
    if d3 >= 0.0 and d4 <= d3:
        return corner[1, 0], corner[1, 1], corner[1, 2], CORNER_B
    d5, d6 = d1 - uw, d2 - ww
    if d6 >= 0.0 and d5 <= d6:
        return corner[2, 0], corner[2, 1], corner[2, 2], CORNER_C
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        t = d1 / uu
        return ax + t * ux, ay + t * uy, az + t * uz, EDGE_AB
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        t = d2 / ww
        return ax + t * wx, ay + t * wy, az + t * wz, EDGE_CA
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 >= d3 and d5 >= d6:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        bx, by, bz = corner[1, 0], corner[1, 1], corner[1, 2]
        return bx + t * (wx - ux), by + t * (wy - uy), bz + t * (wz - uz), EDGE_BC
    t, s = vb / (va + vb + vc), vc / (va + vb + vc)
    return ax + t * ux + s * wx, ay + t * uy + s * wy, az + t * uz + s * wz, FACE


@kernel
def solid_angle(corner, x, y, z):
    """Solid angle in sr of the triangle ``corner`` (3, 3) seen from a point, positive from behind.

    Van Oosterom and Strackee, "The solid angle of a plane triangle", 1983.
    """
    ax, ay, az = corner[0, 0] - x, corner[0, 1] - y, corner[0, 2] - z
    bx, by, bz = corner[1, 0] - x, corner[1, 1] - y, corner[1, 2] - z
    cx, cy, cz = corner[2, 0] - x, corner[2, 1] - y, corner[2, 2] - z
    a = math.sqrt(ax * ax + ay * ay + az * az)
    b = math.sqrt(bx * bx + by * by + bz * bz)
    c = math.sqrt(cx * cx + cy * cy + cz * cz)
    volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    ab, bc, ca = ax * bx + ay * by + az * bz, bx * cx + by * cy + bz * cz, cx * ax + cy * ay + cz * az
    return 2.0 * math.atan2(volume, a * b * c + ab * c + bc * a + ca * b)
