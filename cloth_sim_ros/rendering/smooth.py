"""Loop subdivision, so that silhouettes and folds are drawn round although the cloth is computed coarsely."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags, vstack


def loop_subdivision(triangles: np.ndarray, vertex_count: int) -> tuple[csr_matrix, np.ndarray]:
    """One step of Loop's scheme as a matrix, computed once per mesh.

    Old vertices come first, then one new vertex per edge. Borders follow the cubic spline of their own
    vertices alone. Source: Loop, Smooth subdivision surfaces based on triangles, 1987, with Warren's
    weights of the old vertices.

    Args:
        triangles: (T, 3).
        vertex_count: V.

    Returns:
        The sparse (V + E, V) matrix that gives fine positions from coarse ones, and the (4 T, 3) int32
        fine triangles, turned the same way.
    """
    corners = np.concatenate([triangles[:, order] for order in ([0, 1, 2], [1, 2, 0], [2, 0, 1])])
    edge, of_corner, sides = np.unique(np.sort(corners[:, :2], axis=1), axis=0, return_inverse=True, return_counts=True)
    of_corner = of_corner.ravel()
    border = sides == 1
    on_edge = _edge_vertices(edge, border, of_corner, corners[:, 2], vertex_count)
    fine = vstack([_old_vertices(edge, border, vertex_count), on_edge]).tocsr()

    a, b, c = triangles.T
    ab, bc, ca = vertex_count + of_corner.reshape(3, -1)
    four = ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
    return fine, np.concatenate([np.stack(corner, axis=1) for corner in four]).astype(np.int32)


def _edge_vertices(
    edge: np.ndarray, border: np.ndarray, of_corner: np.ndarray, opposite: np.ndarray, vertex_count: int
) -> csr_matrix:
    """3/8 of each end and 1/8 of each opposite corner; the middle of a border edge."""
    inner = ~border[of_corner]
    row = np.concatenate([np.repeat(np.arange(len(edge)), 2), of_corner[inner]])
    column = np.concatenate([edge.ravel(), opposite[inner]])
    weight = np.concatenate([np.full(2 * len(edge), 3.0), np.ones(inner.sum())])
    return _averages(row, column, weight, (len(edge), vertex_count))


def _old_vertices(edge: np.ndarray, border: np.ndarray, vertex_count: int) -> csr_matrix:
    """5/8 of the vertex itself and 3/8 of its neighbours; 3/4 and 1/4 along the border."""
    on_border = np.zeros(vertex_count, bool)
    on_border[edge[border]] = True
    pair = np.concatenate([edge, edge[:, ::-1]])
    pair = pair[np.tile(border, 2) | ~on_border[pair[:, 0]]]
    degree = np.bincount(pair[:, 0], minlength=vertex_count)
    own = np.where(on_border, 6.0, np.where(degree == 3, 7.0 / 3.0, degree * 5.0 / 3.0))
    everyone = np.arange(vertex_count)
    row, column = np.concatenate([everyone, pair[:, 0]]), np.concatenate([everyone, pair[:, 1]])
    weight = np.concatenate([np.maximum(own, 1.0), np.ones(len(pair))])
    return _averages(row, column, weight, (vertex_count, vertex_count))


def _averages(row: np.ndarray, column: np.ndarray, weight: np.ndarray, shape: tuple[int, int]) -> csr_matrix:
    matrix = coo_matrix((weight, (row, column)), shape=shape).tocsr()
    return diags(1.0 / np.asarray(matrix.sum(axis=1)).ravel()) @ matrix
