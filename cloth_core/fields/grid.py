"""Where the grid of a distance field stands, how fine it is and how large it may be."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cloth_core.errors import SettingError
from cloth_core.fields.solid import Solid

VOXEL_LOW, VOXEL_HIGH = 1e-4, 10.0
"""m."""

BLOCKS_MOST = 2**21
"""Blocks of 4 x 4 x 4 voxels of a field: 512 voxels a side of a cube."""

BRICKS_MOST = 250_000
"""Blocks that the shell passes through: 30 million voxels, some 250 MB while it is built."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Blocks of 4 x 4 x 4 voxels around a solid, with room for the shell; lengths in m."""

    origin: np.ndarray
    shape: np.ndarray
    """(3,) blocks along x, y, z."""
    voxel: float
    band: float
    coarse_step: float
    """One unit of the 16-bit distances at corners of blocks."""

    @property
    def reach(self) -> float:
        """Voxels with a corner as near as this to the surface are in the shell, so that all of the band is.

        The point of a voxel that is closest to a surface outside lies on one of its sides, and the way there is square
        to it: a corner is at most half the diagonal of the side off the foot.
        """
        return math.sqrt(self.band**2 + 0.5 * self.voxel**2)

    @property
    def node_step(self) -> float:
        """One unit of the 16-bit distances in the shell: its nodes are no farther than a diagonal beyond the reach."""
        return (self.reach + 2.0 * self.voxel) / 32767.0

    @property
    def fine_step(self) -> float:
        """One unit, in those of nodes, of the 8 bits by which nodes within a refined voxel exceed the interpolation.

        That is no more than they are apart, half a diagonal, from what it is the mean of.
        """
        return math.sqrt(0.75) * self.voxel / 127.0 / self.node_step

    def check_bricks(self, count: int) -> None:
        """Refuse a shell of too many bricks."""
        if count > BRICKS_MOST:
            fits = 1.05 * self.voxel * math.sqrt(count / BRICKS_MOST)
            raise SettingError(
                "voxel", f"{self.voxel:g} m makes {64 * count} voxels near the surface: {fits:.2g} m or more would fit"
            )

    def place(self, blocks: np.ndarray) -> np.ndarray:
        """(N, 3) places of blocks given by their numbers, x running fastest."""
        x, y, _ = self.shape
        return np.stack([blocks % x, blocks // x % y, blocks // (x * y)], axis=1)


def fitted(solid: Solid, voxel: float, band: float) -> Grid:
    """The grid around a solid.

    Raises:
        SettingError: the voxel is out of its range, or there would be too many of them.
    """
    if not VOXEL_LOW <= voxel <= VOXEL_HIGH:
        raise SettingError("voxel", f"{voxel!r} is out of range: a number {VOXEL_LOW:g} .. {VOXEL_HIGH:g} m")
    extent = solid.high - solid.low
    shape = _blocks(extent, voxel, band)
    if np.prod(shape) > BLOCKS_MOST:
        fits = voxel
        while np.prod(_blocks(extent, fits, max(band, fits))) > BLOCKS_MOST:
            fits *= 1.02
        size = " x ".join(f"{4 * n:.0f}" for n in shape)
        most = 64 * BLOCKS_MOST
        raise SettingError(
            "voxel",
            f"{voxel:g} m makes a grid of {size} voxels in an extent of {extent.max():.3g} m, more than {most}: "
            f"{fits:.2g} m or more would fit",
        )
    middle = 0.5 * (solid.low + solid.high)
    diagonal = 4.0 * voxel * float(np.linalg.norm(shape))
    return Grid(middle - 2.0 * voxel * shape, shape.astype(np.int64), voxel, band, diagonal / 32767.0)


def _blocks(extent: np.ndarray, voxel: float, band: float) -> np.ndarray:
    """(3,) as floats: they may be too many for integers. Two voxels beyond the band hold the outermost of the shell."""
    return np.ceil((extent + 2.0 * band + 4.0 * voxel) / (4.0 * voxel))
