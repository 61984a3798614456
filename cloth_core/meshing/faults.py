"""Finds what makes no physical sense in a mesh; each function returns the numbers of the elements at fault."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from cloth_core.meshing.areas import triangle_areas

LARGEST_COORDINATE = 1e6
"""m, as for poses: beyond it squares of lengths lose the digits that a thread of cloth needs."""

ATOM = 1e-10
"""m: nothing in a cloth is shorter."""

SLIVER = 1e-6
"""Height of a triangle over its longest edge, below which its shape says nothing about stiffness or bending."""

DUST = 1e-4
"""Area of a part of a mesh over that of its largest part, below which it is a left-over of modelling or scanning."""


def unplaced(position: np.ndarray) -> np.ndarray:
    """Vertices whose place is not finite, or further than :data:`LARGEST_COORDINATE` from the origin."""
    return np.flatnonzero(~(np.abs(position) <= LARGEST_COORDINATE).all(axis=1))


def outside(elements: np.ndarray, vertex_count: int) -> np.ndarray:
    """Elements that name a vertex that does not exist."""
    return np.flatnonzero(((elements < 0) | (elements >= vertex_count)).any(axis=1))


def collapsed(elements: np.ndarray) -> np.ndarray:
    """Elements that name the same vertex twice."""
    ordered = np.sort(elements, axis=1)
    return np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))


def repeated(elements: np.ndarray) -> np.ndarray:
    """Elements that name the same vertices, in any order, as one before them."""
    ordered = np.sort(elements, axis=1)
    order = np.lexsort(ordered.T)  # stable: among equals the first comes first
    ordered = ordered[order]
    return np.sort(order[1:][(ordered[1:] == ordered[:-1]).all(axis=1)])


def unused(vertex_count: int, triangles: np.ndarray) -> np.ndarray:
    """Vertices that no triangle names."""
    return np.setdiff1d(np.arange(vertex_count), triangles)


def slivers(position: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Triangles without area, or with next to none for their length."""
    corner = position[triangles]
    longest = np.linalg.norm(corner - np.roll(corner, -1, axis=1), axis=2).max(axis=1, initial=0.0)
    least = np.maximum(SLIVER * longest, ATOM)
    return np.flatnonzero(~(2 * triangle_areas(position, triangles) > least * longest))


class _Sides(NamedTuple):
    """The three sides of every triangle, sorted so that those on one edge of the mesh stand together."""

    triangle: np.ndarray
    start: np.ndarray
    end: np.ndarray
    follows: np.ndarray
    """(3T - 1,) bool: the next side lies on the same edge."""


def _sides(triangles: np.ndarray) -> _Sides:
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.lexsort((high, low))
    low, high = low[order], high[order]
    follows = (low[1:] == low[:-1]) & (high[1:] == high[:-1])
    return _Sides(order // 3, start[order], end[order], follows)


def crowded(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (E, 2) that more than two triangles share, and those triangles."""
    side = _sides(triangles)
    third = np.flatnonzero(side.follows[1:] & side.follows[:-1]) + 2
    edges = np.unique(np.sort(np.stack([side.start[third], side.end[third]], axis=1), axis=1), axis=0)
    around = np.concatenate([third - 2, third - 1, third])
    return edges, np.unique(side.triangle[around])


def turned(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles wound against most of their piece of surface, and all those of pieces that have one side only.

    Every edge must belong to at most two triangles. Each triangle is taken twice, as it is and reversed, and
    joined to its neighbours the way round that fits: a piece falls into two halves, one for each of its
    sides, or hangs together if it has but one (a Moebius strip).
    """
    count, side = len(triangles), _sides(triangles)
    at = np.flatnonzero(side.follows)
    one, other = side.triangle[at], side.triangle[at + 1]
    clash = side.start[at] == side.start[at + 1]
    if not clash.any():
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    joined = np.concatenate([one, one + count]), np.concatenate([other + count * clash, other + count * ~clash])
    graph = coo_matrix((np.ones(2 * len(at)), joined), shape=(2 * count, 2 * count))
    halves, half = connected_components(graph, directed=False)
    as_it_is, reversed_ = half[:count], half[count:]
    size, first = np.bincount(as_it_is, minlength=halves), np.full(halves, count)
    np.minimum.at(first, as_it_is, np.arange(count))
    fewer = size[as_it_is] < size[reversed_]
    later = (size[as_it_is] == size[reversed_]) & (first[as_it_is] > first[reversed_])
    return np.flatnonzero(fewer | later), np.flatnonzero(as_it_is == reversed_)


def dust(position: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Triangles of parts that hang together with nothing and are too small to be cloth, beside one that is not.

    A part is dust if its area is less than :data:`DUST` of the largest part's, or if it is one triangle alone,
    which cannot bend, beside a larger part of several.
    """
    joined = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    graph = coo_matrix((np.ones(triangles.size), joined), shape=(len(position),) * 2)
    part = connected_components(graph, directed=False)[1][triangles[:, 0]]
    area, members = np.bincount(part, weights=triangle_areas(position, triangles)), np.bincount(part)
    largest = np.argmax(area)
    alone = (members == 1) & (members[largest] > 1)
    return np.flatnonzero((alone | (area < DUST * area[largest]))[part])
