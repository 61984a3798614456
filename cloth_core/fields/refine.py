"""Voxels that are halved, again and again, where interpolation would err too much."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np

from cloth_core.errors import SettingError
from cloth_core.fields.grid import Grid
from cloth_core.fields.solid import Solid
from cloth_core.kernels import voxels as kernels

NODES = np.array([(a, b, c) for c, b, a in product(range(3), repeat=3)])
"""(27, 3) places of the nodes of a refined cell, in halves of it."""

CORNERS = np.array([(a, b, c) for c, b, a in product((0, 2), repeat=3)])
PARTS = CORNERS // 2
IS_CORNER = np.all(NODES % 2 == 0, axis=1)

WEIGHTS = np.prod(1.0 - 0.5 * np.abs(NODES[:, None] - CORNERS), axis=2)
"""(27, 8): what each corner of a cell gives to the interpolation at each node."""

REFINED_MOST = 2**23
"""Refined cells that 32 bits count, of which 8 say something else."""

CHUNK = 256
"""Groups of cells sampled between two reports of progress."""


class Refined(NamedTuple):
    """All refined cells, level after level, those of a level in the order of their parents."""

    chosen: np.ndarray
    """(N,) int64 bits of the refined voxels of each brick."""
    fine: np.ndarray
    """(C, 27) int8."""
    split: np.ndarray
    """(C,) int32."""


def refined(
    solid: Solid,
    grid: Grid,
    place: np.ndarray,
    distance: np.ndarray,
    shell: np.ndarray,
    tolerance: float,
    depth: int,
    report: Callable[[float], None],
) -> Refined:
    """Halve the voxels of the ``shell`` (N,) whose interpolation errs by more than ``tolerance`` m, ``depth`` times.

    ``place`` (N, 3) are the blocks, ``distance`` (N, 5, 5, 5) m those at their nodes. The interpolation stays
    continuous: a new node on a side or edge where a cell begins that is not refined gets what that cell interpolates.
    """
    chosen, exact = _halved(solid, grid, 4 * place, 4, distance, shell, grid.voxel, (tolerance, tolerance), report)
    parent, bit = set_bits(chosen, 64)
    within = np.stack([bit % 4, bit // 4 % 4, bit // 16], axis=1)
    cells, (a, b, c) = 4 * place[parent] + within, (within[:, None] + PARTS).transpose(2, 0, 1)
    corner = np.rint(distance[parent[:, None], c, b, a] / grid.node_step)
    fine, split, size, total = [], [], grid.voxel, 0
    part_most = 2.0 * tolerance, tolerance
    for level in range(depth):
        excess, value = _stored(cells, exact / grid.node_step, corner, grid.fine_step / 2**level)
        parts, deeper = np.zeros(len(cells), np.int64), exact[:0]
        size, total = 0.5 * size, total + len(cells)
        if level + 1 < depth:
            everything = np.full(len(cells), 255)
            parts, deeper = _halved(solid, grid, 2 * cells, 2, exact, everything, size, part_most, _untold)
        parent, bit = set_bits(parts, 8)
        fine.append(excess)
        split.append((total + np.searchsorted(parent, np.arange(len(cells))) << 8) + parts)
        cells, exact = 2 * cells[parent] + PARTS[bit], deeper
        corner = value[parent[:, None], (PARTS[bit][:, None] + PARTS) @ (1, 3, 9)]
    if total >= REFINED_MOST:
        raise SettingError("voxel", f"{grid.voxel:g} m is too fine for so rough a surface: {total} parts of voxels")
    return Refined(chosen, np.concatenate(fine), np.concatenate(split).astype(np.int32))


def _halved(
    solid: Solid,
    grid: Grid,
    place: np.ndarray,
    cells: int,
    distance: np.ndarray,
    wanted: np.ndarray,
    size: float,
    most: tuple[float, float],
    report: Callable[[float], None],
) -> tuple[np.ndarray, np.ndarray]:
    """Bits (N,) of the cells of edge ``size`` m to refine, and the distances (M, 3, 3, 3) m at their nodes.

    ``most`` m is what a cell may err, and what it may where that makes inside of outside.
    """
    chosen, found = np.zeros(len(wanted), np.int64), [np.zeros((0, 3, 3, 3))]
    low = grid.origin + size * place
    room = np.empty((CHUNK * cells**3, 3, 3, 3))
    for begin in range(0, len(wanted), CHUNK):
        part = slice(begin, begin + CHUNK)
        count = kernels.refine(
            solid.surfaces, solid.shapes, low[part], 0.5 * size, cells, distance[part], wanted[part], *most,
            chosen[part], room,
        )  # fmt: skip
        found.append(room[:count].copy())
        report(min(1.0, (begin + CHUNK) / len(wanted)))
    return chosen, np.concatenate(found)


def _stored(cells: np.ndarray, exact: np.ndarray, corner: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """What is stored for the nodes of refined cells of one size, (C, 27) int8, and (C, 27) the distances read of that.

    Stored is what the ``exact`` distance exceeds the interpolation of the ``corner`` (C, 8) distances by, in ``step``:
    0 where any cell around the node is not refined. Distances and ``step`` in units of nodes.
    """
    interpolated = corner @ WEIGHTS.T
    free = np.tile(~IS_CORNER, (len(cells), 1))
    order = np.sort(_keys(cells))
    for way in product((-1, 0, 1), repeat=3):
        if len(cells) and np.abs(way).sum() in (1, 2):
            beside = np.all((np.array(way) == 0) | (NODES - 1 == way), axis=1)
            wanted = _keys(cells + way)
            there = order[np.minimum(np.searchsorted(order, wanted), len(order) - 1)] == wanted
            free[:, beside] &= there[:, None]
    excess = np.where(free, np.rint((exact.reshape(-1, 27) - interpolated) / step), 0.0).clip(-127, 127)
    return excess.astype(np.int8), interpolated + step * excess


def _keys(cells: np.ndarray) -> np.ndarray:
    """One number for each cell; at most 2^20 of them along an axis."""
    return ((cells[:, 2] + 1) << 42) + ((cells[:, 1] + 1) << 21) + cells[:, 0] + 1


def _untold(share: float) -> None:
    pass


def set_bits(words: np.ndarray, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Word and bit of all bits set, in order."""
    return np.nonzero((words[:, None] >> np.arange(width)) & 1)


def rounded(distance: np.ndarray, step: float) -> np.ndarray:
    """Distances in m as int16 units of ``step`` m."""
    return np.rint(distance / step).astype(np.int16)
