"""Sampling of solids on the grid of a distance field; see :mod:`cloth_core.fields.build` for what is sampled.

``origin`` (3,) m is the low corner of the grid, ``size`` m the edge of a voxel, a block is 4 x 4 x 4 voxels. Blocks and
cells are numbered with x running fastest.
"""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import kernel
from cloth_core.kernels.solids import solid_distance


@kernel
def sample_corners(surfaces, shapes, origin, spacing, shape, begin, end, distance):
    """Distances in m at the points ``begin`` .. ``end`` of a lattice of ``shape`` (3,) points, into ``distance``."""
    for n in range(begin, end):
        x = origin[0] + spacing * (n % shape[0])
        y = origin[1] + spacing * (n // shape[0] % shape[1])
        z = origin[2] + spacing * (n // (shape[0] * shape[1]))
        distance[n] = solid_distance(surfaces, shapes, x, y, z)[0]


@kernel
def sample_nodes(surfaces, shapes, origin, size, block, brick_of, shape, begin, end, distance):
    """Distances in m at the nodes of the bricks ``end - 1`` down to ``begin``, into ``distance`` (N, 5, 5, 5).

    ``block`` (N, 3) is where they are, in rising order, ``brick_of`` the brick of every block or -1. What the next
    bricks along x, y and z, sampled before, have in common with one is copied.
    """
    for n in range(end - 1, begin - 1, -1):
        i, j, k = block[n]
        for c in range(5):
            for b in range(5):
                for a in range(5):
                    ni, nj, nk = i + a // 4, j + b // 4, k + c // 4
                    next_one = n
                    if ni < shape[0] and nj < shape[1] and nk < shape[2]:
                        next_one = brick_of[ni + shape[0] * (nj + shape[1] * nk)]
                    if next_one >= 0 and next_one != n:
                        distance[n, c, b, a] = distance[next_one, c % 4, b % 4, a % 4]
                        continue
                    x = origin[0] + size * (4 * i + a)
                    y = origin[1] + size * (4 * j + b)
                    z = origin[2] + size * (4 * k + c)
                    distance[n, c, b, a] = solid_distance(surfaces, shapes, x, y, z)[0]


@kernel
def mark_cells(distance, limit, near, inside):
    """Bits of the cells of each brick: those with a corner within ``limit`` m, and of the others those inside.

    ``distance`` (N, 5, 5, 5) m; the words ``near`` and ``inside`` (N,) int64.
    """
    for n in range(distance.shape[0]):
        near[n] = inside[n] = 0
        for cell in range(64):
            a, b, c = cell % 4, cell // 4 % 4, cell // 16
            least = np.inf
            for corner in range(8):
                least = min(least, abs(distance[n, c + corner // 4, b + corner // 2 % 2, a + corner % 2]))
            if least <= limit:
                near[n] |= 1 << cell
            elif distance[n, c, b, a] < 0.0:
                inside[n] |= 1 << cell


@kernel
def mark_nodes(near, block, brick_of, shape, used):
    """Bits of the nodes at the corners of the cells ``near`` (N,), in the brick that has the node at its low side.

    Every brick that gets any must be among the N; ``used`` (N,) must be 0.
    """
    for n in range(near.shape[0]):
        if near[n] == 0:
            continue
        for cell in range(64):
            if not (near[n] >> cell) & 1:
                continue
            for corner in range(8):
                a, b, c = cell % 4 + corner % 2, cell // 4 % 4 + corner // 2 % 2, cell // 16 + corner // 4
                i, j, k = block[n, 0] + a // 4, block[n, 1] + b // 4, block[n, 2] + c // 4
                used[brick_of[i + shape[0] * (j + shape[1] * k)]] |= 1 << (a % 4 + 4 * (b % 4) + 16 * (c % 4))


@kernel
def _middle(grid, c, b, a):
    """Mean of the corners of the cell of edge 2 that point (c, b, a) of ``grid`` is the middle of, or of its side."""
    total, count = 0.0, 0
    for dc in range(-(c % 2), c % 2 + 1, 2 if c % 2 else 1):
        for db in range(-(b % 2), b % 2 + 1, 2 if b % 2 else 1):
            for da in range(-(a % 2), a % 2 + 1, 2 if a % 2 else 1):
                total += grid[c + dc, b + db, a + da]
                count += 1
    return total / count


@kernel
def refine(surfaces, shapes, place, spacing, cells, coarse, wanted, tolerance, turning, chosen, finer):
    """Find the cells whose trilinear interpolation errs too much, and sample them twice as fine.

    For each group n of ``cells``^3 cells with the low corner ``place`` (N, 3) m, ``coarse`` (N, cells + 1, ...) m are
    the distances at its nodes and ``wanted`` (N,) the bits of the cells to look at. A cell errs if it does at any of
    the 19 points in the middle of it, its sides and its edges: by more than ``tolerance`` m, or ``turning`` m where
    that makes inside of outside. The bits of these cells go to ``chosen`` (N,), the distances at their 3 x 3 x 3
    nodes, ``spacing`` m apart, to ``finer`` (M, 3, 3, 3), which must have room.

    Returns how many there are.
    """
    wide = 2 * cells + 1
    grid = np.empty((wide, wide, wide))
    count = 0
    for n in range(place.shape[0]):
        chosen[n] = 0
        if wanted[n] == 0:
            continue
        grid[:] = np.nan
        grid[::2, ::2, ::2] = coarse[n]
        for cell in range(cells**3):
            if not (wanted[n] >> cell) & 1:
                continue
            a0, b0, c0 = 2 * (cell % cells), 2 * (cell // cells % cells), 2 * (cell // cells**2)
            errs = False
            for c in range(c0, c0 + 3):
                for b in range(b0, b0 + 3):
                    for a in range(a0, a0 + 3):
                        if a % 2 == 0 and b % 2 == 0 and c % 2 == 0:
                            continue
                        if np.isnan(grid[c, b, a]):
                            x, y, z = place[n, 0] + spacing * a, place[n, 1] + spacing * b, place[n, 2] + spacing * c
                            grid[c, b, a] = solid_distance(surfaces, shapes, x, y, z)[0]
                        interpolated = _middle(grid, c, b, a)
                        error = abs(grid[c, b, a] - interpolated)
                        allowed = turning if (grid[c, b, a] < 0.0) != (interpolated < 0.0) else tolerance
                        errs = errs or error > allowed
            if errs:
                chosen[n] |= 1 << cell
                finer[count] = grid[c0 : c0 + 3, b0 : b0 + 3, a0 : a0 + 3]
                count += 1
    return count


@kernel
def sample_planes(surfaces, shapes, origin, size, block, near, plane):
    """Tangent planes of the bits of ``near`` (N,) in the blocks ``block`` (N, 3), in order, into ``plane`` (P, 4).

    The normal at the surface point closest to the voxel's centre, and the signed distance in m from the plane to the
    centre (paper, 4.2.2).
    """
    count = 0
    for n in range(block.shape[0]):
        for cell in range(64):
            if not (near[n] >> cell) & 1:
                continue
            x = origin[0] + size * (4 * block[n, 0] + cell % 4 + 0.5)
            y = origin[1] + size * (4 * block[n, 1] + cell // 4 % 4 + 0.5)
            z = origin[2] + size * (4 * block[n, 2] + cell // 16 + 0.5)
            _, cx, cy, cz, nx, ny, nz = solid_distance(surfaces, shapes, x, y, z)
            plane[count, 0], plane[count, 1], plane[count, 2] = nx, ny, nz
            plane[count, 3] = nx * (x - cx) + ny * (y - cy) + nz * (z - cz)
            count += 1
