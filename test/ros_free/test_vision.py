"""What a camera sees of the cloth, against closed forms and a look through every triangle."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cloth_core import ClothMesh, Pose
from cloth_core.obstacles import Box, Capsule, Plane, Sphere
from cloth_sim_ros.vision.camera import Lens
from cloth_sim_ros.vision.visible import visible_vertices

DOWN = (1.0, 0.0, 0.0, 0.0)  # half a turn about x: the optical axis points down
WIDE = Lens(640, 480, 300.0, 300.0, 319.5, 239.5)
MESH = ClothMesh.grid(width=1.0, height=1.0, columns=41, rows=41)


def look(position, obstacles=None, *, pose=None, lens=WIDE, triangles=MESH.triangles, poses=None):
    pose = pose or Pose((0.0, 0.0, 2.0), DOWN)
    return visible_vertices(pose, lens, position, triangles, obstacles or {}, poses or {})


def test_a_flat_cloth_in_the_image_is_seen_whole_from_either_side():
    everything = list(range(MESH.vertex_count))
    assert look(MESH.rest_position).tolist() == everything
    assert look(MESH.rest_position, pose=Pose((0.0, 0.0, -2.0))).tolist() == everything


def test_what_is_outside_the_image_or_behind_the_camera_is_not_seen():
    # 0.2 m of half width at 2 m
    narrow = Lens(640, 480, 320 * 10.0, 320 * 10.0, 319.5, 239.5)
    seen = MESH.rest_position[look(MESH.rest_position, lens=narrow)]
    assert np.abs(seen[:, 0]).max() == pytest.approx(0.2, abs=0.026)
    assert np.abs(seen[:, 1]).max() == pytest.approx(0.15, abs=0.026)
    assert len(look(MESH.rest_position, pose=Pose((0.0, 0.0, 2.0)))) == 0  # looks up


def test_a_ball_hides_the_disc_of_its_shadow():
    radius, height = 0.2, 1.0
    ball = Sphere(radius=radius, center=(0.0, 0.0, height))
    seen = look(MESH.rest_position, {"ball": ball})
    # The tangent cone from 2 m above the cloth around a ball 1 m away.
    shadow = 2.0 * math.tan(math.asin(radius / 1.0))
    distance = np.linalg.norm(MESH.rest_position[:, :2], axis=1)
    assert set(seen) == set(np.flatnonzero(distance > shadow))
    moved = look(MESH.rest_position, {"ball": ball}, poses={"ball": Pose((5.0, 0.0, 1.0))})
    assert len(moved) == MESH.vertex_count


def test_a_turned_box_hides_what_its_corners_hide():
    half = math.sqrt(0.5)
    box = Box(
        extents=(0.2, 0.2, 1e-3),
        center=(0.0, 0.0, 1.0),
        orientation=(0.0, 0.0, math.sin(math.pi / 8), math.cos(math.pi / 8)),
    )
    seen = look(MESH.rest_position, {"box": box})
    turned = (np.abs(MESH.rest_position[:, 0]) + np.abs(MESH.rest_position[:, 1])) * half
    assert set(np.flatnonzero(turned > 0.2005)) <= set(seen) <= set(np.flatnonzero(turned > 0.1995))


def test_cloth_that_lies_on_an_obstacle_is_seen_and_from_below_the_floor_nothing():
    lying = np.add(MESH.rest_position, (0.0, 0.0, 0.005))
    assert len(look(lying, {"floor": Plane()})) == MESH.vertex_count
    grazing = Pose((3.0, 0.0, 0.3), (0.5, 0.5, -0.5, -0.5))
    forward = grazing.rotation[:, 2]
    assert forward == pytest.approx([-1.0, 0.0, 0.0])
    assert len(look(lying, {"floor": Plane()}, pose=grazing)) == MESH.vertex_count
    assert len(look(lying, {"floor": Plane()}, pose=Pose((0.0, 0.0, -2.0)))) == 0


def test_the_lower_of_two_sheets_is_hidden_where_the_upper_one_is():
    aside = np.array([0.0031, 0.0017, 1.0])  # no line of sight goes right through an edge
    upper = MESH.rest_position * 0.5 + aside
    both = np.concatenate([MESH.rest_position, upper])
    triangles = np.concatenate([MESH.triangles, MESH.triangles + MESH.vertex_count])
    seen = look(both, triangles=triangles)
    shadow = np.abs(MESH.rest_position[:, :2] - 2.0 * aside[:2]).max(axis=1) < 0.5  # 0.25 m at half the distance
    lower = np.flatnonzero(~shadow)
    assert 0 < len(lower) < MESH.vertex_count
    assert set(range(MESH.vertex_count, 2 * MESH.vertex_count)) <= set(seen)
    assert set(seen[seen < MESH.vertex_count]) == set(lower)


def crumpled(seed):
    generator = np.random.default_rng(seed)
    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=15, rows=15)
    waves = generator.normal(0.0, 0.15, (4, 3))
    x, y, _ = mesh.rest_position.T
    offsets = sum(np.outer(np.sin((k + 1) * 4.0 * x + y * (3 - k) * 3.0 + k), waves[k]) for k in range(4))
    return mesh, np.ascontiguousarray(mesh.rest_position + offsets)


def seen_through_every_triangle(pose, lens, position, triangles):
    """Which vertices are seen, from signed volumes of tetrahedra, all triangles tried for all vertices."""
    eye = np.array(pose.position)
    local = pose.inverse_apply(position)
    u, v = lens.fx * local[:, 0] / local[:, 2] + lens.cx, lens.fy * local[:, 1] / local[:, 2] + lens.cy
    seen = (local[:, 2] > 0.01) & (np.abs(u - lens.cx) < lens.width / 2) & (np.abs(v - lens.cy) < lens.height / 2)
    p, q, r = position[triangles].transpose(1, 0, 2)

    def volume(a, b, c, d):
        return np.einsum("...i,...i->...", b - a, np.cross(c - a, d - a))

    for vertex in np.flatnonzero(seen):
        end = position[vertex]
        sides = np.stack([volume(eye, end, p, q), volume(eye, end, q, r), volume(eye, end, r, p)])
        inside = (sides > 0).all(axis=0) | (sides < 0).all(axis=0)
        apart = np.sign(volume(eye, p, q, r)) != np.sign(volume(end, p, q, r))
        seen[vertex] = not (inside & apart & ~(triangles == vertex).any(axis=1)).any()
    return np.flatnonzero(seen)


@pytest.mark.parametrize("seed", range(6))
def test_a_crumpled_cloth_is_seen_as_a_look_through_every_triangle_says(seed):
    mesh, position = crumpled(seed)
    for pose in (
        Pose((0.3, -0.2, 1.2), DOWN),
        Pose((1.5, 0.1, 0.2), (0.5, 0.5, -0.5, -0.5)),
        Pose((0.1, 0.0, 0.2), DOWN),
    ):
        expected = seen_through_every_triangle(pose, WIDE, position, mesh.triangles)
        seen = look(position, pose=pose, triangles=mesh.triangles)
        assert seen.tolist() == expected.tolist()
    assert 20 < len(look(position, pose=Pose((0.3, -0.2, 1.8), DOWN), triangles=mesh.triangles)) < 200


def test_a_capsule_between_hides_a_strip():
    rod = Capsule(
        radius=0.05, length=10.0, center=(0.0, 0.0, 1.0), orientation=(0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))
    )
    seen = look(MESH.rest_position, {"rod": rod})
    strip = 2.0 * math.tan(math.asin(0.05))
    assert set(seen) == set(np.flatnonzero(np.abs(MESH.rest_position[:, 1]) > strip))
