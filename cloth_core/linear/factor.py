"""The inverse of one symmetric positive definite matrix, as a sparse Cholesky factor in dense panels."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from cloth_core.kernels import dense, panels
from cloth_core.linear.dissection import Block, dissect

LEAF = 24
"""Vertices of the smallest blocks: larger ones waste products on zeros, smaller ones leave vector lanes empty."""

SINGLE_BYTES = 500_000
"""Panels beyond this no longer stay near the processor, and are kept in single precision: reading them is what then
takes the time. The right-hand sides of a step are corrections, so that their last digits are made up for by the
next one."""


class Factor:
    """(N, N) A = L L' in the order of a nested dissection, computed front by front (Duff and Reid 1983).

    Args:
        matrix: A.
        place: (N, 3) m, where the rows lie; for the order alone.
        rows: (N,) where the rows of A stand in the right-hand sides and solutions, which may have more.
        dense_limit: rows up to which L is one dense block, and L^-1 what is stored, as the paper stores W.
    """

    def __init__(
        self, matrix: csr_matrix, place: np.ndarray, dense_limit: int, rows: np.ndarray | None = None
    ) -> None:
        size = matrix.shape[0]
        self.name = "dense" if size <= dense_limit else "sparse"
        matrix = matrix.tocsr()
        matrix.sort_indices()
        blocks = dissect(matrix, place, max(dense_limit, 1) if self.name == "dense" else LEAF)
        order = np.concatenate([block.vertices for block in blocks])
        self._order = order if rows is None else rows[order]
        self._place = np.empty(size, dtype=np.int64)
        self._place[order] = np.arange(size)
        widths = np.array([len(block.vertices) for block in blocks])
        self._first = _starts(widths)
        below, made = self._eliminate(matrix, blocks)
        heights = widths + [len(rows) for rows in below]
        self._below, self._below_start = np.concatenate(below).astype(np.int64), _starts(heights - widths)
        self._panel, self._panel_start = np.concatenate(made), _starts([len(panel) for panel in made])
        if self._panel.nbytes > SINGLE_BYTES:
            self._panel = self._panel.astype(np.float32)
        self._parent = _parents(blocks)
        self._all = np.arange(len(blocks))
        self._y = np.empty((3, size))
        self._work, self._block = np.empty((3, heights.max())), np.empty((3, widths.max() + 3))
        self.hold(np.zeros(0, dtype=np.int64))

    @property
    def nbytes(self) -> int:
        """Memory of the panels."""
        return int(self._panel.nbytes)

    def hold(self, rows: np.ndarray) -> None:
        """From now on keep these ``rows`` of the solution at given values.

        Of G = L^-1 E, E the unit columns of the held rows, only the blocks between them and the root are not zero:
        few. With the small Schur complement G' G, a solve is exact without a new factor.
        """
        self._held = self._place[rows]
        if len(rows) == 0:
            return
        path = self._path_to_root(self._held)
        self._support = np.concatenate([np.arange(self._first[s], self._first[s + 1]) for s in path])
        columns = np.zeros((len(self._support), 3 * ((len(rows) + 2) // 3)))
        for start in range(0, len(rows), 3):
            some = self._held[start : start + 3]
            self._y[:] = 0.0
            self._y[np.arange(len(some)), some] = 1.0
            self._forward(self._path_to_root(some))
            columns[:, start : start + 3] = self._y[:, self._support].T
        self._response = np.ascontiguousarray(columns[:, : len(rows)].T)
        self._schur = dense.cholesky(dense.transposed_product(columns, columns)[: len(rows), : len(rows)].copy())

    def solve(self, right_side: np.ndarray, solution: np.ndarray, wanted: np.ndarray | None = None) -> None:
        """A^-1 ``right_side`` into ``solution``, held rows at the ``wanted`` (K, 3) values."""
        panels.gather(self._order, right_side, self._y)
        self._forward(self._all)
        if len(self._held):
            self._impose(wanted)
        panels.solve_backward(
            self._first, self._below_start, self._below, self._panel_start, self._panel,
            self._y, self._work, self._block,
        )  # fmt: skip
        panels.scatter(self._order, self._y, solution)

    def _impose(self, wanted: np.ndarray) -> None:
        reached = dense.product(self._response, self._y[:, self._support].T)
        force = dense.cholesky_solve(self._schur, wanted - reached)
        self._y[:, self._support] += dense.transposed_product(self._response, force).T

    def _forward(self, blocks: np.ndarray) -> None:
        panels.solve_forward(
            blocks, self._first, self._below_start, self._below, self._panel_start, self._panel,
            self._y, self._work, self._block,
        )  # fmt: skip

    def _path_to_root(self, places: np.ndarray) -> np.ndarray:
        """Blocks of these places in the elimination order, and all that depend on them, in rising order."""
        found = set()
        for block in np.searchsorted(self._first, places, side="right") - 1:
            while block >= 0 and block not in found:
                found.add(int(block))
                block = self._parent[block]
        return np.array(sorted(found))

    def _eliminate(self, matrix: csr_matrix, blocks: list[Block]) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Rows below, and panel, of every block."""
        row_of = np.zeros(matrix.shape[0], dtype=np.int64)
        updates: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        below, made = [], []
        for number, block in enumerate(blocks):
            first, end = self._first[number], self._first[number + 1]
            parts = [updates.pop(child) for child in block.children]
            touched = [self._place[matrix.indices[matrix.indptr[v] : matrix.indptr[v + 1]]] for v in block.vertices]
            rows = np.unique(np.concatenate(touched + [rows for rows, _ in parts]))
            rows = rows[rows >= end]
            width, count = end - first, end - first + len(rows)
            row_of[first:end] = np.arange(width)
            row_of[rows] = np.arange(width, count)
            front = np.zeros((count, count))
            panels.assemble_front(
                matrix.indptr, matrix.indices, matrix.data, self._place, block.vertices, first, row_of, front
            )
            for child_rows, update in parts:
                panels.extend_add(front, row_of[child_rows], update)
            dense.eliminate(front, width)
            panel = np.zeros(count * ((width + 3) // 4 * 4))
            panels.fill_panel(front, width, np.zeros((width, width)), panel)
            below.append(rows)
            made.append(panel)
            updates[number] = rows, front[width:, width:]
        return below, made


def _starts(lengths: np.ndarray | list[int]) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)


def _parents(blocks: list[Block]) -> np.ndarray:
    parent = np.full(len(blocks), -1, dtype=np.int64)
    for number, block in enumerate(blocks):
        parent[list(block.children)] = number
    return parent
