"""Sparse Cholesky factors in dense panels: making them, and solving with them.

A panel belongs to a block of w columns that are eliminated together and holds, column by column, the (w + r, w)
matrix C = [D; -B D]: D the inverse of the block's triangle, B the r rows below. With it both halves of a solve are
one dense product each: forwards z = D x and x_below -= B z, backwards x = D' (z - B' x_below). Columns are padded with
zeros to a multiple of four, for the four that the loops take at once.

Reassociation is allowed here, for sums over rows must run in vector lanes; the order is fixed when the kernel is
compiled, so that equal inputs give equal bits. Nothing here tests for NaN.
"""

from __future__ import annotations

from cloth_core.kernels import kernel, lane_kernel


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
def fill_panel(front, width, inverse, panel):
    """Make the panel of an eliminated front; ``inverse`` (w, w) is room to work in, ``panel`` starts at zero."""
    count = front.shape[0]
    for c in range(width):
        for i in range(c, width):
            total = 1.0 if i == c else 0.0
            for k in range(c, i):
                total -= front[k, i] * inverse[k, c]
            inverse[i, c] = total / front[i, i]
    for k in range(width):
        column = panel[k * count : (k + 1) * count]
        for i in range(k, width):
            column[i] = inverse[i, k]
        for j in range(k, width):
            factor = inverse[j, k]
            row = front[j]
            for i in range(width, count):
                column[i] -= row[i] * factor


@lane_kernel
def _forward(panel, count, width, z, sum0, sum1, sum2):
    sum0[:count] = 0.0
    sum1[:count] = 0.0
    sum2[:count] = 0.0
    for k in range(0, width, 4):
        c0 = panel[k * count : (k + 1) * count]
        c1 = panel[(k + 1) * count : (k + 2) * count]
        c2 = panel[(k + 2) * count : (k + 3) * count]
        c3 = panel[(k + 3) * count : (k + 4) * count]
        x0, x1, x2, x3 = z[0, k], z[0, k + 1], z[0, k + 2], z[0, k + 3]
        y0, y1, y2, y3 = z[1, k], z[1, k + 1], z[1, k + 2], z[1, k + 3]
        z0, z1, z2, z3 = z[2, k], z[2, k + 1], z[2, k + 2], z[2, k + 3]
        for i in range(count):
            a, b, c, d = c0[i], c1[i], c2[i], c3[i]
            sum0[i] += a * x0 + b * x1 + c * x2 + d * x3
            sum1[i] += a * y0 + b * y1 + c * y2 + d * y3
            sum2[i] += a * z0 + b * z1 + c * z2 + d * z3


@lane_kernel
def _backward(panel, count, width, in0, in1, in2, x):
    for k in range(0, width, 4):
        c0 = panel[k * count : (k + 1) * count]
        c1 = panel[(k + 1) * count : (k + 2) * count]
        c2 = panel[(k + 2) * count : (k + 3) * count]
        c3 = panel[(k + 3) * count : (k + 4) * count]
        x0 = x1 = x2 = x3 = 0.0
        y0 = y1 = y2 = y3 = 0.0
        z0 = z1 = z2 = z3 = 0.0
        for i in range(count):
            a, b, c, d = c0[i], c1[i], c2[i], c3[i]
            u, v, w = in0[i], in1[i], in2[i]
            x0 += a * u
            x1 += b * u
            x2 += c * u
            x3 += d * u
            y0 += a * v
            y1 += b * v
            y2 += c * v
            y3 += d * v
            z0 += a * w
            z1 += b * w
            z2 += c * w
            z3 += d * w
        x[0, k], x[0, k + 1], x[0, k + 2], x[0, k + 3] = x0, x1, x2, x3
        x[1, k], x[1, k + 1], x[1, k + 2], x[1, k + 3] = y0, y1, y2, y3
        x[2, k], x[2, k + 1], x[2, k + 2], x[2, k + 3] = z0, z1, z2, z3


@lane_kernel
def solve_forward(blocks, first, below_start, below, panel_start, panel, y, work, block):
    """z = L^-1 y for three columns, in place in ``y`` (3, N), through the given ``blocks`` in rising order.

    ``first`` (S + 1,), ``below_start`` (S + 1,) and ``panel_start`` (S + 1,) say which columns, rows below and panel
    a block has; ``work`` (3, M) and ``block`` (3, W) are room to work in.
    """
    y0, y1, y2 = y[0], y[1], y[2]
    sum0, sum1, sum2 = work[0], work[1], work[2]
    for n in range(blocks.shape[0]):
        s = blocks[n]
        c = first[s]
        width = first[s + 1] - c
        r = below_start[s]
        count = width + below_start[s + 1] - r
        padded = (width + 3) // 4 * 4
        for i in range(width):
            block[0, i], block[1, i], block[2, i] = y0[c + i], y1[c + i], y2[c + i]
        for i in range(width, padded):
            block[0, i], block[1, i], block[2, i] = 0.0, 0.0, 0.0
        _forward(panel[panel_start[s] : panel_start[s + 1]], count, padded, block, sum0, sum1, sum2)
        for i in range(width):
            y0[c + i], y1[c + i], y2[c + i] = sum0[i], sum1[i], sum2[i]
        for i in range(width, count):
            q = below[r + i - width]
            y0[q] += sum0[i]
            y1[q] += sum1[i]
            y2[q] += sum2[i]


@lane_kernel
def solve_backward(first, below_start, below, panel_start, panel, y, work, block):
    """x = L^-T y for three columns, in place in ``y`` (3, N); arguments as in :func:`solve_forward`."""
    y0, y1, y2 = y[0], y[1], y[2]
    in0, in1, in2 = work[0], work[1], work[2]
    for s in range(first.shape[0] - 2, -1, -1):
        c = first[s]
        width = first[s + 1] - c
        r = below_start[s]
        count = width + below_start[s + 1] - r
        padded = (width + 3) // 4 * 4
        for i in range(width):
            in0[i], in1[i], in2[i] = y0[c + i], y1[c + i], y2[c + i]
        for i in range(width, count):
            q = below[r + i - width]
            in0[i], in1[i], in2[i] = y0[q], y1[q], y2[q]
        _backward(panel[panel_start[s] : panel_start[s + 1]], count, padded, in0, in1, in2, block)
        for i in range(width):
            y0[c + i], y1[c + i], y2[c + i] = block[0, i], block[1, i], block[2, i]


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
