"""Products with sparse matrices."""

from __future__ import annotations

from cloth_core.kernels import kernel


@kernel
def product(indptr, indices, data, scale, columns, result):
    """``scale`` times a compressed sparse row matrix times ``columns`` (N, 3), into ``result`` (N, 3)."""
    for row in range(result.shape[0]):
        x = y = z = 0.0
        for p in range(indptr[row], indptr[row + 1]):
            j = indices[p]
            w = data[p]
            x += w * columns[j, 0]
            y += w * columns[j, 1]
            z += w * columns[j, 2]
        result[row, 0] = scale * x
        result[row, 1] = scale * y
        result[row, 2] = scale * z
