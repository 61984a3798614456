"""Sheets of any triangulation: see :meth:`cloth_core.mesh.ClothMesh.from_triangles`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cloth_core.errors import MeshError
from cloth_core.meshing import checks
from cloth_core.meshing.areas import triangle_areas, vertex_areas
from cloth_core.meshing.directions import WARP, WEFT
from cloth_core.meshing.hinges import hinges


def fields(
    position: Any, triangles: Any, uv: Any, groups: Mapping[str, Sequence[int]], warp: Sequence[float]
) -> dict[str, Any]:
    """The fields of the mesh."""
    position = checks.as_numbers("positions", position, 3, " (m)")
    checks.check_positions(position)
    triangles = checks.as_indices("triangles", triangles, 3, len(position))
    checks.check_sheet(position, triangles)
    springs, carried = _edges_with_area(triangles, triangle_areas(position, triangles))
    along = position[springs[:, 1]] - position[springs[:, 0]]
    length = np.linalg.norm(along, axis=1)
    # k = E * area / length^2 stretches a triangulation like the sheet it stands for (Van Gelder 1998).
    stiff = carried / length**2
    share = ((along / length[:, None]) @ _direction(warp)) ** 2
    weight = np.zeros((len(springs), 4))
    weight[:, WARP], weight[:, WEFT] = stiff * share, stiff * (1 - share)
    hinge_vertex, hinge_weight = hinges(position, triangles)
    return dict(
        rest_position=position,
        triangles=triangles,
        spring_vertex=springs,
        spring_rest=length,
        spring_weight=weight,
        spring_limited=np.ones(len(springs), bool),
        hinge_vertex=hinge_vertex,
        hinge_weight=hinge_weight,
        vertex_area=vertex_areas(position, triangles),
        uv=checks.check_uv(uv, len(position)),
        groups=checks.check_groups(groups, len(position)),
    )


def _edges_with_area(triangles: np.ndarray, area: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unique edges (S, 2) int32, and the area of the triangles at each."""
    sides = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    edges, which = np.unique(sides, axis=0, return_inverse=True)
    return edges.astype(np.int32), np.bincount(which.ravel(), weights=np.tile(area, 3), minlength=len(edges))


def _direction(warp: Sequence[float]) -> np.ndarray:
    """(3,) unit vector."""
    (along,) = checks.as_numbers("warp", [warp], 3, "")
    length = np.linalg.norm(along)
    if not 1e-150 < length < 1e150:
        raise MeshError(f"warp {warp} is not a direction: three finite numbers, not all of them 0")
    return along / length
