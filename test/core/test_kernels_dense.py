"""Dense kernels against numpy."""

from __future__ import annotations

import numpy as np
import pytest

from cloth_core.kernels import dense


@pytest.mark.parametrize("size", [1, 2, 7, 40])
def test_cholesky_solves_what_numpy_solves(size):
    random = np.random.default_rng(size)
    root = random.normal(size=(size, size + 3))
    matrix, right_side = root @ root.T, random.normal(size=(size, 3))
    upper = np.triu(dense.cholesky(matrix))
    np.testing.assert_allclose(upper.T @ upper, matrix, rtol=1e-12, atol=1e-12)
    expected = np.linalg.solve(matrix, right_side)
    np.testing.assert_allclose(dense.cholesky_solve(upper, right_side), expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("shape", [(1, 1, 1), (4, 9, 3), (30, 5, 2), (0, 4, 3)])
def test_transposed_product(shape):
    k, n, m = shape
    matrix, right_side = np.random.default_rng(k).normal(size=(k, n)), np.random.default_rng(n).normal(size=(k, m))
    np.testing.assert_allclose(dense.transposed_product(matrix, right_side), matrix.T @ right_side, atol=1e-12)
