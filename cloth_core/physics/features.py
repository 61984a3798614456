"""What the leaves of a tree of patches are made of: each vertex and each edge stands in one of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cloth_core.mesh import ClothMesh
from cloth_core.meshing.patches import Patches


@dataclass(frozen=True, eq=False)
class Features:
    """The features of a mesh by leaves.

    No pair of features comes twice then (Curtis, Tamstorf and Manocha 2008, "Fast collision detection for deformable
    models using representative-triangles").

    Args:
        sheet: what kernels want of the mesh: positions at rest (V, 3) m, the piece of each vertex (V,), triangles
            (T, 3) uint32 in the order of the leaves, where each leaf begins in it, where in the next, vertices uint32,
            where in the next, edges (E, 2) uint32.
        mean_edge: m.
        short_edge: m; one in twenty is shorter.
        longest_edge: m.
    """

    sheet: tuple[np.ndarray, ...]
    mean_edge: float
    short_edge: float
    longest_edge: float

    @classmethod
    def of(cls, mesh: ClothMesh, tree: Patches) -> Features:
        """Give every feature to the first leaf that has it."""
        leaves = len(tree.leaf_start) - 1
        corner = mesh.triangles[tree.order]
        leaf = np.repeat(np.arange(leaves), np.diff(tree.leaf_start))
        vertex, at = np.unique(corner, return_index=True)
        vertex_start, own_vertex = _by_leaf(leaf[at // 3], vertex, leaves)
        sides = np.sort(corner[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edge, at = np.unique(sides, axis=0, return_index=True)
        edge_start, own_edge = _by_leaf(leaf[at // 3], edge, leaves)
        ends = mesh.rest_position[edge]
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        sheet = (
            mesh.rest_position, mesh.component, np.ascontiguousarray(corner, np.uint32), tree.leaf_start,
            vertex_start, own_vertex, edge_start, own_edge,
        )  # fmt: skip
        return cls(
            sheet=sheet,
            mean_edge=float(length.mean()) if len(length) else 0.0,
            short_edge=float(np.percentile(length, 5.0)) if len(length) else 0.0,
            longest_edge=float(length.max()) if len(length) else 0.0,
        )


def _by_leaf(leaf: np.ndarray, feature: np.ndarray, leaves: int) -> tuple[np.ndarray, np.ndarray]:
    """Where each leaf's features begin, and the features (as uint32) in the order of the leaves."""
    order = np.argsort(leaf, kind="stable")
    start = np.searchsorted(leaf[order], np.arange(leaves + 1)).astype(np.int32)
    return start, np.ascontiguousarray(feature[order].astype(np.uint32))
