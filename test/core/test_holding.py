"""Held rows of a factor, and plans that serve several matrices: against dense algebra, and to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix, diags

from cloth_core import ClothMesh, Material
from cloth_core.linear import Plans, bending_matrix, stretch_matrix
from cloth_core.linear import factor as factor_module
from cloth_core.linear.elimination import plan_elimination
from cloth_core.linear.factor import Factor

MESH = ClothMesh.grid(width=0.8, height=0.7, columns=23, rows=19)
PLACE = MESH.rest_position
PATCH = np.flatnonzero(np.linalg.norm(PLACE - PLACE[200], axis=1) < 0.17)
SCATTERED = np.sort(np.random.default_rng(1).choice(len(PLACE), 64, replace=False))
SETS = pytest.mark.parametrize("rows", [PATCH, SCATTERED, np.array([7]), np.arange(len(PLACE))], ids=len)


def matrix_of(material: Material, kind: str = "stretch", time: float = 0.002) -> csr_matrix:
    stiffness = stretch_matrix(MESH, material) if kind == "stretch" else bending_matrix(MESH, material)
    matrix = (diags(MESH.vertex_mass(material)) + time * time * stiffness).tocsr()
    matrix.sort_indices()
    return matrix


def solved(factor: Factor, wanted: np.ndarray | None = None) -> np.ndarray:
    solution = np.empty_like(PLACE)
    factor.solve(np.random.default_rng(5).normal(size=PLACE.shape), solution, wanted)
    return solution


@SETS
@pytest.mark.parametrize("kind", ["stretch", "bending"])
@pytest.mark.parametrize("largest", [5, 24, 1000])
def test_the_schur_complement_is_the_inverse_between_the_held_rows(rows, kind, largest, monkeypatch):
    monkeypatch.setattr(factor_module, "LEAF", largest)
    monkeypatch.setattr(factor_module, "SINGLE_BYTES", 10**9)
    matrix = matrix_of(Material(), kind)
    factor = Factor(matrix, PLACE, 0)
    factor.hold(rows)
    held, upper = factor._held, np.triu(factor._held._upper)
    between = np.linalg.inv(matrix.toarray())[np.ix_(rows, rows)][np.ix_(held._order, held._order)]
    np.testing.assert_allclose(upper.T @ upper, between, atol=1e-11 * between.max())


@SETS
def test_hundreds_of_held_rows_get_what_is_wanted_and_the_rest_follows(rows):
    matrix, random = matrix_of(Material()), np.random.default_rng(2)
    wanted, right_side = random.normal(size=(len(rows), 3)), random.normal(size=PLACE.shape)
    factor, solution, shuffled = Factor(matrix, PLACE, 0), np.empty_like(PLACE), random.permutation(len(rows))
    factor.hold(rows[shuffled])
    factor.solve(right_side, solution, wanted[shuffled])
    free, whole = np.setdiff1d(np.arange(len(PLACE)), rows), matrix.toarray()
    expected = np.empty_like(PLACE)
    expected[rows] = wanted
    expected[free] = np.linalg.solve(whole[np.ix_(free, free)], right_side[free] - whole[np.ix_(free, rows)] @ wanted)
    np.testing.assert_allclose(solution, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(("rows", "most"), [(SCATTERED, 0.35), (np.array([7]), 0.25)], ids=["many", "one"])
def test_only_the_blocks_between_the_held_rows_and_the_root_are_kept(rows, most):
    matrix = matrix_of(Material())
    factor = Factor(matrix, PLACE, 0)
    factor.hold(rows)
    assert 8 * len(rows) * 5 < factor._held.nbytes < most * 8 * len(rows) * len(PLACE)


def test_a_plan_serves_another_material_to_the_last_bit():
    plans, soft, stiff = Plans(), Material(), Material(stretch_warp=9e4, shear=3.0, areal_density=1.1)
    first = Factor(matrix_of(soft), PLACE, 0, plans=plans)
    again = Factor(matrix_of(stiff, time=0.01), PLACE, 0, plans=plans)
    fresh = Factor(matrix_of(stiff, time=0.01), PLACE, 0)
    assert len(plans._known) == 1
    np.testing.assert_array_equal(solved(again), solved(fresh))
    assert (solved(first) != solved(fresh)).any()


@pytest.mark.parametrize("other", ["bending", "another limit", "unsheared"])
def test_what_no_plan_fits_gets_one_of_its_own(other):
    plans, material = Plans(), Material()
    Factor(matrix_of(material), PLACE, 0, plans=plans)
    if other == "unsheared":
        material = Material(shear=0.0)
    matrix, limit = matrix_of(material, "bending" if other == "bending" else "stretch"), 0
    matrix.eliminate_zeros()
    if other == "another limit":
        limit = len(PLACE)
    with_plans, fresh = Factor(matrix, PLACE, limit, plans=plans), Factor(matrix, PLACE, limit)
    assert len(plans._known) == 2
    np.testing.assert_array_equal(solved(with_plans), solved(fresh))


def test_the_rows_below_a_block_are_those_of_the_dense_factor_and_few_more():
    matrix, kept, needed = matrix_of(Material(), "bending"), 0, 0
    plan = plan_elimination(matrix, PLACE, 5)
    lower = np.linalg.cholesky(matrix.toarray()[np.ix_(plan.order, plan.order)])
    for s in range(len(plan.parent)):
        end = plan.first[s + 1]
        rows = plan.below[plan.below_start[s] : plan.below_start[s + 1]]
        filled = end + np.flatnonzero((np.abs(lower[end:, plan.first[s] : end]) > 1e-14).any(axis=1))
        assert (np.diff(rows) > 0).all() and np.isin(filled, rows).all()
        kept, needed = kept + len(rows), needed + len(filled)
    assert needed <= kept < 1.25 * needed
