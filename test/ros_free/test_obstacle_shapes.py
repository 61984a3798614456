"""What is drawn for an obstacle fills the space that the cloth keeps out of."""

from __future__ import annotations

import math

import bodies
import numpy as np
import pytest

from cloth_core import Pose
from cloth_core.fields import Compound, VoxelField
from cloth_core.fields.outline import TRIANGLES_MOST
from cloth_core.obstacles import Box, Capsule, Ellipsoid, Plane, Sphere
from cloth_core.shapes import SHAPES
from cloth_sim_ros.messages.obstacle_shapes import CUBE, CYLINDER, SPHERE, TRIANGLE_LIST, shapes_of

UPSIDE = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))  # a quarter turn about x takes z to -y
THERE = Pose((1.0, 2.0, 3.0), UPSIDE)


@pytest.mark.parametrize(
    ("obstacle", "kind", "scale"),
    [
        (Sphere(radius=0.5), SPHERE, (1.0, 1.0, 1.0)),
        (Box(extents=(1.0, 2.0, 3.0)), CUBE, (1.0, 2.0, 3.0)),
        (Ellipsoid(radii=(1.0, 2.0, 3.0)), SPHERE, (2.0, 4.0, 6.0)),
    ],
)
def test_a_simple_shape_is_one_marker_of_full_extents(obstacle, kind, scale):
    (shape,) = shapes_of(obstacle, THERE)
    assert (shape.kind, shape.scale, shape.pose) == (kind, scale, THERE)


def test_a_capsule_is_a_rod_and_two_balls_at_its_ends():
    rod, *ends = shapes_of(Capsule(radius=0.1, length=2.0), THERE)
    assert (rod.kind, rod.scale, rod.pose) == (CYLINDER, (0.2, 0.2, 2.0), THERE)
    assert {end.kind for end in ends} == {SPHERE}
    places = sorted(end.pose.position for end in ends)
    assert places[0] == pytest.approx((1.0, 1.0, 3.0))
    assert places[1] == pytest.approx((1.0, 3.0, 3.0))


def test_a_capsule_without_length_needs_no_rod():
    assert {shape.kind for shape in shapes_of(Capsule(radius=0.1, length=0.0), Pose())} == {SPHERE}


def test_a_plane_is_a_slab_whose_upper_face_is_the_plane():
    (slab,) = shapes_of(Plane(), THERE)
    top = slab.pose.compose(Pose((0.0, 0.0, slab.scale[2] / 2)))
    assert top.position == pytest.approx(THERE.position)


def test_a_mesh_is_its_triangles_and_a_fine_one_fewer():
    ball = bodies.ball(0.5, finer=1)
    (shape,) = shapes_of(VoxelField(surface=ball, scale=2.0), THERE)
    assert (shape.kind, shape.scale, shape.pose) == (TRIANGLE_LIST, (1.0, 1.0, 1.0), THERE)
    np.testing.assert_array_equal(shape.outline.corners.reshape(-1, 3, 3), 2.0 * ball.position[ball.triangles])
    (shape,) = shapes_of(VoxelField(surface=bodies.ball(0.5, finer=5)), THERE)  # 20,480 triangles
    assert 500 < len(shape.outline.corners) / 3 <= TRIANGLES_MOST
    np.testing.assert_allclose(np.linalg.norm(shape.outline.corners, axis=1), 0.5, atol=0.01)


def test_a_compound_is_its_parts_where_they_stand():
    post = Box(extents=(0.1, 0.1, 1.0), center=(0.0, 0.0, 0.5))
    vase = VoxelField(surface=bodies.ball(0.1), center=(0.0, 0.0, 1.1))
    one, other = shapes_of(Compound(parts={"post": post, "vase": vase}), THERE)
    assert (one.kind, one.scale, other.kind) == (CUBE, (0.1, 0.1, 1.0), TRIANGLE_LIST)
    assert one.pose.position == pytest.approx((1.0, 1.5, 3.0))
    assert other.pose.position == pytest.approx((1.0, 0.9, 3.0))


def test_every_shape_that_a_scene_can_have_can_be_drawn():
    needed = {"sphere": {"radius": 1.0}, "box": {"extents": (1, 1, 1)}, "capsule": {"radius": 1.0, "length": 1.0}}
    needed |= {"ellipsoid": {"radii": (1, 1, 1)}, "plane": {}}
    needed |= {"voxel_field": {"surface": bodies.ball(0.5)}, "compound": {"parts": {"it": Sphere(radius=1.0)}}}
    for name, kind in SHAPES.items():
        assert shapes_of(kind(**needed[name]), Pose()), name
