"""Contacts of the cloth with obstacles: push-out, friction and impact.

What touches is a point of the cloth: a vertex, or a point of an edge or of a triangle, which moves with its corners.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cloth_core.kernels import inlined_kernel, kernel
from cloth_core.kernels.bodies import Bodies, distance_in_world, into_frame, out_of_frame, surface_displacement

LEAST_PUSH = 1e-9
"""m; what is less is rounding: a point that others have brought to the shell does not touch on its own account."""


class Points(NamedTuple):
    """P points of the cloth that may touch an obstacle within the substep at hand."""

    corners: np.ndarray
    """(P,) 1, 2 or 3: a vertex, a point of an edge, a point of a triangle."""
    corner: np.ndarray
    """(P, 3) the vertices it moves with; the first ``corners`` count."""
    weight: np.ndarray
    """(P, 3) the share of each."""
    yields: np.ndarray
    """(P,) 1/kg, weight^2 / mass over the corners; held ones do not yield."""
    body: np.ndarray
    """(P,) the obstacle."""
    depth: np.ndarray
    """(P,) m below the shell that the point may still have afterwards."""
    plane: np.ndarray
    """(P, 4) in the obstacle's frame, unit normal and offset in m: what a fast point may not cross, whatever is
    behind it. A normal of zero: the obstacle's own surface counts."""
    left: np.ndarray
    """(P, 3) m, where the last sweep left the point; NaN for nowhere."""
    pushed: np.ndarray
    """(P,) m, by the sweeps so far."""
    spent: np.ndarray
    """(P,) m, what friction took back so far."""
    normal: np.ndarray
    """(P, 3) of the obstacle, in the world, when the point was looked at last."""
    gap: np.ndarray
    """(P,) m above the shell, with what ``depth`` allows, where that left the point."""
    shift: np.ndarray
    """(P, 3) m, by which pushes, friction and impact have moved the point so far."""


@inlined_kernel
def where(position, corners, corner, weight, p):
    """Point ``p``: x, y and z in m."""
    v = corner[p, 0]
    w = 1.0 if corners[p] == 1 else weight[p, 0]
    x, y, z = w * position[v, 0], w * position[v, 1], w * position[v, 2]
    for n in range(1, corners[p]):
        v, w = corner[p, n], weight[p, n]
        x, y, z = x + w * position[v, 0], y + w * position[v, 1], z + w * position[v, 2]
    return x, y, z


@inlined_kernel
def move(position, corners, corner, weight, yields, p, inverse_mass, x, y, z):
    """Move point ``p`` by x, y and z, its corners by as little as that takes."""
    for n in range(corners[p]):
        v = corner[p, n]
        share = 1.0 if corners[p] == 1 else weight[p, n] * inverse_mass[v] / yields[p]
        position[v, 0] += share * x
        position[v, 1] += share * y
        position[v, 2] += share * z


@inlined_kernel
def add(vectors, p, x, y, z):
    """Add x, y and z to the first three numbers of row ``p``."""
    vectors[p, 0] += x
    vectors[p, 1] += y
    vectors[p, 2] += z


@inlined_kernel
def push(position, corners, corner, weight, yields, p, inverse_mass, way, nx, ny, nz, pushed, shift):
    """Push point ``p`` by ``way`` m along a unit normal, and write down that it was."""
    move(position, corners, corner, weight, yields, p, inverse_mass, way * nx, way * ny, way * nz)
    pushed[p] += way
    add(shift, p, way * nx, way * ny, way * nz)


@inlined_kernel
def is_at(left, p, x, y, z):
    """Whether point ``p`` is still where it was ``left``: a sweep moves few of those that touch."""
    return x == left[p, 0] and y == left[p, 1] and z == left[p, 2]


@inlined_kernel
def gap(kind, size, rotation, origin, plane, x, y, z):
    """Distance in m of the point at x, y, z from what it may not cross, and the unit normal, in the world."""
    nx, ny, nz = plane[0], plane[1], plane[2]
    if nx == 0.0 and ny == 0.0 and nz == 0.0:
        return distance_in_world(kind, size, rotation, origin, x, y, z)
    x, y, z = into_frame(rotation, origin, x, y, z)
    distance = nx * x + ny * y + nz * z - plane[3]
    nx, ny, nz = out_of_frame(rotation, nx, ny, nz)
    return distance, nx, ny, nz


# Kernels take the arrays out of their tuples before the loop, and pass single ones on: a tuple that is handed to
# another function costs a count of references for each of its arrays.


@kernel
def push_out(position, bodies: Bodies, points: Points, count, inverse_mass, shell):
    """Bring points that are too deep back to the shell (eq. 6, with the exact normal).

    The first ``count`` of the ``points``, but for those that are where they were left. Adds up ``pushed``, stores
    ``normal`` and ``gap``. Returns the largest distance pushed, m.
    """
    corners, corner, weight, yields = points.corners, points.corner, points.weight, points.yields
    body, depth, plane, left = points.body, points.depth, points.plane, points.left
    pushed, normal, shift, above = points.pushed, points.normal, points.shift, points.gap
    kind, size, rotation, origin = bodies.kind, bodies.size, bodies.rotation, bodies.origin
    most = 0.0
    for p in range(count):
        x, y, z = where(position, corners, corner, weight, p)
        if is_at(left, p, x, y, z):
            continue
        o = body[p]
        distance, nx, ny, nz = gap(kind[o], size[o], rotation[o], origin[o], plane[p], x, y, z)
        way = shell - depth[p] - distance
        above[p] = max(0.0, -way)
        normal[p, 0], normal[p, 1], normal[p, 2] = nx, ny, nz
        if way > LEAST_PUSH:
            push(position, corners, corner, weight, yields, p, inverse_mass, way, nx, ny, nz, pushed, shift)
            most = max(most, way)
    return most


@kernel
def apply_friction(start, position, bodies: Bodies, points: Points, count, inverse_mass):
    """Coulomb: take back the tangential way relative to the surface, friction * ``pushed`` in all at most.

    In displacements, not velocities: there it would creep. Adds up ``spent``, and notes in ``left`` where it leaves
    the points.
    """
    corners, corner, weight, yields = points.corners, points.corner, points.weight, points.yields
    body, left, pushed, spent, normal = points.body, points.left, points.pushed, points.spent, points.normal
    shift = points.shift
    origin, origin_before, turn, friction = bodies.origin, bodies.origin_before, bodies.turn, bodies.friction
    for p in range(count):
        x, y, z = where(position, corners, corner, weight, p)
        if is_at(left, p, x, y, z):
            continue
        if pushed[p] > 0.0:
            o = body[p]
            fx, fy, fz = where(start, corners, corner, weight, p)
            sx, sy, sz = surface_displacement(x, y, z, origin[o], origin_before[o], turn[o])
            wx, wy, wz = x - fx - sx, y - fy - sy, z - fz - sz
            nx, ny, nz = normal[p, 0], normal[p, 1], normal[p, 2]
            along = wx * nx + wy * ny + wz * nz
            wx, wy, wz = wx - along * nx, wy - along * ny, wz - along * nz
            way = math.sqrt(wx * wx + wy * wy + wz * wz)
            most = max(0.0, friction[o] * pushed[p] - spent[p])
            if way > 0.0 and most > 0.0:
                taken = min(way, most)
                share = taken / way
                spent[p] += taken
                move(position, corners, corner, weight, yields, p, inverse_mass, -share * wx, -share * wy, -share * wz)
                add(shift, p, -share * wx, -share * wy, -share * wz)
                x, y, z = where(position, corners, corner, weight, p)
        left[p, 0], left[p, 1], left[p, 2] = x, y, z


@kernel
def contact_velocity(
    velocity, velocity_before, position, h, bodies: Bodies, points: Points, count, inverse_mass, restitution, rest_speed
):
    """Set the normal velocity of touched points: the surface's own, plus what an impact gives back.

    A push-out is a correction of position, not an impulse: left in the velocity it would shoot the cloth
    away. Impacts slower than ``rest_speed`` m/s do not bounce.
    """
    corners, corner, weight, yields = points.corners, points.corner, points.weight, points.yields
    body, pushed, normal, shift = points.body, points.pushed, points.normal, points.shift
    origin, origin_before, turn = bodies.origin, bodies.origin_before, bodies.turn
    for p in range(count):
        if pushed[p] <= 0.0:
            continue
        o = body[p]
        x, y, z = where(position, corners, corner, weight, p)
        sx, sy, sz = surface_displacement(x, y, z, origin[o], origin_before[o], turn[o])
        nx, ny, nz = normal[p, 0], normal[p, 1], normal[p, 2]
        surface = (sx * nx + sy * ny + sz * nz) / h
        vx, vy, vz = where(velocity, corners, corner, weight, p)
        bx, by, bz = where(velocity_before, corners, corner, weight, p)
        now = vx * nx + vy * ny + vz * nz - surface
        before = bx * nx + by * ny + bz * nz - surface
        wanted = -restitution * before if before < -rest_speed else 0.0
        change = wanted - now
        move(velocity, corners, corner, weight, yields, p, inverse_mass, change * nx, change * ny, change * nz)
        add(shift, p, h * change * nx, h * change * ny, h * change * nz)
