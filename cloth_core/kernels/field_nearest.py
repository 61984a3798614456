"""The nearest point of a vertex, an edge or a triangle to the surface of a distance field.

A field is no convex shape: along an edge its distance may fall and rise again. But what a field shows is not much
smaller than its voxels. So edges and triangles are sampled no more than a voxel apart, and from the lowest sample one
goes on downhill. What lies between the samples is lower by half their distance at the most: distances change by no more
than the way.

Of edges and triangles what counts is their inside. Their border has its own turn.
"""

from __future__ import annotations

import math

from cloth_core.kernels import part_kernel
from cloth_core.kernels.fields import field_distance

DOWNHILL = 4
"""Looks at the field on the way downhill, two on a straight line."""
LEVEL = 1e-3
"""m of fall per m of way, less than which is no slope."""


@part_kernel
def nearest_in_field(
    real, whole, coarse, occupied, brick, node, fine, split, plane, f, corner, corners, spacing, weight
):  # fmt: skip
    """Signed distance in m and unit normal at the nearest point of the ``corners`` (1 to 3) in ``corner`` (3, 3) m.

    All in the frame of field ``f``; samples are ``spacing`` m apart at the most. Which point it is, goes to ``weight``
    (3,). Last comes what other points may be nearer by at the most, m.
    """
    side = _longest_side(corner, corners)
    parts = max(1, math.ceil(side / spacing))
    apart, first = side / parts, 0.0 if corners < 3 else 1.0 / 3.0
    least, one, two, nx, ny, nz = math.inf, 0.0, 0.0, 0.0, 0.0, 1.0
    for j in range(parts if corners == 3 else 1):
        for i in range(1 if corners == 1 else parts + 1 if corners == 2 else parts - j):
            u, v = (first + i) / parts, (first + j) / parts if corners == 3 else 0.0
            x, y, z = _point(corner, corners, u, v)
            d, dx, dy, dz = field_distance(real, whole, coarse, occupied, brick, node, fine, split, plane, f, x, y, z)
            if d < least:
                least, one, two, nx, ny, nz = d, u, v, dx, dy, dz
    if corners > 1:
        least, one, two, nx, ny, nz = _downhill(
            real, whole, coarse, occupied, brick, node, fine, split, plane, f, corner, corners, 0.5 * apart,
            least, one, two, nx, ny, nz,
        )  # fmt: skip
    weight[0], weight[1], weight[2] = 1.0 - one - two, one, two
    return least, nx, ny, nz, (0.0, 0.5 * apart, apart)[corners - 1]


@part_kernel
def _downhill(
    real, whole, coarse, occupied, brick, node, fine, split, plane, f, corner, corners, step,
    least, one, two, nx, ny, nz,
):  # fmt: skip
    """From a point with the shares ``one`` and ``two`` of the second and third corner on; what is found, and where.

    Along the steepest line one looks ``step`` m ahead, and if the way rises there, where the two slopes would meet.
    Then the next line begins at the lowest point so far.
    """
    from_one, from_two, du, dv, fall, ahead, rising = one, two, 0.0, 0.0, 0.0, 0.0, False
    begin = least
    for _ in range(DOWNHILL):
        if not rising:
            du, dv, fall = _steepest(corner, corners, nx, ny, nz)
            from_one, from_two, begin = one, two, least
            ahead = min(step, _way_to_border(one, two, du, dv))
            if fall < LEVEL or ahead <= 0.0:
                break
        u, v = from_one + ahead * du, from_two + ahead * dv
        x, y, z = _point(corner, corners, u, v)
        d, dx, dy, dz = field_distance(real, whole, coarse, occupied, brick, node, fine, split, plane, f, x, y, z)
        if d < least:
            least, one, two, nx, ny, nz = d, u, v, dx, dy, dz
        if rising:
            rising, step = False, 0.5 * step
            continue
        climb = _along(corner, corners, du, dv, dx, dy, dz)
        rising = climb > 0.0
        if rising:
            ahead *= min(max((begin - d + climb * ahead) / ((climb + fall) * ahead), 0.0), 1.0)
        elif d >= begin:
            step *= 0.5
    return least, one, two, nx, ny, nz


@part_kernel
def _point(corner, corners, u, v):
    """The shares ``u`` and ``v`` of the way from the first corner to the second and the third."""
    x, y, z = corner[0, 0], corner[0, 1], corner[0, 2]
    if corners > 1:
        x, y, z = x + u * (corner[1, 0] - x), y + u * (corner[1, 1] - y), z + u * (corner[1, 2] - z)
    if corners > 2:
        x += v * (corner[2, 0] - corner[0, 0])
        y += v * (corner[2, 1] - corner[0, 1])
        z += v * (corner[2, 2] - corner[0, 2])
    return x, y, z


@part_kernel
def _side(corner, n):
    """From the first corner to corner ``n``."""
    return corner[n, 0] - corner[0, 0], corner[n, 1] - corner[0, 1], corner[n, 2] - corner[0, 2]


@part_kernel
def _along(corner, corners, u, v, nx, ny, nz):
    """What a gradient is worth along the shares ``u`` and ``v``."""
    x, y, z = _side(corner, 1)
    along = u * (x * nx + y * ny + z * nz)
    if corners == 3:
        x, y, z = _side(corner, 2)
        along += v * (x * nx + y * ny + z * nz)
    return along


@part_kernel
def _steepest(corner, corners, nx, ny, nz):
    """The direction of steepest fall, in shares per m of way, and the fall in m per m."""
    x, y, z = _side(corner, 1)
    uu, slope = x * x + y * y + z * z, x * nx + y * ny + z * nz
    du, dv, fall = -slope / uu, 0.0, 0.0
    if corners == 3:
        a, b, c = _side(corner, 2)
        vv, uv, other = a * a + b * b + c * c, a * x + b * y + c * z, a * nx + b * ny + c * nz
        area = uu * vv - uv * uv
        du, dv = (uv * other - vv * slope) / area, (uv * slope - uu * other) / area
        fall = math.sqrt(max(0.0, -(du * slope + dv * other)))
    else:
        fall = abs(slope) / math.sqrt(uu)
    if not 0.0 < fall < 2.0:  # nothing falls, or the corners are in a line
        return 0.0, 0.0, 0.0
    return du / fall, dv / fall, fall


@part_kernel
def _way_to_border(one, two, du, dv):
    """m from a point to where a share becomes zero."""
    way = math.inf
    if du < 0.0:
        way = min(way, one / -du)
    if dv < 0.0:
        way = min(way, two / -dv)
    if du + dv > 0.0:
        way = min(way, (1.0 - one - two) / (du + dv))
    return way


@part_kernel
def _longest_side(corner, corners):
    """m; of a vertex, 0."""
    square = 0.0
    for n in range(corners):
        for m in range(n):
            x, y, z = corner[n, 0] - corner[m, 0], corner[n, 1] - corner[m, 1], corner[n, 2] - corner[m, 2]
            square = max(square, x * x + y * y + z * z)
    return math.sqrt(square)
