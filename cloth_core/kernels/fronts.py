"""Making a sparse Cholesky factor front by front (Duff and Reid 1983), without the interpreter in between.

Blocks come in postorder, children before their parent. So the updates that wait for a parent form a stack, and the
children of the block at hand are on top of it.
"""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import kernel
from cloth_core.kernels.dense import eliminate
from cloth_core.kernels.panels import assemble_front, extend_add, fill_columns, fill_panels, panel_sizes


@kernel
def rows_below(indptr, indices, order, place, first, parent):
    """Rows that each block has below its columns, sorted, as (S + 1,) starts and one array of all.

    They are the neighbours of its vertices and what its children have below, if eliminated later.
    """
    blocks = parent.shape[0]
    start, below = np.zeros(blocks + 1, np.int64), np.empty(8 * order.shape[0] + 8, np.int64)
    wanted = np.zeros(order.shape[0], np.bool_)
    waiting = np.empty(blocks, np.int64)
    waits = 0
    for s in range(blocks):
        while waits > 0 and parent[waiting[waits - 1]] == s:
            waits -= 1
            child = waiting[waits]
            for r in range(start[child], start[child + 1]):
                wanted[below[r]] = True
        for p in range(first[s], first[s + 1]):
            v = order[p]
            for n in range(indptr[v], indptr[v + 1]):
                wanted[place[indices[n]]] = True
        wanted[first[s] : first[s + 1]] = False
        end, up = start[s], parent[s]
        while up >= 0:  # all that is later and touched belongs to the blocks above
            for q in range(first[up], first[up + 1]):
                if wanted[q]:
                    if end == below.shape[0]:
                        more = np.empty(2 * end, np.int64)
                        for r in range(end):
                            more[r] = below[r]
                        below = more
                    below[end] = q
                    end += 1
                    wanted[q] = False
            up = parent[up]
        start[s + 1] = end
        for p in range(first[s], first[s + 1]):  # those before belong to blocks below, which are done
            v = order[p]
            for n in range(indptr[v], indptr[v + 1]):
                wanted[place[indices[n]]] = False
        waiting[waits] = s
        waits += 1
    return start, below[: start[blocks]].copy()


@kernel
def factorise(indptr, indices, data, order, place, first, parent, below_start, below, down_start, down, up_start, up):
    """Fill both panels of every block, as :mod:`cloth_core.kernels.panels` describes them."""
    blocks = parent.shape[0]
    row_of = np.zeros(order.shape[0], np.int64)
    waiting, begins = np.empty(blocks, np.int64), np.empty(blocks, np.int64)
    stack = np.empty(_deepest(parent, below_start))
    waits, top = 0, 0
    for s in range(blocks):
        width = first[s + 1] - first[s]
        rows = below[below_start[s] : below_start[s + 1]]
        count = width + rows.shape[0]
        for i in range(width):
            row_of[first[s] + i] = i
        for i in range(width, count):
            row_of[rows[i - width]] = i
        front = np.zeros((count, count))
        assemble_front(indptr, indices, data, place, order[first[s] : first[s + 1]], first[s], row_of, front)
        while waits > 0 and parent[waiting[waits - 1]] == s:
            waits -= 1
            child, top = waiting[waits], begins[waits]
            inner = below[below_start[child] : below_start[child + 1]]
            size = inner.shape[0]
            extend_add(front, row_of[inner], stack[top : top + size * size].reshape(size, size))
        eliminate(front, width)
        columns = np.empty((width, count))
        fill_columns(front, width, np.empty((width, width)), columns)
        fill_panels(columns, down[down_start[s] : down_start[s + 1]], up[up_start[s + 1] : up_start[s]])
        waiting[waits], begins[waits] = s, top
        waits += 1
        for i in range(width, count):
            for j in range(width, count):
                stack[top] = front[i, j]
                top += 1


@kernel
def _deepest(parent, below_start):
    """Numbers that the stack of updates holds at the most."""
    sizes, waiting = np.empty(parent.shape[0], np.int64), np.empty(parent.shape[0], np.int64)
    waits, top, most = 0, 0, 0
    for s in range(parent.shape[0]):
        while waits > 0 and parent[waiting[waits - 1]] == s:
            waits -= 1
            top -= sizes[waits]
        sizes[waits], waiting[waits] = (below_start[s + 1] - below_start[s]) ** 2, s
        top += sizes[waits]
        most = max(most, top)
        waits += 1
    return most


@kernel
def panel_starts(first, below_start):
    """Where the panels of every block begin, (S + 1,) each: down in rising order of the blocks, up in falling order.

    The panel of block s begins at ``down_start[s]`` or at ``up_start[s + 1]``.
    """
    blocks = first.shape[0] - 1
    down_start, up_start = np.zeros(blocks + 1, np.int64), np.zeros(blocks + 1, np.int64)
    for s in range(blocks):
        width = first[s + 1] - first[s]
        down, up_start[s] = panel_sizes(width, width + below_start[s + 1] - below_start[s])
        down_start[s + 1] = down_start[s] + down
    for s in range(blocks - 1, -1, -1):
        up_start[s] += up_start[s + 1]
    return down_start, up_start
