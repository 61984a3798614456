"""The plan of an elimination: what a factor owes to the pattern of its matrix, whatever the numbers in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from cloth_core.kernels import fronts
from cloth_core.kernels.shares import WORTH
from cloth_core.linear.dissection import Block, dissect


@dataclass(frozen=True, eq=False)
class Elimination:
    """Which rows are eliminated when, with which others, and whom that concerns; S blocks, N rows, in postorder.

    A matrix of the same pattern, of another material or another substep, is eliminated by the same plan.
    """

    indptr: np.ndarray
    """With ``indices``, the pattern: that of a sorted compressed sparse row matrix."""
    indices: np.ndarray
    largest: int
    """Rows of a block that is not split any more."""
    order: np.ndarray
    """(N,) row that is eliminated n-th."""
    place: np.ndarray
    """(N,) its inverse."""
    first: np.ndarray
    """(S + 1,) places at which the blocks begin."""
    parent: np.ndarray
    """(S,) block that separates this one from its sibling; -1 for the root."""
    earliest: np.ndarray
    """(S,) place at which the subtree of a block begins."""
    below_start: np.ndarray
    """(S + 1,) into ``below``: places, rising, of the rows that the columns of a block have below themselves."""
    below: np.ndarray
    down_start: np.ndarray
    """(S + 1,) at which the panels of the blocks begin, those for the forward half of a solve."""
    up_start: np.ndarray
    """(S + 1,) the same for the backward half, which begins with the last block: that of block s is at [s + 1]."""

    parts: np.ndarray
    """(P, 2) blocks, first and one past the last, that have no row in common but those of the blocks after them all."""

    def fits(self, matrix: csr_matrix, largest: int) -> bool:
        """Whether a sorted ``matrix`` of the same places has this very pattern."""
        return (
            self.largest == largest
            and np.array_equal(self.indptr, matrix.indptr)
            and np.array_equal(self.indices, matrix.indices)
        )


def plan_elimination(matrix: csr_matrix, place: np.ndarray, largest: int) -> Elimination:
    """The plan for a sorted symmetric (N, N) ``matrix`` whose rows lie at ``place`` (N, D) m.

    Args:
        matrix: whose entries say who is neighbour to whom.
        place: where the rows lie in the rest shape, for the order alone.
        largest: rows of a block that is not split any more.
    """
    blocks = dissect(matrix, place, largest)
    widths = np.array([len(block.vertices) for block in blocks])
    first = starts(widths)
    order = np.concatenate([block.vertices for block in blocks])
    turned = np.empty_like(order)
    turned[order] = np.arange(len(order))
    parent, earliest = _tree(blocks, first)
    below_start, below = fronts.rows_below(matrix.indptr, matrix.indices, order, turned, first, parent)
    return Elimination(
        matrix.indptr, matrix.indices, largest, order, turned, first, parent, earliest, below_start, below,
        *fronts.panel_starts(first, below_start), _parts(parent, len(order)),
    )  # fmt: skip


class Plans:
    """Plans at hand, for matrices of the same vertices at the same places; each is made once."""

    def __init__(self) -> None:
        self._known: list[Elimination] = []

    def of(self, matrix: csr_matrix, place: np.ndarray, largest: int) -> Elimination:
        """The plan for ``matrix``; see :func:`plan_elimination`, which gives the same."""
        for plan in tuple(self._known):
            if plan.fits(matrix, largest):
                return plan
        self._known.append(plan_elimination(matrix, place, largest))
        return self._known[-1]


def starts(lengths: np.ndarray) -> np.ndarray:
    """Where parts of these ``lengths`` (S,) begin, one after the other; (S + 1,) with the end of the last."""
    return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)


def _tree(blocks: list[Block], first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    parent, earliest = np.full(len(blocks), -1, dtype=np.int64), first[:-1].copy()
    for number, block in enumerate(blocks):
        for child in block.children:
            parent[child] = number
            earliest[number] = min(earliest[number], earliest[child])
    return parent, earliest


def _parts(parent: np.ndarray, rows: int) -> np.ndarray:
    root = len(parent) - 1
    ends = np.flatnonzero(parent == root) + 1
    if rows < WORTH or len(ends) < 2:
        ends = np.array([root + 1])
    return np.column_stack([np.concatenate([[0], ends[:-1]]), ends])
