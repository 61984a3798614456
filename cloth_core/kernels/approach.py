"""Which points of the cloth may touch an obstacle within a substep: vertices, and where they are too few, others.

Between vertices a cloth meets what is sharp or thin: the edge of a table, a rod, the tip of a needle. And what is fast
may have passed a thin obstacle at the end of a substep. So the nearest points of edges and triangles are looked for,
too, and the way of what is fast is followed to where it first touches (conservative advancement; Mirtich 1996,
"Impulse-based dynamic simulation of rigid body systems"), in the frame of the obstacle, where only the cloth moves.
"""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from cloth_core.kernels import inlined_kernel, kernel, shared_kernel
from cloth_core.kernels.bodies import Bodies, into_frame
from cloth_core.kernels.contact import Points
from cloth_core.kernels.nearest import nearest, slopes_inwards
from cloth_core.kernels.shapes import BOX, CAPSULE, PLANE, signed_distance

FINEST_STEP = 0.25
"""Of the shell, the least step on the way of what touches already, but moves away there."""
MOST_STEPS = 256
SAME_SIDE = 0.5
"""Cosine between the normals of one side."""
INSIDE = 0.02
"""Shares of an edge or a triangle that are less belong to its border, which is looked at for itself."""


@shared_kernel
def find_points(
    start, predicted, edge, triangle, longest_edge, free, inverse_mass, bodies: Bodies, sharp, thin, swift, flat,
    shell, recover, points: Points, way, distance, normal,
):  # fmt: skip
    """List the ``points`` that may touch while the vertices go from ``start`` to about ``predicted`` (V, 3) m.

    A point counts if it comes within the shell on its way, with the obstacle's own added. Its ``depth`` is what may
    be left of it below the shell: what was already inside comes out by ``recover`` m and no faster, so that nothing is
    shot away. ``edge`` (E, 2), no longer than ``longest_edge`` m, and ``triangle`` (T, 3) are looked at for the
    obstacles that are ``sharp`` (O,) alone. Those that are ``thin`` (O,) are passed by what is pushed a little. What
    moves by more than ``swift`` (O,) m may pass an obstacle, and is followed to where it first touches. Slower edges
    and triangles need no look if the normals at their ends have a cosine above ``flat`` (2,).

    Returns how many there are, which may be more than there is room for: then the rest is missing.
    ``way`` (V,), ``distance`` (V,) and ``normal`` (V, 3) are room to work in.
    """
    vertices = start.shape[0]
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    longest = 0.0
    for v in range(vertices):
        x, y, z = predicted[v, 0] - start[v, 0], predicted[v, 1] - start[v, 1], predicted[v, 2] - start[v, 2]
        way[v] = math.sqrt(x * x + y * y + z * z)
        longest = max(longest, way[v])
        for a in range(3):
            low[a], high[a] = min(low[a], start[v, a]), max(high[a], start[v, a])
    count = 0
    begin, end, weight = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    corners, corner, body, depth = points.corners, points.corner, points.body, points.depth
    plane, left, pushed, spent = points.plane, points.left, points.pushed, points.spent
    for o in range(bodies.kind.shape[0]):
        bound = bodies.reach[o] + 2.0 * shell + longest + bodies.travel[o]
        if box_distance_to(low, high, bodies.origin_before[o]) > bound:
            continue
        beyond = 2.0 * shell + bodies.travel[o] + (longest_edge if sharp[o] else 0.0)
        kind, size, reach = bodies.kind[o], bodies.size[o], bodies.reach[o]
        rotation, origin, travel = bodies.rotation_before[o], bodies.origin_before[o], bodies.travel[o]
        for v in prange(vertices):
            survey(start, v, kind, size, rotation, origin, reach, beyond + way[v], sharp[o], distance, normal)
        for v in range(vertices):
            moves = way[v] + travel
            if free[v] and distance[v] < 2.0 * shell + moves:
                if moves > swift[o]:
                    i = np.uint32(v)  # as edges name it, so that one kernel does for all
                    count = add_point(
                        start, predicted, i, i, i, 1, bodies, o, thin[o], moves > swift[o], moves, shell, recover,
                        inverse_mass, points, count, begin, end, weight,
                    )  # fmt: skip
                else:
                    count = add_vertex(
                        v, o, distance[v], shell, recover,
                        corners, corner, body, depth, plane, left, pushed, spent, count,
                    )  # fmt: skip
        if not sharp[o]:
            continue
        for e in range(edge.shape[0]):
            i, j = edge[e, 0], edge[e, 1]
            moves = max(way[i], way[j]) + travel
            if (
                0.5 * (distance[i] + distance[j] - longest_edge) < 2.0 * shell + moves
                and (free[i] or free[j])
                and (moves > swift[o] or cosine(normal, i, j) < flat[0])
            ):
                count = add_point(
                    start, predicted, i, j, j, 2, bodies, o, thin[o], moves > swift[o], moves, shell, recover,
                    inverse_mass, points, count, begin, end, weight,
                )  # fmt: skip
        for t in range(triangle.shape[0]):
            i, j, k = triangle[t, 0], triangle[t, 1], triangle[t, 2]
            moves = max(way[i], way[j], way[k]) + travel
            if (
                (distance[i] + distance[j] + distance[k]) / 3.0 - longest_edge < 2.0 * shell + moves
                and (free[i] or free[j] or free[k])
                and (moves > swift[o] or min(cosine(normal, i, j), cosine(normal, i, k)) < flat[1])
            ):
                count = add_point(
                    start, predicted, i, j, k, 3, bodies, o, thin[o], moves > swift[o], moves, shell, recover,
                    inverse_mass, points, count, begin, end, weight,
                )  # fmt: skip
    return count


@kernel
def box_distance_to(low, high, center):
    """Distance in m of a point from the box between two corners; zero inside."""
    square = 0.0
    for a in range(3):
        off = max(low[a] - center[a], center[a] - high[a], 0.0)
        square += off * off
    return math.sqrt(square)


@inlined_kernel
def survey(start, v, kind, size, rotation, origin, reach, near, sharp, distance, normal):
    """Distance of vertex ``v``; farther than ``near``, a bound. If ``sharp``, its normal in that frame, too."""
    x, y, z = start[v, 0] - origin[0], start[v, 1] - origin[1], start[v, 2] - origin[2]
    nx = ny = nz = 0.0
    away = math.sqrt(x * x + y * y + z * z) - reach
    if away <= near:
        x, y, z = (
            rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z,
            rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z,
            rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z,
        )
        if kind == PLANE:
            away, nz = z, 1.0
        else:
            away, nx, ny, nz = signed_distance(kind, size, x, y, z)
    distance[v] = away
    if sharp:
        normal[v, 0], normal[v, 1], normal[v, 2] = nx, ny, nz


@kernel
def cosine(normal, i, j):
    """Of the angle by which the surface bends from one vertex to another; 0 where one is too far away to know."""
    return normal[i, 0] * normal[j, 0] + normal[i, 1] * normal[j, 1] + normal[i, 2] * normal[j, 2]


@inlined_kernel
def add_vertex(v, o, distance, shell, recover, corners, corner, body, depth, plane, left, pushed, spent, p):
    """List a vertex that is too slow to pass anything; returns the number of the next point."""
    if p < body.shape[0]:
        corners[p], corner[p, 0], body[p] = 1, v, o
        pushed[p] = spent[p] = 0.0
        depth[p] = max(0.0, shell - distance - recover)
        plane[p, 0] = plane[p, 1] = plane[p, 2] = 0.0
        left[p, 0] = np.nan
    return p + 1


@kernel
def add_point(
    start, predicted, i, j, k, corners, bodies, o, thin, follow, moves, shell, recover,
    inverse_mass, points, p, begin, end, weight
):  # fmt: skip
    """Look at the nearest point of a vertex, an edge or a triangle, and list it as number ``p`` if it may touch.

    ``follow`` says that it ``moves``, by as many m, enough to pass the obstacle: then it is followed to where it first
    touches. Returns the number of the next one.
    """
    chosen = (i, j, k)
    for n in range(corners):
        v = chosen[n]
        begin[n, 0], begin[n, 1], begin[n, 2] = into_frame(
            bodies.rotation_before[o], bodies.origin_before[o], start[v, 0], start[v, 1], start[v, 2]
        )
        end[n, 0], end[n, 1], end[n, 2] = into_frame(
            bodies.rotation[o], bodies.origin[o], predicted[v, 0], predicted[v, 1], predicted[v, 2]
        )
    kind, size = bodies.kind[o], bodies.size[o]
    if corners == 3 and not (meets_tip(kind, size, begin) or meets_tip(kind, size, end)):
        return p
    distance, nx, ny, nz = nearest(kind, size, begin, corners, weight)
    outside, stopped = distance > 0.0, False
    if follow and outside:
        stopped, there, nx, ny, nz = first_touch(kind, size, begin, end, corners, shell, weight)
        distance = there if stopped else distance
    if corners > 1:
        if not stopped and (distance > 2.0 * shell + moves or (follow and outside)):
            return p
        for n in range(corners):
            if weight[n] < INSIDE:
                return p
    if p < points.body.shape[0]:
        points.corners[p], points.body[p] = corners, o
        points.yields[p] = points.pushed[p] = points.spent[p] = 0.0
        offset = -distance
        for n in range(corners):
            v, w = chosen[n], weight[n]
            points.corner[p, n], points.weight[p, n] = v, w
            points.yields[p] += w * w * inverse_mass[v]
            offset += w * (nx * begin[n, 0] + ny * begin[n, 1] + nz * begin[n, 2])
        points.depth[p] = max(0.0, shell - distance - recover)
        points.plane[p] = 0.0
        if stopped and (thin or passes(kind, size, end, corners, weight, nx, ny, nz)):
            points.plane[p, 0], points.plane[p, 1], points.plane[p, 2], points.plane[p, 3] = nx, ny, nz, offset
        points.left[p, 0] = np.nan
    return p + 1


@kernel
def meets_tip(kind, size, corner):
    """Whether a triangle may be nearest to a tip of the shape: else an edge of it touches first."""
    if kind == BOX:
        for a in range(3):
            if max(abs(corner[0, a]), abs(corner[1, a]), abs(corner[2, a])) < size[a]:
                return False
    if kind == CAPSULE:
        return max(abs(corner[0, 2]), abs(corner[1, 2]), abs(corner[2, 2])) > size[1]
    return True


@kernel
def passes(kind, size, end, corners, weight, nx, ny, nz):
    """Whether a point that came from the side of a normal would be put out on another one at the ``end`` of its way.

    Else the surface itself is what it may not cross: the plane that it first touches would catch what slides off.
    """
    x = y = z = 0.0
    for n in range(corners):
        x, y, z = x + weight[n] * end[n, 0], y + weight[n] * end[n, 1], z + weight[n] * end[n, 2]
    _, ex, ey, ez = signed_distance(kind, size, x, y, z)
    return nx * ex + ny * ey + nz * ez < SAME_SIDE


@kernel
def first_touch(kind, size, begin, end, corners, shell, weight):
    """Follow corners from ``begin`` to ``end`` (3, 3) m until their nearest point comes within the shell.

    Returns:
        Whether it does, and moves inwards there; its distance in m and the normal. ``begin`` becomes where the corners
        are then, ``weight`` (3,) which point it is.
    """
    most = 0.0
    for n in range(corners):
        square = 0.0
        for a in range(3):
            square += (end[n, a] - begin[n, a]) ** 2
        most = max(most, math.sqrt(square))
    done = 0.0
    distance, nx, ny, nz = nearest(kind, size, begin, corners, weight)
    for _ in range(MOST_STEPS):
        if distance <= shell * 1.001 and slopes_inwards(begin, end, corners, weight, nx, ny, nz):
            return True, distance, nx, ny, nz
        step = max(distance - shell, FINEST_STEP * shell) / most
        if done + step >= 1.0:
            break
        for n in range(corners):
            for a in range(3):
                begin[n, a] += (end[n, a] - begin[n, a]) * step / (1.0 - done)
        done += step
        distance, nx, ny, nz = nearest(kind, size, begin, corners, weight)
    return False, distance, nx, ny, nz
