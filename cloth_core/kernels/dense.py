"""Dense linear algebra whose last bits do not depend on the number of threads.

BLAS and LAPACK split their work by the threads they find, and with it the order of their sums: two settings
of one machine would give two states. This loop keeps one order.
"""

from __future__ import annotations

import math

from cloth_core.kernels import lane_kernel


@lane_kernel
def eliminate(front, width):
    """Cholesky of the first ``width`` columns of a front, in its upper triangle; the rest becomes the update."""
    count = front.shape[0]
    for k in range(width):
        row = front[k]
        pivot = math.sqrt(row[k])
        for i in range(k, count):
            row[i] /= pivot
        for j in range(k + 1, count):
            factor = row[j]
            if factor != 0.0:
                below = front[j]
                for i in range(j, count):
                    below[i] -= factor * row[i]
