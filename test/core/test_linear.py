"""W: one operator, whatever its representation and whoever is held."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import diags

from cloth_core import ClothMesh, Material
from cloth_core.linear import ImplicitFilter, bending_matrix, stretch_matrix
from cloth_core.linear.factor import Factor

SCALE = 0.004**2
MATERIAL = Material.preset("denim")
MESH = ClothMesh.grid(width=0.9, height=0.6, columns=11, rows=9)
MASS = MESH.vertex_mass(MATERIAL)
STIFFNESS = stretch_matrix(MESH, MATERIAL) + bending_matrix(MESH, MATERIAL)
A = (diags(MASS) + SCALE * STIFFNESS).toarray()
DENSE, SPARSE = 5000, 0


def operator(pinned=(), dense_limit=DENSE) -> ImplicitFilter:
    return filter_by(STIFFNESS, SCALE, pinned, dense_limit)


def filter_by(stiffness, scale, pinned=(), dense_limit=DENSE) -> ImplicitFilter:
    return ImplicitFilter(
        MASS, stiffness, scale, place=MESH.rest_position, pinned=np.array(pinned, np.int32), dense_limit=dense_limit
    )


def reduced_solution(right_side: np.ndarray, held: np.ndarray, values: np.ndarray) -> np.ndarray:
    """From scratch: held rows eliminated, the rest solved with numpy."""
    free = np.setdiff1d(np.arange(len(A)), held)
    x = np.zeros_like(right_side)
    x[held] = values
    x[free] = np.linalg.solve(A[np.ix_(free, free)], right_side[free] - A[np.ix_(free, held)] @ values)
    return x


def solved(w: ImplicitFilter, right_side: np.ndarray, held: np.ndarray, values: np.ndarray) -> np.ndarray:
    x = np.full_like(right_side, np.nan)
    x[held] = values
    w.solve(right_side, x)
    return x


def test_stiffness_is_equation_4_and_symmetric():
    h = -stretch_matrix(MESH, MATERIAL).toarray()
    k = MESH.spring_stiffness(MATERIAL)
    expected = np.zeros_like(h)
    for (i, j), kij in zip(MESH.spring_vertex, k, strict=True):
        expected[i, j] = expected[j, i] = kij
    expected -= np.diag(expected.sum(axis=1))
    np.testing.assert_allclose(h, expected, atol=1e-10)
    np.testing.assert_allclose(STIFFNESS.toarray(), STIFFNESS.toarray().T, rtol=1e-12)


@pytest.mark.parametrize("limit", [DENSE, SPARSE])
def test_every_representation_solves_the_system_to_rounding(limit):
    right_side = np.random.default_rng(1).normal(size=(len(A), 3))
    solution = np.full_like(right_side, np.nan)
    Factor((diags(MASS) + SCALE * STIFFNESS).tocsr(), MESH.rest_position, limit).solve(right_side, solution)
    expected = np.linalg.solve(A, right_side)
    np.testing.assert_allclose(solution, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("scale", [0.0, 1e-6, 1e-2])
def test_the_scale_weighs_the_stiffness_against_the_masses(scale):
    right_side = np.random.default_rng(2).normal(size=(len(A), 3))
    got = solved(filter_by(STIFFNESS, scale), right_side, np.array([], int), np.zeros((0, 3)))
    weighed = MASS[:, None] * got + scale * (STIFFNESS @ got)
    np.testing.assert_allclose(weighed, right_side, atol=1e-9)


def test_representation_follows_the_number_of_free_vertices():
    assert operator(dense_limit=len(A)).representation == "dense"
    assert operator(dense_limit=len(A) - 1).representation == "sparse"
    assert operator(pinned=[3], dense_limit=len(A) - 1).representation == "dense"
    assert operator(pinned=range(len(A))).representation == "none"


@pytest.mark.parametrize("limit", [DENSE, SPARSE])
def test_w_times_masses_keeps_a_rigid_motion(limit):
    """Without pins the rows of W M sum to one: a translation passes unfiltered (notes on eq. 4)."""
    moved = solved(operator(dense_limit=limit), np.outer(MASS, [1.0, -2.0, 0.5]), np.array([], int), np.zeros((0, 3)))
    np.testing.assert_allclose(moved, np.tile([1.0, -2.0, 0.5], (len(A), 1)), rtol=1e-11)


def test_w_is_symmetric_and_not_negative_without_bending():
    flat = stretch_matrix(MESH, MATERIAL)
    w = filter_by(flat, SCALE)
    inverse = np.column_stack(
        [solved(w, np.eye(len(A))[:, k : k + 3], np.array([], int), np.zeros((0, 3))) for k in range(0, len(A), 3)]
    )
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-12 * inverse.max())
    assert (inverse > 0).all()


@pytest.mark.parametrize("limit", [DENSE, SPARSE])
@pytest.mark.parametrize("seed", range(6))
def test_holding_is_solving_the_reduced_system(limit, seed):
    random = np.random.default_rng(seed)
    chosen = random.permutation(len(A))[: random.integers(1, 40)]
    cut = random.integers(0, len(chosen) + 1)
    pinned, grasped = np.sort(chosen[:cut]), np.sort(chosen[cut:])
    held, values = np.concatenate([pinned, grasped]), random.normal(size=(len(chosen), 3))
    right_side = random.normal(size=(len(A), 3))
    w = operator(pinned, limit)
    w.hold(grasped)
    got = solved(w, right_side, held, values)
    expected = reduced_solution(right_side, held, values)
    np.testing.assert_array_equal(got[held], values)
    np.testing.assert_allclose(got, expected, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("limit", [DENSE, SPARSE])
def test_the_path_to_a_held_set_leaves_no_trace(limit):
    random = np.random.default_rng(3)
    right_side, values = random.normal(size=(len(A), 3)), random.normal(size=(4, 3))
    held = np.array([5, 17, 40, 80])
    straight, winding = operator(dense_limit=limit), operator(dense_limit=limit)
    straight.hold(held)
    for step in ([80], [1, 2, 3], [], [5, 80], list(range(50)), [5, 17, 40, 80]):
        winding.hold(np.array(step, int))
    np.testing.assert_array_equal(solved(straight, right_side, held, values), solved(winding, right_side, held, values))
    winding.hold(np.array([], int))
    nothing = np.array([], int)
    np.testing.assert_array_equal(
        solved(winding, right_side, nothing, np.zeros((0, 3))),
        solved(operator(dense_limit=limit), right_side, nothing, np.zeros((0, 3))),
    )


def test_all_vertices_may_be_pinned_or_grasped():
    everyone = np.arange(len(A))
    values = np.random.default_rng(0).normal(size=(len(A), 3))
    grasped = operator()
    grasped.hold(everyone)
    for w in (operator(pinned=everyone), grasped):
        np.testing.assert_array_equal(solved(w, np.ones((len(A), 3)), everyone, values), values)
