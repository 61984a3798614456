"""The vertices that a camera sees: in its image, and hidden neither by obstacles nor by the cloth itself."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cloth_core import Pose
from cloth_core.obstacles import Box, Capsule, Ellipsoid, Obstacle, Plane, Sphere
from cloth_sim_ros.vision import kernels
from cloth_sim_ros.vision.camera import NEAR, Lens

_TILES = 64  # across the image
_ANALYTIC = (Plane, Sphere, Box, Capsule, Ellipsoid)


def visible_vertices(
    pose: Pose,
    lens: Lens,
    position: np.ndarray,
    triangles: np.ndarray,
    obstacles: Mapping[str, Obstacle],
    poses: Mapping[str, Pose],
) -> np.ndarray:
    """Numbers of the vertices seen, sorted, (N,) uint32.

    The line of sight of every vertex is followed to its end; there is no depth image whose pixels would decide.

    Args:
        pose: of the optical frame (z ahead, x right, y down).
        lens: how it maps points.
        position: (V, 3) m.
        triangles: (T, 3); both sides hide what is behind.
        obstacles: by name. Only the analytic shapes hide anything; meshes do not yet.
        poses: where they stand; those not named stand where they started.
    """
    seen_from = pose.inverse_apply(position)
    pixel, seen = lens.project(seen_from)
    eye = np.array(pose.position)
    for name, obstacle in obstacles.items():
        if isinstance(obstacle, _ANALYTIC):
            at = poses.get(name, obstacle.pose)
            size = np.array(obstacle.size, dtype=float)
            kernels.hide_behind_shape(
                position, eye, obstacle.kind, size, at.rotation, np.array(at.position), seen
            )  # fmt: skip
    tile = lens.width / _TILES
    down = max(1, int(np.ceil(lens.height / tile)))
    triangles = np.ascontiguousarray(triangles)
    start, listed = kernels.sort_into_tiles(triangles, pixel, seen_from[:, 2] > NEAR, tile, _TILES, down)
    kernels.hide_behind_triangles(
        position, triangles, eye, pixel, tile, _TILES, down, start, listed, seen
    )  # fmt: skip
    return np.flatnonzero(seen).astype(np.uint32)
