"""The sparse factor in dense panels against numpy, on graphs of every shape."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_matrix, diags

from cloth_core import ClothMesh, Material
from cloth_core.linear import bending_matrix, stretch_matrix
from cloth_core.linear import factor as factor_module
from cloth_core.linear.dissection import dissect
from cloth_core.linear.factor import Factor

DENSE, SPARSE = 10_000, 0


def graph(seed: int, size: int, links: int) -> tuple[csr_matrix, np.ndarray]:
    """A random weighted Laplacian plus a positive diagonal, not connected in general, and random places."""
    random = np.random.default_rng(seed)
    i, j = random.integers(0, size, (2, links))
    weight = 10.0 ** random.uniform(-3, 3, links)
    off = csr_matrix((weight, (i, j)), shape=(size, size))
    off = off + off.T
    off.setdiag(0.0)
    laplacian = diags(np.asarray(off.sum(axis=1)).ravel()) - off
    return (laplacian + diags(random.uniform(0.5, 2.0, size))).tocsr(), random.normal(size=(size, 3))


def sheet(columns: int, rows: int, kind: str) -> tuple[csr_matrix, np.ndarray]:
    mesh, material = ClothMesh.grid(width=1.0, height=0.7, columns=columns, rows=rows), Material()
    stiffness = stretch_matrix(mesh, material) if kind == "stretch" else bending_matrix(mesh, material)
    return (diags(mesh.vertex_mass(material)) + 1e-5 * stiffness).tocsr(), mesh.rest_position


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    size=st.integers(1, 90),
    density=st.floats(0.0, 4.0),
    limit=st.sampled_from([DENSE, SPARSE]),
    held=st.integers(0, 7),
)
def test_any_graph_is_solved_with_any_rows_held(seed, size, density, limit, held):
    matrix, place = graph(seed, size, int(density * size))
    random = np.random.default_rng(seed + 1)
    rows = np.sort(random.choice(size, min(held, size), replace=False))
    right_side, wanted = random.normal(size=(size, 3)), random.normal(size=(len(rows), 3))
    factor, solution = Factor(matrix, place, limit), np.empty((size, 3))
    factor.hold(rows)
    factor.solve(right_side, solution, wanted)
    whole, free = matrix.toarray(), np.setdiff1d(np.arange(size), rows)
    expected = np.empty((size, 3))
    expected[rows] = wanted
    expected[free] = np.linalg.solve(whole[np.ix_(free, free)], right_side[free] - whole[np.ix_(free, rows)] @ wanted)
    np.testing.assert_allclose(solution, expected, atol=1e-8 * (1.0 + np.abs(expected).max()))


@pytest.mark.parametrize("kind", ["stretch", "bending"])
@pytest.mark.parametrize(("columns", "rows"), [(2, 2), (3, 40), (24, 17), (31, 30)])
def test_sheets_are_solved_to_rounding(columns, rows, kind):
    matrix, place = sheet(columns, rows, kind)
    right_side = np.random.default_rng(3).normal(size=place.shape)
    for limit in (DENSE, SPARSE) if len(place) < 200 else (SPARSE,):  # larger ones are kept in single precision
        solution = np.empty_like(right_side)
        Factor(matrix, place, limit).solve(right_side, solution)
        np.testing.assert_allclose(matrix @ solution, right_side, atol=1e-10)


def test_releasing_gives_back_the_very_same_solution():
    matrix, place = sheet(20, 20, "stretch")
    right_side = np.random.default_rng(5).normal(size=place.shape)
    factor = Factor(matrix, place, SPARSE)
    before, after = np.empty_like(right_side), np.empty_like(right_side)
    factor.solve(right_side, before)
    factor.hold(np.arange(40, 60))
    factor.solve(right_side, after, np.ones((20, 3)))
    assert (after[40:60] != before[40:60]).any()
    factor.hold(np.zeros(0, int))
    factor.solve(right_side, after)
    np.testing.assert_array_equal(before, after)


def test_large_panels_in_single_precision_are_good_to_five_digits(monkeypatch):
    matrix, place = sheet(40, 40, "stretch")
    right_side = np.random.default_rng(7).normal(size=place.shape)
    exact, rough = np.empty_like(right_side), np.empty_like(right_side)
    monkeypatch.setattr(factor_module, "SINGLE_BYTES", 10**9)
    double = Factor(matrix, place, SPARSE)
    monkeypatch.setattr(factor_module, "SINGLE_BYTES", 0)
    single = Factor(matrix, place, SPARSE)
    assert 2 * single.nbytes == double.nbytes
    double.solve(right_side, exact)
    single.solve(right_side, rough)
    error = np.abs(rough - exact).max() / np.abs(exact).max()
    assert 1e-10 < error < 1e-5


@pytest.mark.parametrize("largest", [1, 5, 24, 1000])
def test_dissection_lists_every_vertex_once_and_separates(largest):
    matrix, place = sheet(17, 13, "stretch")
    blocks = dissect(matrix, place, largest)
    everyone = np.concatenate([block.vertices for block in blocks])
    np.testing.assert_array_equal(np.sort(everyone), np.arange(len(place)))

    def below(number):
        block = blocks[number]
        return np.concatenate([block.vertices, *(below(child) for child in block.children)])

    for number, block in enumerate(blocks):
        assert all(child < number for child in block.children)
        if block.children:
            one, other = (below(child) for child in block.children)
            assert matrix[one][:, other].nnz == 0
        else:
            assert len(block.vertices) <= max(largest, 16)  # what its separator would use up stays whole


def test_a_good_order_keeps_the_factor_small():
    matrix, place = sheet(60, 60, "stretch")
    entries = Factor(matrix, place, SPARSE).nbytes / 8  # two panels in single precision
    assert 10 * 3600 < entries < 60 * 3600  # n log n; a band would have 60 n, the dense triangle 1,800 n
