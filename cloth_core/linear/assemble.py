"""The constant matrices behind W: springs at zero rest length (eq. 4) and quadratic bending."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from cloth_core.material import Material
from cloth_core.mesh import ClothMesh


class Assembly:
    """What these matrices owe to a mesh, whatever its material, of which they are linear functions.

    It never changes, so that solvers in several threads may share it.
    """

    def __init__(self, mesh: ClothMesh) -> None:
        self._count = mesh.vertex_count
        i, j = mesh.spring_vertex.T
        rows, columns = np.concatenate([i, j, i, j]), np.concatenate([i, j, j, i])
        self._springs = self._summed(rows, columns, np.zeros(len(rows)))
        entry = _entries_of(self._springs, rows, columns)
        self._weights = {
            kind: np.bincount(entry, np.concatenate([share, share, -share, -share]), self._springs.nnz)
            for kind, share in enumerate(mesh.spring_weight.T)
            if share.any()
        }
        w = mesh.hinge_weight
        values = w[:, :, None] * w[:, None, :]
        rows, columns = np.repeat(mesh.hinge_vertex, 4, axis=1), np.tile(mesh.hinge_vertex, (1, 4))
        self._hinges = self._summed(rows.ravel(), columns.ravel(), values.ravel())

    def stretch(self, material: Material) -> csr_matrix:
        """-H of eq. (4), positive semi-definite, (V, V) N/m: k on the diagonal, -k between the ends of a spring."""
        shares = (material.stretch_warp, material.stretch_weft, material.shear, 1.0)
        data = np.zeros(self._springs.nnz)
        for kind, weights in self._weights.items():
            data += shares[kind] * weights
        return self._like(self._springs, data)

    def bending(self, material: Material) -> csr_matrix:
        """Hessian of the quadratic bending energy, (V, V) N/m: bend * (weight outer weight) of every hinge."""
        return self._like(self._hinges, material.bend * self._hinges.data)

    def _summed(self, rows: np.ndarray, columns: np.ndarray, values: np.ndarray) -> csr_matrix:
        matrix = coo_matrix((values, (rows, columns)), shape=(self._count, self._count)).tocsr()
        matrix.sum_duplicates()  # zeros stay: one pattern for all
        return matrix

    def _like(self, pattern: csr_matrix, data: np.ndarray) -> csr_matrix:
        return csr_matrix((data, pattern.indices, pattern.indptr), shape=pattern.shape)


def _entries_of(pattern: csr_matrix, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Where in the data of a sorted matrix the entries at ``rows`` and ``columns`` (N,) stand."""
    width = pattern.shape[1]
    places = np.repeat(np.arange(pattern.shape[0]) * width, np.diff(pattern.indptr)) + pattern.indices
    return np.searchsorted(places, rows.astype(np.int64) * width + columns)


def stretch_matrix(mesh: ClothMesh, material: Material) -> csr_matrix:
    """:meth:`Assembly.stretch` of a mesh of which nothing else is wanted."""
    return Assembly(mesh).stretch(material)


def bending_matrix(mesh: ClothMesh, material: Material) -> csr_matrix:
    """:meth:`Assembly.bending` of a mesh of which nothing else is wanted."""
    return Assembly(mesh).bending(material)
