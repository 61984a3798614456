"""The kernels of self-collision against their slow twins."""

from __future__ import annotations

import itertools

import layers as twins
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cloth_core import ClothMesh
from cloth_core.kernels import closest, hierarchy, impacts, parting, response, sides, untangle
from cloth_core.meshing.patches import patches

SEEDS = st.integers(0, 2**32 - 1)
ROW = np.arange(4, dtype=np.uint32)


def four(random: np.random.Generator, flat: bool = False) -> np.ndarray:
    x = random.normal(size=(4, 3))
    if flat:
        x[:, 2] *= 1e-3
    return x


@given(SEEDS, st.booleans(), st.booleans())
def test_closest_points_are_as_close_as_two_features_get(seed, edges, flat):
    x = four(np.random.default_rng(seed), flat)
    weight = np.array(closest.closest_weights(x, *ROW, edges))
    assert (np.abs(weight) <= 1 + 1e-12).all() and weight.sum() == pytest.approx(0.0, abs=1e-12)
    signs = (1, 1, -1, -1) if edges else (1, -1, -1, -1)
    assert (weight * signs >= -1e-12).all()
    assert np.linalg.norm(weight @ x) == pytest.approx(twins.distance(x, ROW, edges), abs=1e-9)


@pytest.mark.parametrize("edges", [False, True])
def test_closest_points_of_what_is_degenerate_are_finite_and_on_the_features(edges):
    x = np.zeros((4, 3))
    assert np.isfinite(closest.closest_weights(x, *ROW, edges)).all()
    x[:, 0] = (0.0, 1.0, 2.0, 4.0)  # all in a line
    assert np.linalg.norm(np.array(closest.closest_weights(x, *ROW, edges)) @ x) == pytest.approx(1.0)


@given(SEEDS, st.booleans())
def test_a_direction_that_parts_features_before_and_after_parts_them_in_between(seed, edges):
    random = np.random.default_rng(seed)
    before = four(random)
    after = before + random.normal(size=(4, 3))
    nx, ny, nz, distance = closest.toward(before, *ROW, edges)
    gap = closest.separation(before, *ROW, edges, nx, ny, nz)
    assert gap == pytest.approx(distance, abs=1e-9)
    if closest.separation(after, *ROW, edges, nx, ny, nz) > 0:
        assert twins.meeting(before, after, ROW, edges) == -1.0


@given(SEEDS, st.booleans())
def test_meetings_are_found_when_they_happen(seed, edges):
    random = np.random.default_rng(seed)
    start = four(random)
    end = random.normal(size=(4, 3)) - start
    place = np.zeros((4, 3))
    found = impacts.meeting(start, end, *ROW, edges, place)
    expected = twins.meeting(start, end, ROW, edges)
    if expected < 0.0:
        assert found < 0.0 or twins.distance(place, ROW, edges) < 1e-5
    else:
        assert found == pytest.approx(expected, abs=1e-6)
        assert twins.distance(place, ROW, edges) < 1e-5


def test_meetings_happen_often_enough_to_be_tested():
    random = np.random.default_rng(1)
    many = [four(random) for _ in range(300)]
    seen = [twins.meeting(x, random.normal(size=(4, 3)) - x, ROW, bool(n % 2)) >= 0 for n, x in enumerate(many)]
    assert 40 < sum(seen) < 260


@given(SEEDS)
def test_contacts_push_and_rub_as_coulomb_says(seed):
    random = np.random.default_rng(seed)
    count, vertices = 6, 9
    row = np.array([random.choice(vertices, 4, replace=False) for _ in range(count)], np.uint32)
    weight = np.array([[1.0, *(-random.dirichlet((1, 1, 1)))] for _ in range(count)])
    normal = random.normal(size=(count, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    target, inverse_mass = random.uniform(0.1, 1.0, count), random.uniform(0.5, 2.0, vertices)
    inverse_mass[0] = 0.0
    start = random.normal(size=(vertices, 3))
    x = start + 0.5 * random.normal(size=(vertices, 3))
    pushed, spent, mobility = random.choice([0.0, 0.1], count), random.uniform(0, 0.02, count), np.empty(count)
    response.ease(row, weight, inverse_mass, count, mobility)
    np.testing.assert_allclose(mobility, (weight**2 * inverse_mass[row]).sum(axis=1))
    contacts = (row, weight, normal, target)
    expected = twins.push_apart(start, x, contacts, inverse_mass, 0.4, pushed, spent, response.IDLE)
    momentum = (x[1:] / inverse_mass[1:, None]).sum(axis=0)
    moved = x.copy()
    response.push_apart(start, moved, *contacts, inverse_mass, mobility, 0.4, pushed, spent, 0, count, False)
    for got, wanted in zip((moved, pushed, spent), expected, strict=True):
        np.testing.assert_allclose(got, wanted, atol=1e-12)
    np.testing.assert_array_equal(moved[0], x[0])
    if not (row == 0).any():
        np.testing.assert_allclose((moved[1:] / inverse_mass[1:, None]).sum(axis=0), momentum, atol=1e-12)


@given(SEEDS)
def test_contacts_go_on_as_they_stand_and_keep_more_as_they_come_apart(seed):
    random = np.random.default_rng(seed)
    start, weight = random.normal(size=(4, 3)), np.array([[1.0, -0.2, -0.3, -0.5]])
    normal, keep, recover = np.array([[0.6, 0.0, 0.8]]), np.array([0.5]), 0.1
    up = normal[0] @ (weight[0] @ start)
    for before in (0.3, 0.5):
        target, pushed, spent = np.array([before]), np.ones(1), np.ones(1)
        response.renew(start, ROW[None].copy(), weight, normal, target, keep, recover, 1, pushed, spent)
        assert target[0] == pytest.approx(np.clip(up + recover, before, 0.5)) and pushed[0] == spent[0] == 0.0


@given(SEEDS)
def test_impacts_end_as_inelastic_ones_and_keep_momentum(seed):
    random = np.random.default_rng(seed)
    velocity, inverse_mass = random.normal(size=(4, 3)), random.uniform(0.5, 2.0, 4)
    weight, normal = np.array([[0.3, 0.7, -0.4, -0.6]]), np.array([[0.6, 0.0, 0.8]])
    mobility = np.array([(weight[0] ** 2 * inverse_mass).sum()])
    momentum = (velocity / inverse_mass[:, None]).sum(axis=0)
    start, row, h = random.normal(size=(4, 3)), ROW[None].copy(), 0.1
    up, before = normal[0] @ (weight[0] @ start), normal[0] @ (weight[0] @ velocity)
    target = np.array([up + 0.05 * random.normal()])
    rest = (row, weight, normal, target, inverse_mass, mobility)
    response.end_impacts(velocity, start, *rest, np.ones(1), 1, h)
    after = normal[0] @ (weight[0] @ velocity)
    corrected = max(0.0, target[0] - up) / h
    assert after == pytest.approx(max(0.0, before - corrected) if before > 0 else 0.0, abs=1e-12)
    np.testing.assert_allclose((velocity / inverse_mass[:, None]).sum(axis=0), momentum, atol=1e-12)
    untouched = velocity.copy()
    response.end_impacts(velocity, start, *rest, np.zeros(1), 1, h)
    np.testing.assert_array_equal(velocity, untouched)  # what was not pushed goes on


@given(SEEDS, st.floats(0.0, 1.0), st.sampled_from([-1.0, 1.0]))
def test_a_side_tells_what_is_beside_a_triangle(seed, margin, sign):
    x = four(np.random.default_rng(seed))
    p, *corner = x
    normal = np.cross(corner[1] - corner[0], corner[2] - corner[0])
    normal *= sign / np.linalg.norm(normal)
    beyond = []
    for k in range(3):
        q, r, s = (corner[(k + i) % 3] for i in range(3))
        inward = (s - q) - (s - q) @ (r - q) / ((r - q) @ (r - q)) * (r - q)
        beyond.append(-(p - q) @ inward / np.linalg.norm(inward))
    if abs(max(beyond) - margin) > 1e-9:
        assert sides.is_beside(x, *ROW, *normal, sign, margin) == (max(beyond) > margin)


@given(SEEDS, st.booleans())
def test_ways_of_features_that_meet_are_never_told_apart(seed, edges):
    random = np.random.default_rng(seed)
    start, tangled = four(random), np.zeros(4, np.bool_)
    end = random.normal(size=(4, 3)) - start
    if twins.meeting(start, end, ROW, edges) > 0.0:
        assert impacts.ways_meet(start, end, *ROW, edges) and impacts.may_pass(start, end, *ROW, edges, tangled)
    away = np.where(np.arange(4) < (2 if edges else 1), 100.0, 0.0)[:, None]
    assert not impacts.ways_meet(start + away, end + away, *ROW, edges)


@given(SEEDS)
def test_edges_through_triangles_are_told_from_others(seed):
    x = np.random.default_rng(seed).normal(size=(5, 3))
    assert untangle.runs_through(x, *range(5)) == twins.runs_through(*x)


def searched(mesh: ClothMesh, before: np.ndarray, after: np.ndarray, margin: float) -> set[tuple[int, int]]:
    """Pairs of triangles whose leaves the solver's search lists."""
    tree = patches(mesh.rest_position, mesh.triangles, mesh.component)
    triangles = mesh.triangles[tree.order].astype(np.uint32)
    leaves, nodes = len(tree.leaf_start) - 1, len(tree.compact)
    low, high, patch_low, patch_high = (np.empty((n, 9)) for n in (len(triangles),) * 2 + (nodes,) * 2)
    hierarchy.fit_triangles(before, after, triangles, mesh.triangle_area[tree.order], low, high)
    hierarchy.fit_patches(low, high, tree.leaf_start, patch_low, patch_high)
    pair = np.empty((10**5, 2), np.int32)
    count = hierarchy.meeting_leaves(
        leaves, tree.compact, tree.beside_start, tree.beside, patch_low, patch_high, margin, pair
    )
    fit = np.empty((len(triangles), 3)), np.empty((len(triangles), 6)), *(np.empty((leaves, 3)) for _ in range(3))
    parting.mark_leaves(pair[:count], wanted := np.zeros(leaves, np.bool_))
    parting.fit_leaves(before, after, triangles, tree.leaf_start, wanted, *fit)
    normal, gap = np.empty((count, 3)), np.empty(count)
    listed = (pair[:count], normal, gap)
    parting.part_leaves(before, after, tree.corner_start, tree.corner, *fit[2:], margin, *listed)
    count = parting.keep_close(margin, *listed)
    of = [tree.order[tree.leaf_start[n] : tree.leaf_start[n + 1]] for n in range(leaves)]
    found = {(int(t), int(u)) for a, b in pair[:count] for t in of[a] for u in of[b]}
    return found | {(u, t) for t, u in found}


@pytest.mark.parametrize("seed", range(6))
def test_all_that_comes_close_on_its_way_is_found(seed):
    random = np.random.default_rng(seed)
    mesh, margin = twins.sheets((0.0, 0.0, 0.0), (0.01, 0.02, 0.02), count=7), 0.01
    half = mesh.vertex_count // 2
    before = mesh.rest_position + 0.01 * random.normal(size=(mesh.vertex_count, 3))
    after = before + 0.01 * random.normal(size=before.shape) + random.normal(size=3)  # all of it flies off
    after[half:, 2] -= 0.03
    found = searched(mesh, before, after, margin)
    close = 0
    for t, u in itertools.product(range(len(mesh.triangles)), repeat=2):
        rows = mesh.triangles[t], mesh.triangles[u]
        if mesh.component[rows[0][0]] >= mesh.component[rows[1][0]]:
            continue
        for share in (0.0, 0.5, 1.0):
            x = before + share * (after - before)
            if min(twins.vertex_triangle(x[v], *x[rows[1]]) for v in rows[0]) < margin:
                close += 1
                assert (t, u) in found, (t, u, share)
                break
    assert close > 50
    assert len(found) < 0.5 * len(mesh.triangles) ** 2


def test_what_falls_together_does_not_meet_nor_does_what_is_smooth():
    mesh = twins.sheets((0.0, 0.0, 0.0), (0.0, 0.0, 0.05))
    place = mesh.rest_position
    assert searched(mesh, place, place - [0.0, 0.0, 5.0], 0.01) == set()
    half = mesh.vertex_count // 2
    bowed = place.copy()
    bowed[:, 2] += 2.0 * place[:, 0] ** 2
    assert searched(mesh, bowed, bowed - [0.0, 0.0, 5.0], 0.01) == set()
    down = place.copy()
    down[half:, 2] -= 0.045
    assert len(searched(mesh, place, down, 0.01)) > len(mesh.triangles)


def test_patches_tell_strips_rings_and_pieces_from_disks():
    square = ClothMesh.grid(width=1.0, height=1.0, columns=17, rows=17)
    compact = patches(square.rest_position, square.triangles, square.component).compact
    assert compact[:31].all() and compact.mean() > 0.9
    strip = ClothMesh.grid(width=4.0, height=0.1, columns=81, rows=3)
    compact = patches(strip.rest_position, strip.triangles, strip.component).compact
    assert not compact[0] and compact[-64:].mean() > 0.8
    middle = square.rest_position[square.triangles].mean(axis=1)
    ring = square.triangles[np.abs(middle[:, :2]).max(axis=1) > 0.2]
    assert not patches(square.rest_position, ring, square.component).compact[0]
    two = twins.sheets((0.0, 0.0, 0.0), (0.0, 0.0, 0.01))
    compact = patches(two.rest_position, two.triangles, two.component).compact
    assert not compact[0] and compact[1:3].all()


@pytest.mark.parametrize(("second", "compact"), [((2, 3, 4), False), ((1, 3, 2), True)], ids=["corner", "edge"])
def test_triangles_that_meet_at_a_corner_alone_are_no_patch_that_normals_tell_about(second, compact):
    place = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 1.0, 0.0), (1.0, 2.0, 0.0), (0.0, 2.0, 0.0)])
    tree = patches(place, np.array([(0, 1, 2), second]), np.zeros(5, int))
    assert len(tree.compact) == 1 and tree.compact[0] == compact


def test_every_triangle_stands_in_one_leaf_and_neighbours_know_each_other():
    mesh = ClothMesh.grid(width=1.0, height=0.7, columns=11, rows=8)
    tree = patches(mesh.rest_position, mesh.triangles, mesh.component)
    assert sorted(tree.order) == list(range(len(mesh.triangles)))
    leaves = len(tree.leaf_start) - 1
    edges = []
    for leaf in range(leaves):
        rows = mesh.triangles[tree.order[tree.leaf_start[leaf] : tree.leaf_start[leaf + 1]]]
        corner = tree.corner[tree.corner_start[leaf] : tree.corner_start[leaf + 1]]
        assert set(corner) == set(rows.ravel()) and len(corner) == len(set(corner))
        edges.append({tuple(sorted(pair)) for row in rows for pair in itertools.combinations(row, 2)})
    for a, b in itertools.permutations(range(leaves), 2):
        n = leaves - 1 + a
        beside = tree.beside[tree.beside_start[n] : tree.beside_start[n + 1]]
        assert (leaves - 1 + b in beside) == bool(edges[a] & edges[b])
