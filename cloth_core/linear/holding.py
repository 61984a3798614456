"""Rows of a factored matrix that are held at given values: no new factor, and no more work than they are worth."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import dense, holding
from cloth_core.linear.elimination import Elimination, starts


class HeldRows:
    """What it takes to hold some rows of the solution of L L' x = b: a function of the set alone.

    Of G = L^-1 E, E the unit columns of the held rows, only the blocks between them and the root are not zero, and of
    those only the columns that begin below them. With the Schur complement G' G of the constraints, z = L^-1 b becomes
    z + G (G' G)^-1 (wanted - G' z), and the rest of the solve does not change.

    Args:
        plan: of the elimination.
        down: panels of the factor for the forward half of a solve, as :mod:`cloth_core.kernels.panels` describes them.
        places: (K,) of the held rows, in the order of the elimination.
    """

    def __init__(self, plan: Elimination, down: np.ndarray, places: np.ndarray) -> None:
        self._order = np.argsort(places, kind="stable")
        held = places[self._order]
        marked = np.zeros(len(plan.parent), dtype=np.bool_)
        holding.mark_paths(np.searchsorted(plan.first, held, side="right") - 1, plan.parent, marked)
        self._path = np.flatnonzero(marked)
        self._first = plan.first
        widths = np.diff(plan.first)[self._path]
        self._low = np.searchsorted(held, plan.earliest[self._path])
        self._high = np.searchsorted(held, plan.first[self._path + 1])
        self._start = starts(widths * (self._high - self._low))
        self._response = np.empty(self._start[-1])
        number = np.cumsum(marked) - 1
        holding.respond(
            self._path, plan.first, plan.parent, plan.below_start, plan.below, plan.down_start, down,
            held, self._low, self._high, self._start, number, self._response,
        )  # fmt: skip
        self._upper = np.zeros((len(held), len(held)))
        holding.add_squares(widths, self._low, self._high, self._start, self._response, self._upper)
        dense.eliminate(self._upper, len(held))
        self._force = np.empty((3, len(held)))

    @property
    def nbytes(self) -> int:
        """Memory of G."""
        return int(self._response.nbytes)

    def impose(self, wanted: np.ndarray, z: np.ndarray) -> None:
        """Change ``z`` (3, N), the columns of L^-1 b, so that the held rows of x become ``wanted`` (K, 3)."""
        holding.impose(
            self._path, self._first, self._low, self._high, self._start, self._response, self._upper,
            wanted[self._order], self._force, z,
        )  # fmt: skip
