"""The cloth's surface: area vectors and the drag of the medium around it."""

from __future__ import annotations

import math

from cloth_core.kernels import kernel


@kernel
def area_vectors(position, triangles, area_vector):
    """A third of each adjoining triangle's area vector, summed per vertex, into ``area_vector`` (V, 3) m^2.

    Its length is the area that the vertex shows, its direction the area-weighted normal.
    """
    area_vector[:] = 0.0
    for t in range(triangles.shape[0]):
        a = triangles[t, 0]
        b = triangles[t, 1]
        c = triangles[t, 2]
        ux = position[b, 0] - position[a, 0]
        uy = position[b, 1] - position[a, 1]
        uz = position[b, 2] - position[a, 2]
        vx = position[c, 0] - position[a, 0]
        vy = position[c, 1] - position[a, 1]
        vz = position[c, 2] - position[a, 2]
        nx = (uy * vz - uz * vy) / 6.0
        ny = (uz * vx - ux * vz) / 6.0
        nz = (ux * vy - uy * vx) / 6.0
        for v in (a, b, c):
            area_vector[v, 0] += nx
            area_vector[v, 1] += ny
            area_vector[v, 2] += nz


@kernel
def normals(area_vector, normal):
    """Unit normals of ``area_vector``, into ``normal`` (V, 3); zero where there is no surface."""
    for v in range(area_vector.shape[0]):
        x = area_vector[v, 0]
        y = area_vector[v, 1]
        z = area_vector[v, 2]
        length = math.sqrt(x * x + y * y + z * z)
        scale = 1.0 / length if length > 0.0 else 0.0
        normal[v, 0] = x * scale
        normal[v, 1] = y * scale
        normal[v, 2] = z * scale


@kernel
def add_drag_of_flow(flow, area_vector, rest_area, coefficient, force):
    """Add eq. (5), ``coefficient * |w| (n . w) n`` per area, to ``force`` (V, 3) N.

    w is the ``flow`` (V, 3) m/s alone, as in the paper. A vertex shows the wind no more than its ``rest_area``
    (V,) m^2: if stretching made it larger, the wind would stretch it ever faster.
    """
    for v in range(flow.shape[0]):
        ax = area_vector[v, 0]
        ay = area_vector[v, 1]
        az = area_vector[v, 2]
        area = math.sqrt(ax * ax + ay * ay + az * az)
        if area > 0.0:
            wx = flow[v, 0]
            wy = flow[v, 1]
            wz = flow[v, 2]
            speed = math.sqrt(wx * wx + wy * wy + wz * wz)
            c = coefficient * min(area, rest_area[v]) * speed
            c = c * (ax * wx + ay * wy + az * wz) / (area * area)
            force[v, 0] += c * ax
            force[v, 1] += c * ay
            force[v, 2] += c * az


@kernel
def add_relative_drag(velocity, flow, area_vector, rest_area, coefficient, mass, h, force):
    """Add eq. (5) with the velocity relative to the ``flow``, bounded for stability, to ``force`` (V, 3) N.

    The drag along the normal is c (w - v) with c = ``coefficient`` area |w - v|, the area as in
    :func:`add_drag_of_flow`; c never exceeds what brings the vertex, left alone, to the flow's velocity within
    ``h`` s, so that no wind makes it overshoot. Below that bound the force is exact, so that what hangs or falls
    in a steady wind ends where theory says.
    """
    for v in range(flow.shape[0]):
        ax = area_vector[v, 0]
        ay = area_vector[v, 1]
        az = area_vector[v, 2]
        area = math.sqrt(ax * ax + ay * ay + az * az)
        if area > 0.0:
            wx = flow[v, 0] - velocity[v, 0]
            wy = flow[v, 1] - velocity[v, 1]
            wz = flow[v, 2] - velocity[v, 2]
            speed = math.sqrt(wx * wx + wy * wy + wz * wz)
            c = min(coefficient * min(area, rest_area[v]) * speed, mass[v] / h)
            c = c * (ax * wx + ay * wy + az * wz) / (area * area)
            force[v, 0] += c * ax
            force[v, 1] += c * ay
            force[v, 2] += c * az


@kernel
def gust_flow(position, time, mean, wave, frequency, phase, amplitude, flow):
    """Mean wind plus travelling waves at every vertex, into ``flow`` (V, 3) m/s.

    ``wave`` (M, 3) rad/m, ``frequency`` (M,) rad/s, ``phase`` (M,) rad, ``amplitude`` (M, 3) m/s.
    """
    for v in range(position.shape[0]):
        fx = mean[0]
        fy = mean[1]
        fz = mean[2]
        for m in range(wave.shape[0]):
            along = wave[m, 0] * position[v, 0] + wave[m, 1] * position[v, 1] + wave[m, 2] * position[v, 2]
            s = math.sin(along - frequency[m] * time + phase[m])
            fx += s * amplitude[m, 0]
            fy += s * amplitude[m, 1]
            fz += s * amplitude[m, 2]
        flow[v, 0] = fx
        flow[v, 1] = fy
        flow[v, 2] = fz
