"""Symmetric tensors of 3 x 3, six numbers each: the upper half, row by row."""

from __future__ import annotations

from cloth_core.kernels import inlined_kernel


@inlined_kernel
def times(tensor, v, x, y, z):
    """Row ``v`` of tensors (V, 6) times a vector."""
    return (
        tensor[v, 0] * x + tensor[v, 1] * y + tensor[v, 2] * z,
        tensor[v, 1] * x + tensor[v, 3] * y + tensor[v, 4] * z,
        tensor[v, 2] * x + tensor[v, 4] * y + tensor[v, 5] * z,
    )


@inlined_kernel
def add_square(tensor, v, weight, x, y, z):
    """Add to row ``v`` of tensors (V, 6) the ``weight`` times a vector times itself."""
    tensor[v, 0] += weight * x * x
    tensor[v, 1] += weight * x * y
    tensor[v, 2] += weight * x * z
    tensor[v, 3] += weight * y * y
    tensor[v, 4] += weight * y * z
    tensor[v, 5] += weight * z * z


@inlined_kernel
def product(p, q):
    """Of two that commute."""
    a, b, c, d, e, f = p
    g, h, i, j, k, m = q
    return (
        a * g + b * h + c * i, a * h + b * j + c * k, a * i + b * k + c * m,
        b * h + d * j + e * k, b * i + d * k + e * m, c * i + e * k + f * m,
    )  # fmt: skip


@inlined_kernel
def smoothed(q):
    """3 q^2 - 2 q^3, for one whose eigenvalues are 0 to 1: nearer to a projection."""
    a, b, c, d, e, f = q
    return product(product(q, q), (3.0 - 2.0 * a, -2.0 * b, -2.0 * c, 3.0 - 2.0 * d, -2.0 * e, 3.0 - 2.0 * f))


@inlined_kernel
def projection(tensor, soft):
    """Onto the directions in which the eigenvalues of ``tensor`` are above ``soft`` > 0, smooth about that.

    That is H (H + soft)^-1, smoothed twice.
    """
    a, b, c, d, e, f = tensor
    a, d, f = a + soft, d + soft, f + soft
    i, j, k = d * f - e * e, c * e - b * f, b * e - c * d
    share = soft / (a * i + b * j + c * k)
    q = (
        1.0 - share * i, -share * j, -share * k,
        1.0 - share * (a * f - c * c), -share * (b * c - a * e), 1.0 - share * (a * d - b * b),
    )  # fmt: skip
    return smoothed(smoothed(q))
