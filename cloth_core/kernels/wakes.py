"""Shelter behind obstacles: rays against the wind through their signed distances."""

from __future__ import annotations

import math

from cloth_core.kernels import kernel
from cloth_core.kernels.bodies import Bodies, distance_in_world

SHELTERED, ENDED = 1.5, 6.0
"""Widths of the obstacle behind it: to where no air moves past it, and from where on it is as if there were none."""
SPREAD = 0.09
"""Growth of the shadow's edge, m per m downwind."""
STEPS, FINEST = 128, 0.01
"""A ray's most steps, and its shortest one, as a share of the obstacle's width."""


@kernel
def smooth(share):
    """From 0 to 1 as ``share`` does, level at both ends; it is cut there."""
    share = min(max(share, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


@kernel
def least_width(rotation, half, ex, ey, ez):
    """Least width in m of a box of ``half`` edges (3,) m, turned by ``rotation`` and seen along (ex, ey, ez).

    What is seen is a hexagon, and a convex polygon is narrowest across one of its sides, which are edges of the box.
    """
    least = math.inf
    for a in range(3):
        ux, uy, uz = rotation[0, a], rotation[1, a], rotation[2, a]
        x, y, z = ey * uz - ez * uy, ez * ux - ex * uz, ex * uy - ey * ux  # across the edge, in the picture
        length = math.sqrt(x * x + y * y + z * z)
        if length > 1e-9:
            extent = 0.0
            for b in range(3):
                extent += half[b] * abs(x * rotation[0, b] + y * rotation[1, b] + z * rotation[2, b])
            least = min(least, 2.0 * extent / length)
    return least


@kernel
def depth_of(rotation, half, ex, ey, ez):
    """How far a box of ``half`` edges (3,) m, turned by ``rotation``, reaches from its middle along (ex, ey, ez), m."""
    depth = 0.0
    for a in range(3):
        depth += half[a] * abs(ex * rotation[0, a] + ey * rotation[1, a] + ez * rotation[2, a])
    return depth


@kernel
def hidden(kind, size, rotation, origin, ex, ey, ez, x, y, z, first, last, finest):
    """How much of a point an obstacle hides from the wind that comes along the unit vector (ex, ey, ez), 0 .. 1.

    A ray goes upwind from the point, from ``first`` to ``last`` m, by steps as long as the surface is away. Where it
    meets the surface all is hidden; where it passes by, the closest pass says, measured by the width that the shadow's
    edge has grown to on the way (as soft shadows of distance fields do).
    """
    closest, t = 1.0, first
    for _ in range(STEPS):
        distance, _, _, _ = distance_in_world(kind, size, rotation, origin, x - t * ex, y - t * ey, z - t * ez)
        if distance <= 0.0:
            return 1.0
        edge = SPREAD * t
        closest = min(closest, distance / edge) if edge > 0.0 else closest
        if t > last or distance > (last - t) + SPREAD * last:  # nothing that counts comes closer any more
            break
        t += max(distance if distance > 2.0 * edge else 0.5 * distance, finest)
    return smooth(1.0 - closest)


@kernel
def misses(along, aside, radius, reach, depth, width):
    """Whether a ball of ``radius`` m lies outside the wake of an obstacle.

    Its middle is ``along`` m downwind and ``aside`` m beside the obstacle's origin. A point is a ball of radius 0.
    """
    last = along + radius + reach
    return last <= 0.0 or along - radius - depth >= ENDED * width or aside - radius > reach + SPREAD * last


@kernel
def ball_about(position):
    """Middle and radius in m of a ball that holds all of ``position`` (V, 3) m, not the least one."""
    x, y, z = 0.0, 0.0, 0.0
    for v in range(position.shape[0]):
        x, y, z = x + position[v, 0], y + position[v, 1], z + position[v, 2]
    x, y, z = x / position.shape[0], y / position.shape[0], z / position.shape[0]
    square = 0.0
    for v in range(position.shape[0]):
        square = max(square, (position[v, 0] - x) ** 2 + (position[v, 1] - y) ** 2 + (position[v, 2] - z) ** 2)
    return x, y, z, math.sqrt(square)


@kernel
def shelter(position, bodies: Bodies, half, drift, mean, flow):
    """Bring the ``flow`` (V, 3) m/s behind each obstacle to the obstacle's own velocity ``drift`` (O, 3) m/s, in place.

    ``half`` (O, 3) m are the half edges of a box about it, infinite where it is to be left out. Wakes point along the
    ``mean`` (3,) m/s of the wind, relative to the obstacle.
    """
    mx, my, mz, radius = ball_about(position)
    for o in range(half.shape[0]):
        ux, uy, uz = drift[o, 0], drift[o, 1], drift[o, 2]
        ex, ey, ez = mean[0] - ux, mean[1] - uy, mean[2] - uz
        speed = math.sqrt(ex * ex + ey * ey + ez * ez)
        if speed == 0.0 or half[o, 0] == math.inf:
            continue
        ex, ey, ez = ex / speed, ey / speed, ez / speed
        kind, size, reach = bodies.kind[o], bodies.size[o], bodies.reach[o]
        rotation, origin = bodies.rotation[o], bodies.origin[o]
        width, depth = least_width(rotation, half[o], ex, ey, ez), depth_of(rotation, half[o], ex, ey, ez)
        ox, oy, oz = origin[0], origin[1], origin[2]
        px, py, pz = mx - ox, my - oy, mz - oz
        along = px * ex + py * ey + pz * ez
        aside = math.sqrt(max(px * px + py * py + pz * pz - along * along, 0.0))
        if misses(along, aside, radius, reach, depth, width):
            continue
        for v in range(position.shape[0]):
            x, y, z = position[v, 0], position[v, 1], position[v, 2]
            px, py, pz = x - ox, y - oy, z - oz
            along = px * ex + py * ey + pz * ez
            aside = math.sqrt(max(px * px + py * py + pz * pz - along * along, 0.0))
            if misses(along, aside, 0.0, reach, depth, width):
                continue
            first, last = max(along - reach, 0.0), along + reach
            share = hidden(kind, size, rotation, origin, ex, ey, ez, x, y, z, first, last, FINEST * width)
            if share > 0.0:
                share *= smooth((ENDED - (along - depth) / width) / (ENDED - SHELTERED))
                flow[v, 0] += share * (ux - flow[v, 0])
                flow[v, 1] += share * (uy - flow[v, 1])
                flow[v, 2] += share * (uz - flow[v, 2])
