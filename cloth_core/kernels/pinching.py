"""What two fingers have between them."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import kernel
from cloth_core.kernels.bodies import distance_in_world

OPPOSED = -0.5
"""Cosine between the normals of two fingers that press against each other."""


@kernel
def squeeze(place, kind, size, rotation, origin, reach, near, gap, shift):
    """How close two fingers (2, ...) come to each other at each ``place`` (K, 3) m.

    ``gap`` (K,) receives the m between them at places within ``near`` m of both, and infinity elsewhere; ``shift``
    (K, 3) the way in m that leads to the middle.
    """
    for k in range(place.shape[0]):
        x, y, z = place[k, 0], place[k, 1], place[k, 2]
        gap[k] = np.inf
        shift[k, 0] = shift[k, 1] = shift[k, 2] = 0.0
        dx, dy, dz = x - origin[0, 0], y - origin[0, 1], z - origin[0, 2]
        if dx * dx + dy * dy + dz * dz > (reach[0] + near) ** 2:
            continue
        one, ax, ay, az = distance_in_world(kind[0], size[0], rotation[0], origin[0], x, y, z)
        other, bx, by, bz = distance_in_world(kind[1], size[1], rotation[1], origin[1], x, y, z)
        if one > near or other > near or ax * bx + ay * by + az * bz > OPPOSED:
            continue
        gap[k] = one + other
        way = 0.5 * (other - one)
        shift[k, 0], shift[k, 1], shift[k, 2] = way * ax, way * ay, way * az
