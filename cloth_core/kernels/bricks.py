"""The arrays of distance fields: their columns and words, and where in them the voxel around a point is."""

from __future__ import annotations

from cloth_core.kernels import part_kernel
from cloth_core.kernels.bits import ones_below

ORIGIN, LOW, HIGH = 0, 3, 6
VOXEL, PER_METRE, NODE_STEP, COARSE_STEP, FINE_STEP, BAND, REACH = range(9, 16)
"""Columns of ``real``: low corner of the grid and box around the surface, m; m of a voxel, and voxels in a m; m of one
unit of ``node``, and of ``coarse``; units of ``node`` that one of ``fine`` is in a voxel halved once; m that everything
outside the shell is away from the surface; m from the object's origin to the farthest of the surface."""
REALS = 16

SHAPE, COARSE_FIRST, OCCUPIED_FIRST, TANGENT = 0, 3, 4, 5
"""Columns of ``whole``: blocks along x, y, z; where the field begins in ``coarse`` and ``occupied``; 1 for planes."""
WHOLES = 6

NEAR, REFINED, NODES, FIRST = range(4)
"""Words of ``brick``, with bit i + 4 j + 16 k for cell or node (i, j, k): cells in the shell; of these the refined (of
planes: those the surface passes through), of the others those inside; nodes that are stored; the first node or plane,
and the first refined cell, in 32 bits each."""


DEPTH = 3
"""How often voxels are halved at the most: so that plates half a voxel thick keep an inside, however they lie."""


@part_kernel
def _beyond(low, high, x):
    """How far a coordinate is below ``low`` (negative), above ``high``, or 0."""
    return min(x - low, 0.0) + max(x - high, 0.0)


@part_kernel
def way_to_box(real, f, x, y, z):
    """The way in m from the box around the surface to a point, 0 inside."""
    return (
        _beyond(real[f, LOW], real[f, HIGH], x),
        _beyond(real[f, LOW + 1], real[f, HIGH + 1], y),
        _beyond(real[f, LOW + 2], real[f, HIGH + 2], z),
    )


@part_kernel
def beyond_box(real, f, x, y, z, near):
    """Whether a point of the object's frame is more than ``near`` m from the box around the surface of field ``f``."""
    wx, wy, wz = way_to_box(real, f, x, y, z)
    return wx * wx + wy * wy + wz * wz > near * near


@part_kernel
def in_voxels(real, f, x, y, z):
    """A point in voxels from the low corner of the grid."""
    per_metre = real[f, PER_METRE]
    return (
        per_metre * (x - real[f, ORIGIN]),
        per_metre * (y - real[f, ORIGIN + 1]),
        per_metre * (z - real[f, ORIGIN + 2]),
    )


@part_kernel
def first(word):
    """Of the two numbers in a word the high one."""
    return word >> 32


@part_kernel
def brick_at(whole, occupied, f, i, j, k):
    """The brick that holds voxel (i, j, k), or -1."""
    block = (i >> 2) + whole[f, SHAPE] * ((j >> 2) + whole[f, SHAPE + 1] * (k >> 2))
    word = whole[f, OCCUPIED_FIRST] + (block >> 6)
    bits, bit = occupied[word, 0], block & 63
    b = occupied[word, 1] + ones_below(bits, bit)
    return b if (bits >> bit) & 1 else -1
