"""Lines of sight: what is between an eye and the vertices of a mesh."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import kernel
from cloth_core.kernels.bodies import into_frame
from cloth_core.kernels.shapes import signed_distance

TOUCH = 1e-3
"""m before a vertex at which the look for obstacles ends: what it lies on does not hide it."""
_CLOSE = 1e-5
_STEPS = 200


@kernel
def tiles_of(low_u, high_u, low_v, high_v, tile, across, down):
    """First and last tile, in each direction, of a rectangle of pixels; the last before the first if it is outside."""
    first_u, last_u = max(0.0, math.floor(low_u / tile)), min(across - 1.0, math.floor(high_u / tile))
    first_v, last_v = max(0.0, math.floor(low_v / tile)), min(down - 1.0, math.floor(high_v / tile))
    return int(first_u), int(last_u), int(first_v), int(last_v)


@kernel
def sort_into_tiles(triangles, pixel, ahead, tile, across, down):
    """Which triangles may cover a tile of the image: start (tiles + 1,) into the list of them, and the list.

    A triangle with a corner that is not ahead of the camera may be anywhere.
    """
    start = np.zeros(across * down + 1, np.int64)
    listed = np.zeros(0, np.int64)
    for filling in (False, True):
        cursor = start[:-1].copy()
        for t in range(len(triangles)):
            a, b, c = triangles[t]
            everywhere = not (ahead[a] and ahead[b] and ahead[c])
            if everywhere and not (ahead[a] or ahead[b] or ahead[c]):
                continue
            u0, u1, v0, v1 = 0, across - 1, 0, down - 1
            if not everywhere:
                u0, u1, v0, v1 = tiles_of(
                    min(pixel[a, 0], pixel[b, 0], pixel[c, 0]), max(pixel[a, 0], pixel[b, 0], pixel[c, 0]),
                    min(pixel[a, 1], pixel[b, 1], pixel[c, 1]), max(pixel[a, 1], pixel[b, 1], pixel[c, 1]),
                    tile, across, down,
                )  # fmt: skip
            for v in range(v0, v1 + 1):
                for u in range(u0, u1 + 1):
                    place = v * across + u
                    if filling:
                        listed[cursor[place]] = t
                        cursor[place] += 1
                    else:
                        start[place + 1] += 1
        if not filling:
            for place in range(across * down):
                start[place + 1] += start[place]
            listed = np.zeros(start[-1], np.int64)
    return start, listed


@kernel
def crosses(eye, end, p, q, r):
    """Whether the open segment from ``eye`` to ``end`` meets a triangle (Moeller and Trumbore 1997)."""
    dx, dy, dz = end[0] - eye[0], end[1] - eye[1], end[2] - eye[2]
    ax, ay, az = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    bx, by, bz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    hx, hy, hz = dy * bz - dz * by, dz * bx - dx * bz, dx * by - dy * bx
    volume = ax * hx + ay * hy + az * hz
    if volume == 0.0:
        return False
    sx, sy, sz = eye[0] - p[0], eye[1] - p[1], eye[2] - p[2]
    first = (sx * hx + sy * hy + sz * hz) / volume
    if first < 0.0 or first > 1.0:
        return False
    gx, gy, gz = sy * az - sz * ay, sz * ax - sx * az, sx * ay - sy * ax
    second = (dx * gx + dy * gy + dz * gz) / volume
    if second < 0.0 or first + second > 1.0:
        return False
    way = (bx * gx + by * gy + bz * gz) / volume
    return 0.0 < way < 1.0


@kernel
def hide_behind_triangles(position, triangles, eye, pixel, tile, across, down, start, listed, seen):
    """Take those out of ``seen`` (V,) that have a triangle before them, other than one of their own."""
    for vertex in range(len(position)):
        if not seen[vertex]:
            continue
        u0, _, v0, _ = tiles_of(
            pixel[vertex, 0], pixel[vertex, 0], pixel[vertex, 1], pixel[vertex, 1], tile, across, down
        )
        place = min(v0, down - 1) * across + min(u0, across - 1)
        for k in range(start[place], start[place + 1]):
            a, b, c = triangles[listed[k]]
            if a == vertex or b == vertex or c == vertex:
                continue
            if crosses(eye, position[vertex], position[a], position[b], position[c]):
                seen[vertex] = False
                break


@kernel
def hide_behind_shape(position, eye, kind, size, rotation, origin, seen):
    """Take those out of ``seen`` (V,) whose line of sight enters an obstacle (sphere tracing, Hart 1996)."""
    for vertex in range(len(position)):
        if not seen[vertex]:
            continue
        dx, dy, dz = position[vertex, 0] - eye[0], position[vertex, 1] - eye[1], position[vertex, 2] - eye[2]
        length = math.sqrt(dx * dx + dy * dy + dz * dz)
        gone = 0.0
        for _ in range(_STEPS):
            share = gone / length
            x, y, z = into_frame(rotation, origin, eye[0] + share * dx, eye[1] + share * dy, eye[2] + share * dz)
            distance = signed_distance(kind, size, x, y, z)[0]
            if distance < _CLOSE:
                seen[vertex] = False
                break
            gone += distance
            if gone >= length - TOUCH:
                break
