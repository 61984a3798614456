"""Dense linear algebra whose last bits do not depend on the number of threads.

BLAS and LAPACK split their work by the threads they find, and with it the order of their sums: two settings
of one machine would give two states. These loops keep one order.
"""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import kernel, lane_kernel


@kernel
def transposed_product(matrix, right_side):
    """``matrix.T @ right_side`` for a C-ordered (K, N) and a (K, M), as (N, M)."""
    columns = right_side.shape[1]
    product = np.zeros((columns, matrix.shape[1]))
    for k in range(matrix.shape[0]):
        row = matrix[k]
        for c in range(columns):
            factor = right_side[k, c]
            target = product[c]
            for i in range(row.shape[0]):
                target[i] += row[i] * factor
    return np.ascontiguousarray(product.T)


@kernel
def product(matrix, right_side):
    """``matrix @ right_side`` for a C-ordered (K, N) and an (N, M)."""
    result = np.zeros((matrix.shape[0], right_side.shape[1]))
    for k in range(matrix.shape[0]):
        row = matrix[k]
        for c in range(right_side.shape[1]):
            total = 0.0
            for i in range(row.shape[0]):
                total += row[i] * right_side[i, c]
            result[k, c] = total
    return result


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


@kernel
def cholesky(matrix):
    """(K, K) whose upper triangle U satisfies U.T @ U = ``matrix``, symmetric positive definite; ignore the rest."""
    upper = matrix.copy()
    eliminate(upper, upper.shape[0])
    return upper


@kernel
def cholesky_solve(upper, right_side):
    """The (K, M) solution x of ``U.T @ U @ x = right_side`` for the factor that :func:`cholesky` gives."""
    count = upper.shape[0]
    x = right_side.copy()
    for c in range(x.shape[1]):
        for k in range(count):
            x[k, c] /= upper[k, k]
            for i in range(k + 1, count):
                x[i, c] -= upper[k, i] * x[k, c]
        for k in range(count - 1, -1, -1):
            for i in range(k + 1, count):
                x[k, c] -= upper[k, i] * x[i, c]
            x[k, c] /= upper[k, k]
    return x
