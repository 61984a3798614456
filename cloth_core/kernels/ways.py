"""Shortest ways over a graph."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import kernel


@kernel
def shortest_ways(indptr, indices, length, begin, wanted, way):
    """Lengths of the shortest ways from ``begin`` into ``way`` (V,), by Dijkstra's algorithm.

    The graph is a symmetric compressed sparse row matrix of the ``length`` of its links. The search ends as soon as
    it is sure of all ``wanted`` (N,) vertices: what is as near as the farthest of them is exact, the rest infinite.
    """
    awaited = np.zeros(way.shape[0], np.bool_)
    missing = 0
    for v in wanted:
        if not awaited[v]:
            awaited[v] = True
            missing += 1
    way[:] = np.inf
    way[begin] = 0.0
    heap = np.empty(indices.shape[0] + 1, np.int64)
    key = np.empty(indices.shape[0] + 1)
    heap[0], key[0], size, sure = begin, 0.0, 1, 0.0
    while size > 0 and missing > 0:
        v, sure = heap[0], key[0]
        size -= 1
        _sift_down(heap, key, heap[size], key[size], size)
        if sure > way[v]:
            continue  # a shorter way was found after this one
        if awaited[v]:
            awaited[v] = False
            missing -= 1
        for p in range(indptr[v], indptr[v + 1]):
            w = indices[p]
            along = sure + length[p]
            if along < way[w]:
                way[w] = along
                _sift_up(heap, key, w, along, size)
                size += 1
    for v in range(way.shape[0]):
        if way[v] > sure and size > 0:
            way[v] = np.inf


@kernel
def _sift_up(heap, key, vertex, value, size):
    """Add a vertex to the heap of the given ``size``."""
    n = size
    while n > 0 and value < key[(n - 1) // 2]:
        up = (n - 1) // 2
        heap[n], key[n] = heap[up], key[up]
        n = up
    heap[n], key[n] = vertex, value


@kernel
def _sift_down(heap, key, vertex, value, size):
    """Put a vertex in the place of the first of the heap that has ``size`` left."""
    n = 0
    while 2 * n + 1 < size:
        child = 2 * n + 1
        if child + 1 < size and key[child + 1] < key[child]:
            child += 1
        if key[child] >= value:
            break
        heap[n], key[n] = heap[child], key[child]
        n = child
    heap[n], key[n] = vertex, value
