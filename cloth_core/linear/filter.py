"""The operator W with vertices that are pinned for good and vertices that are grabbed and let go."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix, diags

from cloth_core.linear.elimination import Plans
from cloth_core.linear.factor import Factor


class ImplicitFilter:
    """Solves (M + scale K) x = b for the free vertices while the held ones keep given values.

    Pinned vertices are eliminated before factorising. Grabbed ones are not: the factor stays, and the
    constraint forces that keep them in place follow from a small dense system (Schur complement), exact
    to rounding. The answer depends on the two sets alone, never on the order in which they came about.

    Args:
        mass: (V,) kg.
        stiffness: (V, V) N/m, constant, symmetric and positive semi-definite.
        scale: s^2, for example h^2 of an implicit step h.
        place: (V, 3) m, the rest shape, which gives the order of elimination.
        pinned: vertices that never move.
        dense_limit: vertices up to which the inverse is stored as a dense matrix.
        plans: plans of elimination made for the same vertices with the same ones pinned.
    """

    def __init__(
        self,
        mass: np.ndarray,
        stiffness: csr_matrix,
        scale: float,
        *,
        place: np.ndarray,
        pinned: np.ndarray,
        dense_limit: int,
        plans: Plans | None = None,
    ) -> None:
        self._free = np.setdiff1d(np.arange(len(mass)), pinned)
        self._pinned = np.unique(np.asarray(pinned, dtype=np.int64))
        matrix = (diags(mass) + scale * stiffness).tocsr()
        free_rows = matrix[self._free]
        self._coupling = free_rows[:, self._pinned].tocsr()
        inner = free_rows[:, self._free].tocsr()
        free = self._free
        self._factor = Factor(inner, place[free], dense_limit, free, plans) if len(free) else None
        self._row_of = np.full(len(mass), -1, dtype=np.int64)
        self._row_of[self._free] = np.arange(len(self._free))
        self.held = np.zeros(0, dtype=np.int64)

    @property
    def representation(self) -> str:
        """Name of the factor in use: dense or sparse."""
        return self._factor.name if self._factor else "none"

    @property
    def precision(self) -> np.dtype | None:
        """Of the numbers that the factor is kept in; None if no vertex is free."""
        return self._factor.precision if self._factor else None

    def hold(self, vertices: np.ndarray) -> None:
        """From now on keep these vertices, sorted and not pinned, at the values given to :meth:`solve`."""
        self.held = np.asarray(vertices, dtype=np.int64)
        if self._factor is not None:
            self._factor.hold(self._row_of[self.held])

    def solve(self, right_side: np.ndarray, x: np.ndarray) -> None:
        """Overwrite the free rows of ``x`` (V, 3) with the solution for ``right_side`` (V, 3).

        Pinned and held rows of ``x`` are read: they are where those vertices shall be.
        """
        if self._factor is None:
            return
        wanted = x[self.held]
        pulled = x[self._pinned]
        if pulled.any():
            right_side = right_side.copy()
            right_side[self._free] -= self._coupling @ pulled
        self._factor.solve(right_side, x, wanted)
        x[self.held] = wanted
