"""Interpolation between the corners of a cell.

A ``cell`` is the tuple of the distances at its corners, x running fastest, and the place (u, v, w) in it, each 0 .. 1.
"""

from __future__ import annotations

import math

from cloth_core.kernels import part_kernel


@part_kernel
def trilinear(cell):
    """The interpolated distance and its gradient by u, v and w."""
    d000, d100, d010, d110, d001, d101, d011, d111, u, v, w = cell
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
    share = 1.0 / length if length > 0.0 else 0.0
    return distance, share * gx, share * gy, share * gz if length > 0.0 else 1.0


@part_kernel
def eighth(cell):
    """The eighth of a cell around its place: its number, its low corner among 3 x 3 x 3 nodes, and as a cell."""
    d000, d100, d010, d110, d001, d101, d011, d111, u, v, w = cell
    u, v, w = 2.0 * u, 2.0 * v, 2.0 * w
    i, j, k = min(int(u), 1), min(int(v), 1), min(int(w), 1)
    d000, d100, d010, d110 = _quarter_of_side(i, j, d000, d100, d010, d110)
    d001, d101, d011, d111 = _quarter_of_side(i, j, d001, d101, d011, d111)
    d000, d001 = _half_of_edge(k, d000, d001)
    d100, d101 = _half_of_edge(k, d100, d101)
    d010, d011 = _half_of_edge(k, d010, d011)
    d110, d111 = _half_of_edge(k, d110, d111)
    itself = d000, d100, d010, d110, d001, d101, d011, d111, u - i, v - j, w - k
    return i + 2 * j + 4 * k, i + 3 * j + 9 * k, itself


@part_kernel
def _half_of_edge(upper, low, high):
    """The ends of the lower or upper half of an edge."""
    middle = 0.5 * (low + high)
    return middle if upper else low, high if upper else middle


@part_kernel
def _quarter_of_side(i, j, d00, d10, d01, d11):
    """The corners of quarter (i, j) of a side."""
    d00, d10 = _half_of_edge(i, d00, d10)
    d01, d11 = _half_of_edge(i, d01, d11)
    d00, d01 = _half_of_edge(j, d00, d01)
    d10, d11 = _half_of_edge(j, d10, d11)
    return d00, d10, d01, d11
