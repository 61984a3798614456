"""Surfaces of what stands around the cloth: obstacles, grippers, the wind's arrow."""

from __future__ import annotations

import numpy as np
import pyvista as pv

from cloth_core.fields import Compound, VoxelField
from cloth_core.inputs import Grasp
from cloth_core.obstacles import Box, Capsule, Ellipsoid, Obstacle, Sphere
from cloth_core.pose import Pose

FINGER_LENGTH, FINGER_RADIUS = 0.07, 0.008


def matrix(pose: Pose) -> np.ndarray:
    """(4, 4) homogeneous transform of a pose."""
    result = np.eye(4)
    result[:3, :3] = pose.rotation
    result[:3, 3] = pose.position
    return result


def surface(obstacle: Obstacle) -> pv.PolyData | None:
    """The surface of an obstacle in its own frame; None for what has no bounds, a plane."""
    if isinstance(obstacle, Sphere):
        return pv.Sphere(radius=obstacle.radius, theta_resolution=64, phi_resolution=48)
    if isinstance(obstacle, Ellipsoid):
        unit = pv.Sphere(radius=1.0, theta_resolution=64, phi_resolution=48)
        return unit.scale(obstacle.radii, inplace=False)
    if isinstance(obstacle, Box):
        return pv.Cube(x_length=obstacle.extents[0], y_length=obstacle.extents[1], z_length=obstacle.extents[2])
    if isinstance(obstacle, Capsule):
        return rod(obstacle.radius, obstacle.length)
    if isinstance(obstacle, VoxelField):
        return pv.PolyData.from_regular_faces(obstacle.mesh.position, obstacle.mesh.triangles)
    if isinstance(obstacle, Compound):
        parts = [surface(part).transform(matrix(part.pose), inplace=False) for part in obstacle.parts.values()]
        return pv.merge(parts, merge_points=False).extract_surface(algorithm=None)
    return None


def rod(radius: float, length: float) -> pv.PolyData:
    """A capsule along z, centred; ``length`` m is the distance between the centres of its ends."""
    ball = pv.Sphere(radius=radius, theta_resolution=32, phi_resolution=33, direction=(0, 0, 1))
    ends = ball.points
    ends[:, 2] += np.where(ends[:, 2] > 0, 0.5, -0.5) * length
    ball.points = ends
    return ball.compute_normals(split_vertices=False)


def gripper(grasp: Grasp) -> pv.PolyData:
    """Two fingers and a palm in the grasp's frame: origin between the fingertips, x approach, y closing."""
    opening = FINGER_RADIUS + 0.03 * (1.0 - grasp.closure)
    parts = []
    for side in (-1.0, 1.0):
        finger = rod(FINGER_RADIUS, FINGER_LENGTH).rotate_y(90.0, inplace=False)
        parts.append(finger.translate((-0.5 * FINGER_LENGTH + 0.01, side * opening, 0.0), inplace=False))
    palm = rod(1.6 * FINGER_RADIUS, 0.075).rotate_x(90.0, inplace=False)
    parts.append(palm.translate((-FINGER_LENGTH, 0.0, 0.0), inplace=False))
    wrist = rod(2.0 * FINGER_RADIUS, 0.07).rotate_y(90.0, inplace=False)
    parts.append(wrist.translate((-FINGER_LENGTH - 0.045, 0.0, 0.0), inplace=False))
    return pv.merge(parts, merge_points=False).extract_surface(algorithm=None)


def wind_arrow(velocity: np.ndarray, middle: np.ndarray, length_per_speed: float) -> pv.PolyData:
    """A slim arrow along the wind, ``length_per_speed`` m for every m/s, around ``middle`` (3,) m."""
    speed = float(np.linalg.norm(velocity))
    length = length_per_speed * speed
    thick = 0.35 * length_per_speed
    return pv.Arrow(
        start=middle - 0.5 * length * velocity / speed,
        direction=velocity / speed,
        scale=length,
        tip_length=min(0.5, 3.5 * thick / length),
        tip_radius=1.4 * thick / length,
        shaft_radius=0.5 * thick / length,
        tip_resolution=32,
        shaft_resolution=32,
    )
