"""Sums over a whole cloth in shares, so that threads can take one each: the same sum whoever takes which."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import kernel

SHARES = 2
"""Of a sum; each costs a cloth full of zeros and its addition, so no more than the threads of a small machine."""
WORTH = 2000
"""Vertices of a cloth from which on shares pay."""


def room(vertices: int) -> np.ndarray:
    """(P, V, 3), where all shares but the first of a sum over a cloth of so many ``vertices`` are collected."""
    return np.zeros((SHARES - 1 if vertices >= WORTH else 0, vertices, 3))


@kernel
def add_shares(apart, total):
    """Add the shares ``apart`` (P, V, 3) to ``total`` (V, 3), in their order."""
    for n in range(apart.shape[0]):
        for v in range(total.shape[0]):
            for a in range(3):
                total[v, a] += apart[n, v, a]
