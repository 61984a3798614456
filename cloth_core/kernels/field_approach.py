"""Which points of the cloth may touch an obstacle that is a distance field; as :mod:`cloth_core.kernels.approach`.

What differs is what is known: distances near the surface and lower bounds elsewhere, of a shape that may be hollow. So
edges are sampled, and taken to bend outwards between two samples alone; and what is fast is followed by what its
nearest sample allows.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import prange

from cloth_core.kernels import kernel, shared_kernel
from cloth_core.kernels.approach import FINEST_STEP, INSIDE, MOST_STEPS, SAME_SIDE, add_vertex
from cloth_core.kernels.bodies import Bodies, into_frame
from cloth_core.kernels.bricks import BAND, VOXEL, beyond_box
from cloth_core.kernels.contact import Points
from cloth_core.kernels.field_gates import between_vertices, may_meet_tip, misses
from cloth_core.kernels.field_nearest import nearest_in_field
from cloth_core.kernels.fields import field_distance
from cloth_core.kernels.nearest import slopes_inwards


class Course(NamedTuple):
    """What came to pass since the step began, so that edges which hardly move are looked at once in a step."""

    last: np.ndarray
    """(V, 3) m, where the last substep began; NaN before the first."""
    passed: np.ndarray
    """(V,) m, the ways of the vertices."""
    gone: np.ndarray
    """(F,) m, the farthest that any point of each field went."""
    clear: np.ndarray
    """(F, E) m, the way up to which nothing can touch between the ends of an edge; of edges not looked at, -1."""
    fresh: np.ndarray
    """(F,) whether no edge was looked at."""
    near: np.ndarray
    """(E,) room to work in: which edges are to be followed."""


ROUND = 0.1
"""Of the shell, how far a field may stick into it between vertices that rest on it."""


@shared_kernel
def find_field_points(
    start, predicted, edge, triangle, longest_edge, free, inverse_mass, bodies: Bodies, first,
    real, whole, coarse, occupied, brick, node, fine, split, plane, between, shell, recover,
    points: Points, count, way, distance, normal, course: Course,
):  # fmt: skip
    """Add to the first ``count`` of the ``points`` those that may touch a field: a body from the ``first`` on.

    Without ``between`` they are vertices alone. ``course`` goes on from substep to substep; for all else see
    :func:`~cloth_core.kernels.approach.find_points`.

    Returns how many points there are, which may be more than there is room for: then the rest is missing.
    """
    vertices = start.shape[0]
    last, passed, gone = course.last, course.passed, course.gone
    clear, fresh, near = course.clear, course.fresh, course.near
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    longest = 0.0
    for v in range(vertices):
        x, y, z = predicted[v, 0] - start[v, 0], predicted[v, 1] - start[v, 1], predicted[v, 2] - start[v, 2]
        way[v] = math.sqrt(x * x + y * y + z * z)
        longest = max(longest, way[v])
        x, y, z = start[v, 0] - last[v, 0], start[v, 1] - last[v, 1], start[v, 2] - last[v, 2]
        passed[v] = 0.0 if math.isnan(x) else passed[v] + math.sqrt(x * x + y * y + z * z)
        for a in range(3):
            last[v, a] = start[v, a]
            low[a], high[a] = min(low[a], start[v, a]), max(high[a], start[v, a])
    begin, end, weight = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    corners, corner, body, depth = points.corners, points.corner, points.body, points.depth
    plane_of, left, pushed, spent = points.plane, points.left, points.pushed, points.spent
    for o in range(first, bodies.kind.shape[0]):
        f, rotation, origin, travel = o - first, bodies.rotation_before[o], bodies.origin_before[o], bodies.travel[o]
        if misses(real, f, rotation, origin, low, high, 2.0 * shell + longest + travel):
            continue
        spacing, band = max(2.0 * (1.0 - ROUND) * shell, real[f, VOXEL]), real[f, BAND]
        beyond = 2.0 * shell + travel + (longest_edge if between else 0.0)
        for v in prange(vertices):
            x, y, z = into_frame(rotation, origin, start[v, 0], start[v, 1], start[v, 2])
            if beyond_box(real, f, x, y, z, beyond + way[v]):
                distance[v], normal[v, 0], normal[v, 1], normal[v, 2] = np.inf, 0.0, 0.0, 0.0
            else:
                distance[v], normal[v, 0], normal[v, 1], normal[v, 2] = field_distance(
                    real, whole, coarse, occupied, brick, node, fine, split, plane, f, x, y, z
                )
        for v in range(vertices):
            moves = way[v] + travel
            if free[v] and distance[v] < 2.0 * shell + moves:
                if moves > shell:
                    i = np.uint32(v)  # as edges name it, so that one kernel does for all
                    count = add_field_point(
                        start, predicted, i, i, i, 1, bodies, o, f,
                        real, whole, coarse, occupied, brick, node, fine, split, plane, spacing, moves, shell, recover,
                        inverse_mass, points, count, begin, end, weight,
                    )  # fmt: skip
                else:
                    count = add_vertex(
                        v, o, distance[v], shell, recover,
                        corners, corner, body, depth, plane_of, left, pushed, spent, count,
                    )  # fmt: skip
        if not between:
            continue
        if fresh[f]:
            fresh[f], clear[f] = False, -1.0
        for e in prange(edge.shape[0]):
            i, j = edge[e, 0], edge[e, 1]
            moves = max(way[i], way[j]) + travel
            near[e] = False
            if 0.5 * (distance[i] + distance[j] - longest_edge) < 2.0 * shell + moves and (free[i] or free[j]):
                if moves > shell:
                    near[e] = True
                elif max(passed[i], passed[j]) + gone[f] + moves >= clear[f, e]:
                    least, sag, sag_there = between_vertices(
                        real, whole, coarse, occupied, brick, node, fine, split, plane, f, rotation, origin,
                        start, i, j, distance, normal, spacing, shell + moves,
                    )  # fmt: skip
                    # It is how the surface bends that counts, not how deep the edge is now: else it would be let go as
                    # soon as it is pushed out, to fall again.
                    near[e] = sag_there > ROUND * shell
                    spare = max(min(least, distance[i], distance[j]) - shell, 0.5 * (ROUND * shell - sag))
                    clear[f, e] = min(spare, 0.5 * shell) + min(passed[i], passed[j]) + gone[f]
        for e in range(edge.shape[0]):
            if near[e]:
                i, j = edge[e, 0], edge[e, 1]
                count = add_field_point(
                    start, predicted, i, j, j, 2, bodies, o, f,
                    real, whole, coarse, occupied, brick, node, fine, split, plane, spacing,
                    max(way[i], way[j]) + travel, shell, recover,
                    inverse_mass, points, count, begin, end, weight,
                )  # fmt: skip
        for t in range(triangle.shape[0]):
            i, j, k = triangle[t, 0], triangle[t, 1], triangle[t, 2]
            moves = max(way[i], way[j], way[k]) + travel
            if (
                (distance[i] + distance[j] + distance[k]) / 3.0 - longest_edge < 2.0 * shell + moves
                and (free[i] or free[j] or free[k])
                and may_meet_tip(start, rotation, i, j, k, distance, normal, shell + moves, moves > shell, band)
            ):
                count = add_field_point(
                    start, predicted, i, j, k, 3, bodies, o, f,
                    real, whole, coarse, occupied, brick, node, fine, split, plane, spacing, moves, shell, recover,
                    inverse_mass, points, count, begin, end, weight,
                )  # fmt: skip
    return count


@kernel
def add_field_point(
    start, predicted, i, j, k, corners, bodies, o, f,
    real, whole, coarse, occupied, brick, node, fine, split, plane, spacing, moves, shell, recover,
    inverse_mass, points, p, begin, end, weight
):  # fmt: skip
    """Look at the nearest point of a vertex, an edge or a triangle, and list it as number ``p`` if it may touch.

    What is fast is followed on its way, by as much at a time as its nearest sample allows. Returns the number of the
    next point.
    """
    chosen, most = (i, j, k), 0.0
    for n in range(corners):
        v = chosen[n]
        begin[n, 0], begin[n, 1], begin[n, 2] = into_frame(
            bodies.rotation_before[o], bodies.origin_before[o], start[v, 0], start[v, 1], start[v, 2]
        )
        end[n, 0], end[n, 1], end[n, 2] = into_frame(
            bodies.rotation[o], bodies.origin[o], predicted[v, 0], predicted[v, 1], predicted[v, 2]
        )
        x, y, z = end[n, 0] - begin[n, 0], end[n, 1] - begin[n, 1], end[n, 2] - begin[n, 2]
        most = max(most, math.sqrt(x * x + y * y + z * z))
    distance, nx, ny, nz, done, follows, stopped = 0.0, 0.0, 0.0, 1.0, 0.0, False, False
    for step in range(MOST_STEPS):
        d, x, y, z, unseen = nearest_in_field(
            real, whole, coarse, occupied, brick, node, fine, split, plane, f, begin, corners, spacing, weight
        )
        if step == 0:
            distance, nx, ny, nz = d, x, y, z
            follows = moves > shell and d > 0.0
        if not follows or d - unseen > shell + (1.0 - done) * most:
            break
        if d <= shell * 1.001 and slopes_inwards(begin, end, corners, weight, x, y, z):
            distance, nx, ny, nz, stopped = d, x, y, z, True
            break
        ahead = max(d - unseen - shell, FINEST_STEP * shell) / most
        if done + ahead >= 1.0:
            break
        for n in range(corners):
            for a in range(3):
                begin[n, a] += (end[n, a] - begin[n, a]) * ahead / (1.0 - done)
        done += ahead
    if corners > 1:
        if not stopped and (follows or distance > 2.0 * shell + moves):
            return p
        for n in range(corners):
            if weight[n] < INSIDE:
                return p
    if p < points.body.shape[0]:
        points.corners[p], points.body[p] = corners, o
        points.yields[p] = points.pushed[p] = points.spent[p] = 0.0
        offset, x, y, z = -distance, 0.0, 0.0, 0.0
        for n in range(corners):
            v, w = chosen[n], weight[n]
            points.corner[p, n], points.weight[p, n] = v, w
            points.yields[p] += w * w * inverse_mass[v]
            offset += w * (nx * begin[n, 0] + ny * begin[n, 1] + nz * begin[n, 2])
            x, y, z = x + w * end[n, 0], y + w * end[n, 1], z + w * end[n, 2]
        points.depth[p] = max(0.0, shell - distance - recover)
        points.plane[p] = 0.0
        if stopped:
            _, ex, ey, ez = field_distance(real, whole, coarse, occupied, brick, node, fine, split, plane, f, x, y, z)
            if nx * ex + ny * ey + nz * ez < SAME_SIDE:  # it would be put out on another side
                points.plane[p, 0], points.plane[p, 1], points.plane[p, 2], points.plane[p, 3] = nx, ny, nz, offset
        points.left[p, 0] = np.nan
    return p + 1
