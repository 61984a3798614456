"""How far the threads are stretched, vertex by vertex."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import membrane, springs
from cloth_core.mesh import ClothMesh
from cloth_core.physics.rest_scale import RestShape


def vertex_strain(mesh: ClothMesh, position: np.ndarray, rest: RestShape | None = None) -> np.ndarray:
    """(V,) largest strain of the threads at each vertex for a ``position`` (V, 3) m; 0 where there are none.

    ``rest`` lengths are those of the mesh unless others are given.

    Threads are the limited springs of a grid or net, and warp and weft in the triangles of any other sheet.
    """
    rest = rest or RestShape.of(mesh)
    strain = np.empty(mesh.vertex_count)
    if len(mesh.triangle_slope) and not mesh.spring_weight.any():
        membrane.vertex_thread_strain(position, mesh.triangles, rest.triangle_slope, strain)
    else:
        springs.vertex_strain(position, mesh.spring_vertex, rest.spring_rest, mesh.spring_limited, strain)
    return strain
