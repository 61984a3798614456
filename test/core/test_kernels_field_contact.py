"""Contacts with distance fields against slow twins, and against what the field says on fine grids."""

from __future__ import annotations

import functools

import bodies as solids
import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cloth_core import Pose
from cloth_core.fields import Closed, Compound, Field, VoxelField, pooled
from cloth_core.kernels import field_approach, field_contact, field_nearest
from cloth_core.kernels.bodies import Bodies
from cloth_core.kernels.contact import Points
from cloth_core.obstacles import Box, Capsule

SEEDS = st.integers(0, 10**6)
SHELL, VOXEL = 0.02, 0.04
SPACING = 2.0 * (1.0 - field_approach.ROUND) * SHELL


@numba.njit
def nearest(real, whole, coarse, occupied, brick, node, fine, split, plane, corner, corners, spacing, weight):
    return field_nearest.nearest_in_field(
        real, whole, coarse, occupied, brick, node, fine, split, plane, 0, corner, corners, spacing, weight
    )


@functools.cache
def made(name: str) -> Field:
    surface: dict[str, Closed] = {
        "ball": solids.ball(0.3),
        "torus": solids.torus(0.3, 0.1),
        "block": solids.box(0.3, 0.2, 0.1),
        "lumps": solids.knobbly(np.random.default_rng(3)),
    }
    return VoxelField(surface=surface[name], voxel=VOXEL).made(band=2.0 * SHELL)


NAMES = ("ball", "torus", "block", "lumps")


def shares(corners: int, fine: int) -> np.ndarray:
    """(N, 3) weights of points all over an edge or a triangle."""
    u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 1, fine), np.linspace(0, 1, fine)))
    if corners == 2:
        return np.column_stack([1 - u[:fine], u[:fine], 0 * u[:fine]])
    inside = u + v <= 1.0 + 1e-12
    return np.column_stack([1 - u - v, u, v])[inside]


@given(SEEDS, st.sampled_from(NAMES), st.sampled_from([2, 3]))
def test_what_other_points_are_nearer_by_is_no_more_than_said(seed, name, corners):
    random, field = np.random.default_rng(seed), made(name)
    corner = random.normal(0, 0.3, 3) + random.normal(0, 0.1, (3, 3))
    weight = np.zeros(3)
    distance, *normal, unseen = nearest(*field.pool, corner, corners, SPACING, weight)
    assert weight[:corners].sum() == pytest.approx(1.0)
    assert (weight[:corners] >= -1e-12).all()
    there = field.distance(weight[None, :corners] @ corner[:corners])
    assert distance == pytest.approx(there[0][0], abs=1e-9)
    np.testing.assert_allclose(normal, there[1][0], atol=1e-6)
    least = field.distance(shares(corners, 101) @ corner)[0].min()
    if abs(least) < field.band:  # elsewhere distances are bounds, which may jump
        assert distance - unseen < least + 0.15 * VOXEL
        assert unseen <= SPACING


@given(SEEDS, st.sampled_from(["ball", "block"]))
def test_on_convex_bodies_the_nearest_point_of_an_edge_is_that_of_a_fine_grid(seed, name):
    random, field = np.random.default_rng(seed), made(name)
    foot = solids.around(random, VoxelField(surface=solids.ball(0.3)).mesh, 1, 0.0)[0] if name == "ball" else None
    foot = random.uniform(-1, 1, 3) * [0.3, 0.2, 0.1] if foot is None else foot
    corner = foot + random.normal(0, 0.05, (3, 3))
    weight = np.zeros(3)
    distance = nearest(*field.pool, corner, 2, SPACING, weight)[0]
    lowest = field.distance(shares(2, 401) @ corner)[0].min()
    if abs(lowest) < field.band:
        assert distance < lowest + 0.05 * VOXEL


def scene(seed: int, names: tuple[str, ...] = NAMES) -> tuple[np.random.Generator, list[Field], Bodies]:
    random, fields = np.random.default_rng(seed), [made(name) for name in names]
    count = len(fields)
    rotation, origin = Rotation.random(count, rng=random).as_matrix(), random.normal(0, 0.4, (count, 3))
    zero = np.zeros((count, 3))
    return (
        random,
        fields,
        Bodies(
            kind=np.full(count, 5), size=zero, reach=np.array([f.reach for f in fields]), friction=np.zeros(count),
            rotation_before=rotation, origin_before=origin, rotation=rotation, origin=origin, turn=zero,
            travel=np.zeros(count),
        ),
    )  # fmt: skip


def room(count: int) -> Points:
    return Points(
        corners=np.ones(count, np.int8), corner=np.zeros((count, 3), np.uint32), weight=np.ones((count, 3)),
        yields=np.zeros(count), body=np.zeros(count, np.int32), depth=np.zeros(count), plane=np.zeros((count, 4)),
        left=np.full((count, 3), np.nan), pushed=np.zeros(count), spent=np.zeros(count), normal=np.zeros((count, 3)),
        shift=np.zeros((count, 3)), gap=np.zeros(count),
    )  # fmt: skip


def unseen(count: int) -> np.ndarray:
    return np.full((count, 7), np.nan)


def anew(vertices: int, edges: int, fields: int) -> field_approach.Course:
    """Before the first substep."""
    return field_approach.Course(
        last=np.full((vertices, 3), np.nan), passed=np.zeros(vertices), gone=np.zeros(fields),
        clear=np.zeros((fields, edges)), fresh=np.ones(fields, bool), near=np.zeros(edges, bool),
    )  # fmt: skip


def found(
    start: np.ndarray, end: np.ndarray, fields: list[Field], around: Bodies, edge: np.ndarray, triangle: np.ndarray,
    course: field_approach.Course | None = None,
) -> tuple[int, Points]:  # fmt: skip
    vertices, points = len(start), room(4000)
    course = course or anew(vertices, len(edge), len(fields))
    longest = max((np.linalg.norm(start[i] - start[j]) for i, j in edge), default=0.1)
    count = field_approach.find_field_points(
        start, end, edge.astype(np.uint32), triangle.astype(np.uint32), longest, np.ones(vertices, bool),
        np.ones(vertices), around, 0, *pooled(fields), True, SHELL, 0.004, points, 0,
        np.zeros(vertices), np.zeros(vertices), np.zeros((vertices, 3)), course,
    )  # fmt: skip
    assert count < 4000
    return count, points


def gaps(fields: list[Field], around: Bodies, x: np.ndarray) -> np.ndarray:
    """(O, N) distances of points of the world."""
    return np.array([f.distance((x - around.origin[o]) @ around.rotation[o])[0] for o, f in enumerate(fields)])


NOTHING = np.zeros((0, 2), int), np.zeros((0, 3), int)


@pytest.mark.parametrize("seed", range(6))
def test_found_vertices_are_all_that_may_touch(seed):
    random, fields, around = scene(seed)
    x = random.normal(0, 0.5, (200, 3))
    step = random.normal(0, 0.002, x.shape)
    count, points = found(x, x + step, fields, around, *NOTHING)
    gap = gaps(fields, around, x)
    near = gap < 2.0 * SHELL + np.linalg.norm(step, axis=1)
    expected = {(v, o): max(0.0, SHELL - gap[o, v] - 0.004) for o, v in np.argwhere(near)}
    listed = list(zip(points.corner[:count, 0].tolist(), points.body[:count].tolist(), strict=True))
    assert len(listed) == len(expected) > 20
    assert dict(zip(listed, points.depth[:count], strict=True)) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("drift", [0.0, 0.002])
@pytest.mark.parametrize("seed", range(4))
def test_the_surface_comes_through_no_edge_that_is_not_found(seed, drift):
    """Edges anywhere around the bodies, in one substep after the other; each body wanders by up to the drift."""
    random, fields, around = scene(seed)
    x = random.normal(0, 0.5, (6000, 3))
    x[1::2] = x[::2] + random.normal(0, 0.15, (3000, 3))
    edge, course = np.arange(6000).reshape(-1, 2), anew(6000, 3000, len(fields))
    step, way = random.uniform(-1, 1, (2, 3)) * drift / 3**0.5
    for _ in range(6):
        count, points = found(x, x + step, fields, around, edge, NOTHING[1], course)
        gap = gaps(fields, around, x)
        seen = (gap > SHELL).all(axis=0)[edge].all(axis=1)
        listed = {(points.body[p], *points.corner[p, :2].tolist()) for p in range(count) if points.corners[p] == 2}
        share = np.linspace(0.0, 1.0, 60)[None, :, None]
        along = (1.0 - share) * x[edge[seen, 0], None] + share * x[edge[seen, 1], None]
        least = gaps(fields, around, along.reshape(-1, 3)).reshape(len(fields), -1, 60).min(axis=2)
        missed = [
            least[o, e]
            for o in range(len(fields))
            for e, (i, j) in enumerate(edge[seen])
            if (o, int(i), int(j)) not in listed
        ]
        assert min(missed) > 0.0
        assert np.count_nonzero(least < 0.0) > 5
        there = np.einsum("pn,pnk->pk", points.weight[:count, :2], x[points.corner[:count, :2]])
        of_edge = np.flatnonzero(points.corners[:count] == 2)
        reach = gaps(fields, around, there[of_edge])[points.body[of_edge], np.arange(len(of_edge))]
        assert reach.max() < 2.0 * SHELL + drift
        x = x + step
        around.origin[:] += way
        course.gone[:] += np.linalg.norm(way)


def thin_plate() -> tuple[Field, Bodies]:
    """Less than a voxel thick, across the z axis."""
    field = Compound(parts={"plate": Box(extents=(1.0, 1.0, 0.03))}, voxel=VOXEL).made(band=2.0 * SHELL)
    zero, eye = np.zeros((1, 3)), np.eye(3)[None]
    still = Bodies(
        kind=np.full(1, 5), size=zero, reach=np.array([field.reach]), friction=np.zeros(1), rotation_before=eye,
        origin_before=zero, rotation=eye, origin=zero, turn=zero, travel=np.zeros(1),
    )  # fmt: skip
    return field, still


@given(SEEDS)
@settings(max_examples=40)
def test_what_passes_a_plate_within_a_step_is_stopped_on_its_side(seed):
    """A triangle, its edges and its vertices fly through; each is held by the upper face."""
    random, (field, still) = np.random.default_rng(seed), thin_plate()
    start = np.column_stack([random.uniform(-0.2, 0.2, (3, 2)), random.uniform(0.1, 0.3, 3)])
    edge, triangle = np.array([[0, 1], [1, 2], [2, 0]]), np.array([[0, 1, 2]])
    count, points = found(start, start - [0.0, 0.0, 1.0], [field], still, edge, triangle)
    at_corner = points.corners[:count] == 1
    assert np.count_nonzero(at_corner) == 3
    np.testing.assert_allclose(points.plane[:count, :3][at_corner], 3 * [[0.0, 0.0, 1.0]], atol=0.02)
    assert points.plane[:count, 3][at_corner] == pytest.approx(0.015, abs=0.15 * VOXEL)
    back, points = found(start, start + np.array([0.0, 0.0, 1.0]), [field], still, edge, triangle)
    assert (points.plane[:back] == 0.0).all()


@given(SEEDS)
@settings(max_examples=40)
def test_push_out_brings_points_to_the_shell_along_the_normal(seed):
    random, fields, around = scene(seed)
    x = random.normal(0, 0.4, (300, 3))
    count, points = found(x, x, fields, around, *NOTHING)
    points.depth[:] = random.uniform(0.0, 0.01, len(points.depth))
    still = random.random(count) < 0.2
    points.left[:count][still] = x[points.corner[:count, 0]][still]
    expected, pushed = x.copy(), np.zeros(count)
    for p in range(count):
        o, v = points.body[p], points.corner[p, 0]
        if still[p] and (expected[v] == x[v]).all():
            continue
        distance, normal = fields[o].distance((expected[v] - around.origin[o])[None] @ around.rotation[o])
        pushed[p] = max(0.0, SHELL - points.depth[p] - distance[0])
        expected[v] += pushed[p] * around.rotation[o] @ normal[0]
    most = field_contact.push_out_of_fields(
        x, around, 0, *pooled(fields), points, 0, count, np.ones(len(x)), SHELL, unseen(count)
    )
    np.testing.assert_allclose(x, expected, atol=1e-12)
    np.testing.assert_allclose(points.pushed[:count], pushed, atol=1e-12)
    assert most == pytest.approx(pushed.max(initial=0.0))


@given(SEEDS, st.floats(0.02, 0.08))
@settings(max_examples=25, deadline=None)
def test_vertices_end_a_shell_off_the_true_surface_whatever_voxel_and_pose(seed, voxel):
    """A rod that lies anyhow in its field, which stands anyhow in the world; the formula of the rod is the judge."""
    random = np.random.default_rng(seed)
    rod = Capsule(radius=0.1, length=0.4, center=tuple(random.uniform(-1, 1, 3)), orientation=quaternion(random))
    field = Compound(parts={"rod": rod}, voxel=voxel).made(band=2.0 * SHELL)
    pose = Pose(tuple(random.uniform(-1, 1, 3)), quaternion(random))
    eye, place = pose.rotation[None], np.array([pose.position])
    around = Bodies(
        kind=np.full(1, 5), size=np.zeros((1, 3)), reach=np.array([field.reach]), friction=np.zeros(1),
        rotation_before=eye, origin_before=place, rotation=eye, origin=place, turn=np.zeros((1, 3)), travel=np.zeros(1),
    )  # fmt: skip
    angle, radius = random.uniform(0, 2 * np.pi, 100), random.uniform(0.02, 0.1, 100)
    along = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), random.uniform(-0.2, 0.2, 100)])
    x = pose.apply(rod.pose.apply(along))
    count, points = found(x, x, [field], around, *NOTHING)
    points.depth[:] = 0.0
    for _ in range(4):
        field_contact.push_out_of_fields(
            x, around, 0, *field.pool, points, 0, count, np.ones(100), SHELL, unseen(count)
        )
    local = rod.pose.inverse_apply(pose.inverse_apply(x))
    local[:, 2] -= np.clip(local[:, 2], -0.2, 0.2)
    assert np.linalg.norm(local, axis=1) - 0.1 == pytest.approx(SHELL, abs=0.3 * voxel)


def quaternion(random: np.random.Generator) -> tuple[float, ...]:
    return tuple(Rotation.random(rng=random).as_quat())
