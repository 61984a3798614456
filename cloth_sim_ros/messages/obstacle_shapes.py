"""Obstacles as the boxes, balls, cylinders and triangles that a viewer can draw."""

from __future__ import annotations

from dataclasses import dataclass

from cloth_core import Pose
from cloth_core.fields import Compound, VoxelField
from cloth_core.fields.outline import Outline
from cloth_core.obstacles import Box, Capsule, Ellipsoid, Obstacle, Plane, Sphere

CUBE, SPHERE, CYLINDER, TRIANGLE_LIST = 1, 2, 3, 11  # visualization_msgs/Marker
PLANE_EXTENT = 10.0
"""m; planes go on for ever, what is drawn of them does not."""


@dataclass(frozen=True)
class Shape:
    """One marker: what it is, where it stands, and its full extents in m along its axes.

    ``outline`` is what a list of triangles consists of, in its frame.
    """

    kind: int
    pose: Pose
    scale: tuple[float, float, float]
    outline: Outline | None = None


def shapes_of(obstacle: Obstacle, pose: Pose) -> list[Shape]:
    """What to draw for ``obstacle`` standing at ``pose``."""
    if isinstance(obstacle, Plane):
        slab = 0.002
        return [Shape(CUBE, pose.compose(Pose((0.0, 0.0, -slab / 2))), (PLANE_EXTENT, PLANE_EXTENT, slab))]
    if isinstance(obstacle, Box):
        return [Shape(CUBE, pose, obstacle.extents)]
    if isinstance(obstacle, Sphere):
        return [Shape(SPHERE, pose, (2 * obstacle.radius,) * 3)]
    if isinstance(obstacle, Ellipsoid):
        return [Shape(SPHERE, pose, tuple(2 * radius for radius in obstacle.radii))]  # type: ignore[arg-type]
    if isinstance(obstacle, Capsule):
        thick, half = 2 * obstacle.radius, obstacle.length / 2
        ends = [Shape(SPHERE, pose.compose(Pose((0.0, 0.0, z))), (thick,) * 3) for z in (-half, half)]
        rod = [Shape(CYLINDER, pose, (thick, thick, obstacle.length))] if half > 0 else []
        return rod + ends
    if isinstance(obstacle, VoxelField):
        return [Shape(TRIANGLE_LIST, pose, (1.0, 1.0, 1.0), obstacle.outline)]
    if isinstance(obstacle, Compound):
        return [shape for part in obstacle.parts.values() for shape in shapes_of(part, pose.compose(part.pose))]
    raise TypeError(f"no shape is known for {type(obstacle).__name__}")
