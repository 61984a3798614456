"""What a field answers: against the solid that it was built of, closed forms, and its own neighbours."""

from __future__ import annotations

import bodies
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cloth_core import Pose
from cloth_core.errors import InputError, SettingError
from cloth_core.fields import Solid, pooled
from cloth_core.fields.build import build
from cloth_core.fields.grid import fitted
from cloth_core.kernels import fields as kernels
from cloth_core.obstacles import Box, Capsule, Sphere

SEEDS = st.integers(0, 10**6)
HALF_DIAGONAL = np.sqrt(0.75)


def in_box(random: np.random.Generator, solid: Solid, count: int, margin: float) -> np.ndarray:
    return random.uniform(solid.low - margin, solid.high + margin, (count, 3))


def some_solid(random: np.random.Generator) -> Solid:
    """A lumpy ball, a torus, a plate thinner than a voxel, or a rod and a box that overlap; anywhere, turned."""
    pose = bodies.any_pose(random)
    kind = random.integers(4)
    if kind == 0:
        return Solid.of_surface(bodies.knobbly(random), pose)
    if kind == 1:
        return Solid.of_surface(bodies.torus(random.uniform(0.2, 0.4), random.uniform(0.05, 0.15), 48), pose)
    if kind == 2:
        return Solid.of_surface(bodies.box(0.3, 0.2, random.uniform(0.001, 0.02)), pose)
    where = dict(center=pose.position, orientation=pose.orientation)
    rod, block = Capsule(radius=0.05, length=0.6, **where), Box(extents=(0.3, 0.2, 0.1), **where)
    return Solid.union([Solid.of_shape(rod), Solid.of_shape(block)])


@given(SEEDS)
@settings(max_examples=12)
def test_the_shell_is_right_on_both_sides(seed):
    """To 0.3 voxels wherever the surface is, 99 in 100 points to 0.2: at edges and thin plates too."""
    random = np.random.default_rng(seed)
    solid, voxel = some_solid(random), random.uniform(0.02, 0.05)
    field = build(solid, voxel)
    points = in_box(random, solid, 20000, 2.0 * voxel)
    exact = solid.measure(points)[0]
    within = np.abs(exact) <= field.band
    distance, normal = field.distance(points[within])
    error = np.abs(distance - exact[within]) / voxel
    assert error.max() < 0.3
    assert np.percentile(error, 99.0) < 0.2
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0, abs=1e-12)


@given(SEEDS)
@settings(max_examples=12)
def test_beyond_the_shell_nothing_is_nearer_than_told_and_what_is_inside_stays_so(seed):
    random = np.random.default_rng(seed)
    solid, voxel = some_solid(random), random.uniform(0.02, 0.05)
    field = build(solid, voxel)
    points = np.concatenate([in_box(random, solid, 10000, 10.0 * voxel), in_box(random, solid, 10000, voxel)])
    exact = solid.measure(points)[0]
    distance = field.distance(points)[0]
    outside, inside = exact > field.band, exact < -field.band
    assert (distance[outside] > 0.5 * field.band).all()
    assert (distance[outside] <= exact[outside] + 0.25 * voxel).all()
    assert (distance[inside] < -0.5 * field.band).all()
    assert (np.abs(distance - exact)[inside] < 4.0 * voxel * HALF_DIAGONAL + 0.25 * voxel).all()


@given(SEEDS)
@settings(max_examples=10)
def test_what_is_inside_comes_out(seed):
    """Pushed by its distance along its normal, again and again, a point of the inside reaches the surface."""
    random = np.random.default_rng(seed)
    solid, voxel = some_solid(random), random.uniform(0.02, 0.05)
    field = build(solid, voxel)
    points = in_box(random, solid, 3000, 0.0)
    points = points[solid.measure(points)[0] < 0.0]
    for _ in range(60):
        distance, normal = field.distance(points)
        points = points - np.minimum(distance, 0.0)[:, None] * normal
    assert solid.measure(points)[0].min(initial=0.0) > -0.3 * voxel


@given(SEEDS)
@settings(max_examples=12)
def test_distances_are_continuous_in_the_shell(seed):
    """Across every side between cells, of any size: they differ by no more than the way."""
    random = np.random.default_rng(seed)
    solid, voxel = some_solid(random), 0.04
    field = build(solid, voxel)
    points, origin = in_box(random, solid, 20000, voxel), field.pool.real[0, :3]
    smallest, axis = voxel / 8.0, random.integers(0, 3, len(points))
    rows = np.arange(len(points))
    points[rows, axis] = origin[axis] + smallest * np.round((points[rows, axis] - origin[axis]) / smallest)
    within = np.abs(solid.measure(points)[0]) < 0.9 * field.band
    points, step = points[within], 1e-9 * np.eye(3)[axis[within]]
    before, after = field.distance(points - step)[0], field.distance(points + step)[0]
    assert np.abs(after - before).max() < 1e-8


@pytest.mark.parametrize("voxel", [0.01, 0.02, 0.04])
def test_error_of_a_ball_falls_with_the_square_of_the_voxel(voxel):
    """Trilinear interpolation of |x| - R between points a voxel apart errs by h^2 / (4 R) at the most."""
    field = build(Solid.of_shape(Sphere(radius=0.3)), voxel, tolerance=10.0)
    points = bodies.around(np.random.default_rng(0), bodies.ball(0.3), 20000, 0.3 * voxel)
    exact = np.linalg.norm(points, axis=1) - 0.3
    within = np.abs(exact) < voxel
    error = np.abs(field.distance(points)[0] - exact)[within].max()
    assert 0.5 * voxel**2 / (4.0 * 0.27) < error < voxel**2 / (4.0 * 0.27) + 2e-4 * voxel


@given(SEEDS)
@settings(max_examples=10)
def test_a_torus_is_that_of_the_formula(seed):
    """As near as its facets are to it: sagitta r (1 - cos(pi / n)) in both circles."""
    random = np.random.default_rng(seed)
    major, minor, voxel, pose = random.uniform(0.25, 0.4), random.uniform(0.08, 0.2), 0.02, bodies.any_pose(random)
    sag = (major + minor) * (1 - np.cos(np.pi / 96)) + minor * (1 - np.cos(np.pi / 48))
    field = build(Solid.of_surface(bodies.torus(major, minor), pose), voxel)
    points = random.uniform(-0.6, 0.6, (5000, 3)) * [1, 1, 0.5]
    exact = bodies.torus_distance(points, major, minor)
    within = np.abs(exact) < voxel - sag
    distance, normal = field.distance(pose.apply(points[within]))
    assert distance == pytest.approx(exact[within], abs=sag + 0.25 * voxel)
    ring = points[within] * [1, 1, 0]
    away = points[within] - major * ring / np.linalg.norm(ring, axis=1, keepdims=True)
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    assert np.einsum("pk,pk->p", away @ pose.rotation.T, normal).min() > np.cos(np.radians(20.0))


@pytest.mark.parametrize("thickness", [1.0, 0.5, 0.25])
@pytest.mark.parametrize("turned", [(0.0, 0.0, 0.0, 1.0), (0.3, 0.2, 0.1, 0.9)])
def test_a_plate_thinner_than_a_voxel_has_two_sides(thickness, turned):
    """In its middle the distance is negative, on either side positive and the normal away from the plate."""
    voxel, pose = 0.04, Pose((0.013, 0.007, 0.003), turned)
    half = 0.5 * thickness * voxel
    field = build(Solid.of_surface(bodies.box(0.4, 0.3, half), pose), voxel)
    random = np.random.default_rng(0)
    across = np.column_stack([random.uniform(-0.35, 0.35, 2000), random.uniform(-0.25, 0.25, 2000), np.zeros(2000)])
    distance = field.distance(pose.apply(across))[0]
    assert (distance < 0.0).mean() > 0.99 if thickness >= 0.5 else (distance < half).all()
    for side in (1.0, -1.0):
        points = across + np.array([0.0, 0.0, side * (half + 0.5 * voxel)])
        distance, normal = field.distance(pose.apply(points))
        assert distance == pytest.approx(0.5 * voxel, abs=0.25 * voxel)
        assert (side * normal @ pose.rotation[:, 2]).min() > 0.7


def test_tangent_planes_are_those_of_the_paper():
    """Eq. 6: of each voxel the plane through the surface point closest to its centre, square to the normal there."""
    solid, voxel = Solid.of_surface(bodies.torus(0.3, 0.1)), 0.02
    field = build(solid, voxel, query="tangent_plane")
    random = np.random.default_rng(0)
    points = in_box(random, solid, 30000, voxel)
    points = points[np.abs(solid.measure(points)[0]) < field.band]
    origin = field.pool.real[0, :3]
    centre = origin + voxel * (np.floor((points - origin) / voxel) + 0.5)
    there, closest, normal = solid.measure(centre)
    plane = np.einsum("pk,pk->p", points - closest, normal)
    kind = field.kinds(points)
    expected = np.where(kind == kernels.SURFACE, plane, np.where(there < 0, np.minimum(plane, 0), np.maximum(plane, 0)))
    distance, found = field.distance(points)
    assert distance == pytest.approx(expected, abs=1e-8)
    assert found == pytest.approx(normal, abs=1e-6)


def test_voxels_are_outside_inside_or_surface():
    """By many points of each voxel: those with points on both sides are of the surface, the others have one side."""
    surface, voxel = bodies.torus(0.3, 0.1, 48), 0.05
    solid = Solid.of_surface(surface)
    field = build(solid, voxel, query="tangent_plane")
    random, origin = np.random.default_rng(0), field.pool.real[0, :3]
    count = np.ceil((solid.high - origin) / voxel).astype(int)
    cell = np.stack(np.meshgrid(*(np.arange(n) for n in count), indexing="ij"), axis=-1).reshape(-1, 3)
    kind = field.kinds(origin + voxel * (cell + 0.5))
    least, most = np.full(len(cell), np.inf), np.full(len(cell), -np.inf)
    for _ in range(60):
        distance = solid.measure(origin + voxel * (cell + random.uniform(0, 1, cell.shape)))[0]
        least, most = np.minimum(least, distance), np.maximum(most, distance)
    assert (most[kind == kernels.INSIDE] < 0).all() and (least[kind == kernels.OUTSIDE] > 0).all()
    assert np.array_equal(np.unique(kind), [0, 1, 2])
    both = (least < 0) & (most > 0)
    assert (kind[both] == kernels.SURFACE).all()
    assert both.sum() > 0.8 * (kind == kernels.SURFACE).sum()


def test_only_fields_of_planes_tell_voxels_apart():
    with pytest.raises(InputError, match="tangent_plane, not trilinear"):
        build(Solid.of_shape(Sphere(radius=0.3)), 0.05).kinds(np.zeros((1, 3)))


def test_fields_answer_alike_alone_and_in_a_pool():
    random = np.random.default_rng(0)
    solids = [some_solid(random) for _ in range(6)]
    fields = [build(s, 0.04, query="tangent_plane" if n % 3 == 1 else "trilinear") for n, s in enumerate(solids)]
    pool = pooled(fields)
    points = random.uniform(-0.8, 0.8, (5000, 3))
    for number, field in enumerate(fields):
        distance, normal = np.full(len(points), np.nan), np.full_like(points, np.nan)
        kernels.field_distances(*pool, number, points, distance, normal)
        alone, direction = field.distance(points)
        assert np.array_equal(distance, alone) and np.array_equal(normal, direction)
    assert pooled([]).nbytes == 0


def test_the_same_solid_gives_the_same_field():
    solid = Solid.of_surface(bodies.knobbly(np.random.default_rng(5)))
    one, other = build(solid, 0.03), build(solid, 0.03)
    assert all(np.array_equal(a, b) for a, b in zip(one.pool, other.pool, strict=True))


def test_what_is_not_finite_is_nowhere():
    field = build(Solid.of_shape(Sphere(radius=0.3)), 0.02)
    points = np.array([[np.nan, 0, 0], [0, np.inf, 0], [0, 0, -np.inf], [1e300, 0, 0]])
    assert not (field.distance(points)[0] < 1e6).any()


def test_a_shell_takes_a_fraction_of_the_dense_grid():
    field = build(Solid.of_surface(bodies.ball(0.5, finer=4)), 0.01)
    assert field.pool.nbytes < 4 * field.dense_voxels / 7


def test_progress_rises_to_one_and_may_stop_the_work():
    solid, told = Solid.of_shape(Sphere(radius=0.3)), []
    build(solid, 0.02, progress=told.append)
    assert len(told) > 3 and told == sorted(told) and told[-1] == 1.0

    def enough(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        build(solid, 0.02, progress=enough)


def test_the_band_can_be_wider():
    """Then distances are right farther off."""
    solid = Solid.of_shape(Sphere(radius=0.3))
    field = build(solid, 0.02, band=0.08)
    points = np.outer(np.linspace(0.23, 0.37, 50), [0.6, 0.0, 0.8])
    assert field.distance(points)[0] == pytest.approx(np.linspace(-0.07, 0.07, 50), abs=0.01 * 0.08)


@pytest.mark.parametrize("voxel", [1e-5, 11.0, np.nan])
def test_the_voxel_has_bounds(voxel):
    with pytest.raises(SettingError, match=r"out of range: a number 0\.0001 \.\. 10 m"):
        build(Solid.of_shape(Sphere(radius=0.3)), voxel)


def test_a_grid_too_fine_is_refused_with_the_voxel_that_fits():
    solid = Solid.of_shape(Sphere(radius=10.0))
    with pytest.raises(SettingError, match=r"more than 134217728: .* m or more would fit") as refused:
        build(solid, 0.001)
    fits = float(str(refused.value).split(": ")[-1].split(" m or")[0])
    assert 0.035 < fits < 0.05
    grid = fitted(solid, fits, fits)
    with pytest.raises(SettingError, match=r"16064000 voxels near the surface: .* m or more would fit"):
        grid.check_bricks(251000)
