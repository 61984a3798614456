"""Dense kernels against numpy."""

from __future__ import annotations

import numpy as np
import pytest

from cloth_core.kernels import dense


@pytest.mark.parametrize("size", [1, 2, 7, 40])
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_elimination_leaves_the_cholesky_factor_and_the_schur_complement(size, share):
    root = np.random.default_rng(size).normal(size=(size, size + 3))
    matrix, width = root @ root.T, round(share * size)
    front = matrix.copy()
    dense.eliminate(front, width)
    upper = np.triu(front)[:width]
    np.testing.assert_allclose((upper.T @ upper)[:width], matrix[:width], rtol=1e-9, atol=1e-9)
    inner, cross, outer = matrix[:width, :width], matrix[:width, width:], matrix[width:, width:]
    left = np.triu(outer - cross.T @ np.linalg.solve(inner, cross)) if width else np.triu(outer)
    np.testing.assert_allclose(np.triu(front)[width:, width:], left, rtol=1e-7, atol=1e-9)
