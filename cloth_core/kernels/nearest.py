"""The nearest point of a vertex, an edge or a triangle to an obstacle.

Along a straight line the distance from a convex shape is convex, so the nearest point is where it stops falling:
found by halving, and by a straight line through the last two slopes. That makes it depend on its corners without jumps:
what touched at a point of a coarse series would be nearest there again, and rounding would choose its neighbours.

Of a triangle it is the nearest of the nearest points of lines that are parallel to an edge.
"""

from __future__ import annotations

from cloth_core.kernels import kernel
from cloth_core.kernels.shapes import signed_distance

HALVINGS = 6


@kernel
def nearest(kind, size, corner, corners, weight):
    """Signed distance in m and unit normal at the nearest point of the ``corners`` (1 to 3) in ``corner`` (3, 3) m.

    All in the frame of the obstacle. Which point it is, goes to ``weight`` (3,).
    """
    if corners == 1:
        weight[0] = 1.0
        return signed_distance(kind, size, corner[0, 0], corner[0, 1], corner[0, 2])
    if corners == 2:
        return nearest_of_line(kind, size, corner, 0.0, weight)
    return nearest_of_triangle(kind, size, corner, weight)


@kernel
def nearest_of_line(kind, size, corner, lifted, weight):
    """The same for the line between the first two corners, ``lifted`` by that share towards the third."""
    dx, dy, dz = corner[1, 0] - corner[0, 0], corner[1, 1] - corner[0, 1], corner[1, 2] - corner[0, 2]
    distance, nx, ny, nz = _at(kind, size, corner, 0.0, lifted, weight)
    falls = nx * dx + ny * dy + nz * dz
    if falls >= 0.0:
        return distance, nx, ny, nz
    distance, nx, ny, nz = _at(kind, size, corner, 1.0, lifted, weight)
    rises = nx * dx + ny * dy + nz * dz
    if rises <= 0.0:
        return distance, nx, ny, nz
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        distance, nx, ny, nz = _at(kind, size, corner, middle, lifted, weight)
        slope = nx * dx + ny * dy + nz * dz
        if slope < 0.0:
            low, falls = middle, slope
        else:
            high, rises = middle, slope
    return _at(kind, size, corner, low + (high - low) * falls / (falls - rises), lifted, weight)


@kernel
def nearest_of_triangle(kind, size, corner, weight):
    """The same for a triangle."""
    distance, nx, ny, nz = nearest_of_line(kind, size, corner, 0.0, weight)
    falls = _slope(corner, weight, nx, ny, nz)
    if falls >= 0.0:
        return distance, nx, ny, nz
    low, high, rises = 0.0, 1.0, 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        distance, nx, ny, nz = nearest_of_line(kind, size, corner, middle, weight)
        slope = _slope(corner, weight, nx, ny, nz)
        if slope < 0.0:
            low, falls = middle, slope
        else:
            high, rises = middle, slope
    if high == 1.0:
        return distance, nx, ny, nz
    return nearest_of_line(kind, size, corner, low + (high - low) * falls / (falls - rises), weight)


@kernel
def slopes_inwards(begin, end, corners, weight, nx, ny, nz):
    """Whether the point of ``weight`` moves against the normal on its way from ``begin`` to ``end`` (3, 3) m."""
    along = 0.0
    for n in range(corners):
        along += weight[n] * (
            nx * (end[n, 0] - begin[n, 0]) + ny * (end[n, 1] - begin[n, 1]) + nz * (end[n, 2] - begin[n, 2])
        )
    return along < 0.0


@kernel
def _at(kind, size, corner, share, lifted, weight):
    weight[0], weight[1], weight[2] = (1.0 - share) * (1.0 - lifted), share * (1.0 - lifted), lifted
    x = y = z = 0.0
    for n in range(3 if lifted > 0.0 else 2):
        w = weight[n]
        x, y, z = x + w * corner[n, 0], y + w * corner[n, 1], z + w * corner[n, 2]
    return signed_distance(kind, size, x, y, z)


@kernel
def _slope(corner, weight, nx, ny, nz):
    """How the distance changes from the point of ``weight`` towards the third corner, m per way."""
    along = 0.0
    for a, n in enumerate((nx, ny, nz)):
        here = weight[0] * corner[0, a] + weight[1] * corner[1, a] + weight[2] * corner[2, a]
        along += n * (corner[2, a] - here)
    return along
