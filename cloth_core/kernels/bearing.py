"""Obstacles bear the cloth: forces on the points that touch, spread over the cloth along its threads.

A force is in kg m: over the mass of a free vertex, the way in m by which it moves that in the substep.
"""

from __future__ import annotations

import math

from numba import prange

from cloth_core.kernels import inlined_kernel, kernel, shared_kernel
from cloth_core.kernels.along import SOFT, joined
from cloth_core.kernels.bodies import Bodies, surface_displacement
from cloth_core.kernels.contact import Points, add, move, where
from cloth_core.kernels.tensors import projection, times


@inlined_kernel
def find_hardness_of(v, position, stiffness, begins, neighbour, hard):
    """Row ``v`` of :func:`find_hardness`."""
    a = b = c = d = e = f = 0.0
    weight = stiffness[v] / max(begins[v + 1] - begins[v], 1)
    for k in range(begins[v], begins[v + 1]):
        u = neighbour[k]
        x, y, z = position[u, 0] - position[v, 0], position[u, 1] - position[v, 1], position[u, 2] - position[v, 2]
        square = x * x + y * y + z * z
        share = weight / square if square > 0.0 else 0.0
        a, d, f = a + share * x * x, d + share * y * y, f + share * z * z
        b, c, e = b + share * x * y, c + share * x * z, e + share * y * z
    hard[v, 0], hard[v, 1], hard[v, 2], hard[v, 3], hard[v, 4], hard[v, 5] = projection((a, b, c, d, e, f), SOFT)


@shared_kernel
def find_hardness(position, stiffness, begins, neighbour, hard):
    """What of a push of each vertex its threads bear, rather than its inertia alone: a projection, smoothed.

    Args:
        position: (V, 3) m.
        stiffness: (V,) of the threads of a vertex, beside its inertia.
        begins: (V + 1,) where the neighbours of each vertex begin in ``neighbour``.
        neighbour: along the threads.
        hard: (V, 6) symmetric tensors, upper half row by row; overwritten.
    """
    for v in prange(position.shape[0]):
        find_hardness_of(v, position, stiffness, begins, neighbour, hard)


@kernel
def keep_in(start, end, bodies: Bodies, points: Points, count, inverse_mass):
    """Take back in ``end`` (V, 3) m what pushes brought points farther out than they were at the ``start`` (V, 3) m.

    To come out of an obstacle is no motion that threads or inertia should know of: sweeps bring out what is in.
    """
    corners, corner, weight, yields = points.corners, points.corner, points.weight, points.yields
    body, normal, pushed, shift = points.body, points.normal, points.pushed, points.shift
    origin, origin_before, turn = bodies.origin, bodies.origin_before, bodies.turn
    for p in range(count):
        if pushed[p] <= 0.0:
            continue
        o = body[p]
        x, y, z = where(end, corners, corner, weight, p)
        fx, fy, fz = where(start, corners, corner, weight, p)
        sx, sy, sz = surface_displacement(x, y, z, origin[o], origin_before[o], turn[o])
        nx, ny, nz = normal[p, 0], normal[p, 1], normal[p, 2]
        back = min(pushed[p], (x - fx - sx) * nx + (y - fy - sy) * ny + (z - fz - sz) * nz)
        if back > 0.0:
            pushed[p] -= back
            move(end, corners, corner, weight, yields, p, inverse_mass, -back * nx, -back * ny, -back * nz)
            add(shift, p, -back * nx, -back * ny, -back * nz)


@kernel
def find_lack(
    start, met, end, bodies: Bodies, points: Points, count, negligible, stiffness, begins, neighbour, hard, lack
):  # fmt: skip
    """What points lack at the ``end`` to be where obstacles and perfect friction want them, into ``lack`` (P, 3) m.

    Args:
        start: (V, 3) m, where the substep began.
        met: (V, 3) m, where the points were looked at, and pushed to: the surface is there, or ``gap`` away.
        end: (V, 3) m, where threads have led from there.
        bodies: the obstacles.
        points: what may touch.
        count: the first so many points.
        negligible: m, what points may lack along their normal.
        stiffness: as ``begins``, ``neighbour`` and ``hard`` see :func:`find_hardness`; rows of points that lack more
            are found here.
        begins: see there.
        neighbour: see there.
        hard: see there.
        lack: overwritten.

    Returns:
        m, the most that one lacks along its normal which threads bear.
    """
    corners, corner, weight, body, normal = points.corners, points.corner, points.weight, points.body, points.normal
    gap, origin, origin_before, turn = points.gap, bodies.origin, bodies.origin_before, bodies.turn
    most = 0.0
    for p in range(count):
        o = body[p]
        x, y, z = where(end, corners, corner, weight, p)
        mx, my, mz = where(met, corners, corner, weight, p)
        nx, ny, nz = normal[p, 0], normal[p, 1], normal[p, 2]
        fx, fy, fz = where(start, corners, corner, weight, p)
        sx, sy, sz = surface_displacement(x, y, z, origin[o], origin_before[o], turn[o])
        way = (mx - x) * nx + (my - y) * ny + (mz - z) * nz - gap[p]
        wx, wy, wz = x - fx - sx, y - fy - sy, z - fz - sz
        # Along the normal it lacks the way out, across it the way that it slid.
        along = way + wx * nx + wy * ny + wz * nz
        lack[p, 0], lack[p, 1], lack[p, 2] = along * nx - wx, along * ny - wy, along * nz - wz
        if way > negligible:
            share = 0.0
            for n in range(corners[p]):
                v = corner[p, n]
                find_hardness_of(v, end, stiffness, begins, neighbour, hard)
                x, y, z = times(hard, v, nx, ny, nz)
                share += (1.0 if corners[p] == 1 else weight[p, n]) * math.sqrt(x * x + y * y + z * z)
            most = max(most, share * way)
    return most


@inlined_kernel
def within_friction(x, y, z, nx, ny, nz, friction):
    """What an obstacle can give of a vector: no draught along its normal, and across it what Coulomb allows."""
    press = x * nx + y * ny + z * nz
    x, y, z = x - press * nx, y - press * ny, z - press * nz
    press = max(press, 0.0)
    across, most = math.sqrt(x * x + y * y + z * z), friction * press
    share = 1.0 if across <= most else most / across
    return press * nx + share * x, press * ny + share * y, press * nz + share * z


@kernel
def ask(points: Points, count, friction, inverse_mass, hard, heavy, lack, force, total, kept):
    """The ``force`` (P, 3) that would bring each point alone to what it lacks, if an obstacle can give that.

    Args:
        points: what may touch.
        count: the first so many points.
        friction: (O,) of the obstacles.
        inverse_mass: (V,) 1/kg.
        hard: (V, 6), see :func:`find_hardness`.
        heavy: how many times its mass a vertex seems to have that is pushed along its threads.
        lack: (P, 3) m.
        force: overwritten.
        total: (V, 3) what it comes to on the vertices; overwritten.
        kept: (V, 3) of that, what threads bear; overwritten.
    """
    corners, corner, weight, body, normal = points.corners, points.corner, points.weight, points.body, points.normal
    total[:] = kept[:] = 0.0
    for p in range(count):
        nx, ny, nz = normal[p, 0], normal[p, 1], normal[p, 2]
        gives = 0.0
        if lack[p, 0] * nx + lack[p, 1] * ny + lack[p, 2] * nz > 0.0:
            for n in range(corners[p]):
                v = corner[p, n]
                w = 1.0 if corners[p] == 1 else weight[p, n]
                x, y, z = times(hard, v, nx, ny, nz)
                along = x * x + y * y + z * z
                across = (nx - x) * (nx - x) + (ny - y) * (ny - y) + (nz - z) * (nz - z)
                gives += w * w * inverse_mass[v] * (along / heavy + across)
        if gives == 0.0:
            force[p, 0] = force[p, 1] = force[p, 2] = 0.0
            continue
        x, y, z = within_friction(
            lack[p, 0] / gives, lack[p, 1] / gives, lack[p, 2] / gives, nx, ny, nz, friction[body[p]]
        )
        force[p, 0], force[p, 1], force[p, 2] = x, y, z
        for n in range(corners[p]):
            w = 1.0 if corners[p] == 1 else weight[p, n]
            add(total, corner[p, n], w * x, w * y, w * z)
    for p in range(count):
        for n in range(corners[p]):
            v = corner[p, n]
            kept[v, 0], kept[v, 1], kept[v, 2] = times(hard, v, total[v, 0], total[v, 1], total[v, 2])


@kernel
def give(points: Points, count, inverse_mass, hard, total, lack, force, moved, end):
    """Move the ``end`` (V, 3) m by as much of the ``force`` (P, 3) as is best, and write down that obstacles did.

    Of what W has ``moved`` (V, 3) m by what threads bear of it, that counts which goes along threads; across them the
    ``total`` (V, 3) meets inertia alone. ``moved`` becomes by how much the cloth has moved. Best is what brings points
    to what they ``lack`` (P, 3) m with the least effort.
    """
    corners, corner, weight, yields = points.corners, points.corner, points.weight, points.yields
    pushed, spent, normal, shift = points.pushed, points.spent, points.normal, points.shift
    for v in range(total.shape[0]):
        moved[v, 0], moved[v, 1], moved[v, 2] = joined(
            hard, v, (moved[v, 0], moved[v, 1], moved[v, 2]), (total[v, 0], total[v, 1], total[v, 2]), inverse_mass[v]
        )
    won = effort = 0.0
    for p in range(count):
        x, y, z = where(moved, corners, corner, weight, p)
        fx, fy, fz = force[p, 0], force[p, 1], force[p, 2]
        won += fx * lack[p, 0] + fy * lack[p, 1] + fz * lack[p, 2]
        effort += fx * x + fy * y + fz * z
    share = won / effort if won > 0.0 and effort > 0.0 else 0.0
    for v in range(end.shape[0]):
        moved[v, 0], moved[v, 1], moved[v, 2] = share * moved[v, 0], share * moved[v, 1], share * moved[v, 2]
        add(end, v, moved[v, 0], moved[v, 1], moved[v, 2])
    for p in range(count):
        given = share * (inverse_mass[corner[p, 0]] if corners[p] == 1 else yields[p])
        fx, fy, fz = given * force[p, 0], given * force[p, 1], given * force[p, 2]
        press = fx * normal[p, 0] + fy * normal[p, 1] + fz * normal[p, 2]
        pushed[p] += press
        spent[p] += math.sqrt(max(fx * fx + fy * fy + fz * fz - press * press, 0.0))
        add(shift, p, fx, fy, fz)
