"""Cloth in streams: dragged along, lifted by what it displaces, and only where it is wet (paper, 6: the river).

Drag is eq. (5) with the velocity relative to the stream, for both integrators: of a cloth that is carried along, the
stream alone would never stop pulling. Along the cloth there is friction, too, which eq. (5) does not know. Lift is the
weight of the fluid in the volume of the cloth (Archimedes). The surface stays where it is, whatever goes through it,
and nothing counts the water that moves with the cloth (the added mass).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cloth_core.fluids import Fluid
from cloth_core.kernels import immersion
from cloth_core.kernels.immersion import Regions
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh


def regions_of(fluids: Mapping[str, Fluid], material: Material) -> Regions | None:
    """The ``fluids`` as kernels know them, in the order of their names, for a cloth of a ``material``."""
    if not fluids:
        return None
    parts = [fluids[name] for name in sorted(fluids)]
    poses = [part.shape.pose for part in parts]
    drag = [material.drag if part.drag is None else part.drag for part in parts]
    density = np.array([part.density for part in parts])
    return Regions(
        kind=np.array([part.shape.kind for part in parts], dtype=np.int64),
        size=np.array([part.shape.size for part in parts], dtype=float),
        rotation=np.array([pose.rotation for pose in poses]),
        origin=np.array([pose.position for pose in poses], dtype=float),
        velocity=np.array([part.velocity for part in parts], dtype=float),
        face_on=0.5 * density * drag,
        along=0.5 * density * [part.skin_drag for part in parts],
        displaced=density * material.thickness * [part.displaced for part in parts],
    )


class Immersion:
    """A cloth that may be wet.

    Args:
        mesh: the cloth.
        material: of its thickness.
        mass: (V,) kg.
    """

    def __init__(self, mesh: ClothMesh, material: Material, mass: np.ndarray) -> None:
        self._area, self._thickness, self._mass = mesh.vertex_area, material.thickness, mass
        self._dry = np.empty_like(mass)

    def add_forces(
        self,
        position: np.ndarray,
        velocity: np.ndarray,
        gravity: np.ndarray,
        h: float,
        regions: Regions,
        area_vector: np.ndarray,
        force: np.ndarray,
    ) -> np.ndarray:
        """Add what the fluids do to ``force`` (V, 3) N within ``h`` s.

        Returns:
            (V,) m^2, the rest area that is dry, valid until the next call; ``area_vector`` (V, 3) m^2 shrinks to it.
        """
        immersion.immerse(
            position, velocity, self._area, self._mass, self._thickness, gravity, h, regions, area_vector, force,
            self._dry,
        )  # fmt: skip
        return self._dry
