"""A distance field: its arrays, its figures, and questions to it from Python."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cloth_core.kernels import fields as kernels


class Pool(NamedTuple):
    """Distance fields as the kernels know them, one or several of a scene; see :mod:`cloth_core.kernels.fields`.

    Each field is a tree of limited depth with three kinds of branches. The grid is cut into blocks of 4 x 4 x 4 voxels,
    whose corners carry distances. Blocks that the shell around the surface passes through have a brick, which says by
    bits which of its voxels are in the shell and which of its nodes are stored: nothing is stored twice, and nothing far
    from the surface. Voxels in which trilinear interpolation would err too much are halved, again and again.
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
    """(C, 27) int16: distances at the 3 x 3 x 3 nodes of each refined cell."""
    split: np.ndarray
    """(C, 2) int32: which of its 8 parts are refined further, and the first of these."""
    plane: np.ndarray
    """(P, 4) float32: unit normal, and distance in m of the voxel's centre above the tangent plane."""

    @classmethod
    def of(cls, fields: Sequence[Pool]) -> Pool:
        """Several pools as one; the fields keep their order."""
        fields = list(fields) or [cls.empty()]
        moved = []
        at = {"coarse": 0, "occupied": 0, "brick": 0, "node": 0, "fine": 0, "plane": 0}
        for one in fields:
            whole, occupied, brick, split = (a.copy() for a in (one.whole, one.occupied, one.brick, one.split))
            whole[:, kernels.COARSE_FIRST] += at["coarse"]
            whole[:, kernels.OCCUPIED_FIRST] += at["occupied"]
            occupied[:, 1] += at["brick"]
            # A pool of planes has no nodes, one of nodes no planes.
            first = at["plane"] if len(one.plane) else at["node"]
            brick[:, kernels.FIRST] += (first << 32) + at["fine"]
            split[:, 1] += at["fine"]
            moved.append(one._replace(whole=whole, occupied=occupied, brick=brick, split=split))
            for name in at:
                at[name] += len(getattr(one, name))
        return cls(*(np.concatenate(arrays) for arrays in zip(*moved, strict=True)))

    @classmethod
    def empty(cls) -> Pool:
        """No field."""
        short, whole = np.zeros(0, np.int16), np.zeros
        return cls(
            np.zeros((0, kernels.REALS)), whole((0, kernels.WHOLES), np.int64), short,
            whole((0, 2), np.int64), whole((0, 4), np.int64), short,
            np.zeros((0, 27), np.int16), whole((0, 2), np.int32), np.zeros((0, 4), np.float32),
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
        return float(self.pool.real[0, kernels.VOXEL])

    @property
    def band(self) -> float:
        """Half the thickness of the shell in m: as far from the surface distances are exact to the voxel's accuracy."""
        return float(self.pool.real[0, kernels.BAND])

    @property
    def query(self) -> str:
        """``trilinear`` or ``tangent_plane``."""
        return "tangent_plane" if self.pool.whole[0, kernels.TANGENT] else "trilinear"

    @property
    def reach(self) -> float:
        """Radius in m of a sphere around the object's origin that holds the surface."""
        return float(self.pool.real[0, kernels.REACH])

    @property
    def dense_bytes(self) -> int:
        """Bytes of the same box, shell included, full of the same numbers: a node, or a plane, for every voxel."""
        low, high = (self.pool.real[0, at : at + 3] for at in (kernels.LOW, kernels.HIGH))
        voxels = np.ceil((high - low + 2.0 * self.band) / self.voxel)
        each = self.pool.plane if self.query == "tangent_plane" else self.pool.node
        return int(np.prod(voxels)) * each[:1].nbytes

    def distance(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance (N,) m, negative inside, and unit normal (N, 3), at points (N, 3) m of the object's frame."""
        points = np.ascontiguousarray(points, float).reshape(-1, 3)
        distance, normal = np.empty(len(points)), np.empty_like(points)
        kernels.field_distances(self.pool, 0, points, distance, normal)
        return distance, normal

    def kinds(self, points: np.ndarray) -> np.ndarray:
        """(N,) what the voxels around points are, of a field of tangent planes: outside 0, inside 1, surface 2."""
        points = np.ascontiguousarray(points, float).reshape(-1, 3)
        kind = np.empty(len(points), np.int64)
        kernels.voxel_kinds(self.pool, 0, points, kind)
        return kind
