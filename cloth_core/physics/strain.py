"""How far the threads are stretched, vertex by vertex."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import membrane, springs
from cloth_core.mesh import ClothMesh


def vertex_strain(mesh: ClothMesh, position: np.ndarray) -> np.ndarray:
    """(V,) largest strain of the threads at each vertex for a ``position`` (V, 3) m; 0 where there are none.

    Threads are the limited springs of a grid or net, and warp and weft in the triangles of any other sheet.
    """
    strain = np.empty(mesh.vertex_count)
    if len(mesh.triangle_slope) and not mesh.spring_weight.any():
        membrane.vertex_thread_strain(position, mesh.triangles, mesh.triangle_slope, strain)
    else:
        springs.vertex_strain(position, mesh.spring_vertex, mesh.spring_rest, mesh.spring_limited, strain)
    return strain
