"""The constant matrices behind W: springs and gauges at zero rest length (eq. 4), and quadratic bending."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from cloth_core.linear.gauges import gauges
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh


class Assembly:
    """What these matrices owe to a mesh, whatever its material, of which they are linear functions.

    It never changes, so that solvers in several threads may share it.
    """

    def __init__(self, mesh: ClothMesh) -> None:
        self._mesh, self._count = mesh, mesh.vertex_count
        i, j = mesh.spring_vertex.T
        rows, columns = np.concatenate([i, j, i, j]), np.concatenate([i, j, j, i])
        self._springs = self._summed(rows, columns, np.zeros(len(rows)))
        entry = _entries_of(self._springs, rows, columns)
        self._weights = {
            kind: np.bincount(entry, np.concatenate([share, share, -share, -share]), self._springs.nnz)
            for kind, share in enumerate(mesh.spring_weight.T)
            if share.any()
        }
        corners = mesh.triangles if len(mesh.triangle_slope) else np.zeros((0, 3), np.int64)
        rows, columns = np.repeat(corners, 3, axis=1).ravel(), np.tile(corners, (1, 3)).ravel()
        self._triangles = self._summed(rows, columns, np.zeros(len(rows)))
        self._corner_pairs = _entries_of(self._triangles, rows, columns)
        entries = (mesh.curvature_weight, mesh.curvature_vertex, mesh.curvature_start)
        reading = csr_matrix(entries, shape=(len(mesh.curvature_start) - 1, self._count))
        self._curvature = (reading.T @ reading).tocsr()
        self._curvature.sort_indices()

    def stretch(self, material: Material) -> csr_matrix:
        """-H of eq. (4), positive semi-definite, (V, V) N/m: k on the diagonal, -k between the ends of a spring.

        A gauge that reads the sum of w_i x_i over the corners of a triangle likewise adds its stiffness times w_i w_j.
        """
        if self._mesh.is_membrane(material):
            return self._membrane(material)
        data = np.zeros(self._springs.nnz)
        for kind, weights in self._weights.items():
            data += (*material.sheet_stiffness(), 1.0)[kind] * weights
        return self._like(self._springs, data)

    def _membrane(self, material: Material) -> csr_matrix:
        direction, modulus = gauges(material)
        weight = self._mesh.triangle_slope @ direction.T
        values = np.einsum("t,d,tid,tjd->tij", self._mesh.triangle_area, modulus, weight, weight, optimize=True)
        return self._like(
            self._triangles, np.bincount(self._corner_pairs, values.ravel(), minlength=self._triangles.nnz)
        )

    def bending(self, material: Material) -> csr_matrix:
        """Hessian of the quadratic bending energy, (V, V) N/m: bend * (weight outer weight) of every reading."""
        return self._like(self._curvature, material.bend * self._curvature.data)

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
