"""Ways to keep the inverse of one symmetric positive definite matrix: dense, or as a sparse factor."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.linalg import splu

from cloth_core.kernels.dense import transposed_product

try:
    import cholespy
except ImportError:  # an accelerator, not a need: scipy's factor gives the same answer, slower
    cholespy = None


class Factor(Protocol):
    """The inverse of an (N, N) matrix, ready to be applied."""

    name: str

    def solve(self, right_side: np.ndarray) -> np.ndarray:
        """The (N, M) solution for an (N, M) right-hand side."""
        ...


class SuperLU:
    """SciPy's sparse factor, always available."""

    name = "superlu"

    def __init__(self, matrix: csr_matrix) -> None:
        self._factor = splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", options=dict(SymmetricMode=True))

    def solve(self, right_side: np.ndarray) -> np.ndarray:
        """Two sparse triangular solves."""
        return self._factor.solve(right_side)


class SparseCholesky:
    """CHOLMOD through cholespy: half the work of an LU factor, three columns at once."""

    name = "cholespy"

    def __init__(self, matrix: csr_matrix) -> None:
        entries = coo_matrix(matrix)
        self._factor = cholespy.CholeskySolverD(
            matrix.shape[0],
            np.ascontiguousarray(entries.row, dtype=np.int32),
            np.ascontiguousarray(entries.col, dtype=np.int32),
            np.ascontiguousarray(entries.data, dtype=np.float64),
            cholespy.MatrixType.COO,
        )

    def solve(self, right_side: np.ndarray) -> np.ndarray:
        """Two sparse triangular solves."""
        right_side = np.ascontiguousarray(right_side, dtype=np.float64)
        solution = np.empty_like(right_side)
        self._factor.solve(right_side, solution)
        return solution


class DenseInverse:
    """The inverse itself, as the paper stores W: one matrix product a solve, best for small cloths."""

    name = "dense"

    def __init__(self, matrix: csr_matrix) -> None:
        inverse = _sparse(matrix).solve(np.eye(matrix.shape[0]))
        self._inverse = 0.5 * (inverse + inverse.T)

    def solve(self, right_side: np.ndarray) -> np.ndarray:
        """One matrix product."""
        return transposed_product(self._inverse, right_side)  # symmetric


def _sparse(matrix: csr_matrix) -> Factor:
    return SparseCholesky(matrix) if cholespy is not None else SuperLU(matrix)


def factorise(matrix: csr_matrix, dense_limit: int) -> Factor:
    """The representation that is fastest at this size: dense up to ``dense_limit`` rows."""
    return DenseInverse(matrix) if matrix.shape[0] <= dense_limit else _sparse(matrix)
