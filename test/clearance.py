"""How far a cloth is from the true surfaces of what it meets: analytic shapes and meshes, not their fields."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cloth_core.fields import Closed, Solid
from cloth_core.fields.obstacle import FieldObstacle
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Obstacle, Plane
from cloth_core.pose import Pose

PARTS = 8
"""Samples of a triangle lie on a grid of this many intervals a side."""


def solid_of(obstacle: Obstacle) -> Solid:
    """An obstacle in its own frame."""
    if not isinstance(obstacle, FieldObstacle):
        return Solid.of_shape(replace(obstacle, center=(0.0, 0.0, 0.0), orientation=(0.0, 0.0, 0.0, 1.0)))
    pieces = obstacle.pieces
    return Solid.union([_piece(piece) for piece in pieces])


def clearance(obstacle: Obstacle, pose: Pose, mesh: ClothMesh, position: np.ndarray) -> float:
    """Least signed distance in m of any point of the cloth, as sampled, from an obstacle at ``pose``."""
    corner = pose.inverse_apply(position)[mesh.triangles]
    size = np.ptp(corner, axis=1).max()
    if isinstance(obstacle, Plane):
        return float(corner[..., 2].min())
    solid = solid_of(obstacle)
    away = solid.measure(corner.mean(axis=1))[0]
    near = corner[away < away.min() + size]
    share = np.array([(i, j, PARTS - i - j) for i in range(PARTS + 1) for j in range(PARTS + 1 - i)]) / PARTS
    points = np.einsum("sc,tck->tsk", share, near).reshape(-1, 3)
    return float(solid.measure(points)[0].min())


def deepest(obstacles: Mapping[str, Obstacle], poses: Mapping[str, Pose], mesh: ClothMesh, position: np.ndarray):
    """The least clearance of all obstacles in m, and whose it is."""
    return min((clearance(o, poses[name], mesh, position), name) for name, o in obstacles.items())


def _piece(piece) -> Solid:
    if isinstance(piece, Closed):
        return Solid.of_surface(piece)
    return Solid.of_shape(piece) if isinstance(piece, Obstacle) else Solid.of_surface(*piece)
