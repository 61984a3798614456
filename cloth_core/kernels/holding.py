"""Holding rows of a factored matrix: G = L^-1 E, block by block, and what it takes to impose values with it.

E are the unit columns of the held rows, sorted as they are eliminated. A block then has entries in those columns alone
that begin in its subtree, and these stand side by side: from ``low`` to ``high``. They are kept column by column, the
rows of the block one after the other, beginning at ``start``.

Sums over rows run in vector lanes, in an order that is fixed when the kernel is compiled.
"""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import kernel, lane_kernel
from cloth_core.kernels.lanes import LANES, add_product, load, spread, store


@kernel
def mark_paths(blocks, parent, marked):
    """Mark the given ``blocks`` and all that depend on them, up to the root, in ``marked`` (S,)."""
    for n in range(blocks.shape[0]):
        s = blocks[n]
        while s >= 0 and not marked[s]:
            marked[s] = True
            s = parent[s]


@kernel
def _times_panel(down, start, count, width, x, sums):
    """Four columns ``x`` (4, W) times the panel at ``start``, into ``sums`` (4, count and the rest of a tile)."""
    zero = down.dtype.type(0)
    p = start
    for t in range(0, count, LANES):
        sum0 = sum1 = sum2 = sum3 = spread(zero)
        for k in range(min(width, t + LANES)):
            column = load(down, p)
            sum0 = add_product(sum0, column, x[0, k])
            sum1 = add_product(sum1, column, x[1, k])
            sum2 = add_product(sum2, column, x[2, k])
            sum3 = add_product(sum3, column, x[3, k])
            p += LANES
        store(sums[0], t, sum0)
        store(sums[1], t, sum1)
        store(sums[2], t, sum2)
        store(sums[3], t, sum3)


@kernel
def respond(path, first, parent, below_start, below, down_start, down, held, low, high, start, number, response):
    """Fill ``response`` with G for the rows at the sorted places ``held`` (K,).

    ``path`` (P,) are the blocks between them and the root in rising order, ``low``, ``high`` and ``start`` (P,) as
    above, ``number`` (S,) says which of the path a block is.
    """
    tallest, widest = 1, 1
    for n in range(path.shape[0]):
        s = path[n]
        width = first[s + 1] - first[s]
        widest = max(widest, width)
        tallest = max(tallest, width + below_start[s + 1] - below_start[s])
    x, sums = np.zeros((4, widest), down.dtype), np.zeros((4, tallest + LANES), down.dtype)
    target, stride = np.empty(tallest, np.int64), np.empty(tallest, np.int64)
    response[:] = 0.0
    for n in range(path.shape[0]):
        s = path[n]
        width = first[s + 1] - first[s]
        count = width + below_start[s + 1] - below_start[s]
        for i in range(width):
            target[i], stride[i] = start[n] - low[n] * width + i, width
        up = parent[s]
        for i in range(width, count):
            q = below[below_start[s] + i - width]
            while q >= first[up + 1]:
                up = parent[up]
            m, wide = number[up], first[up + 1] - first[up]
            target[i], stride[i] = start[m] - low[m] * wide + q - first[up], wide
        for c in range(low[n], high[n]):
            if first[s] <= held[c]:
                response[target[held[c] - first[s]] + c * width] = 1.0
        for begin in range(low[n], high[n], 4):
            some = min(4, high[n] - begin)
            x[some:] = 0.0
            for c in range(some):
                origin = start[n] + (begin + c - low[n]) * width
                for i in range(width):
                    x[c, i] = response[origin + i]
            _times_panel(down, down_start[s], count, width, x, sums)
            for c in range(some):
                origin = start[n] + (begin + c - low[n]) * width
                for i in range(width):
                    response[origin + i] = sums[c, i]
                for i in range(width, count):
                    response[target[i] + (begin + c) * stride[i]] += sums[c, i]


@lane_kernel
def _dot(one, other):
    total = 0.0
    for i in range(one.shape[0]):
        total += one[i] * other[i]
    return total


@kernel
def add_squares(widths, low, high, start, response, schur):
    """Add the upper triangle of G' G to ``schur`` (K, K); ``widths`` (P,) are those of the blocks."""
    for n in range(widths.shape[0]):
        width = widths[n]
        for c in range(low[n], high[n]):
            origin = start[n] + (c - low[n]) * width
            one = response[origin : origin + width]
            for d in range(c, high[n]):
                other = start[n] + (d - low[n]) * width
                schur[c, d] += _dot(one, response[other : other + width])


@lane_kernel
def impose(path, first, low, high, start, response, upper, wanted, force, y):
    """Change z = L^-1 b in ``y`` (3, N) so that the held rows of the solution become ``wanted`` (K, 3).

    ``upper`` (K, K) is the Cholesky factor of G' G; ``force`` (3, K) receives what holds the rows there.
    """
    count = wanted.shape[0]
    for k in range(count):
        force[0, k], force[1, k], force[2, k] = wanted[k, 0], wanted[k, 1], wanted[k, 2]
    for n in range(path.shape[0]):
        begin, end = first[path[n]], first[path[n] + 1]
        y0, y1, y2 = y[0, begin:end], y[1, begin:end], y[2, begin:end]
        width = end - begin
        for c in range(low[n], high[n]):
            origin = start[n] + (c - low[n]) * width
            column = response[origin : origin + width]
            sum0 = sum1 = sum2 = 0.0
            for i in range(width):
                g = column[i]
                sum0 += g * y0[i]
                sum1 += g * y1[i]
                sum2 += g * y2[i]
            force[0, c] -= sum0
            force[1, c] -= sum1
            force[2, c] -= sum2
    _solve_three(upper, force)
    for n in range(path.shape[0]):
        begin, end = first[path[n]], first[path[n] + 1]
        y0, y1, y2 = y[0, begin:end], y[1, begin:end], y[2, begin:end]
        width = end - begin
        for c in range(low[n], high[n]):
            origin = start[n] + (c - low[n]) * width
            column = response[origin : origin + width]
            f0, f1, f2 = force[0, c], force[1, c], force[2, c]
            for i in range(width):
                g = column[i]
                y0[i] += g * f0
                y1[i] += g * f1
                y2[i] += g * f2


@lane_kernel
def _solve_three(upper, x):
    """Overwrite ``x`` (3, K) with the solution of U' U x' = ``x``' for each row, row after row."""
    x0, x1, x2 = x[0], x[1], x[2]
    count = upper.shape[0]
    for k in range(count):
        row = upper[k]
        x0[k] /= row[k]
        x1[k] /= row[k]
        x2[k] /= row[k]
        a, b, c = x0[k], x1[k], x2[k]
        for i in range(k + 1, count):
            x0[i] -= row[i] * a
            x1[i] -= row[i] * b
            x2[i] -= row[i] * c
    for k in range(count - 1, -1, -1):
        row = upper[k]
        a = b = c = 0.0
        for i in range(k + 1, count):
            a += row[i] * x0[i]
            b += row[i] * x1[i]
            c += row[i] * x2[i]
        x0[k] = (x0[k] - a) / row[k]
        x1[k] = (x1[k] - b) / row[k]
        x2[k] = (x2[k] - c) / row[k]
