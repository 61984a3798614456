"""Angle-weighted pseudonormals: which side of a closed surface a point is on, from the closest part of it alone."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

FLAT = 1e-10
"""Height of a triangle over its longest edge, below which its normal is noise."""


def pseudonormals(position: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(T, 7, 3) normal of face, edges ab, bc, ca and corners a, b, c of every triangle, and which of them are flat.

    The normal of an edge is the sum of its two faces', that of a corner the sum of all around it weighted by their
    angles there (Baerentzen and Aanaes 2005); lengths are 1. Parts for which that says nothing get 0: those of and
    next to flat triangles, edges of more than two triangles, corners where several fans of triangles meet.
    """
    corner = position[triangles]
    along = np.roll(corner, -1, axis=1) - corner  # ab, bc, ca
    length = np.linalg.norm(along, axis=2)
    face = np.cross(along[:, 0], -along[:, 2])
    twice_area = np.linalg.norm(face, axis=1)
    flat = ~(twice_area > FLAT * length.max(axis=1) ** 2)
    face[flat] = 0.0
    face[~flat] /= twice_area[~flat, None]

    edge_of, faces_at, straight = _edges(triangles)
    clear_edge = straight & (np.bincount(edge_of[flat].ravel(), minlength=len(faces_at)) == 0)
    edge = np.zeros((len(faces_at), 3))
    np.add.at(edge, edge_of, face[:, None, :])
    edge[~clear_edge] = 0.0

    back = -np.roll(along, 1, axis=1)  # from each corner to the one before
    angle = np.arctan2(twice_area[:, None], np.einsum("tnk,tnk->tn", along, back))
    vertex = np.zeros((len(position), 3))
    np.add.at(vertex, triangles, angle[:, :, None] * face[:, None, :])
    clear = _single_fan(triangles, edge_of, len(position))
    clear[triangles[flat]] = False
    for side in range(3):
        clear[triangles[~straight[edge_of[:, side]]][:, [side, (side + 1) % 3]]] = False
    vertex[~clear] = 0.0

    normal = np.concatenate([face[:, None, :], edge[edge_of], vertex[triangles]], axis=1)
    size = np.linalg.norm(normal, axis=2, keepdims=True)
    return np.divide(normal, size, out=np.zeros_like(normal), where=size > 1e-9), flat


def _edges(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(T, 3) the edge that each side lies on, faces at each edge, and whether these are two, wound alike."""
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)
    ordered = np.sort(sides, axis=2).astype(np.int64)
    _, edge_of = np.unique(ordered[..., 0] * (triangles.max() + 1) + ordered[..., 1], return_inverse=True)
    edge_of = edge_of.reshape(triangles.shape)
    faces_at = np.bincount(edge_of.ravel())
    forward = np.bincount(edge_of.ravel(), weights=(sides[..., 0] < sides[..., 1]).ravel())
    return edge_of, faces_at, (faces_at == 2) & (forward == 1)


def _single_fan(triangles: np.ndarray, edge_of: np.ndarray, vertex_count: int) -> np.ndarray:
    """Vertices around which all triangles hang together edge by edge."""
    count = len(triangles)
    number = np.arange(3 * count).reshape(count, 3)
    order = np.argsort(edge_of, axis=None, kind="stable")
    same = np.flatnonzero(np.diff(edge_of.ravel()[order]) == 0)
    one, other = order[same], order[same + 1]
    joins = []
    for shift in (0, 1):  # both ends of the first side, whichever way the second runs
        here = number.ravel()[(one // 3) * 3 + (one % 3 + shift) % 3]
        for turn in (0, 1):
            there = number.ravel()[(other // 3) * 3 + (other % 3 + turn) % 3]
            equal = triangles.ravel()[here] == triangles.ravel()[there]
            joins.append(np.stack([here[equal], there[equal]]))
    row, column = np.concatenate(joins, axis=1)
    graph = coo_matrix((np.ones(len(row)), (row, column)), shape=(3 * count, 3 * count))
    fan = connected_components(graph, directed=False)[1]
    first = np.zeros(fan.max() + 1, np.int64)
    first[fan] = triangles.ravel()
    return np.bincount(first, minlength=vertex_count) <= 1
