"""A distance field: its arrays, its figures, and questions to it from Python."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cloth_core.errors import InputError
from cloth_core.kernels import bricks as columns
from cloth_core.kernels import fields as kernels


class Pool(NamedTuple):
    """Distance fields as the kernels know them, one or several of a scene; see :mod:`cloth_core.kernels.bricks`.

    ``cloth_core.kernels.fields.field_distance(*pool, f, x, y, z)`` asks field ``f``.

    Each field is a tree of limited depth (paper, 4.2.3). The grid is cut into blocks of 4 x 4 x 4 voxels, whose corners
    carry distances. Blocks that the shell around the surface passes through have a brick, which says by bits which of
    its voxels are in the shell and which of its nodes are stored: no node is stored twice, and none far from the
    surface. Voxels in which trilinear interpolation would err too much are halved, again and again.
    """

    real: np.ndarray
    """(F, REALS) float64: measures in m."""
    whole: np.ndarray
    """(F, WHOLES) int64: numbers of blocks, places."""
    coarse: np.ndarray
    """int16: distances at the corners of blocks, x running fastest."""
    occupied: np.ndarray
    """(W, 2) int64: for 64 blocks the bits of those with a brick, and the first brick."""
    brick: np.ndarray
    """(B, 4) int64: words of each brick."""
    node: np.ndarray
    """int16: distances at the nodes of voxels in the shell."""
    fine: np.ndarray
    """(C, 27) int8: what distances at the 3 x 3 x 3 nodes of each refined cell exceed the interpolation by."""
    split: np.ndarray
    """(C,) int32: which of its 8 parts are refined further in 8 bits, and above them the first of these."""
    plane: np.ndarray
    """(P, 4) float32: unit normal, and distance in m of the voxel's centre above the tangent plane."""

    @classmethod
    def empty(cls) -> Pool:
        """No field."""
        short, whole = np.zeros(0, np.int16), np.zeros
        return cls(
            np.zeros((0, columns.REALS)), whole((0, columns.WHOLES), np.int64), short,
            whole((0, 2), np.int64), whole((0, 4), np.int64), short,
            np.zeros((0, 27), np.int8), whole(0, np.int32), np.zeros((0, 4), np.float32),
        )  # fmt: skip

    @property
    def nbytes(self) -> int:
        """Bytes of all arrays."""
        return sum(array.nbytes for array in self)


class Field(NamedTuple):
    """The distance field of one solid, in the object's frame."""

    pool: Pool
    """A pool of this field alone."""

    @property
    def voxel(self) -> float:
        """Edge of a voxel in m."""
        return float(self.pool.real[0, columns.VOXEL])

    @property
    def band(self) -> float:
        """Half the thickness of the shell in m: as far from the surface distances are exact to the voxel's accuracy."""
        return float(self.pool.real[0, columns.BAND])

    @property
    def query(self) -> str:
        """``trilinear`` or ``tangent_plane``."""
        return "tangent_plane" if self.pool.whole[0, columns.TANGENT] else "trilinear"

    @property
    def reach(self) -> float:
        """Radius in m of a sphere around the object's origin that holds the surface."""
        return float(self.pool.real[0, columns.REACH])

    @property
    def dense_voxels(self) -> int:
        """Voxels of a grid without gaps over the same box, shell included."""
        low, high = (self.pool.real[0, at : at + 3] for at in (columns.LOW, columns.HIGH))
        return int(np.prod(np.ceil((high - low + 2.0 * self.band) / self.voxel)))

    def distance(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance (N,) m, negative inside, and unit normal (N, 3), at points (N, 3) m of the object's frame."""
        points = np.ascontiguousarray(points, float).reshape(-1, 3)
        distance, normal = np.empty(len(points)), np.empty_like(points)
        kernels.field_distances(*self.pool, 0, points, distance, normal)
        return distance, normal

    def kinds(self, points: np.ndarray) -> np.ndarray:
        """(N,) what the voxels around points are, of a field of tangent planes: outside 0, inside 1, surface 2.

        Raises:
            InputError: the field is trilinear, and its voxels have distances instead.
        """
        if self.query != "tangent_plane":
            raise InputError(f"voxels are told apart in fields of the query tangent_plane, not {self.query}")
        points = np.ascontiguousarray(points, float).reshape(-1, 3)
        kind = np.empty(len(points), np.int64)
        kernels.voxel_kinds(*self.pool, 0, points, kind)
        return kind


def pooled(fields: Sequence[Field]) -> Pool:
    """One pool of several fields, numbered in their order; that of one field, but for places counted through."""
    moved, at = [], dict.fromkeys(("coarse", "occupied", "brick", "node", "fine", "plane"), 0)
    for field in fields:
        pool = field.pool
        whole, occupied, brick = pool.whole.copy(), pool.occupied.copy(), pool.brick.copy()
        whole[:, columns.COARSE_FIRST] += at["coarse"]
        whole[:, columns.OCCUPIED_FIRST] += at["occupied"]
        occupied[:, 1] += at["brick"]
        first = at["plane" if field.query == "tangent_plane" else "node"]
        brick[:, columns.FIRST] += (first << 32) + at["fine"]
        moved.append(
            pool._replace(whole=whole, occupied=occupied, brick=brick, split=pool.split + np.int32(at["fine"] << 8))
        )
        for name in at:
            at[name] += len(getattr(pool, name))
    return Pool(*(np.concatenate(arrays) for arrays in zip(Pool.empty(), *moved, strict=True)))
