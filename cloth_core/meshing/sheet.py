"""Sheets of any triangulation: see :meth:`cloth_core.mesh.ClothMesh.from_triangles`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cloth_core.meshing import checks
from cloth_core.meshing.areas import vertex_areas
from cloth_core.meshing.curvature import readings
from cloth_core.meshing.hinges import hinges
from cloth_core.meshing.threads import bias, direction, slopes


def fields(
    position: Any, triangles: Any, uv: Any, groups: Mapping[str, Sequence[int]], warp: Sequence[float]
) -> dict[str, Any]:
    """The fields of the mesh."""
    position = checks.as_numbers("positions", position, 3, " (m)")
    checks.check_positions(position)
    triangles = checks.as_indices("triangles", triangles, 3, len(position))
    checks.check_sheet(position, triangles)
    springs = _edges(triangles)
    along = position[springs[:, 1]] - position[springs[:, 0]]
    thread = direction(warp)
    curvature = readings(position, triangles)
    return dict(
        rest_position=position,
        triangles=triangles,
        spring_vertex=springs,
        spring_rest=np.linalg.norm(along, axis=1),
        spring_weight=np.zeros((len(springs), 4)),
        spring_limited=np.ones(len(springs), bool),
        spring_bias=bias(along, thread),
        triangle_slope=slopes(position, triangles, thread),
        hinge_vertex=hinges(position, triangles)[0],
        curvature_start=curvature.start,
        curvature_vertex=curvature.vertex,
        curvature_weight=curvature.weight,
        vertex_area=vertex_areas(position, triangles),
        uv=checks.check_uv(uv, len(position)),
        groups=checks.check_groups(groups, len(position)),
    )


def _edges(triangles: np.ndarray) -> np.ndarray:
    """Unique edges (S, 2) int32."""
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.unique(np.sort(sides, axis=1), axis=0).astype(np.int32)
