"""What is drawn for an obstacle fills the space that the cloth keeps out of."""

from __future__ import annotations

import math

import pytest

from cloth_core import Pose
from cloth_core.obstacles import SHAPES, Box, Capsule, Ellipsoid, Plane, Sphere
from cloth_sim_ros.messages.obstacle_shapes import CUBE, CYLINDER, SPHERE, shapes_of

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


def test_every_shape_that_a_scene_can_have_can_be_drawn():
    needed = {"sphere": {"radius": 1.0}, "box": {"extents": (1, 1, 1)}, "capsule": {"radius": 1.0, "length": 1.0}}
    needed |= {"ellipsoid": {"radii": (1, 1, 1)}, "plane": {}}
    for name, kind in SHAPES.items():
        assert shapes_of(kind(**needed[name]), Pose()), name
