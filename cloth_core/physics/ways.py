"""Ways over a cloth at rest: what its threads join, and how far it is from here to there over its surface."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components

from cloth_core.kernels.panels import touching
from cloth_core.kernels.ways import shortest_ways
from cloth_core.mesh import ClothMesh
from cloth_core.meshing.flatness import flat_and_convex

DETOUR = 1.09
"""A way over edges and across the diagonals of triangle pairs, over the straight one, at the most: 1.035 on
equilateral triangles, 1 / cos(22.5 deg) = 1.082 on squares. Ways over springs that are no surface have no shortcut."""


class Ways:
    """The graph of a mesh for shortest ways. It never changes, so that solvers in several threads may share it.

    Args:
        mesh: the cloth.
    """

    def __init__(self, mesh: ClothMesh) -> None:
        self._mesh, self._count = mesh, mesh.vertex_count
        is_sheet = len(mesh.hinge_vertex) > 0
        limited = mesh.spring_vertex[mesh.spring_limited]
        self.part = connected_components(_linked(limited, self._count), directed=False)[1]
        """(V,): number of the part that limited springs join each vertex to."""
        self.detour = DETOUR if is_sheet else 1.0
        """Longest that a way of this graph is, over the shortest on the cloth."""
        self.straight = 1.0 if is_sheet else _shrinkage(mesh)
        """Shortest that the way between two vertices can be, over the straight line as placed."""
        self._links = _linked(mesh.spring_vertex, self._count)
        self._flat = np.zeros(self._count, dtype=bool)
        if is_sheet:
            self._flat = flat_and_convex(mesh.rest_position, mesh.triangles, mesh.component)
        self._graph = None if self._flat.all() else self._lengths(is_sheet)

    def bend(self, first: np.ndarray, second: np.ndarray) -> bool:
        """Whether a way from ``first`` to ``second`` vertices may be longer than the straight line."""
        return not (self._flat[first].all() and self._flat[second].all())

    def rim(self, vertex: np.ndarray) -> np.ndarray:
        """Those that a spring joins to others: what is inside moves with them anyhow. Sorted."""
        vertex, outside = np.unique(vertex).astype(np.int64), np.ones(self._count, dtype=bool)
        outside[vertex] = False
        leaves = np.empty(len(vertex), dtype=bool)
        touching(self._links.indptr, self._links.indices, vertex, outside, leaves)
        return vertex[leaves]

    def of(self, begin: int, wanted: np.ndarray) -> np.ndarray:
        """Shortest ways from ``begin`` to the ``wanted`` vertices, (V,) m; infinite beyond, and where there is none."""
        way = np.empty(self._count)
        shortest_ways(self._graph.indptr, self._graph.indices, self._graph.data, begin, wanted, way)
        return way

    def _lengths(self, is_sheet: bool) -> csr_matrix:
        mesh = self._mesh
        if not is_sheet:
            return _graph(mesh.spring_vertex[mesh.spring_limited], mesh.spring_rest[mesh.spring_limited], self._count)
        opposite, across = _unfolded(mesh.rest_position, mesh.hinge_vertex)
        pairs = np.concatenate([mesh.spring_vertex, opposite])
        return _graph(pairs, np.concatenate([mesh.spring_rest, across]), self._count)


def _shrinkage(mesh: ClothMesh) -> float:
    """Springs may be shorter at rest than as placed, and then all that they join is."""
    limited, rest = mesh.spring_vertex[mesh.spring_limited], mesh.spring_rest[mesh.spring_limited]
    placed = np.linalg.norm(np.diff(mesh.rest_position[limited], axis=1)[:, 0], axis=1)
    return float(min(1.0, (rest / np.maximum(placed, 1e-12)).min(initial=1.0)))


def _linked(pairs: np.ndarray, count: int) -> csr_matrix:
    """Who is linked to whom, symmetric."""
    i, j = pairs.T
    ends = np.concatenate([i, j]), np.concatenate([j, i])
    return coo_matrix((np.ones(2 * len(pairs), dtype=np.int8), ends), shape=(count, count)).tocsr()


def _graph(pairs: np.ndarray, length: np.ndarray, count: int) -> csr_matrix:
    """Symmetric; of two links between the same vertices, the shorter one counts."""
    pairs = np.concatenate([pairs, pairs[:, ::-1]]).astype(np.int64)
    length = np.maximum(np.concatenate([length, length]), 1e-12)
    order = np.lexsort((length, pairs[:, 1], pairs[:, 0]))
    pairs, length = pairs[order], length[order]
    first = np.ones(len(pairs), dtype=bool)
    first[1:] = (pairs[1:] != pairs[:-1]).any(axis=1)
    return csr_matrix((length[first], tuple(pairs[first].T)), shape=(count, count))


def _unfolded(position: np.ndarray, hinge: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The two vertices opposite each shared edge, and their distance (H,) m once the hinge is laid flat."""
    a, b, c, d = (position[column] for column in hinge.T)
    axis = b - a
    length = np.linalg.norm(axis, axis=1)
    axis = axis / length[:, None]
    along = ((d - c) * axis).sum(axis=1)
    up, down = (np.linalg.norm(np.cross(axis, corner - a), axis=1) for corner in (c, d))
    return hinge[:, 2:], np.hypot(along, up + down)
