"""Distances, push-out, friction and impact against their slow twins."""

from __future__ import annotations

import numpy as np
import pytest
import twins
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from cloth_core.kernels import contact

SEEDS = st.integers(0, 10**6)
SHAPES = range(5)


def capsule_point(size: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Where the ray from the centre along ``d`` leaves the capsule: through its side, or through an end."""
    radius, half = size[:2]
    across = np.hypot(d[0], d[1])
    if radius * abs(d[2]) < half * across:
        return radius / across * d
    return (half * abs(d[2]) + np.sqrt((half * d[2]) ** 2 - half**2 + radius**2)) * d


# A point of the surface for each direction.
POINTS = {
    contact.SPHERE: lambda s, d: s[0] * d,
    contact.BOX: lambda s, d: s * d / np.abs(d).max(),
    contact.CAPSULE: capsule_point,
    contact.ELLIPSOID: lambda s, d: s * d,
}


def random_size(random: np.random.Generator, kind: int) -> np.ndarray:
    return np.zeros(3) if kind == contact.PLANE else random.uniform(0.2, 1.5, 3)


@given(SEEDS, st.sampled_from(SHAPES))
def test_distance_is_that_of_the_twin(seed, kind):
    random = np.random.default_rng(seed)
    size, point = random_size(random, kind), random.normal(0, 1.0, 3)
    distance = contact.signed_distance(kind, size, *point)[0]
    assert distance == pytest.approx(twins.DISTANCE[kind](size, point), abs=1e-9)


@given(SEEDS, st.sampled_from([contact.SPHERE, contact.BOX, contact.CAPSULE, contact.ELLIPSOID]))
def test_no_point_of_the_surface_is_nearer_than_the_distance(seed, kind):
    """Points of the surface by direction, the nearest refined by scipy: the formula under test is not used."""
    random = np.random.default_rng(seed)
    size, point = random_size(random, kind), random.normal(0, 1.0, 3)
    distance = contact.signed_distance(kind, size, *point)[0]

    def gap(angles):
        u, v = angles
        direction = np.array([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)])
        return float(np.linalg.norm(POINTS[kind](size, direction) - point))

    grid = [(u, v) for u in np.linspace(-3.1, 3.1, 40) for v in np.linspace(-1.5, 1.5, 21)]
    starts = sorted(grid, key=gap)[:6]
    nearest = min(
        minimize(gap, start, method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-9}).fun for start in starts
    )
    assert nearest >= abs(distance) - 1e-9
    assert nearest == pytest.approx(abs(distance), abs=0.01)


@given(SEEDS, st.sampled_from(SHAPES))
def test_normal_is_the_gradient_and_leads_to_the_surface(seed, kind):
    random = np.random.default_rng(seed)
    size, point = random_size(random, kind), random.normal(0, 1.0, 3)
    distance, *normal = contact.signed_distance(kind, size, *point)
    assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-9)
    assert contact.signed_distance(kind, size, *(point - distance * np.array(normal)))[0] == pytest.approx(
        0.0, abs=1e-7
    )


@pytest.mark.parametrize("kind", SHAPES)
def test_distance_and_normal_are_finite_at_the_centre_on_axes_and_on_the_surface(kind):
    size = np.array([0.5, 0.5, 0.5]) if kind == contact.ELLIPSOID else np.array([0.5, 0.4, 0.3])
    for sizes in (size, np.array([0.5, 0.2, 0.2]), np.array([0.3, 0.5, 0.1])):
        for point in np.concatenate(
            [np.zeros((1, 3)), 0.1 * np.eye(3), np.diag(sizes), 3 * np.eye(3), -np.diag(sizes)]
        ):
            distance, *normal = contact.signed_distance(kind, sizes, *point)
            assert np.isfinite(distance)
            assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("radii", [(1.0, 1.0, 1.0), (1.0, 0.5, 0.5), (0.3, 0.3, 0.9), (0.2, 0.4, 0.8)])
def test_ellipsoid_on_its_axes(radii):
    """Outside on an axis the vertex is nearest; at the centre, the end of the shortest axis."""
    for axis in range(3):
        point = np.zeros(3)
        point[axis] = 2.0
        assert contact.ellipsoid_distance(*point, *radii)[0] == pytest.approx(2.0 - radii[axis], abs=1e-7)
    assert contact.ellipsoid_distance(0.0, 0.0, 0.0, *radii)[0] == pytest.approx(-min(radii), abs=1e-7)


@given(SEEDS)
def test_into_frame_is_the_inverse_pose(seed):
    random = np.random.default_rng(seed)
    rotation, origin, point = Rotation.random(rng=random).as_matrix(), *random.normal(size=(2, 3))
    np.testing.assert_allclose(contact.into_frame(rotation, origin, *point), rotation.T @ (point - origin), atol=1e-13)


def crowd(seed: int):
    """40 vertices around five obstacles in random poses."""
    random = np.random.default_rng(seed)
    kind = np.arange(5)
    size = np.array([random_size(random, k) for k in kind])
    reach = np.array([1e9, size[1, 0], np.linalg.norm(size[2]), size[3, 0] + size[3, 1], size[4].max()])
    return (
        random,
        random.normal(0, 1, (40, 3)),
        kind,
        size,
        reach,
        Rotation.random(5, rng=random).as_matrix(),
        random.normal(0, 0.5, (5, 3)),
    )


@pytest.mark.parametrize("seed", range(8))
def test_found_contacts_are_all_that_may_touch(seed):
    random, x, kind, size, reach, rotation, origin = crowd(seed)
    shell, recover, travel = 0.01, 0.004, random.uniform(0, 0.05, 5)
    predicted, free = x + random.normal(0, 0.05, x.shape), random.random(40) < 0.8
    pairs = np.full((2, 200), -1, np.int32)
    depth, left = np.full(200, np.nan), np.zeros((200, 3))
    count = contact.find_contacts(
        x, predicted, kind, size, reach, rotation, origin, travel, shell, recover, free, *pairs, depth, left
    )
    expected = {}
    for v in np.flatnonzero(free):
        way = np.linalg.norm(predicted[v] - x[v])
        for o in range(5):
            distance = twins.DISTANCE[kind[o]](size[o], rotation[o].T @ (x[v] - origin[o]))
            if distance < 2 * shell + way + travel[o]:
                expected[v, o] = max(0.0, shell - distance - recover)
    assert {(int(v), int(o)) for v, o in pairs[:, :count].T} == set(expected)
    assert count == len(expected)
    np.testing.assert_allclose(depth[:count], [expected[v, o] for v, o in pairs[:, :count].T], atol=1e-8)
    np.testing.assert_array_equal(np.isnan(left).any(axis=1), np.arange(200) < count)


@pytest.mark.parametrize("seed", range(8))
def test_push_out_moves_along_the_normal_to_the_allowed_depth(seed):
    random, x, kind, size, _, rotation, origin = crowd(seed)
    vertex, obstacle = np.arange(40, dtype=np.int32), random.integers(0, 5, 40).astype(np.int32)
    depth, pushed, normal, before = random.uniform(0, 0.02, 40), np.full(40, 0.5), np.full((40, 3), np.nan), x.copy()
    left = np.full((40, 3), np.nan)
    left[::4] = x[::4]
    most = contact.push_out(x, kind, size, rotation, origin, 0.01, vertex, obstacle, depth, left, pushed, normal)
    ways = np.zeros(40)
    for v, o in zip(vertex, obstacle, strict=True):
        if v % 4 == 0:
            continue  # it is where it was left
        there = lambda p, o=o: twins.DISTANCE[kind[o]](size[o], rotation[o].T @ (p - origin[o]))  # noqa: E731
        ways[v] = max(0.0, 0.01 - depth[v] - there(before[v]))
        np.testing.assert_allclose(x[v] - before[v], ways[v] * normal[v] if ways[v] else 0.0, atol=1e-8)
        if 0 < ways[v]:
            assert there(x[v]) == pytest.approx(0.01 - depth[v], abs=1e-6)
    np.testing.assert_array_equal(x[::4], before[::4])
    np.testing.assert_allclose(pushed - 0.5, ways, atol=1e-8)
    assert most == pytest.approx(ways.max(), abs=1e-8)
    assert 3 < np.count_nonzero(ways) < 30


def touching(seed: int):
    """Six vertices touching two moving, turning obstacles."""
    random = np.random.default_rng(seed)
    start, x = random.normal(size=(2, 6, 3))
    x = start + 0.1 * x
    origin, origin_before, turn = random.normal(size=(3, 2, 3))
    normal = random.normal(size=(6, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    pushed = random.uniform(0, 0.3, 6) * (random.random(6) < 0.8)
    return (
        random,
        start,
        x,
        origin,
        0.05 * origin_before + origin,
        0.1 * turn,
        normal,
        pushed,
        np.array([0, 1, 0, 1, 0, 1], np.int32),
    )


@given(SEEDS)
def test_friction_takes_back_at_most_mu_times_the_push(seed):
    random, start, x, origin, before, turn, normal, pushed, obstacle = touching(seed)
    mu, spent = random.uniform(0, 1, 2), random.uniform(0, 0.05, 6)
    expected, used = x.copy(), spent.copy()
    left = np.full((6, 3), np.nan)
    left[2] = x[2]
    for v in np.flatnonzero(pushed):
        if v == 2:
            continue  # it is where it was left
        o = obstacle[v]
        surface = twins.surface_way(x[v], origin[o], before[o], turn[o])
        expected[v], taken = twins.friction(start[v], x[v], surface, normal[v], mu[o] * pushed[v] - spent[v])
        used[v] += taken
    vertex = np.arange(6, dtype=np.int32)
    contact.apply_friction(start, x, origin, before, turn, mu, vertex, obstacle, pushed, normal, spent, left)
    np.testing.assert_allclose(x, expected, atol=1e-13)
    np.testing.assert_array_equal(left, x)
    np.testing.assert_allclose(spent, used, atol=1e-13)


@given(SEEDS, st.sampled_from([0.0, 0.5, 1.0]))
def test_impact_gives_back_its_share_of_the_approach(seed, restitution):
    random, _, x, origin, before, turn, normal, pushed, obstacle = touching(seed)
    velocity, earlier = random.normal(0, 2, (2, 6, 3))
    h, rest_speed, expected = 0.02, 0.6, velocity.copy()
    for v in np.flatnonzero(pushed):
        o = obstacle[v]
        surface = twins.surface_way(x[v], origin[o], before[o], turn[o]) @ normal[v] / h
        expected[v] = twins.impact(velocity[v], earlier[v], surface, normal[v], restitution, rest_speed)
    vertex = np.arange(6, dtype=np.int32)
    contact.contact_velocity(
        velocity, earlier, x, h, origin, before, turn, restitution, rest_speed, vertex, obstacle, pushed, normal
    )
    np.testing.assert_allclose(velocity, expected, atol=1e-11)
