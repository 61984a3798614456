"""The same piece of cloth, meshed in three ways."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cloth_core import ClothMesh
from cloth_core.validation.geometry import irregular_sheet

Mesher = Callable[[float, float, int], ClothMesh]
"""Width m, height m and seed to a sheet in z = 0, centred on the origin, warp along y."""


def grid(cells: int) -> Mesher:
    """Squares, ``cells`` of them along the width."""
    return lambda width, height, seed: ClothMesh.grid(
        width=width, height=height, columns=cells + 1, rows=round(cells * height / width) + 1
    )


def irregular(cells: int) -> Mesher:
    """A Delaunay triangulation of jittered points, as many as those of the grid."""

    def sheet(width: float, height: float, seed: int) -> ClothMesh:
        made = irregular_sheet(width, height, cells, seed)
        return ClothMesh.from_triangles(made.rest_position - [0.5 * width, 0.5 * height, 0.0], made.triangles)

    return sheet


def spacing(mesh: ClothMesh) -> float:
    """m between neighbours, on the average."""
    return float(np.sqrt(mesh.vertex_area.mean()))


def mean_over_area(mesh: ClothMesh, values: np.ndarray) -> float:
    """The mean of ``values`` (V,) over the sheet."""
    return float(mesh.vertex_area @ values / mesh.vertex_area.sum())


def on_edge(mesh: ClothMesh, axis: int, side: float) -> np.ndarray:
    """The vertices at one end of an axis: ``side`` -1 the lower, +1 the upper one."""
    along = side * mesh.rest_position[:, axis]
    return np.flatnonzero(along > along.max() - 1e-9)
