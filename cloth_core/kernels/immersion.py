"""Cloth in a fluid: what of it is wet, how it is dragged along and how it is lifted."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cloth_core.kernels import kernel
from cloth_core.kernels.bodies import distance_in_world

GENTLE = 4.0
"""The surface of a fluid is at least as thick as makes a floating vertex swing by 1 / 2 rad in a substep."""


class Regions(NamedTuple):
    """R shapes full of fluid."""

    kind: np.ndarray
    """(R,) which shape."""
    size: np.ndarray
    """(R, 3) m, what the shape is known by."""
    rotation: np.ndarray
    """(R, 3, 3) frame to world."""
    origin: np.ndarray
    """(R, 3) m."""
    velocity: np.ndarray
    """(R, 3) m/s."""
    face_on: np.ndarray
    """(R,) kg/m^3, half the density times the drag coefficient of a patch held face-on."""
    along: np.ndarray
    """(R,) kg/m^3, the same of a patch along the stream."""
    displaced: np.ndarray
    """(R,) kg/m^2, mass of the fluid that the cloth displaces."""


@kernel
def wet_share(distance, across, thickness, area, gentle):
    """Share of a patch that is below a surface ``distance`` m away (negative: below), 0 .. 1.

    The patch is ``thickness`` m high where it lies on the surface, and as high as it is wide where it stands upright;
    ``across`` is the cosine between the two normals. It counts as no less than ``gentle`` m high.
    """
    height = thickness * across + math.sqrt(area * max(1.0 - across * across, 0.0))
    return min(max(0.5 - distance / max(height, gentle), 0.0), 1.0)


@kernel
def immerse(position, velocity, rest_area, mass, thickness, gravity, h, regions: Regions, area_vector, force, dry):
    """Add drag and lift of fluids to ``force`` (V, 3) N, and leave to the air what is dry.

    Drag is that of :func:`cloth_core.kernels.surface.add_relative_drag`, and along the patch as well, each bounded by
    what brings the vertex to the velocity of the stream within ``h`` s. What is wet is asked of where the vertex will
    be: forces of where it is would feed what bobs. Where regions overlap, those that come first count.
    ``area_vector`` (V, 3) m^2 shrinks to what is dry, and ``dry`` (V,) becomes its rest area in m^2.
    """
    gx, gy, gz = gravity[0], gravity[1], gravity[2]
    gentle = GENTLE * math.sqrt(gx * gx + gy * gy + gz * gz) * h * h
    dry[:] = 1.0
    for r in range(regions.kind.shape[0]):
        kind, size, rotation, origin = regions.kind[r], regions.size[r], regions.rotation[r], regions.origin[r]
        sx, sy, sz = regions.velocity[r, 0], regions.velocity[r, 1], regions.velocity[r, 2]
        face_on, skin, displaced = regions.face_on[r], regions.along[r], regions.displaced[r]
        for v in range(position.shape[0]):
            area = rest_area[v]
            if area == 0.0 or dry[v] == 0.0:
                continue
            ux, uy, uz = velocity[v, 0], velocity[v, 1], velocity[v, 2]
            x, y, z = position[v, 0] + h * ux, position[v, 1] + h * uy, position[v, 2] + h * uz
            distance, ox, oy, oz = distance_in_world(kind, size, rotation, origin, x, y, z)
            nx, ny, nz = area_vector[v, 0], area_vector[v, 1], area_vector[v, 2]
            shown = math.sqrt(nx * nx + ny * ny + nz * nz)
            scale = 1.0 / shown if shown > 0.0 else 0.0
            nx, ny, nz = nx * scale, ny * scale, nz * scale
            across = min(abs(nx * ox + ny * oy + nz * oz), 1.0)
            lifted = displaced * area
            share = dry[v] * wet_share(distance, across, thickness, area, gentle * lifted / mass[v])
            if share == 0.0:
                continue
            dry[v] -= share
            wx, wy, wz = sx - ux, sy - uy, sz - uz
            speed, most = share * math.sqrt(wx * wx + wy * wy + wz * wz), mass[v] / h
            c = min(face_on * min(shown, area) * speed, most)
            d = min(skin * area * speed, most)
            through = (c - d) * (nx * wx + ny * wy + nz * wz)
            lifted *= share
            force[v, 0] += d * wx + through * nx - lifted * gx
            force[v, 1] += d * wy + through * ny - lifted * gy
            force[v, 2] += d * wz + through * nz - lifted * gz
    for v in range(position.shape[0]):
        share = dry[v]
        dry[v] *= rest_area[v]
        area_vector[v, 0] *= share
        area_vector[v, 1] *= share
        area_vector[v, 2] *= share
