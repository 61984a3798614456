"""Interpolation between the corners of a cell."""

from __future__ import annotations

import math

from cloth_core.kernels import part_kernel


@part_kernel
def trilinear(d000, d100, d010, d110, d001, d101, d011, d111, u, v, w):
    """Interpolation between the corners of a unit cube, the last digit along z, and its gradient."""
    x00, x10, x01, x11 = d100 - d000, d110 - d010, d101 - d001, d111 - d011
    a00, a10, a01, a11 = d000 + u * x00, d010 + u * x10, d001 + u * x01, d011 + u * x11
    y0, y1 = a10 - a00, a11 - a01
    b0, b1 = a00 + v * y0, a01 + v * y1
    x0, x1 = x00 + v * (x10 - x00), x01 + v * (x11 - x01)
    return b0 + w * (b1 - b0), x0 + w * (x1 - x0), y0 + w * (y1 - y0), b1 - b0


@part_kernel
def with_unit_normal(distance, gx, gy, gz):
    """A distance and the direction of its gradient."""
    length = math.sqrt(gx * gx + gy * gy + gz * gz)
    if length > 0.0:
        share = 1.0 / length
        return distance, share * gx, share * gy, share * gz
    return distance, 0.0, 0.0, 1.0


@part_kernel
def half_of_edge(upper, low, high):
    """The ends of the lower or upper half of an edge, interpolated."""
    middle = 0.5 * (low + high)
    if upper:
        return middle, high
    return low, middle


@part_kernel
def half_of_side(i, j, d00, d10, d01, d11):
    """The corners of quarter (i, j) of a side, interpolated."""
    d00, d10 = half_of_edge(i, d00, d10)
    d01, d11 = half_of_edge(i, d01, d11)
    d00, d01 = half_of_edge(j, d00, d01)
    d10, d11 = half_of_edge(j, d10, d11)
    return d00, d10, d01, d11
