"""The inverse of one symmetric positive definite matrix, as a sparse Cholesky factor in dense panels."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from cloth_core.kernels import fronts, panels
from cloth_core.kernels.lanes import LANES
from cloth_core.linear.elimination import Plans
from cloth_core.linear.holding import HeldRows

LEAF = 40
"""Vertices of the smallest blocks: larger ones waste products on zeros, smaller ones leave lanes empty."""

SINGLE_BYTES = 500_000
"""Panels that would be larger in double precision no longer stay near the processor, and are single: reading them is
what then takes the time. The right-hand sides of a step are corrections, so that their last digits are made up for by
the next one."""


class Factor:
    """(N, N) A = L L' in the order of a nested dissection, computed front by front (Duff and Reid 1983).

    Args:
        matrix: A.
        place: (N, 3) m, where the rows lie; for the order alone.
        dense_limit: rows up to which L is one dense block, and L^-1 what is stored, as the paper stores W.
        rows: (N,) where the rows of A stand in the right-hand sides and solutions, which may have more.
        plans: plans of elimination for these places, to look into and to add to.
    """

    def __init__(
        self,
        matrix: csr_matrix,
        place: np.ndarray,
        dense_limit: int,
        rows: np.ndarray | None = None,
        plans: Plans | None = None,
    ) -> None:
        size = matrix.shape[0]
        self.name = "dense" if size <= dense_limit else "sparse"
        matrix = matrix.tocsr()
        matrix.sort_indices()
        largest = max(dense_limit, 1) if self.name == "dense" else LEAF
        self._plan = plan = (plans or Plans()).of(matrix, place, largest)
        self._order = plan.order if rows is None else rows[plan.order]
        single = plan.down_start[-1] * np.dtype(np.float64).itemsize > SINGLE_BYTES
        kept = np.float32 if single else np.float64
        self._down, self._up = np.empty(plan.down_start[-1], kept), np.empty(plan.up_start[0], kept)
        fronts.factorise(
            matrix.indptr, matrix.indices, matrix.data, plan.order, plan.place, plan.first, plan.parent,
            plan.below_start, plan.below, plan.down_start, self._down, plan.up_start, self._up,
        )  # fmt: skip
        tallest = (np.diff(plan.first) + np.diff(plan.below_start)).max()
        self._y = np.empty((3, size), self._down.dtype)
        parts = len(plan.parts)
        self._work = np.empty((parts, 6, tallest + LANES), self._down.dtype)
        self._beyond = np.empty((parts, 3, size - plan.first[plan.parts[-1, 1]]), self._down.dtype)
        self._held: HeldRows | None = None

    @property
    def nbytes(self) -> int:
        """Memory of the panels."""
        return int(self._down.nbytes + self._up.nbytes)

    @property
    def precision(self) -> np.dtype:
        """Of the numbers in the panels."""
        return self._down.dtype

    def hold(self, rows: np.ndarray) -> None:
        """From now on keep these ``rows`` of the solution at given values, exactly, without a new factor."""
        self._held = HeldRows(self._plan, self._down, self._plan.place[rows]) if len(rows) else None

    def solve(self, right_side: np.ndarray, solution: np.ndarray, wanted: np.ndarray | None = None) -> None:
        """A^-1 ``right_side`` into ``solution``, held rows at the ``wanted`` (K, 3) values."""
        plan = self._plan
        panels.solve_forward(
            plan.parts, self._order, right_side, plan.first, plan.below_start, plan.below,
            plan.down_start, self._down, self._y, self._beyond, self._work,
        )  # fmt: skip
        if self._held is not None:
            self._held.impose(wanted, self._y)
        panels.solve_backward(
            plan.parts, plan.first, plan.below_start, plan.below,
            plan.up_start, self._up, self._y, self._work, self._order, solution,
        )  # fmt: skip
