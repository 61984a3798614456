"""The constant matrices behind W: springs and gauges at zero rest length (eq. 4), and quadratic bending."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from cloth_core.linear.gauges import gauges
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh


def stretch_matrix(mesh: ClothMesh, material: Material) -> csr_matrix:
    """-H of eq. (4), symmetric positive semi-definite, (V, V) N/m: k on the diagonal, -k between a spring's ends.

    A gauge that reads the sum of w_i x_i over the corners of a triangle likewise adds its stiffness times w_i w_j.
    """
    if mesh.is_membrane(material):
        return _membrane_matrix(mesh, material)
    i, j = mesh.spring_vertex.T
    k = mesh.spring_stiffness(material)
    return _assembled(mesh, [i, j, i, j], [i, j, j, i], [k, k, -k, -k])


def _membrane_matrix(mesh: ClothMesh, material: Material) -> csr_matrix:
    direction, modulus = gauges(material)
    weight = mesh.triangle_slope @ direction.T
    values = np.einsum("t,d,tid,tjd->tij", mesh.triangle_area, modulus, weight, weight, optimize=True)
    rows, columns = np.repeat(mesh.triangles, 3, axis=1), np.tile(mesh.triangles, (1, 3))
    return _assembled(mesh, [rows.ravel()], [columns.ravel()], [values.ravel()])


def bending_matrix(mesh: ClothMesh, material: Material) -> csr_matrix:
    """Hessian of the quadratic bending energy, (V, V) N/m: bend * (weight outer weight) of every reading."""
    entries = (mesh.curvature_weight, mesh.curvature_vertex, mesh.curvature_start)
    reading = csr_matrix(entries, shape=(len(mesh.curvature_start) - 1, mesh.vertex_count))
    matrix = (material.bend * (reading.T @ reading)).tocsr()
    matrix.sort_indices()
    return matrix


def _assembled(mesh: ClothMesh, rows: list, columns: list, values: list) -> csr_matrix:
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    matrix = coo_matrix(entries, shape=(mesh.vertex_count,) * 2).tocsr()
    matrix.sum_duplicates()
    return matrix
