"""Sparse Cholesky factors in dense panels: making them, and solving with them.

A block of w columns that are eliminated together, with r rows below them, has the (w + r, w) matrix C = [D; -B D]:
D the inverse of the block's triangle, B the r rows below. With it both halves of a solve are one dense product each:
forwards z = D x and x_below -= B z, backwards x = D' (z - B' x_below). Each half has a panel of its own, in the order
in which it reads: ``down`` in tiles of ``LANES`` rows, column after column, ``up`` in tiles of ``LANES`` columns, row
after row. What lies above the diagonal of D is left out tile by tile; the last tile is padded with zeros.

Equal inputs give equal bits. Nothing here tests for NaN.
"""

from __future__ import annotations

from numba import prange

from cloth_core.kernels import kernel, lane_kernel, shared_kernel
from cloth_core.kernels.lanes import LANES, add_product, load, spread, store


@kernel
def touching(indptr, indices, vertices, marked, touches):
    """Whether each of ``vertices`` (N,) has a neighbour that is ``marked`` (V,), into ``touches`` (N,)."""
    for n in range(vertices.shape[0]):
        v = vertices[n]
        found = False
        for p in range(indptr[v], indptr[v + 1]):
            if marked[indices[p]]:
                found = True
                break
        touches[n] = found


@kernel
def assemble_front(indptr, indices, data, place, vertices, first, row_of, front):
    """Put the entries of a block's columns, on and below the diagonal, into the upper triangle of its ``front``.

    ``place`` (V,) is the elimination order, ``row_of`` (V,) the row of each place in the front.
    """
    for k in range(vertices.shape[0]):
        v = vertices[k]
        for p in range(indptr[v], indptr[v + 1]):
            q = place[indices[p]]
            if q >= first + k:
                front[k, row_of[q]] += data[p]


@kernel
def extend_add(front, row, update):
    """Add the upper triangle of a child's ``update`` (R, R) to its parent's front, at the sorted rows ``row`` (R,)."""
    for i in range(row.shape[0]):
        for j in range(i, row.shape[0]):
            front[row[i], row[j]] += update[i, j]


@lane_kernel
def fill_columns(front, width, inverse, columns):
    """C of an eliminated front, column by column into ``columns`` (w, w + r); ``inverse`` (w, w) is room to work in."""
    count = front.shape[0]
    for c in range(width):
        for i in range(c, width):
            total = 1.0 if i == c else 0.0
            for k in range(c, i):
                total -= front[k, i] * inverse[k, c]
            inverse[i, c] = total / front[i, i]
    for k in range(width):
        column = columns[k]
        column[:] = 0.0
        for i in range(k, width):
            column[i] = inverse[i, k]
        for j in range(k, width):
            factor = inverse[j, k]
            row = front[j]
            for i in range(width, count):
                column[i] -= row[i] * factor


@kernel
def panel_sizes(width, count):
    """Numbers in the two panels of a block of ``width`` columns and ``count`` rows: down, up."""
    down = 0
    for t in range(0, count, LANES):
        down += LANES * min(width, t + LANES)
    up = 0
    for t in range(0, width, LANES):
        up += LANES * (count - t)
    return down, up


@kernel
def fill_panels(columns, down, up):
    """Both panels of a block from C, column by column in ``columns`` (w, w + r)."""
    width, count = columns.shape
    p = 0
    for t in range(0, count, LANES):
        for k in range(min(width, t + LANES)):
            for i in range(t, t + LANES):
                down[p] = columns[k, i] if i < count else 0.0
                p += 1
    p = 0
    for t in range(0, width, LANES):
        for i in range(t, count):
            for k in range(t, t + LANES):
                up[p] = columns[k, i] if k < width else 0.0
                p += 1


@shared_kernel
def solve_forward(parts, order, right_side, first, below_start, below, down_start, down, y, beyond, work):
    """z = L^-1 b into the columns of ``y`` (3, N), for the three columns of ``right_side``.

    ``first`` (S + 1,), ``below_start`` (S + 1,) and ``down_start`` (S + 1,) say which columns, rows below and panel
    a block has. The blocks of different ``parts`` (P, 2), first and one past the last, have no row in common but those
    of the blocks after all of them; ``beyond`` (P, 3, R) collects what the parts take from those rows. ``work``
    (P, 6, M) is room to work in.
    """
    last = parts[-1, 1]
    common = first[last]
    gather(order, right_side, y)
    for n in prange(parts.shape[0]):
        beyond[n] = 0
        begin, end = parts[n]
        forward(begin, end, common, first, below_start, below, down_start, down, y, beyond[n], work[n])
    for n in range(parts.shape[0]):
        for a in range(3):
            for i in range(beyond.shape[2]):
                y[a, common + i] += beyond[n, a, i]
    forward(
        last, first.shape[0] - 1, order.shape[0], first, below_start, below, down_start, down, y, beyond[0], work[0]
    )


@kernel
def forward(begin, end, common, first, below_start, below, down_start, down, y, beyond, work):
    """Eliminate the blocks from ``begin`` to ``end``; what they do to rows from ``common`` on goes to ``beyond``."""
    zero = down.dtype.type(0)
    for s in range(begin, end):
        c = first[s]
        width = first[s + 1] - c
        r = below_start[s]
        count = width + below_start[s + 1] - r
        x0, x1, x2 = y[0, c : c + width], y[1, c : c + width], y[2, c : c + width]
        p = down_start[s]
        for t in range(0, count, LANES):
            sum0 = sum1 = sum2 = spread(zero)
            for k in range(min(width, t + LANES)):
                column = load(down, p)
                sum0 = add_product(sum0, column, x0[k])
                sum1 = add_product(sum1, column, x1[k])
                sum2 = add_product(sum2, column, x2[k])
                p += LANES
            store(work[0], t, sum0)
            store(work[1], t, sum1)
            store(work[2], t, sum2)
        for i in range(width):
            x0[i], x1[i], x2[i] = work[0, i], work[1, i], work[2, i]
        for i in range(width, count):
            q = below[r + i - width]
            if q < common:
                y[0, q] += work[0, i]
                y[1, q] += work[1, i]
                y[2, q] += work[2, i]
            else:
                q -= common
                beyond[0, q] += work[0, i]
                beyond[1, q] += work[1, i]
                beyond[2, q] += work[2, i]


@shared_kernel
def solve_backward(parts, first, below_start, below, up_start, up, y, work, order, solution):
    """x = L^-T y, for three columns, into the rows of ``solution``; arguments as in :func:`solve_forward`."""
    last = parts[-1, 1]
    backward(last, first.shape[0] - 1, first, below_start, below, up_start, up, y, work[0])
    for n in prange(parts.shape[0]):
        begin, end = parts[n]
        backward(begin, end, first, below_start, below, up_start, up, y, work[n])
    scatter(order, y, solution)


@kernel
def backward(begin, end, first, below_start, below, up_start, up, y, work):
    """The blocks from ``end`` back to ``begin``, those that they wait for being done."""
    zero = up.dtype.type(0)
    for s in range(end - 1, begin - 1, -1):
        c = first[s]
        width = first[s + 1] - c
        r = below_start[s]
        count = width + below_start[s + 1] - r
        for i in range(width):
            work[0, i], work[1, i], work[2, i] = y[0, c + i], y[1, c + i], y[2, c + i]
        for i in range(width, count):
            q = below[r + i - width]
            work[0, i], work[1, i], work[2, i] = y[0, q], y[1, q], y[2, q]
        x0, x1, x2 = work[0], work[1], work[2]
        p = up_start[s + 1]
        for t in range(0, width, LANES):
            sum0 = sum1 = sum2 = spread(zero)
            for i in range(t, count):
                row = load(up, p)
                sum0 = add_product(sum0, row, x0[i])
                sum1 = add_product(sum1, row, x1[i])
                sum2 = add_product(sum2, row, x2[i])
                p += LANES
            store(work[3], 0, sum0)
            store(work[4], 0, sum1)
            store(work[5], 0, sum2)
            for k in range(min(LANES, width - t)):
                y[0, c + t + k], y[1, c + t + k], y[2, c + t + k] = work[3, k], work[4, k], work[5, k]


@kernel
def gather(order, rows, y):
    """Rows of ``rows`` (N, 3) in elimination ``order`` (N,), as the columns of ``y`` (3, N)."""
    for p in range(order.shape[0]):
        v = order[p]
        y[0, p], y[1, p], y[2, p] = rows[v, 0], rows[v, 1], rows[v, 2]


@kernel
def scatter(order, y, rows):
    """Undo :func:`gather`."""
    for p in range(order.shape[0]):
        v = order[p]
        rows[v, 0], rows[v, 1], rows[v, 2] = y[0, p], y[1, p], y[2, p]
