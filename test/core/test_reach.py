"""Reach: between the straight line and the way along the threads, and no farther than the cloth can be pulled."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from cloth_core import ClothMesh
from cloth_core.physics.reach import PINS, Reach
from cloth_core.validation.geometry import irregular_sheet

LIMIT = 1.1


def reached(mesh, first, second):
    """(N, M) m at rest, between the rims of a grasp and of the pins; infinite where nothing joins them."""
    tethers = Reach(mesh, LIMIT).tethers({"hand": np.sort(first), PINS: np.sort(second)})
    if not tethers:
        return None
    (tether,) = tethers
    assert (tether.first, tether.second) == ("hand", PINS)
    return tether.first_rim, tether.second_rim, tether.longest / LIMIT


def along_springs(mesh, first, second):
    i, j = mesh.spring_vertex.T
    ways = coo_matrix((mesh.spring_rest, (i, j)), shape=(mesh.vertex_count,) * 2)
    return dijkstra(ways, directed=False, indices=first)[:, second]


@pytest.mark.parametrize("mesh", [ClothMesh.grid(width=1.0, height=0.7, columns=12, rows=9), irregular_sheet(1, 1, 9)])
def test_a_flat_sheet_reaches_the_straight_line(mesh):
    random = np.random.default_rng(1)
    for _ in range(10):
        first, second = np.split(random.choice(mesh.vertex_count, 9, replace=False), [4])
        a, b, reach = reached(mesh, first, second)
        straight = np.linalg.norm(mesh.rest_position[a][:, None] - mesh.rest_position[b][None], axis=2)
        np.testing.assert_allclose(reach, straight, rtol=1e-12)


def tube(around=24, rows=10, radius=0.2):
    angle = np.arange(around) * 2.0 * np.pi / around
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    place = np.concatenate([np.column_stack([ring, np.full(around, 0.05 * row)]) for row in range(rows)])
    triangles = []
    for row in range(rows - 1):
        for n in range(around):
            a, b = row * around + n, row * around + (n + 1) % around
            triangles += [(a, b, b + around), (a, b + around, a + around)]
    return ClothMesh.from_triangles(place, np.array(triangles), warp=(0.0, 0.0, 1.0)), around


def test_a_tube_reaches_along_its_surface():
    mesh, around = tube()
    row = 5 * around
    half_way = around // 2 * 2 * 0.2 * np.sin(np.pi / around)  # along the ring's edges
    _, _, reach = reached(mesh, np.array([row]), np.array([row + around // 2]))
    assert 0.9 * half_way < reach[0, 0] <= half_way * (1 + 1e-12)
    assert reach[0, 0] > 1.3 * 0.4  # the straight line goes through the hole
    _, _, across = reached(mesh, np.array([0]), np.array([9 * around + around // 2]))
    geodesic = np.hypot(half_way, 9 * 0.05)
    assert 0.9 * geodesic < across[0, 0] <= geodesic * (1 + 1e-12)


def rope(place, **options):
    links = np.stack([np.arange(len(place) - 1), np.arange(1, len(place))], axis=1)
    return ClothMesh.from_springs(place, links, stiffness=100.0, mass=0.01, **options)


def coil(count=60):
    angle = np.linspace(0.0, 6.0 * np.pi, count)
    return np.column_stack([0.2 * np.cos(angle), 0.2 * np.sin(angle), 0.02 * angle])


@pytest.mark.parametrize("options", [{}, {"rest_length": np.full(59, 0.01)}, {"rest_length": np.full(59, 0.2)}])
def test_a_coiled_rope_reaches_its_whole_length(options):
    mesh = rope(coil(), **options)
    first, second = np.array([3, 4, 5, 6]), np.array([40, 41])
    a, b, reach = reached(mesh, first, second)
    assert a.tolist() == [3, 6] and b.tolist() == [40, 41]  # what lies inside a hand pulls at nothing
    np.testing.assert_allclose(reach, along_springs(mesh, a, b), rtol=1e-12)


def test_what_nothing_joins_or_only_what_has_no_limit_reaches_anywhere():
    two = rope(coil(), limited=np.arange(59) != 30)
    assert reached(two, np.array([3]), np.array([40])) is None
    assert reached(two, np.array([3]), np.array([20])) is not None


def test_the_reach_follows_from_what_is_held_alone():
    mesh, around = tube()
    held = {"a": np.array([0, 1, around]), "b": np.array([100, 101]), PINS: np.array([200, 201])}
    often = Reach(mesh, LIMIT)
    for some in ({"a": held["a"]}, {"a": held["b"], PINS: held["a"]}, held):
        tethers = often.tethers(some)
    again = Reach(mesh, LIMIT).tethers(dict(reversed(held.items())))
    assert [(t.first, t.second) for t in tethers] == [("a", PINS), ("b", PINS), ("b", "a")]
    for one, other in zip(tethers, again, strict=True):
        assert (one.first, one.second) == (other.first, other.second)
        assert (one.longest == other.longest).all()
