"""Exact distances and sides, against closed forms and the slow twin."""

from __future__ import annotations

import warnings

import bodies
import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from cloth_core import Pose
from cloth_core.errors import MeshError, MeshWarning
from cloth_core.fields import Closed, Solid, closed
from cloth_core.kernels.contact import distance_in_world
from cloth_core.obstacles import Box, Capsule, Ellipsoid, Plane, Sphere

SEEDS = st.integers(0, 10**6)


@given(SEEDS)
@settings(max_examples=15)
def test_distance_and_side_are_those_of_the_twin(seed):
    random = np.random.default_rng(seed)
    surface = bodies.moved(bodies.knobbly(random), bodies.any_pose(random))
    points = bodies.around(random, surface, 12, 0.1)
    distance, closest, _ = Solid.of_surface(surface).measure(points)
    direction = random.normal(size=3)
    for point, found, foot in zip(points, distance, closest, strict=True):
        assert abs(found) == pytest.approx(bodies.slow_distance(surface, point), abs=1e-12)
        assert (found < 0.0) == bodies.slow_inside(surface, point, direction)
        assert np.linalg.norm(point - foot) == pytest.approx(abs(found), abs=1e-12)


@given(SEEDS, st.sampled_from([1e-6, 1e-4, 0.01, 0.3]))
def test_boxes_and_plates_of_any_thickness_are_exact_on_both_sides(seed, thickness):
    random = np.random.default_rng(seed)
    half, pose = np.array([*random.uniform(0.1, 0.5, 2), 0.5 * thickness]), bodies.any_pose(random)
    solid = Solid.of_surface(bodies.box(*half), pose)
    points = np.concatenate([random.uniform(-0.6, 0.6, (100, 3)), random.uniform(-1.2, 1.2, (300, 3)) * half])
    distance, _, normal = solid.measure(pose.apply(points))
    expected = bodies.box_distance(points, half)
    assert distance == pytest.approx(expected, abs=1e-9)
    clear = np.abs(expected) > 1e-9
    assert np.array_equal(distance[clear] < 0.0, expected[clear] < 0.0)
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0, abs=1e-12)


@given(SEEDS)
def test_needles_have_an_inside_up_to_the_tip(seed):
    """The axis of a cone is inside, its continuation outside; the closest point of the latter is the tip."""
    random = np.random.default_rng(seed)
    radius, height, pose = random.uniform(1e-4, 1e-2), random.uniform(0.1, 1.0), bodies.any_pose(random)
    solid = Solid.of_surface(bodies.cone(radius, height), pose)
    along = random.uniform(1e-3, 0.999, 50)
    inside = solid.measure(pose.apply(np.outer(along * height, [0, 0, 1])))[0]
    assert (inside < 0.0).all()
    assert (np.abs(inside) <= radius * (1.0 - along) + 1e-12).all()
    beyond = height * (1.0 + along)
    distance, closest, _ = solid.measure(pose.apply(np.outer(beyond, [0, 0, 1])))
    assert distance == pytest.approx(beyond - height, abs=1e-12)
    assert closest == pytest.approx(np.tile(pose.apply(np.array([[0, 0, height]])), (50, 1)), abs=1e-12)


@given(SEEDS)
def test_a_tip_is_told_from_outside_however_its_sides_are_cut(seed):
    """A sharp cone of few triangles on one side and many on the other, which must not outweigh the few."""
    random = np.random.default_rng(seed)
    radius, height = random.uniform(0.01, 0.1), 1.0
    angle = np.concatenate(
        [np.linspace(0.0, np.pi, 60, endpoint=False), np.linspace(np.pi, 2 * np.pi, 3, endpoint=False)]
    )
    surface = bodies.cone(radius, height, angle)
    solid, tip = Solid.of_surface(surface), np.array([0.0, 0.0, height])
    # Where the tip is closest: in the cone of the normals around it, spanned by those of the faces.
    normal = np.cross(*(surface.position[surface.triangles[:63]][:, n] - tip for n in (0, 1)))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    away = random.dirichlet(np.full(63, 0.05), 200) @ normal
    distance, closest, _ = solid.measure(tip + 0.1 * away)
    assert distance == pytest.approx(0.1 * np.linalg.norm(away, axis=1), abs=1e-9)
    assert closest == pytest.approx(np.tile(tip, (200, 1)), abs=1e-9)


def test_triangles_without_area_do_not_turn_the_side():
    """A box whose sides are cut by slivers along an edge, and by one that is a line."""
    surface = bodies.box(0.3, 0.2, 0.1)
    a, b, c = surface.triangles[0]
    split = 0.5 * (surface.position[a] + surface.position[b])
    position, number = np.vstack([surface.position, split]), len(surface.position)
    whole = [(a, b, number), (a, number, c), (number, b, c)]  # the first is flat and closes the gap between both sides
    other = list(surface.triangles[1:])
    flat = Solid.of_surface(closed(position, np.array([*whole, *other])))
    random = np.random.default_rng(3)
    points = random.uniform(-0.4, 0.4, (2000, 3))
    expected = bodies.box_distance(points, np.array([0.3, 0.2, 0.1]))
    assert flat.measure(points)[0] == pytest.approx(expected, abs=1e-12)


def test_two_boxes_that_touch_in_an_edge_are_told_apart():
    one, other = bodies.box(0.1, 0.1, 0.1), bodies.box(0.1, 0.1, 0.1)
    both = bodies.joined(one, bodies.moved(other, Pose((0.2, 0.2, 0.0))))
    surface = closed(both.position, both.triangles)
    assert len(np.unique(surface.triangles)) == 14
    points = np.random.default_rng(0).uniform(-0.2, 0.4, (3000, 3))
    half = np.full(3, 0.1)
    expected = np.minimum(bodies.box_distance(points, half), bodies.box_distance(points - [0.2, 0.2, 0.0], half))
    assert Solid.of_surface(surface).measure(points)[0] == pytest.approx(expected, abs=1e-12)


def test_a_cavity_is_outside():
    inner = bodies.ball(0.2)
    hollow = bodies.joined(bodies.ball(0.4), Closed(inner.position, inner.triangles[:, ::-1]))
    solid = Solid.of_surface(closed(hollow.position, hollow.triangles))
    distance = solid.measure(np.array([[0.0, 0, 0], [0.3, 0, 0], [0.5, 0, 0]]))[0]
    assert (distance > 0).tolist() == [True, False, True]


def test_a_surface_that_passes_through_itself_has_one_inside():
    """Two overlapping boxes in one mesh: no bubble where one is within the other, and the outside as of their union."""
    long, tall = np.array([0.5, 0.1, 0.1]), np.array([0.1, 0.1, 0.5])
    both = bodies.joined(bodies.box(*long), bodies.box(*tall))
    fine = trimesh.Trimesh(both.position, both.triangles, process=False).subdivide_to_size(0.05)
    with pytest.warns(MeshWarning, match="passes through itself"):
        solid = Solid.of_surface(closed(fine.vertices, fine.faces), source="cross")
    points = np.random.default_rng(1).uniform(-0.6, 0.6, (20000, 3))
    expected = np.minimum(bodies.box_distance(points, long), bodies.box_distance(points, tall))
    distance = solid.measure(points)[0]
    assert np.array_equal(distance < 0.0, expected < 0.0)
    assert distance[expected > 0] == pytest.approx(expected[expected > 0], abs=0.03)  # triangles half buried


@given(SEEDS)
@settings(max_examples=20)
def test_a_union_is_the_least_of_its_members(seed):
    random = np.random.default_rng(seed)
    surfaces = [bodies.knobbly(random), bodies.box(*random.uniform(0.02, 0.3, 3))]
    poses = [bodies.any_pose(random) for _ in range(5)]
    shapes = [
        shape(center=pose.position, orientation=pose.orientation, **size)
        for pose, (shape, size) in zip(
            poses[2:],
            [
                (Capsule, dict(radius=0.1, length=0.3)),
                (Ellipsoid, dict(radii=(0.1, 0.2, 0.3))),
                (Box, dict(extents=(0.1, 0.2, 0.3))),
            ],
            strict=True,
        )
    ]
    members = [Solid.of_surface(s, p) for s, p in zip(surfaces, poses, strict=False)]
    members += [Solid.of_shape(shape) for shape in shapes]
    union = Solid.union(members)
    points = random.uniform(-1.0, 1.0, (300, 3))
    least = np.min([m.measure(points)[0] for m in members], axis=0)
    assert np.array_equal(union.measure(points)[0], least)
    for member in members:
        assert (union.low <= member.low + 1e-15).all() and (member.high <= union.high + 1e-15).all()


@given(SEEDS, st.sampled_from([Sphere, Box, Capsule, Ellipsoid]))
def test_the_box_around_a_shape_holds_it_and_no_more(seed, kind):
    """Along each axis the farthest point of the surface is on the box: the distance from the side is 0."""
    random = np.random.default_rng(seed)
    pose = bodies.any_pose(random)
    size = {
        Sphere: lambda: dict(radius=random.uniform(0.1, 1)),
        Box: lambda: dict(extents=random.uniform(0.1, 1, 3)),
        Capsule: lambda: dict(radius=random.uniform(0.1, 1), length=random.uniform(0, 1)),
        Ellipsoid: lambda: dict(radii=random.uniform(0.1, 1, 3)),
    }[kind]()
    shape = kind(center=pose.position, orientation=pose.orientation, **size)
    solid = Solid.of_shape(shape)
    points = np.array(pose.position) + random.normal(0, 1, (2000, 3))
    distance, closest, _ = solid.measure(points)
    outside = distance > 0.0
    assert (closest[outside] >= solid.low - 1e-9).all() and (closest[outside] <= solid.high + 1e-9).all()
    for axis in range(3):
        direction = np.eye(3)[axis]
        far = np.array(pose.position) + 1e4 * direction
        gap = distance_in_world(shape.kind, np.array(shape.size), pose.rotation, np.array(pose.position), *far)[0]
        assert far[axis] - solid.high[axis] == pytest.approx(gap, abs=1e-4)


def test_a_plane_cannot_be_part_of_a_field():
    with pytest.raises(MeshError, match="no end"):
        Solid.of_shape(Plane())


def test_nothing_has_no_surface():
    with pytest.raises(MeshError, match="without members"):
        Solid.union([])


def test_good_surfaces_make_no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for surface in (bodies.torus(0.3, 0.1), bodies.box(1, 1, 1e-4), bodies.cone(1e-3, 1.0)):
            Solid.of_surface(surface)
