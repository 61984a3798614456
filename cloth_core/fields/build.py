"""Samples a solid into a distance field (paper, 4.2.1)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product

import numpy as np

from cloth_core.errors import SettingError
from cloth_core.fields.field import Field, Pool
from cloth_core.fields.grid import Grid, fitted
from cloth_core.fields.refine import Refined, refined, rounded
from cloth_core.fields.solid import Solid
from cloth_core.kernels import bricks as columns
from cloth_core.kernels import crossing
from cloth_core.kernels import voxels as kernels

Progress = Callable[[float], None]
"""Is told from time to time which share (0 .. 1) of the work is done; what it raises ends the work."""

TOLERANCE = 0.125
"""Voxels: a voxel whose interpolation errs by more is halved; its parts are if they err by twice that, or by this where
it makes inside of outside."""

CHUNK = 256
"""Bricks between two reports of progress."""


def build(
    solid: Solid,
    voxel: float,
    *,
    band: float | None = None,
    query: str = "trilinear",
    tolerance: float = TOLERANCE,
    progress: Progress | None = None,
) -> Field:
    """Build the distance field of a solid.

    Distances are exact at the corners of blocks of 4 x 4 x 4 voxels everywhere, and within the shell at the corners of
    voxels, finer where the interpolation between them would err by more than ``tolerance`` voxels (after Frisken and
    others, "Adaptively sampled distance fields", 2000). Numbers are rounded to 16 bits: in a shell of the least
    thickness to 1/10000 of a voxel.

    Args:
        solid: in the object's frame, m.
        voxel: edge of a voxel in m.
        band: half the thickness of the shell in m; a voxel if omitted, and at least that.
        query: ``trilinear``, or ``tangent_plane`` for the paper's own: each voxel of the shell has the closest point to
            its centre and the normal there, and nothing finer.
        tolerance: voxels.
        progress: see :data:`Progress`.

    Raises:
        SettingError: the grid would have too many voxels; the message says which size would fit.
    """
    if query not in ("trilinear", "tangent_plane"):
        raise SettingError("query", f"{query!r} is not one of trilinear, tangent_plane")
    report = _untold if progress is None else progress
    grid = fitted(solid, voxel, max(band or 0.0, voxel))
    corners = _corners(solid, grid, lambda share: report(0.1 * share))
    near = _near_blocks(corners, grid)
    distance = _nodes(solid, grid, near, lambda share: report(0.1 + 0.3 * share))
    shell, inside = np.empty(len(near), np.int64), np.empty(len(near), np.int64)
    kernels.mark_cells(distance, grid.reach, shell, inside)
    if query == "tangent_plane":
        pool = _planes(solid, grid, near, shell, inside)
    else:
        # Where the surface passes, and no farther: a voxel with a part of it has a corner within half its diagonal.
        passed = np.empty_like(shell)
        kernels.mark_cells(distance, np.sqrt(0.75) * voxel, passed, np.empty_like(shell))
        place, most = grid.place(near), tolerance * voxel
        cells = refined(
            solid, grid, place, distance, passed, most, columns.DEPTH, lambda share: report(0.4 + 0.5 * share)
        )
        pool = _trilinear(grid, near, distance, shell, inside, cells)
    pool = pool._replace(real=_measures(solid, grid), coarse=rounded(corners, grid.coarse_step))
    report(1.0)
    return Field(pool)


def _untold(share: float) -> None:
    pass


def chunks(count: int, size: int, report: Progress) -> Iterator[tuple[int, int]]:
    """Begin and end of pieces of ``size`` of a loop, reported as they are done."""
    for begin in range(0, count, size):
        yield begin, min(begin + size, count)
        report(min(begin + size, count) / count)


def _corners(solid: Solid, grid: Grid, report: Progress) -> np.ndarray:
    """Distances in m at the corners of all blocks, x running fastest."""
    distance = np.empty(int(np.prod(grid.shape + 1)))
    spacing = 4.0 * grid.voxel
    for begin, end in chunks(len(distance), 32 * CHUNK, report):
        kernels.sample_corners(solid.surfaces, solid.shapes, grid.origin, spacing, grid.shape + 1, begin, end, distance)
    return distance


def _near_blocks(corners: np.ndarray, grid: Grid) -> np.ndarray:
    """(N,) numbers of the blocks that may hold a voxel of the shell, and of their neighbours that hold its nodes."""
    nx, ny, nz = grid.shape
    lattice = np.abs(corners.reshape(nz + 1, ny + 1, nx + 1))
    least = np.min([lattice[c : c + nz, b : b + ny, a : a + nx] for c, b, a in product((0, 1), repeat=3)], axis=0)
    # A node of a voxel of the shell is within its diagonal of the reach, and a corner of each block around that node
    # within half the block's diagonal of it.
    near = np.flatnonzero(least.ravel() <= grid.reach + (np.sqrt(3.0) + np.sqrt(12.0)) * grid.voxel)
    grid.check_bricks(len(near))
    return near


def _nodes(solid: Solid, grid: Grid, near: np.ndarray, report: Progress) -> np.ndarray:
    """(N, 5, 5, 5) distances in m at the nodes of blocks."""
    number_of = np.full(int(np.prod(grid.shape)), -1, np.int64)
    number_of[near] = np.arange(len(near))
    distance, place = np.empty((len(near), 5, 5, 5)), grid.place(near)
    for begin, end in chunks(len(near), CHUNK, report):
        last, first = len(near) - begin, len(near) - end  # from the last to the first: each copies from those after it
        kernels.sample_nodes(
            solid.surfaces, solid.shapes, grid.origin, grid.voxel, place, number_of, grid.shape, first, last, distance
        )
    return distance


def _trilinear(
    grid: Grid, near: np.ndarray, distance: np.ndarray, shell: np.ndarray, inside: np.ndarray, cells: Refined
) -> Pool:
    """Bricks with the nodes of the voxels in the shell."""
    used = np.zeros(len(near), np.int64)
    place = grid.place(near)
    number_of = np.full(int(np.prod(grid.shape)), -1, np.int64)
    number_of[near] = np.arange(len(near))
    kernels.mark_nodes(shell, place, number_of, grid.shape, used)
    kept = np.flatnonzero(used)
    brick = np.stack([shell, inside | cells.chosen, used, np.zeros_like(used)], axis=1)[kept]
    brick[:, columns.FIRST] = (_before(brick[:, columns.NODES]) << 32) + _before(cells.chosen[kept])
    own = np.ascontiguousarray(distance[kept][:, :4, :4, :4]).reshape(len(kept), 64)
    node = rounded(own[_bits(brick[:, columns.NODES])], grid.node_step)
    whole, occupied = _layout(grid, near[kept], tangent=False)
    return Pool.empty()._replace(
        whole=whole, occupied=occupied, brick=brick, node=node, fine=cells.fine, split=cells.split
    )


def _planes(solid: Solid, grid: Grid, near: np.ndarray, shell: np.ndarray, inside: np.ndarray) -> Pool:
    """Bricks with a plane for each voxel of the shell."""
    kept = np.flatnonzero(shell)
    place = grid.place(near[kept])
    plane = np.empty((int(_bits(shell).sum()), 4))
    kernels.sample_planes(solid.surfaces, solid.shapes, grid.origin, grid.voxel, place, shell[kept], plane)
    surface = np.zeros(len(kept), np.int64)
    crossing.mark_surface(solid.surfaces, solid.shapes, grid.origin, grid.voxel, place, shell[kept], surface)
    brick = np.zeros((len(kept), 4), np.int64)
    brick[:, columns.NEAR], brick[:, columns.REFINED] = shell[kept], (inside[kept] & ~shell[kept]) | surface
    brick[:, columns.FIRST] = _before(shell[kept]) << 32
    whole, occupied = _layout(grid, near[kept], tangent=True)
    return Pool.empty()._replace(whole=whole, occupied=occupied, brick=brick, plane=plane.astype(np.float32))


def _layout(grid: Grid, blocks: np.ndarray, tangent: bool) -> tuple[np.ndarray, np.ndarray]:
    """``whole`` and ``occupied`` of a pool of this field alone."""
    whole = np.zeros((1, columns.WHOLES), np.int64)
    whole[0, columns.SHAPE : columns.SHAPE + 3], whole[0, columns.TANGENT] = grid.shape, tangent
    occupied = np.zeros((-(-int(np.prod(grid.shape)) // 64), 2), np.int64)
    np.bitwise_or.at(occupied[:, 0], blocks >> 6, np.int64(1) << (blocks & 63))
    occupied[:, 1] = _before(occupied[:, 0])
    return whole, occupied


def _measures(solid: Solid, grid: Grid) -> np.ndarray:
    """``real`` of a pool of this field alone."""
    real = np.zeros((1, columns.REALS))
    for at, vector in ((columns.ORIGIN, grid.origin), (columns.LOW, solid.low), (columns.HIGH, solid.high)):
        real[0, at : at + 3] = vector
    real[0, columns.VOXEL], real[0, columns.BAND] = grid.voxel, grid.band
    real[0, columns.NODE_STEP], real[0, columns.COARSE_STEP] = grid.node_step, grid.coarse_step
    real[0, columns.PER_METRE], real[0, columns.FINE_STEP] = 1.0 / grid.voxel, grid.fine_step
    real[0, columns.REACH] = np.linalg.norm(np.maximum(np.abs(solid.low), np.abs(solid.high)))
    return real


def _bits(words: np.ndarray) -> np.ndarray:
    """(N, 64) bool."""
    return (words[:, None] >> np.arange(64)) & 1 == 1


def _before(words: np.ndarray) -> np.ndarray:
    """(N,) bits that are set in all words before each."""
    count = _bits(words).sum(axis=1)
    return np.cumsum(count) - count
