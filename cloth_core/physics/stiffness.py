"""Whether a material, a mesh and a substep can be computed together."""

from __future__ import annotations

import numpy as np

from cloth_core.linear import bending_matrix, stretch_matrix
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.meshing.checks import refuse

STIFFEST = 1e14
"""h^2 k / m above which inertia is lost in the last digits of M + h^2 K: measured, cloth jitters by tenths of its
size from 1e14 on, and the factorisation fails from 3e14 on."""


def check_stiffness(mesh: ClothMesh, material: Material, substep: float) -> None:
    """Refuse vertices whose stretching and bending outweigh their mass by more than double precision can hold.

    Each value may be in its range and the whole still be impossible: stiff bending on a mesh finer than threads.

    Args:
        mesh: the cloth.
        material: what it is made of.
        substep: s that one solve advances.

    Raises:
        MeshError: naming the vertices.
    """
    stiffness = stretch_matrix(mesh, material).diagonal()
    stiffness += bending_matrix(mesh, material).diagonal()
    lost = ~(substep**2 * stiffness <= STIFFEST * mesh.vertex_mass(material))
    refuse(
        f"vertices too light for how stiffly they are held (more than {STIFFEST:g} times their inertia)",
        np.flatnonzero(lost),
        "choose softer stretching or bending, a heavier cloth, a coarser mesh or a smaller dt",
    )
