"""The obstacles of a scene, and where they are in the substep at hand."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cloth_core.kernels import kernel
from cloth_core.kernels.shapes import PLANE, SPHERE, signed_distance


class Bodies(NamedTuple):
    """O obstacles as kernels know them; ``_before`` is the start of the substep, the rest its end."""

    kind: np.ndarray
    """(O,) which shape."""
    size: np.ndarray
    """(O, 3) m, what the shape is known by."""
    reach: np.ndarray
    """(O,) m, radius about the origin of the frame that holds all of it."""
    friction: np.ndarray
    """(O,) Coulomb coefficient."""
    rotation_before: np.ndarray
    """(O, 3, 3) frame to world."""
    origin_before: np.ndarray
    """(O, 3) m."""
    rotation: np.ndarray
    origin: np.ndarray
    turn: np.ndarray
    """(O, 3) rad, rotation within the substep."""
    travel: np.ndarray
    """(O,) m, the farthest that any point of it moves within the substep."""


@kernel
def into_frame(rotation, origin, x, y, z):
    """A world point in the frame that stands at ``origin`` with ``rotation`` (frame to world)."""
    x -= origin[0]
    y -= origin[1]
    z -= origin[2]
    return (
        rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z,
        rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z,
        rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z,
    )


@kernel
def out_of_frame(rotation, x, y, z):
    """A direction in a frame of ``rotation`` (frame to world), in the world."""
    return (
        rotation[0, 0] * x + rotation[0, 1] * y + rotation[0, 2] * z,
        rotation[1, 0] * x + rotation[1, 1] * y + rotation[1, 2] * z,
        rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2] * z,
    )


@kernel
def distance_in_world(kind, size, rotation, origin, x, y, z):
    """Signed distance in m of a world point, and the outward unit normal in the world.

    Spheres and planes look alike from everywhere, or need one axis alone: no turning into their frames and back.
    """
    if kind == SPHERE:
        x, y, z = x - origin[0], y - origin[1], z - origin[2]
        length = math.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            return length - size[0], x / length, y / length, z / length
    elif kind == PLANE:
        nx, ny, nz = rotation[0, 2], rotation[1, 2], rotation[2, 2]
        return nx * (x - origin[0]) + ny * (y - origin[1]) + nz * (z - origin[2]), nx, ny, nz
    x, y, z = into_frame(rotation, origin, x, y, z)
    distance, nx, ny, nz = signed_distance(kind, size, x, y, z)
    nx, ny, nz = out_of_frame(rotation, nx, ny, nz)
    return distance, nx, ny, nz


@kernel
def surface_displacement(x, y, z, origin, origin_before, turn):
    """Displacement in m during the substep of the obstacle's material at a world point.

    ``turn`` (3,) rad is the obstacle's rotation in the substep.
    """
    x -= origin[0]
    y -= origin[1]
    z -= origin[2]
    return (
        origin[0] - origin_before[0] + turn[1] * z - turn[2] * y,
        origin[1] - origin_before[1] + turn[2] * x - turn[0] * z,
        origin[2] - origin_before[2] + turn[0] * y - turn[1] * x,
    )
