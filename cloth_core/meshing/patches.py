"""A tree of patches of a triangulated surface: halves of halves of neighbouring triangles, fixed for good."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cloth_core.meshing.areas import triangle_areas

LEAF = 4
"""Most triangles in a leaf."""
COMPACT = 60.0
"""Square of a patch's outline over its area, at most, for its normals to tell whether it can touch itself: 16 of a
square, 18 of two. A long strip may wind over itself with all its normals upright."""


@dataclass(frozen=True, eq=False)
class Patches:
    """A complete binary tree; the children of node n are 2 n + 1 and 2 n + 2, all leaves are equally deep.

    Args:
        order: (T,) int32, triangles in the order of the leaves.
        leaf_start: (L + 1,) int32, where the triangles of each leaf begin in ``order``.
        corner_start: (L + 1,) int32, where the vertices of each leaf begin in ``corner``.
        corner: uint32, vertices of the leaves' triangles, each once for a leaf.
        compact: (N,) bool, patches in one piece without holes, of an outline that is short for their area.
        beside_start: (N + 1,) int32, where the row of a node begins in ``beside``.
        beside: int32, the patches of the same depth that share an edge with a node.
    """

    order: np.ndarray
    leaf_start: np.ndarray
    corner_start: np.ndarray
    corner: np.ndarray
    compact: np.ndarray
    beside_start: np.ndarray
    beside: np.ndarray


def patches(position: np.ndarray, triangles: np.ndarray, piece: np.ndarray) -> Patches:
    """The tree of the (T, 3) ``triangles`` at rest at ``position`` (V, 3) m, cut at medians of longest extents.

    Vertices of the same ``piece`` (V,) hang together; pieces are told apart before anything is cut.
    """
    count = len(triangles)
    depth = max(0, int(np.ceil(np.log2(max(1, count) / LEAF))))
    quad = _quads(position, triangles)
    middle = position[triangles].mean(axis=1) if count else np.zeros((0, 3))
    middle = 0.5 * (middle[quad] + middle[_partner(quad)])
    parts, of = [np.arange(count)], piece[triangles[:, 0]]
    for _ in range(depth):
        parts = [half for part in parts for half in _halves(middle, of, quad, part)]
    sizes = np.array([len(part) for part in parts])
    leaf = np.empty(count, np.int64)
    leaf[np.concatenate(parts)] = np.repeat(np.arange(len(parts)), sizes)
    compact, start, beside = _outlines(position, triangles, leaf, depth)
    corner = np.unique(np.stack([np.repeat(leaf, 3), triangles.ravel()], axis=1), axis=0)
    return Patches(
        order=np.concatenate(parts).astype(np.int32),
        leaf_start=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32),
        corner_start=np.searchsorted(corner[:, 0], np.arange(len(parts) + 1)).astype(np.int32),
        corner=corner[:, 1].astype(np.uint32),
        compact=compact,
        beside_start=start,
        beside=beside,
    )


def _quads(position: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(T,) a number for each triangle; two that have their longest edge in common have the same, the lesser of theirs.

    Halved, such a pair would leave triangles that meet at corners alone.
    """
    quad = np.arange(len(triangles))
    first, second, length = _sides(position, triangles)
    longest = np.zeros(len(triangles))
    inner = second >= 0
    np.maximum.at(longest, first, length)
    np.maximum.at(longest, second[inner], length[inner])
    shared = inner & (length >= longest[first]) & (length >= longest[second])
    # Of several longest edges the first one counts, so that a triangle is in one pair.
    free = np.ones(len(triangles), bool)
    for a, b in zip(first[shared], second[shared], strict=True):
        if free[a] and free[b]:
            free[[a, b]] = False
            quad[max(a, b)] = min(a, b)
    return quad


def _partner(quad: np.ndarray) -> np.ndarray:
    """(T,) the other triangle of each pair, or the triangle itself."""
    partner = np.arange(len(quad))
    other = np.flatnonzero(quad != partner)
    partner[quad[other]] = other
    return partner[quad]


def _halves(middle: np.ndarray, piece: np.ndarray, quad: np.ndarray, part: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    if len(part) < 2:
        return part, part[:0]
    points = middle[part]
    # Rounding must not decide how a square is cut: the first of equal extents.
    axis = int(np.argmax(np.round(np.ptp(points, axis=0), 9)))
    along = part[np.lexsort((quad[part], np.round(points[:, axis], 9), piece[part]))]
    half = len(part) // 2
    if quad[along[half - 1]] == quad[along[half]] and len(part) > 2:
        half += 1 if half < len(part) - 1 else -1
    return along[:half], along[half:]


def _outlines(
    position: np.ndarray, triangles: np.ndarray, leaf: np.ndarray, depth: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which nodes are compact, and which lie beside each other, as rows."""
    area = triangle_areas(position, triangles) if len(triangles) else np.zeros(0)
    first, second, length = _sides(position, triangles)
    compact, rows = [], []
    for level in range(depth + 1):
        nodes, base = 2**level, 2**level - 1
        node = leaf >> (depth - level)
        a, b = node[first], np.where(second < 0, -1, node[second])
        across = a != b
        outline = np.bincount(a[across], length[across], nodes)
        inner = across & (b >= 0)
        outline += np.bincount(b[inner], length[inner], nodes)
        # Triangles that meet at a corner alone may turn about it, one over the other.
        inside = ~across & (second >= 0)
        links = coo_array((np.ones(inside.sum()), (first[inside], second[inside])), shape=(len(leaf),) * 2)
        part = connected_components(links, directed=False)[1] if len(leaf) else leaf
        parts = np.bincount(np.unique(node * len(leaf) + part) // max(1, len(leaf)), minlength=nodes)
        # Vertices - edges + triangles is one of a disk, two of two, none of a ring.
        vertices = np.bincount(np.unique(node[:, None] * len(position) + triangles) // len(position), minlength=nodes)
        edges = np.bincount(a, minlength=nodes) + np.bincount(b[inner], minlength=nodes)
        disk = (vertices - edges + np.bincount(node, minlength=nodes) == 1) & (parts == 1)
        compact.append(disk & (outline**2 <= COMPACT * np.bincount(node, area, nodes)))
        rows.append(base + np.stack([np.r_[a[inner], b[inner]], np.r_[b[inner], a[inner]]], axis=1))
    pairs = np.unique(np.concatenate(rows), axis=0)
    start = np.searchsorted(pairs[:, 0], np.arange(2 ** (depth + 1)))
    return np.concatenate(compact), start.astype(np.int32), pairs[:, 1].astype(np.int32)


def _sides(position: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each edge, a triangle, the other one or -1, and its length in m."""
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    number = np.repeat(np.arange(len(triangles)), 3)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    ends, number = ends[order], number[order]
    again = np.r_[False, (ends[1:] == ends[:-1]).all(axis=1)][: len(ends)]
    first = np.flatnonzero(~again)
    last = np.r_[first[1:], len(ends)][: len(first)] - 1
    length = np.linalg.norm(position[ends[first, 1]] - position[ends[first, 0]], axis=1)
    return number[first], np.where(last > first, number[last], -1), length
