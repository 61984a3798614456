"""Laws of the mesh: what it weighs and what it costs to bend it."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

from cloth_core.linear import bending_matrix
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.validation.law import GEOMETRY, Law, Measurement


def irregular_sheet(width: float, height: float, cells: int, seed: int = 7) -> ClothMesh:
    """A rectangle in z = 0, triangulated from a jittered grid of about ``cells`` cells along its width."""
    columns, rows = cells + 1, max(2, round(cells * height / width)) + 1
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(0, width, columns), np.linspace(0, height, rows)))
    random = np.random.default_rng(seed)
    inner_x, inner_y = (x > 0) & (x < width), (y > 0) & (y < height)
    jitter = 0.3 * width / cells * random.uniform(-1, 1, (2, len(x)))
    points = np.stack([x + jitter[0] * (inner_x & inner_y), y + jitter[1] * (inner_x & inner_y)], axis=1)
    triangles = Delaunay(points).simplices
    side = points[triangles]
    along, across = side[:, 1] - side[:, 0], side[:, 2] - side[:, 0]
    turn = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    kept = np.abs(turn) > 1e-6 * (width / cells) ** 2
    triangles = np.where((turn < 0)[:, None], triangles[:, ::-1], triangles)[kept]
    return ClothMesh.from_triangles(np.column_stack([points, np.zeros(len(points))]), triangles)


def total_mass(_: str) -> Measurement:
    """The masses of the vertices of any triangulation add up to areal density times area."""
    material = Material(areal_density=0.35)
    mass = irregular_sheet(1.3, 0.8, 17).vertex_mass(material).sum()
    return Measurement(0.35 * 1.3 * 0.8, float(mass), 1e-12, "kg")


def cylinder_energy(_: str) -> Measurement:
    """A sheet of bending stiffness B rolled to radius R stores B / (2 R^2) per area."""
    radius, width, height, bend = 0.5, 1.0, 0.25, 1e-3
    mesh = ClothMesh.grid(width=width, height=height, columns=121, rows=31)
    x, y, _z = mesh.rest_position.T
    rolled = np.stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius)], axis=1)
    energy = 0.5 * float(np.sum(rolled * (bending_matrix(mesh, Material(bend=bend)) @ rolled)))
    return Measurement(0.5 * bend / radius**2 * width * height, energy, 1e-3, "J")


LAWS = (
    Law("total mass", total_mass, integrators=GEOMETRY),
    Law("cylinder energy", cylinder_energy, integrators=GEOMETRY),
)
