"""Forces of a cloth at rest or displaced, whichever of springs and triangles carry them."""

from __future__ import annotations

import math

import numpy as np
import twins

from cloth_core import ClothMesh, Material
from cloth_core.physics.membrane import Membrane


def with_warp(mesh: ClothMesh, degrees: float) -> ClothMesh:
    """The same triangles, the warp turned from x by ``degrees``."""
    turn = math.radians(degrees)
    return ClothMesh.from_triangles(mesh.rest_position, mesh.triangles, warp=(math.cos(turn), math.sin(turn), 0.0))


def forces(mesh: ClothMesh, material: Material, position: np.ndarray) -> np.ndarray:
    """(V, 3) N, of the springs or of the membrane, whichever carry."""
    found = np.zeros_like(position)
    if mesh.is_membrane(material):
        Membrane(mesh, material).add_forces(position, np.zeros_like(position), 0.0, found)
        return found
    return twins.spring_forces(
        position, 0 * position, mesh.spring_vertex, mesh.spring_rest, mesh.spring_stiffness(material), 0.0
    )


def plane_hessian(mesh: ClothMesh, material: Material) -> np.ndarray:
    """(2 V, 2 V) N/m of small displacements in x and y, by differences of the forces."""
    x, step = mesh.rest_position, 1e-7
    found = np.empty((2 * len(x), 2 * len(x)))
    for column in range(2 * len(x)):
        nudged = x.copy()
        nudged[column // 2, column % 2] += step
        found[:, column] = -forces(mesh, material, nudged)[:, :2].ravel() / step
    return found
