"""The constant stiffness matrix behind W: springs at zero rest length (eq. 4) and quadratic bending."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from cloth_core.material import Material
from cloth_core.mesh import ClothMesh


def stiffness_matrix(mesh: ClothMesh, material: Material) -> csr_matrix:
    """-H of eq. (4), symmetric positive semi-definite, (V, V) N/m.

    Springs contribute k to the diagonal and -k between their ends; hinges contribute
    bend * (weight outer weight).
    """
    i, j = mesh.spring_vertex.T
    k = mesh.spring_stiffness(material)
    w = mesh.hinge_weight
    hinge = material.bend * w[:, :, None] * w[:, None, :]
    rows = np.concatenate([i, j, i, j, np.repeat(mesh.hinge_vertex, 4, axis=1).ravel()])
    columns = np.concatenate([i, j, j, i, np.tile(mesh.hinge_vertex, (1, 4)).ravel()])
    values = np.concatenate([k, k, -k, -k, hinge.ravel()])
    matrix = coo_matrix((values, (rows, columns)), shape=(mesh.vertex_count,) * 2).tocsr()
    matrix.sum_duplicates()
    return matrix
