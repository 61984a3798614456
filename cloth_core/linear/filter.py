"""The operator W with vertices that are pinned for good and vertices that are grabbed and let go."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix, diags

from cloth_core.kernels import dense
from cloth_core.linear.factor import factorise


class ImplicitFilter:
    """Solves (M + h^2 K) x = b for the free vertices while the held ones keep given values.

    Pinned vertices are eliminated before factorising. Grabbed ones are not: the factor stays, and the
    constraint forces that keep them in place follow from a small dense system (Schur complement), exact
    to rounding. The answer depends on the two sets alone, never on the order in which they came about.

    Args:
        mass: (V,) kg.
        stiffness: (V, V) N/m, constant, symmetric and positive semi-definite.
        h: s, the implicit step.
        pinned: vertices that never move.
        dense_limit: vertices up to which the inverse is stored as a dense matrix.
    """

    def __init__(
        self, mass: np.ndarray, stiffness: csr_matrix, h: float, *, pinned: np.ndarray, dense_limit: int
    ) -> None:
        self.h = h
        self._count = len(mass)
        self._free = np.setdiff1d(np.arange(self._count), pinned)
        self._pinned = np.unique(np.asarray(pinned, dtype=np.int64))
        self._all_free = len(self._pinned) == 0
        matrix = (diags(mass) + h * h * stiffness).tocsr()
        free_rows = matrix[self._free]
        self._coupling = free_rows[:, self._pinned].tocsr()
        self._factor = factorise(free_rows[:, self._free].tocsr(), dense_limit) if len(self._free) else None
        self._row_of = np.full(self._count, -1, dtype=np.int64)
        self._row_of[self._free] = np.arange(len(self._free))
        self.hold(np.zeros(0, dtype=np.int32))

    @property
    def representation(self) -> str:
        """Name of the factor in use: dense, cholespy or superlu."""
        return self._factor.name if self._factor else "none"

    def hold(self, vertices: np.ndarray) -> None:
        """From now on keep these vertices, sorted and not pinned, at the values given to :meth:`solve`."""
        self.held = np.asarray(vertices, dtype=np.int64)
        rows = self._row_of[self.held]
        if len(rows) == 0:
            return
        unit = np.zeros((len(self._free), len(rows)))
        unit[rows, np.arange(len(rows))] = 1.0
        self._held_row = rows
        response = self._factor.solve(unit)
        self._response = np.ascontiguousarray(response.T)
        self._schur = dense.cholesky(np.ascontiguousarray(response[rows]))

    def solve(self, right_side: np.ndarray, x: np.ndarray) -> None:
        """Overwrite the free rows of ``x`` (V, 3) with the solution for ``right_side`` (V, 3).

        Pinned and held rows of ``x`` are read: they are where those vertices shall be.
        """
        if self._factor is None:
            return
        b = right_side if self._all_free else right_side[self._free] - self._coupling @ x[self._pinned]
        solution = self._factor.solve(b)
        if len(self.held):
            wanted = x[self.held]
            force = dense.cholesky_solve(self._schur, wanted - solution[self._held_row])
            solution += dense.transposed_product(self._response, force)
            solution[self._held_row] = wanted
        if self._all_free:
            x[:] = solution
        else:
            x[self._free] = solution
