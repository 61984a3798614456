"""Welding: what a thread beyond all limits joins moves as one for a substep."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import kernel

SAME = 1.0 + 1e-9
"""A thread that is no longer than it was, up to rounding, may be as long as it likes."""
TINY = 1e-300


@kernel
def root_of(parent, v):
    """The vertex that stands for the body of ``v``; shortens the way there."""
    root = v
    while parent[root] != root:
        root = parent[root]
    while parent[v] != root:
        v, parent[v] = parent[v], root
    return root


@kernel
def body_way(body, weight, mean, pulled, pull, fixed, strongest, way):
    """Say where a ``body`` goes, into ``way`` (V, 3) m.

    Nowhere if it is ``fixed``; else with its ``mean``, or as far from there toward the hands' ``pull`` as a push of
    ``strongest`` kg m moves its weight.
    """
    for a in range(3):
        way[body, a] = 0.0 if fixed[body] else mean[body, a]
    if fixed[body] or pulled[body] == 0.0:
        return
    square = 0.0
    for a in range(3):
        square += (pull[body, a] - mean[body, a]) ** 2
    need = math.sqrt(square) * weight[body]
    share = min(1.0, strongest / need) if need > 0.0 else 1.0
    for a in range(3):
        way[body, a] += share * (pull[body, a] - mean[body, a])


@kernel
def join(i, j, parent, weight, mean, pulled, pull, fixed):
    """Make the bodies of the roots ``i`` and ``j`` one, with the root ``i``."""
    if i == j:
        return
    weigh = weight[j] / max(weight[i] + weight[j], TINY)
    hands = pulled[j] / max(pulled[i] + pulled[j], 1.0)
    for a in range(3):
        mean[i, a] += weigh * (mean[j, a] - mean[i, a])
        pull[i, a] += hands * (pull[j, a] - pull[i, a])
    parent[j] = i
    weight[i] += weight[j]
    pulled[i] += pulled[j]
    fixed[i] = fixed[i] or fixed[j]


@kernel
def carry_along(start, end, parent, welded, way):
    """Take the vertices of ``welded`` bodies their ``way`` (V, 3) m from the ``start``, into ``end`` (V, 3) m."""
    for v in range(parent.shape[0]):
        root = root_of(parent, v)
        if welded[root]:
            for a in range(3):
                end[v, a] = start[v, a] + way[root, a]


@kernel
def weld_rows(start, end, vertex, strongest, parent, weight, mean, pulled, pull, fixed, welded, way):
    """Weld the four vertices of each row of ``vertex`` (N, 4); all else as for :func:`weld_overlong`."""
    for n in range(vertex.shape[0]):
        i = root_of(parent, np.int64(vertex[n, 0]))
        for k in range(1, 4):
            join(i, root_of(parent, np.int64(vertex[n, k])), parent, weight, mean, pulled, pull, fixed)
        welded[i] = True
        body_way(i, weight, mean, pulled, pull, fixed, strongest, way)
    carry_along(start, end, parent, welded, way)


@kernel
def weld_overlong(
    start, end, spring_vertex, longest, strongest, parent, weight, mean, pulled, pull, fixed, welded, way
):
    """Weld the ends of springs that get longer than ``longest`` (S,) m until none does; ``end`` (V, 3) m in place.

    Bodies are trees in ``parent`` (V,). By root, they have a ``weight`` (V,) kg, whose ``mean`` way (V, 3) m they
    would go, ``pulled`` (V,) hands that ``pull`` them (V, 3) m, and are ``fixed`` (V,) or not. Once ``welded`` (V,)
    they go the same ``way`` (V, 3) m altogether, see :func:`body_way`, which strains no spring within. All are changed.
    """
    again = True
    while again:
        again = False
        for s in range(spring_vertex.shape[0]):
            i = np.int64(spring_vertex[s, 0])  # one type for all that asks for a root
            j = np.int64(spring_vertex[s, 1])
            before = 0.0
            after = 0.0
            for a in range(3):
                before += (start[j, a] - start[i, a]) ** 2
                after += (end[j, a] - end[i, a]) ** 2
            most = max(longest[s], SAME * math.sqrt(before))
            if not after > most * most:
                continue
            i = root_of(parent, i)
            j = root_of(parent, j)
            if i == j and welded[i]:
                continue
            again = True
            join(i, j, parent, weight, mean, pulled, pull, fixed)
            welded[i] = True
            body_way(i, weight, mean, pulled, pull, fixed, strongest, way)
        carry_along(start, end, parent, welded, way)
